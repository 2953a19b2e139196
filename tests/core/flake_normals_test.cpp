// SPDX-License-Identifier: Apache-2.0
//
// The references' own flake normals, against quadrature over the densities and against the core.
#include "reference/flake_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "independent.h"
#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;
using metallic_paint::reference::FlakeNormals;
using metallic_paint::reference::ProjectedAreaTable;
using metallic_paint::reference::RandomStream;

constexpr double kPi = std::numbers::pi;

TEST(FlakeNormals, ProjectedAreaIsTheCores) {
  Worst worst;
  for (const auto kind : {Orientation::gaussian, Orientation::beckmann, Orientation::ggx}) {
    for (const double tilt : {1e-6, 1e-3, 0.05, 0.15, 0.5, 1.0}) {
      const ProjectedAreaTable table((FlakeNormals(kind, tilt)));
      const auto density = metallic_paint::make_orientation(kind, tilt);
      for (double cosine = 1e-8; cosine < 1; cosine *= 1.03) {
        const double area = metallic_paint::mean_projected_area(density, cosine);
        worst.see(relative_error(table.at(cosine), area), "kind", static_cast<int>(kind), "tilt",
                  tilt, "cosine", cosine);
      }
    }
  }
  worst.expect_at_most(4e-6);  // what the header states
}

TEST(FlakeNormals, TiltsAreDistributedAsPBetaSaysExactly) {
  constexpr int kSamples = 400'000, kCells = 60;
  Worst worst;
  int tests = 0;
  RandomStream random(run_seed());
  for (int kind = 0; kind < 3; ++kind) {
    for (double tilt : {1e-4, 0.05, 0.3, 1.0, 50.0}) {
      if (kind > 0 && tilt > 1) continue;
      const FlakeNormals normals(static_cast<Orientation>(kind), tilt);
      const independent::Flakes flakes{kind, tilt};
      // Cells even in the angle near the peak, in its logarithm in the tail.
      std::vector<double> edges{0};
      for (int i = 1; i < kCells; ++i) {
        const double x = std::asinh(kPi / 2 / tilt) * i / kCells;
        edges.push_back(tilt * std::sinh(x));
      }
      edges.push_back(kPi / 2);
      const auto norm = independent::shape_norm(flakes);
      std::vector<double> expected, observed(kCells);
      for (std::size_t i = 0; i < kCells; ++i) {
        const auto part = independent::integrate(
            [&](independent::Real beta) {
              return independent::shape(flakes, beta) * std::sin(beta);
            },
            static_cast<independent::Real>(edges[i]), static_cast<independent::Real>(edges[i + 1]));
        expected.push_back(kSamples * static_cast<double>(part / norm));
      }
      for (int i = 0; i < kSamples; ++i) {
        const Vec3<double> n = normals.sample(random);
        const double beta = std::atan2(std::hypot(n.x, n.y), n.z);
        const auto above = std::upper_bound(edges.begin() + 1, edges.end() - 1, beta);
        observed[static_cast<std::size_t>(above - edges.begin() - 1)] += 1;
      }
      worst.see(chi_square_z(observed, expected), "kind", kind, "tilt", tilt);
      ++tests;
    }
  }
  worst.expect_at_most(sidak_threshold(kFreshLevel, tests));
}

TEST(FlakeNormals, ThoseThatARayMeetsFollowTheirDensity) {
  constexpr int kRings = 12, kSectors = 8, kFine = 24;
  constexpr double kSamples = 40'000;
  Worst worst;
  int tests = 0;
  for (int kind = 0; kind < 3; ++kind) {
    for (const double tilt : {0.02, 0.15, 0.5, 1.0}) {
      const FlakeNormals flakes(static_cast<Orientation>(kind), tilt);
      const independent::Flakes shape{kind, tilt};
      const auto norm = static_cast<double>(independent::shape_norm(shape));
      for (const double degrees : {0.0, 40.0, 75.0, 89.0}) {
        const Vec3<double> v = spherical(degrees * kPi / 180, 0) * (tests % 2 == 0 ? 1.0 : -1.0);
        // Rings even in atan(tan(beta)/tilt), sectors of azimuth, mirrored: cells of the integral
        // of P sin(beta) |v . n| by the midpoint rule.
        std::vector<double> expected(kRings * kSectors), found(kRings * kSectors);
        double total = 0;
        for (int i = 0; i < kRings * kFine; ++i) {
          const double step = kPi / 2 / (kRings * kFine), psi = (i + 0.5) * step;
          const double beta = std::atan(tilt * std::tan(psi));
          const double c = std::cos(psi), s = tilt * std::sin(psi);
          const double ring = static_cast<double>(independent::shape(shape, beta)) / norm *
                              std::sin(beta) * tilt / (c * c + s * s) * step;
          for (int j = 0; j < kSectors * kFine; ++j) {
            const double phi = (j + 0.5) * kPi / (kSectors * kFine);
            const Vec3<double> n = spherical(beta, phi);
            const double cell = ring * std::abs(dot(v, n));
            expected[static_cast<std::size_t>(i / kFine * kSectors + j / kFine)] += cell;
            total += cell;
          }
        }
        const RandomStream seed(run_seed());
        RandomStream random = seed.substream(static_cast<std::uint64_t>(tests));
        for (int i = 0; i < static_cast<int>(kSamples); ++i) {
          Vec3<double> n = flakes.sample_met(v, random);
          if (n.z < 0) n = n * -1.0;
          const double tan_beta = std::hypot(n.x, n.y) / n.z;
          const double psi = std::atan(tan_beta / tilt), phi = std::abs(std::atan2(n.y, n.x));
          const int ring = std::min(static_cast<int>(psi / (kPi / 2) * kRings), kRings - 1);
          const int sector = std::min(static_cast<int>(phi / kPi * kSectors), kSectors - 1);
          ++found[static_cast<std::size_t>(ring * kSectors + sector)];
        }
        for (double& cell : expected) cell *= kSamples / total;
        worst.see(chi_square_z(found, expected, 10), "kind", kind, "tilt", tilt, "degrees",
                  degrees);
        ++tests;
      }
    }
  }
  worst.expect_at_most(sidak_threshold(kFreshLevel, tests));
}

}  // namespace
