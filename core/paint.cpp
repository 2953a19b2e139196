// SPDX-License-Identifier: Apache-2.0
#include "paint.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>

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

// Reflectance and transmittance may not give back more than falls in.
void require_sum(const std::string& field, Rgb<double> reflectance, Rgb<double> transmittance) {
  const double most = max_component(reflectance + transmittance);
  if (most > kMostOfASum) reject(field, most, "at most 1 in every channel");
}

// A choice is none of its words only where C++ was told so by force.
template <std::size_t n>
void require_choice(const std::string& field, int choice, const std::array<const char*, n>& words) {
  if (choice >= 0 && choice < static_cast<int>(n)) return;
  std::string all;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) all += i + 1 < n ? ", " : " or ";
    all += std::to_string(i) + " (" + words[i] + ")";
  }
  reject(field, choice, all);
}

// Holds each parameter of `of` to its range; name(field) is the field's name as the user knows it.
template <class Name>
auto checks(const auto& of, const Name& name) {
  return [&of, name](const char* field, auto member, const auto& range) {
    const auto& value = of.*member;
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_enum_v<Value>) {
      require_choice(name(field), static_cast<int>(value), range);
    } else if constexpr (std::is_same_v<Value, Rgb<double>>) {
      require_colour(name(field), value, range.most, range.unit);
    } else if constexpr (std::is_same_v<Value, double>) {
      require_range(name(field), value, range.least, range.most, range.unit);
    }  // an int, such as the seed, may be any
  };
}

template <class Name>
void validate_species(const FlakeSpecies& flakes, const Name& name) {
  if (flakes.orientation != Orientation::gaussian) {
    const Range& range = kTiltAsRoughness;
    require_range(name("tilt"), flakes.tilt, range.least, range.most, range.unit);
  }
  each_flake_parameter(checks(flakes, name));
  if (flakes.coating != CoatingKind::colors) return;
  const std::string color = name("flake_color"), edge = name("flake_edge_color"),
                    transmission = name("flake_transmission");
  require_sum(color + " + " + transmission, flakes.flake_color, flakes.flake_transmission);
  require_sum(edge + " + " + transmission, flakes.flake_edge_color, flakes.flake_transmission);
}

}  // namespace

void validate(const Paint& paint) {
  const auto own = [](const char* field) { return std::string(field); };
  validate_species(paint, own);
  for (std::size_t i = 0; i < paint.more.size(); ++i) {
    validate_species(paint.more[i],
                     [i](const char* field) { return at_row("more", i) + "." + field; });
  }
  each_paint_parameter(checks(paint, own));
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
    case LightKind::sky:
      if (!(length(light.vector) > 0)) {
        reject("length of light.vector", 0, "above 0 for a light without a place");
      }
      return require_range("light.size", light.size, 0, 1, " (sine of the angular radius)");
    case LightKind::positional:
      return require_range("light.size", light.size, 0, largest, " scene units (radius)");
    case LightKind::area:
      require_range("light.facing.x", light.facing.x, -largest, largest);
      require_range("light.facing.y", light.facing.y, -largest, largest);
      require_range("light.facing.z", light.facing.z, -largest, largest);
      if (!(length(light.facing) > 0)) {
        reject("length of light.facing", 0, "above 0 for an area light");
      }
      return require_range("light.size", light.size, 0, largest, " scene units (radius)");
  }
  reject("light.kind", static_cast<double>(light.kind),
         "0 (unused), 1 (parallel), 2 (positional), 3 (area) or 4 (sky)");
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

namespace {

constexpr double kMost = 1e30;  // of all that pixels are told by

bool is_unit_or_zero(double square) { return square == 0 || is_unit(square); }

// Whether all of the first `count` numbers of a column lie in a range, where it is given.
bool all_within(const Column& column, std::size_t count, double least, double most) {
  return !column.given() || column.as_they_are([&](const auto* number) {
    bool within = true;
    for (std::size_t i = 0; i < count; ++i) {
      within &= (number[i] >= least) & (number[i] <= most);  // without a branch
    }
    return within;
  });
}

// Likewise vectors of length 1 or 0.
bool all_unit_or_zero(const Column& column, std::size_t count) {
  return !column.given() || column.as_they_are([&](const auto* number) {
    bool within = true;
    for (std::size_t i = 0; i < count; ++i) {
      const double x = number[3 * i], y = number[3 * i + 1], z = number[3 * i + 2];
      within &= is_unit_or_zero(x * x + y * y + z * z);
    }
    return within;
  });
}

bool all_sound(const PixelBatch& batch, std::size_t lights) {
  const std::size_t n = batch.size;
  return all_within(batch.position, 3 * n, -kMost, kMost) && all_unit_or_zero(batch.normal, n) &&
         all_unit_or_zero(batch.view, n) && all_within(batch.footprint, n, 0, kMost) &&
         all_within(batch.own_position, 3 * n, -kMost, kMost) &&
         all_unit_or_zero(batch.own_axes, 3 * n) &&
         all_within(batch.slant, 3 * n * lights, 0, kMost);
}

}  // namespace

void validate(const PixelBatch& batch, std::size_t lights) {
  if (all_sound(batch, lights)) return;
  // Something is not: the first, by name.
  // All zero: a pixel without surface.
  const auto require_unit_or_zero = [](const char* name, const Column& vectors, std::size_t at,
                                       std::size_t row) {
    const Vec3<double> v = vector_at<double>(vectors, at);
    const double square = dot(v, v);
    if (is_unit_or_zero(square)) return;
    reject("length of " + at_row(name, row), std::sqrt(square),
           "1 to a thousandth, or 0 where there is no surface");
  };
  for (std::size_t i = 0; i < batch.size; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      require_range(at_row("position", i), batch.position[3 * i + c], -kMost, kMost,
                    " scene units");
    }
    require_unit_or_zero("normal", batch.normal, i, i);
    require_unit_or_zero("view", batch.view, i, i);
    require_range(at_row("footprint", i), batch.footprint[i], 0, kMost, " m2");
    for (std::size_t c = 0; batch.own_position.given() && c < 3; ++c) {
      require_range(at_row("own_position", i), batch.own_position[3 * i + c], -kMost, kMost, " m");
    }
    for (std::size_t c = 0; batch.own_axes.given() && c < 3; ++c) {
      require_unit_or_zero("own_axes", batch.own_axes, 3 * i + c, i);
    }
    if (!batch.slant.given()) continue;
    for (std::size_t k = 3 * lights * i; k < 3 * lights * (i + 1); ++k) {
      require_range(at_row("slant_depth", i), batch.slant[k], 0, kMost);
    }
  }
}

}  // namespace metallic_paint
