// SPDX-License-Identifier: Apache-2.0
//
// The five constants of the coat in core/composition.h, fitted again: least squares of what GGX's
// facets reflect, over indices from 1.2 to 2.4, all roughnesses and all views. facet_fit takes
// nothing and draws nothing; half a minute.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "composition.h"
#include "rough_surface.h"

namespace {

using namespace core_tests;

struct Case {
  double eta, roughness, cosine, reflected;
};

// Of facet_reflectance (three) and facet_albedo (two).
using Constants = std::array<double, 5>;
constexpr Constants kStated = {0.55, 0.56, 0.6, 0.43, 0.26};

// make_coat's `reflected` with constants free.
double reflected(const Constants& c, const Case& at) {
  const double q = at.roughness * at.roughness * std::sqrt(at.roughness);
  const double k = c[0] * q / (1 + c[1] * q), square = at.cosine * at.cosine;
  const double cosine = std::sqrt(std::max(square + k * (1 - c[2] * square), 1e-9));
  const double fresnel =
      1 - fresnel_transmittance(cosine, eta_cos_refracted(cosine, at.eta), at.eta);
  return fresnel * (1 - at.roughness * at.roughness * (c[3] + c[4] * at.cosine));
}

struct Error {
  double largest = 0, root_mean_square = 0;
};

Error error_of(const Constants& constants, const std::vector<Case>& cases) {
  Error error;
  for (const Case& at : cases) {
    const double off = reflected(constants, at) - at.reflected;
    error.largest = std::max(error.largest, std::fabs(off));
    error.root_mean_square += off * off / static_cast<double>(cases.size());
  }
  error.root_mean_square = std::sqrt(error.root_mean_square);
  return error;
}

// The least squares, by steps along one constant at a time that shrink once none helps.
Constants fit(const std::vector<Case>& cases) {
  Constants best = kStated;
  double least = error_of(best, cases).root_mean_square;
  for (double step = 0.1; step > 1e-4; step /= 2) {
    for (bool helped = true; helped;) {
      helped = false;
      for (std::size_t i = 0; i < best.size(); ++i) {
        for (double way : {-step, step}) {
          Constants other = best;
          other[i] += way;
          const double found = error_of(other, cases).root_mean_square;
          if (!(found < least)) continue;
          least = found;
          best = other;
          helped = true;
        }
      }
    }
  }
  return best;
}

void tell(const char* name, const Constants& c, const std::vector<Case>& cases) {
  const Error error = error_of(c, cases);
  std::printf("| %s | %.2f %.2f %.2f | %.2f %.2f | %.3f | %.4f |\n", name, c[0], c[1], c[2], c[3],
              c[4], error.largest, error.root_mean_square);
}

}  // namespace

int main() {
  std::vector<Case> cases;
  for (double eta : {1.2, 1.33, 1.5, 1.65, 1.8, 2.1, 2.4}) {
    for (int i = 1; i <= 10; ++i) {
      for (int j = 0; j <= 10; ++j) {
        Case at{eta, i / 10.0, std::max(j / 10.0, 0.02), 0};
        at.reflected = reflected_by_facets(at.cosine, at.roughness * at.roughness, eta, 200, 200);
        cases.push_back(at);
        const double shipped = make_coat(at.cosine, at.roughness, eta).reflected;
        if (std::fabs(reflected(kStated, at) - shipped) > 1e-12) {
          std::fprintf(stderr, "core/composition.h no longer has the constants stated here\n");
          return 1;
        }
      }
    }
  }
  std::printf(
      "| %zu cases | facet_reflectance | facet_albedo | largest error | root mean square |\n"
      "| --- | --- | --- | ---: | ---: |\n",
      cases.size());
  tell("as they stand", kStated, cases);
  tell("fitted again", fit(cases), cases);
}
