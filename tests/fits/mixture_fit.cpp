// SPDX-License-Identifier: Apache-2.0
//
// What other values of those constants of core/mixture.h and core/diffuse_lobe.h would err that
// stand for finite flakes: on random paints traced with all mirrorings
// (core/reference/disc_walk.h). fit_mixture.py builds this with copies of both headers in which the
// constants are variables.
//
//   mixture_fit trace FILE PAINTS PHOTONS SEED
//   mixture_fit answer FILE
//
// The second writes a line for each group of constants: its name, and names and values in turn.
// Then it answers each line that it reads with one: a group's name with new values by the cost of
// the fitted half, "errors" and a name by that half's errors, "check" and a name by the other's.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "finite_scenes.h"
#include "parallel.h"

namespace {

using namespace core_tests;

// --- traces ----------------------------------------------------------------------------------

constexpr const char* kHeader =
    "# paint (its seed); albedo or brdf; degrees of light, view and azimuth; in green: the whole, "
    "its standard error, of it by single flakes";
constexpr double kSlants[] = {0, 30, 45, 60, 80, 85};  // all lights of kGeometries are among them

void write_row(std::FILE* file, std::uint64_t paint, const char* what, const Geometry& at,
               const reference::ByComponent& traced) {
  std::fprintf(file, "%llu %s %g %g %g %.6g %.3g %.6g\n", static_cast<unsigned long long>(paint),
               what, at.light, at.view, at.azimuth, traced.total.mean.y, traced.total.error.y,
               traced.part[reference::single_flake].mean.y);
}

void trace(const std::string& name, int paints, std::size_t photons, std::uint64_t seed) {
  const std::string part = name + ".part";
  std::FILE* file = std::fopen(part.c_str(), "w");
  if (!file) throw std::runtime_error("cannot write " + part);
  std::fprintf(file, "%s\n", kHeader);
  for (int k = 0; k < paints; ++k) {
    const std::uint64_t paint_seed = seed + static_cast<std::uint64_t>(k);
    Random random(paint_seed);
    const Paint paint = random_layer(random);
    for (const double slant : kSlants) {
      const reference::DiscResult traced =
          reference::trace_discs(scene_of(paint, slant, photons, random.bits()));
      write_row(file, paint_seed, "albedo", {slant, 0, 0}, traced.albedo);
      auto brdf = traced.brdf.begin();
      for (const Geometry& at : kGeometries) {
        if (at.light == slant) write_row(file, paint_seed, "brdf", at, *brdf++);
      }
    }
    std::fprintf(stderr, "%d of %d traced\n", k + 1, paints);
  }
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) throw std::runtime_error("cannot write " + part);
  std::filesystem::rename(part, name);
}

// --- errors ----------------------------------------------------------------------------------

struct Case {
  Paint paint;
  Vec3<double> light, view;
  double whole;         // traced
  double traced_rest;   // without single flakes
  double shown_single;  // of the model; no constant changes it
};

struct Cases {
  std::vector<Case> radiances, albedos;
};

// Those of even seeds, which are fitted, and of odd ones.
std::array<Cases, 2> read(const std::string& name) {
  std::ifstream file(name);
  std::string line;
  if (!std::getline(file, line) || line != kHeader) {
    throw std::runtime_error(name + " holds no traces of this program");
  }
  std::array<Cases, 2> halves;
  std::uint64_t seed = 0;
  std::string what;
  Geometry at{};
  double whole = 0, error = 0, single = 0;
  while (file >> seed >> what >> at.light >> at.view >> at.azimuth >> whole >> error >> single) {
    if (error > kMostNoise * whole) continue;
    Random random(seed);
    Case one{random_layer(random),
             direction(at.light, 0),
             direction(at.view, at.azimuth),
             whole,
             whole - single,
             0};
    Cases& half = halves[seed % 2];
    (what == "albedo" ? half.albedos : half.radiances).push_back(one);
  }
  if (!file.eof()) throw std::runtime_error(name + " has a row that is none");
  for (Cases& half : halves) {
    if (half.radiances.empty()) throw std::runtime_error(name + " has too few paints");
    parallel_for(
        half.radiances.size(),
        [&](std::size_t i) {
          Case& one = half.radiances[i];
          one.shown_single = single_of(one.paint, one.light, one.view);
        },
        8);
  }
  return halves;
}

// Relative, of the whole.
double radiance_error(const Case& one) {
  return (one.shown_single + rest_of(one.paint, one.light, one.view)) / one.whole - 1;
}

