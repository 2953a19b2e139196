// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "batch.h"

namespace metallic_paint {
namespace {

[[noreturn]] void reject(const std::string& field, double value, const std::string& range) {
  std::ostringstream message;
  message.precision(9);
  message << field << " is " << value << ", but must be " << range;
  throw std::invalid_argument(message.str());
}

void require_range(const std::string& field, double value, double least, double most,
                   const std::string& unit = "") {
  if (value >= least && value <= most) return;  // false for NaN
  std::ostringstream range;
  range.precision(9);
  range << "from " << least << " to " << most << unit;
  reject(field, value, range.str());
}

void require_colour(const std::string& field, Rgb<double> value, double most,
                    const std::string& unit = "") {
  require_range(field + ".r", value.x, 0, most, unit);
  require_range(field + ".g", value.y, 0, most, unit);
  require_range(field + ".b", value.z, 0, most, unit);
}

// Reflectance and transmittance may not give back more than falls in, beyond rounding of the sum.
void require_sum(const std::string& field, Rgb<double> reflectance, Rgb<double> transmittance) {
  const double most = max_component(reflectance + transmittance);
  if (most > 1 + 1e-6) reject(field, most, "at most 1 in every channel");
}

}  // namespace

void validate(const Paint& paint) {
  require_range("flakes_per_mm2", paint.flakes_per_mm2, 0, 1e9, " 1/mm2");
  require_range("flake_diameter_um", paint.flake_diameter_um, 1e-3, 1e5, " um");
  require_range("flake_area_spread", paint.flake_area_spread, 0, 100);
  if (paint.orientation == Orientation::gaussian) {
    require_range("tilt", paint.tilt, 1e-6, 100, " rad (gaussian)");
  } else if (paint.orientation == Orientation::beckmann || paint.orientation == Orientation::ggx) {
    require_range("tilt", paint.tilt, 1e-6, 1, " (roughness of beckmann and ggx)");
  } else {
    reject("orientation", static_cast<double>(paint.orientation),
           "0 (gaussian), 1 (beckmann) or 2 (ggx)");
  }
  require_range("flake_spread", paint.flake_spread, 0, 0.5, " rad");
  require_colour("flake_color", paint.flake_color, 1);
  require_colour("flake_edge_color", paint.flake_edge_color, 1);
  require_colour("flake_transmission", paint.flake_transmission, 1);
  require_sum("flake_color + flake_transmission", paint.flake_color, paint.flake_transmission);
  require_sum("flake_edge_color + flake_transmission", paint.flake_edge_color,
              paint.flake_transmission);
  require_range("binder_ior", paint.binder_ior, 0.1, 10);
  require_range("layer_thickness_um", paint.layer_thickness_um, 0, 1e6, " um");
  require_colour("binder_absorption_per_mm", paint.binder_absorption_per_mm, 1e6, " 1/mm");
  require_range("rayleigh_per_mm", paint.rayleigh_per_mm, 0, 1e6, " 1/mm");
  if (paint.depth_model != DepthModel::attenuated && paint.depth_model != DepthModel::thinned) {
    reject("depth_model", static_cast<double>(paint.depth_model), "0 (attenuated) or 1 (thinned)");
  }
  if (paint.radiometry != Radiometry::exact && paint.radiometry != Radiometry::published) {
    reject("radiometry", static_cast<double>(paint.radiometry), "0 (exact) or 1 (published)");
  }
}

void validate(const Light<double>& light) {
  const double largest = 1e30;
  require_range("light.vector.x", light.vector.x, -largest, largest);
  require_range("light.vector.y", light.vector.y, -largest, largest);
  require_range("light.vector.z", light.vector.z, -largest, largest);
  switch (light.kind) {
    case LightKind::unused:
      return;
    case LightKind::parallel:
      if (!(length(light.vector) > 0)) {
        reject("length of light.vector", 0, "above 0 for a parallel light");
      }
      return require_range("light.size", light.size, 0, 1, " (sine of the angular radius)");
    case LightKind::positional:
      return require_range("light.size", light.size, 0, largest, " scene units (radius)");
  }
  reject("light.kind", static_cast<double>(light.kind),
         "0 (unused), 1 (parallel) or 2 (positional)");
}

void validate(const CoatingTable<double>& table) {
  const std::size_t size = table.reflectance.size();
  if (size < 2 || size > 4096) {
    reject("size of the coating table", static_cast<double>(size), "from 2 to 4096");
  }
  if (table.transmittance.size() != size) {
    reject("size of coating.transmittance", static_cast<double>(table.transmittance.size()),
           "that of coating.reflectance, " + std::to_string(size));
  }
  for (std::size_t i = 0; i < size; ++i) {
    const std::string row = "[" + std::to_string(i) + "]";
    require_colour("coating.reflectance" + row, table.reflectance[i], 1);
    require_colour("coating.transmittance" + row, table.transmittance[i], 1);
    require_sum("coating.reflectance" + row + " + coating.transmittance" + row,
                table.reflectance[i], table.transmittance[i]);
  }
}

void validate(const PixelBatch& batch) {
  // Normals and views come as floats: unit length to a thousandth, or all zero for a pixel without
  // surface.
  const auto require_unit = [](const char* name, const double* v, std::size_t row) {
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square == 0 || std::abs(square - 1) < 2e-3) return;
    reject("length of " + std::string(name) + "[" + std::to_string(row) + "]", std::sqrt(square),
           "1 to a thousandth, or 0 where there is no surface");
  };
  for (std::size_t i = 0; i < batch.size; ++i) {
    const std::string row = "[" + std::to_string(i) + "]";
    for (std::size_t c = 0; c < 3; ++c) {
      require_range("position" + row, batch.position[3 * i + c], -1e30, 1e30, " scene units");
    }
    require_unit("normal", batch.normal + 3 * i, i);
    require_unit("view", batch.view + 3 * i, i);
    require_range("footprint" + row, batch.footprint[i], 0, 1e30, " m2");
  }
}

}  // namespace metallic_paint
