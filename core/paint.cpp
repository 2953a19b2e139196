// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

#include "batch.h"
#include "validation.h"

namespace metallic_paint {
namespace {

bool is_whole(double value, double least, double most) {
  return value >= least && value <= most && value == std::floor(value);
}

void require_uniform(const std::string& field, double value) {
  if (value > 0 && value <= 1) return;
  reject(field, text(value, 17), "above 0 and at most 1");
}

// Reflectance and transmittance may not give back more than falls in, beyond rounding of the sum.
void require_sum(const std::string& field, Rgb<double> reflectance, Rgb<double> transmittance) {
  const double most = max_component(reflectance + transmittance);
  if (most > 1 + 1e-6) reject(field, most, "at most 1 in every channel");
}

// name(field) is the field's name as the user knows it.
template <class Name>
void validate_species(const FlakeSpecies& flakes, const Name& name) {
  require_range(name("flakes_per_mm2"), flakes.flakes_per_mm2, 0, 1e9, " 1/mm2");
  require_range(name("flake_diameter_um"), flakes.flake_diameter_um, 1e-3, 1e5, " um");
  require_range(name("flake_area_spread"), flakes.flake_area_spread, 0, 100);
  if (flakes.orientation == Orientation::gaussian) {
    require_range(name("tilt"), flakes.tilt, 1e-6, 100, " rad (gaussian)");
  } else if (flakes.orientation == Orientation::beckmann ||
             flakes.orientation == Orientation::ggx) {
    require_range(name("tilt"), flakes.tilt, 1e-6, 1, " (roughness of beckmann and ggx)");
  } else {
    reject(name("orientation"), static_cast<double>(flakes.orientation),
           "0 (gaussian), 1 (beckmann) or 2 (ggx)");
  }
  require_range(name("flake_spread"), flakes.flake_spread, 0, 0.5, " rad");
  const std::string color = name("flake_color"), edge = name("flake_edge_color"),
                    transmission = name("flake_transmission");
  require_colour(color, flakes.flake_color, 1);
  require_colour(edge, flakes.flake_edge_color, 1);
  require_colour(transmission, flakes.flake_transmission, 1);
  require_coating(name("coating"), static_cast<int>(flakes.coating), flakes.coating_nm);
  if (flakes.coating != CoatingKind::colors) return;
  require_sum(color + " + " + transmission, flakes.flake_color, flakes.flake_transmission);
  require_sum(edge + " + " + transmission, flakes.flake_edge_color, flakes.flake_transmission);
}

}  // namespace

void validate(const Paint& paint) {
  validate_species(paint, [](const char* field) { return std::string(field); });
  for (std::size_t i = 0; i < paint.more.size(); ++i) {
    validate_species(paint.more[i],
                     [i](const char* field) { return at_row("more", i) + "." + field; });
  }
  if (paint.diffraction != Diffraction::none && paint.diffraction != Diffraction::disc) {
    reject("diffraction", static_cast<double>(paint.diffraction), "0 (none) or 1 (disc)");
  }
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
  if (paint.composition != Composition::exact && paint.composition != Composition::published) {
    reject("composition", static_cast<double>(paint.composition), "0 (exact) or 1 (published)");
  }
  require_range("sparkle_contrast", paint.sparkle_contrast, 0, 1);
  require_colour("substrate_color", paint.substrate_color, 1);
  require_range("texture_contrast", paint.texture_contrast, 0, 1);
  require_range("coat_roughness", paint.coat_roughness, 0, 1);
  require_range("orange_peel", paint.orange_peel, 0, 1, " rad");
  require_range("orange_peel_mm", paint.orange_peel_mm, 1e-3, 1e6, " mm");
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

void validate_count(double mean, double slots, double uniform) {
  require_range("mean", mean, 0, std::numeric_limits<double>::infinity());
  if (!is_whole(slots, 0, kPoissonSlots)) {
    reject("slots", text(slots, 17), "a whole number from 0 to " + std::to_string(kPoissonSlots));
  }
  require_uniform("uniform", uniform);
}

void validate_probability(double probability) { require_uniform("probability", probability); }

void validate_cosine(double cos_theta) { require_range("cos_theta", cos_theta, 0, 1); }

void validate_eta(double eta) { require_range("eta", eta, 0.1, 10); }

void validate_beta(double beta) { require_range("beta", beta, 0, std::numbers::pi / 2, " rad"); }

void validate_direction(const std::string& field, std::size_t row, Vec3<double> direction) {
  require_unit(at_row(field, row), direction);
}

void validate_int32(const std::string& field, std::size_t row, double value) {
  using Limits = std::numeric_limits<std::int32_t>;
  if (is_whole(value, Limits::min(), Limits::max())) return;
  reject(at_row(field, row), text(value, 17), "a whole number from -2^31 to 2^31 - 1");
}

void validate(const PixelBatch& batch, std::size_t lights) {
  // All zero: a pixel without surface.
  const auto require_unit_or_zero = [](const char* name, const double* v, std::size_t row) {
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (square == 0 || is_unit(square)) return;
    reject("length of " + at_row(name, row), std::sqrt(square),
           "1 to a thousandth, or 0 where there is no surface");
  };
  for (std::size_t i = 0; i < batch.size; ++i) {
    const std::string position = at_row("position", i);
    for (std::size_t c = 0; c < 3; ++c) {
      require_range(position, batch.position[3 * i + c], -1e30, 1e30, " scene units");
    }
    require_unit_or_zero("normal", batch.normal + 3 * i, i);
    require_unit_or_zero("view", batch.view + 3 * i, i);
    require_range(at_row("footprint", i), batch.footprint[i], 0, 1e30, " m2");
    if (batch.slant == nullptr) continue;
    const std::string slant_depth = at_row("slant_depth", i);
    for (std::size_t k = 3 * lights * i; k < 3 * lights * (i + 1); ++k) {
      require_range(slant_depth, batch.slant[k], 0, 1e30);
    }
  }
}

}  // namespace metallic_paint