// Of M, the albedo without single flakes.
double albedo_error(const Case& one) {
  SurfacePoint<double> point{};
  point.normal = {0, 0, 1};
  point.view = one.light;
  const Stack<double> stack =
      make_stack(one.paint, make_layer<double>(one.paint), point, point.normal);
  const double shown = (stack.diffuse + stack.glossy + stack.returned).y * stack.coat.rest;
  return shown - one.traced_rest;
}

template <class Error>
std::vector<double> errors(const std::vector<Case>& cases, const Error& error) {
  std::vector<double> all(cases.size());
  parallel_for(cases.size(), [&](std::size_t i) { all[i] = error(cases[i]); }, 8);
  return all;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Nearly how many cases are off by more than 5 %; the second term pulls at those far off.
double radiance_cost(const Cases& cases) {
  return mean(errors(cases.radiances, [](const Case& one) {
    const double off = std::fabs(radiance_error(one)), square = off * off;
    return square / (square + 0.05 * 0.05) + std::min(off, 0.3);
  }));
}

// Huber's loss of the relative error.
double albedo_cost(const Cases& cases) {
  return mean(errors(cases.albedos, [](const Case& one) {
    constexpr double kStraight = 0.1;  // from here on
    const double off = std::fabs(albedo_error(one)) / (one.traced_rest + 0.01);
    return off < kStraight ? off * off : kStraight * (2 * off - kStraight);
  }));
}

// --- what other constants cost ---------------------------------------------------------------

struct Constant {
  const char* name;
  double* value;
};

struct Group {
  const char* name;
  std::vector<Constant> constants;
  double (*cost)(const Cases&);
};

#define METALLIC_PAINT_CONSTANT(name) {#name, &name}
const std::array<Group, 2> groups = {{
    {"energy",
     {METALLIC_PAINT_CONSTANT(kHoles), METALLIC_PAINT_CONSTANT(kCrowded),
      METALLIC_PAINT_CONSTANT(kBetweenFlakes)},
     albedo_cost},
    {"lobes",
     {METALLIC_PAINT_CONSTANT(kStretch), METALLIC_PAINT_CONSTANT(kLean),
      METALLIC_PAINT_CONSTANT(kReturnExponent), METALLIC_PAINT_CONSTANT(kReturnNarrowing),
      METALLIC_PAINT_CONSTANT(kReturnHeight), METALLIC_PAINT_CONSTANT(kReturnLowering),
      METALLIC_PAINT_CONSTANT(kFlakesBySlant), METALLIC_PAINT_CONSTANT(kTiltBySlant),
      METALLIC_PAINT_CONSTANT(kAbsorptionBySlant)},
     radiance_cost},
}};
#undef METALLIC_PAINT_CONSTANT

std::string row(const std::string& name, const Cases& cases) {
  const std::vector<double> radiance = sizes(errors(cases.radiances, radiance_error));
  const std::vector<double> albedo = sizes(errors(cases.albedos, albedo_error));
  char text[200];
  std::snprintf(text, sizeof text, "| %s | %zu | %.3f | %.3f | %.4f | %zu | %.4f |\n", name.c_str(),
                radiance.size(), within(radiance, 0.05), within(radiance, 0.1), mean(radiance),
                albedo.size(), quantile(albedo, 0.95));
  return text;
}

void answer(const std::string& name) {
  const auto [fitted, other] = read(name);
  for (const Group& group : groups) {
    std::printf("%s", group.name);
    for (const Constant& constant : group.constants) {
      std::printf(" %s %.17g", constant.name, *constant.value);
    }
    std::printf("\n");
  }
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string first, rest;
    words >> first;
    const auto group = std::find_if(groups.begin(), groups.end(),
                                    [&](const Group& each) { return each.name == first; });
    if (group != groups.end()) {
      for (const Constant& constant : group->constants) words >> *constant.value;
      std::printf("%.17g\n", group->cost(fitted));
    } else if (first == "errors" || first == "check") {
      std::getline(words >> std::ws, rest);
      std::printf("%s", row(rest, first == "errors" ? fitted : other).c_str());
    } else {
      throw std::runtime_error("mixture_fit does not know what to answer to: " + line);
    }
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 5 && arguments[0] == "trace") {
    trace(arguments[1], std::stoi(arguments[2]), std::stoul(arguments[3]),
          std::stoull(arguments[4]));
  } else if (arguments.size() == 2 && arguments[0] == "answer") {
    answer(arguments[1]);
  } else {
    std::fprintf(stderr, "mixture_fit trace FILE PAINTS PHOTONS SEED | mixture_fit answer FILE\n");
    return 2;
  }
}
