// SPDX-License-Identifier: Apache-2.0
//
// The cells of the surface: that their counts follow their law, that cells, levels, normals and
// instances are independent of one another, how much a pixel's filter leaves of point flakes'
// variance, and that no lattice shows.
#include "anchor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <numbers>
#include <vector>

#include "count_law.h"
#include "scenes.h"
#include "sparkles.h"
#include "support.h"

namespace {

using namespace core_tests;

constexpr double kPi = std::numbers::pi;

// A direction anywhere, and two across it.
struct Frame {
  Vec3<double> n, a, b;
};
Frame any_frame(Random& random) {
  Frame frame;
  frame.n = any_direction(random);
  Vec3<double> a = cross(frame.n, any_direction(random));
  while (length(a) < 1e-3) a = cross(frame.n, any_direction(random));
  frame.a = a / length(a);
  frame.b = cross(frame.n, frame.a);
  return frame;
}

// A plane of paint in an object, looked at under this cosine.
SurfacePoint<double> on_plane(const Frame& plane, double cosine, double footprint) {
  SurfacePoint<double> point{};
  point.normal = plane.n;
  point.view = plane.n * cosine + plane.a * std::sqrt((1 - cosine) * (1 + cosine));
  point.footprint = footprint;
  return point;
}

// A light that flakes of this tilt about the normal, towards a, mirror to the observer.
SeenLight<double> mirrored_at(const SurfacePoint<double>& point, const Frame& plane, double tilt,
                              double sine) {
  const Vec3<double> half = plane.n * std::cos(tilt) + plane.b * std::sin(tilt);
  const Vec3<double> light = half * (2 * dot(half, point.view)) - point.view;
  return see_light<double>({LightKind::parallel, light, sine}, {});
}

Paint on_surface(double flakes_per_mm2) {
  Paint paint = undiffracted();
  paint.anchor = Anchor::surface;
  paint.flakes_per_mm2 = flakes_per_mm2;
  return paint;
}

TEST(Anchor, CountsOfCellsFollowTheirLaw) {
  Random random(run_seed());
  constexpr int kCases = 24, kBins = 64, kPoints = 20'000;
  const double threshold = sidak_threshold(kFreshLevel, kCases);
  int binomial = 0;
  for (int i = 0; i < kCases; ++i) {
    // Footprints of some 3 to 30,000 flakes; places where few of them fit.
    const Paint paint = on_surface(3000);
    const Layer<double> layer = make_layer<double>(paint);
    const Frame plane = any_frame(random);
    auto point = on_plane(plane, random.uniform(0.1, 1), random.log_uniform(1e-9, 1e-5));
    const auto light = mirrored_at(point, plane, random.uniform(0, 0.15), 0.00465);
    const auto way = pass_between(layer, point, light);
    if (!way.open) continue;
    std::vector<double> found(kBins), expected(kBins, kPoints / static_cast<double>(kBins));
    for (int k = 0; k < kPoints; ++k) {
      point.own.position = plane.a * random.uniform(-1, 1) + plane.b * random.uniform(-1, 1);
      const auto all = sparkle_at(layer, point, way);
      binomial += all.slots > 0;
      ASSERT_GT(all.mean_count, 0);
      // Uniform in (0, 1) if the count follows its law.
      const auto probability = [&](double n) {
        return std::exp(log_probability(all.mean_count, all.slots, n));
      };
      double below = 0;
      for (double n = 0; n < all.count; ++n) below += probability(n);
      const double equal = probability(all.count);
      const double u = std::clamp(below + equal * random.uniform(), 0.0, 1 - 1e-12);
      found[static_cast<std::size_t>(u * kBins)] += 1;
    }
    EXPECT_LE(std::fabs(chi_square_z(found, expected)), threshold)
        << "footprint " << point.footprint;
  }
  EXPECT_GT(binomial, 0);
}

// The correlation of the counts of two samples, as a standard normal deviate.
template <class First, class Second>
double correlation_z(Random& random, const First& first, const Second& second) {
  constexpr int kPairs = 20'000;
  double aa = 0, bb = 0, ab = 0;
  for (int k = 0; k < kPairs; ++k) {
    const Vec3<double> where{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const double a = first(where), b = second(where);
    aa += a * a;
    bb += b * b;
    ab += a * b;
  }
  return ab / std::sqrt(aa * bb) * std::sqrt(1.0 * kPairs);
}

TEST(Anchor, CellsLevelsNormalsAndInstancesAreIndependent) {
  Random random(run_seed() + 1);
  const Layer<double> layer = make_layer<double>(on_surface(3000));
  const Frame plane = any_frame(random);
  const auto base = on_plane(plane, 0.8, 1e-7);
  const auto light = mirrored_at(base, plane, 0.05, 0.00465);
  // N less its mean, over the deviation of a Poisson count.
  const auto count = [&](Vec3<double> where, auto change) {
    SurfacePoint<double> point = base;
    point.own.position = where;
    SeenLight<double> seen = light;
    change(point, seen);
    const auto all = sparkle_at(layer, point, pass_between(layer, point, seen));
    return (all.count - all.mean_count) / std::sqrt(all.mean_count);
  };
  const auto same = [](auto&, auto&) {};
  const auto here = [&](Vec3<double> where) { return count(where, same); };
  const double side = std::sqrt(find_cell(base, layer.cell_share, 0.0, HashKey{}).area);
  const auto shifted = [&](Vec3<double> by) {
    return [&, by](Vec3<double> where) {
      return count(where,
                   [&](auto& point, auto&) { point.own.position = point.own.position + by; });
    };
  };
  std::map<std::string, double> z;
  // Beyond the longest cell that the footprint may ask for, and cells of the usual size 2^17 to
  // 2^20 apart: there may be half as long ones, and the lattice repeats after 2^22.
  z["the next cell"] = correlation_z(random, here, shifted(plane.a * (3 * side)));
  z["the next cell, across"] = correlation_z(random, here, shifted(plane.b * (3 * side)));
  for (const int power : {17, 19, 20}) {
    const double far = std::ldexp(1.0, power + std::ilogb(side));
    for (const Vec3<double> axis : {Vec3<double>{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      z["cells 2^" + std::to_string(power) + " apart along " +
        std::to_string(axis.y + 2 * axis.z)] = correlation_z(random, here, shifted(axis * far));
    }
  }
  z["another level"] = correlation_z(random, here, [&](Vec3<double> where) {
    return count(where, [](auto& point, auto&) { point.footprint *= 16; });
  });
  z["another normal"] = correlation_z(random, here, [&](Vec3<double> where) {
    return count(where,
                 [&](auto& point, auto& seen) { seen = mirrored_at(point, plane, 0.12, 0.00465); });
  });
  z["another instance"] = correlation_z(random, here, [&](Vec3<double> where) {
    return count(where, [](auto& point, auto&) { point.own.instance = 7; });
  });
  z["the other face"] = correlation_z(random, here, [&](Vec3<double> where) {
    return count(where, [](auto& point, auto& seen) {
      point.normal = point.normal * -1.0;
      point.view = point.view * -1.0;
      seen.direction = seen.direction * -1.0L;
    });
  });
  const double threshold = sidak_threshold(kFreshLevel, static_cast<double>(z.size()));
  for (const auto& [name, deviation] : z) EXPECT_LE(std::fabs(deviation), threshold) << name;
  // What the test would find: a sample of the same cell.
  EXPECT_GT(correlation_z(random, here, here), 100);
}

bool alike(HashKey a, HashKey b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

TEST(Anchor, FlakesStayLitWhileTheHalfWayDirectionTurnsByLessThanTheCone) {
  Random random(run_seed() + 2);
  constexpr int kTurns = 40'000;
  for (const double radius : {1e-3, 0.01, 0.07}) {
    const double sin2_half = radius * radius / 4;
    const auto kept = [&](double radii) {
      int same = 0;
      for (int k = 0; k < kTurns; ++k) {
        const Frame frame = any_frame(random);
        const HashKey cell = stream_key(static_cast<int>(random.bits()), 1, 2, 3);
        const double turn = radii * radius;
        const Vec3<double> turned = frame.n * std::cos(turn) + frame.a * std::sin(turn);
        same +=
            alike(about_normal(cell, frame.n, sin2_half), about_normal(cell, turned, sin2_half));
      }
      return same / static_cast<double>(kTurns);
    };
    // The sides are kNormalCell radii on average and a turn crosses 3/2 of a lattice's walls per
    // side; seven standard errors.
    EXPECT_NEAR(kept(0.25), 1 - 1.5 * 0.25 / kNormalCell, 0.015) << radius;
    EXPECT_GT(kept(1), 0.6) << radius;
    EXPECT_EQ(kept(4 * kNormalCell), 0) << radius;
  }
}

// Of two samples of one pixel through Cycles' filter, Blackman and Harris with the width of 1.5
// pixels, which Cycles doubles (filter_table in its scene/film.cpp): flakes of no size have the
// variance m2 lambda/Sigma times the filter's integral of h^2; cells, in which both samples see the
// same, E[1(same cell)/area].
class Filter {
 public:
  Filter() {
    double first = 0, second = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double h = at((i + 0.5) / kSteps);
      first += h / kSteps;
      second += h * h / kSteps;
    }
    const double along = second / (first * first) / kWidth;
    square_ = along * along;
  }
  double square() const { return square_; }  // in two dimensions, 1/pixel^2
  double sample(Random& random) const {
    for (;;) {
      const double t = random.uniform();
      if (random.uniform() < at(t)) return (t - 0.5) * kWidth;
    }
  }

 private:
  static constexpr double kWidth = 3;
  static constexpr int kSteps = 10'000;
  static double at(double t) {
    return 0.35875 - 0.48829 * std::cos(2 * kPi * t) + 0.14128 * std::cos(4 * kPi * t) -
           0.01168 * std::cos(6 * kPi * t);
  }
  double square_ = 0;
};

struct Share {
  double mean, error;
};

Share share_of_variance(Random& random, const Filter& filter, double cells, double aspect) {
  constexpr int kPlanes = 200, kPairs = 1000;
  Moments shares;
  for (int i = 0; i < kPlanes; ++i) {
    const Frame plane = any_frame(random);
    const double footprint = random.log_uniform(1e-9, 1.6e-8), c = 1 / aspect;
    const double turn = random.uniform(0, 2 * kPi), width = std::sqrt(footprint * c);
    const auto cell_of_sample = [&](Vec3<double> pixel) {
      const double x = filter.sample(random), y = filter.sample(random);
      const double across = x * std::cos(turn) - y * std::sin(turn);
      const double along = x * std::sin(turn) + y * std::cos(turn);
      SurfacePoint<double> point = on_plane(plane, c, footprint);
      point.own.position = pixel + plane.b * (across * width) + plane.a * (along * width / c);
      return find_cell(point, 1 / cells, 0.0, HashKey{1, 2, 3});
    };
    double sum = 0;
    for (int k = 0; k < kPairs; ++k) {
      const Vec3<double> pixel =
          plane.a * random.uniform(0, 0.1) + plane.b * random.uniform(0, 0.1);
      const auto one = cell_of_sample(pixel), other = cell_of_sample(pixel);
      if (alike(one.key, other.key)) sum += footprint / one.area;
    }
    shares.add(sum / kPairs / filter.square());
  }
  return {shares.mean(), std::sqrt((shares.variance() - shares.mean() * shares.mean()) / kPlanes)};
}

TEST(Anchor, AFilteredPixelKeepsTheVarianceOfPointFlakes) {
  Random random(run_seed() + 3);
  const Filter filter;
  const std::vector<double> aspects{1, 1.5, 2, 5, 20, 50};
  const double z = sidak_threshold(kFreshLevel, 4.0 * static_cast<double>(aspects.size()));
  const double cells = Paint{}.cells_per_pixel;
  for (const double aspect : aspects) {
    const Share usual = share_of_variance(random, filter, cells, aspect);
    EXPECT_GT(usual.mean + z * usual.error, 0.7) << "aspect " << aspect;
    EXPECT_LT(usual.mean - z * usual.error, 1.05) << "aspect " << aspect;
    const Share fine = share_of_variance(random, filter, 64, aspect);
    EXPECT_GT(fine.mean + z * fine.error, 0.9) << "aspect " << aspect;
    EXPECT_LT(fine.mean - z * fine.error, 1.05) << "aspect " << aspect;
    std::ostringstream text;
    text.precision(3);
    text << usual.mean << " +- " << usual.error << ", finest " << fine.mean << " +- " << fine.error;
    RecordProperty("aspect " + std::to_string(static_cast<int>(10 * aspect)), text.str());
    std::cout << "aspect " << aspect << ": " << text.str() << '\n';
  }
}

TEST(Anchor, ACellHasTheAreaThatASurfaceCutsOutOfIt) {
  Random random(run_seed() + 4);
  for (int i = 0; i < 20; ++i) {
    const Frame plane = any_frame(random);
    const auto base = on_plane(plane, random.uniform(0.1, 1), random.log_uniform(1e-10, 1e-4));
    // Hits on a fine grid of the plane about a point, for the cell there.
    const double reach = 4 * std::sqrt(base.footprint), step = reach / 1000;
    SurfacePoint<double> point = base;
    const Vec3<double> centre =
        plane.a * random.uniform(-1, 1) + plane.b * random.uniform(-1, 1) + plane.n;
    point.own.position = centre;
    const auto cell = find_cell(point, 0.2, 0.0, HashKey{5, 6, 7});
    long hits = 0;
    for (int x = -500; x < 500; ++x) {
      for (int y = -500; y < 500; ++y) {
        point.own.position = centre + plane.a * (x * step) + plane.b * (y * step);
        hits += alike(find_cell(point, 0.2, 0.0, HashKey{5, 6, 7}).key, cell.key);
      }
    }
    // Columns end after 16 sides, and a neighbour's deviate of the other axis may cut a long cell:
    // a cell may lose some of its area, and has no more.
    EXPECT_LT(static_cast<double>(hits) * step * step, 1.05 * cell.area);
    EXPECT_GT(static_cast<double>(hits), 0);
  }
}

TEST(Anchor, CellsTurnWithTheViewAndKeepTheirFlakes) {
  // An observer walks round a slanted plane by a quarter of its footprints' width over their
  // length. So a cell's ends move by an eighth of its width, twice that where it is longest for its
  // footprint: if all of it moved as far, a quarter would change hands.
  Random random(run_seed() + 6);
  constexpr int kPoints = 40'000;
  for (const double aspect : {5.0, 20.0, 50.0}) {
    int kept = 0;
    for (int k = 0; k < kPoints; ++k) {
      const double azimuth = random.uniform(0, 2 * kPi), footprint = random.log_uniform(1e-9, 1e-7);
      const Vec3<double> where{random.uniform(-1, 1), random.uniform(-1, 1), 0};
      const auto key_from = [&](double angle) {
        Frame plane;
        plane.n = {0, 0, 1};
        plane.a = {std::cos(angle), std::sin(angle), 0};
        SurfacePoint<double> point = on_plane(plane, 1 / aspect, footprint);
        point.own.position = where;
        return find_cell(point, 0.2, 0.0, HashKey{9, 10, 11}).key;
      };
      kept += alike(key_from(azimuth), key_from(azimuth + 0.25 / aspect));
    }
    EXPECT_GT(kept, 0.75 * kPoints) << "aspect " << aspect;
    EXPECT_LT(kept, kPoints);
  }
}

TEST(Anchor, AUniformPlaneShowsNoLattice) {
  Random random(run_seed() + 5);
  constexpr int kSize = 64, kSamples = 8, kPlanes = 12;
  const Paint paint = on_surface(3000);
  const Layer<double> layer = make_layer<double>(paint);

  for (int i = 0; i < kPlanes; ++i) {
    const Frame plane = any_frame(random);
    auto point = on_plane(plane, 0.9, 1e-7);
    const auto way = pass_between(layer, point, mirrored_at(point, plane, 0.03, 0.00465));
    std::vector<double> picture(kSize * kSize);
    const double width = std::sqrt(point.footprint * 0.9);
    double mean = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        double sum = 0;
        for (int k = 0; k < kSamples; ++k) {
          point.own.position = plane.b * ((x + random.uniform()) * width) +
                               plane.a * ((y + random.uniform()) * width / 0.9);
          sum += sparkle_at(layer, point, way, 0, i).radiance.y;
        }
        picture[static_cast<std::size_t>(y * kSize + x)] = sum;
        mean += sum / (kSize * kSize);
      }
    }
    for (double& value : picture) value -= mean;
    const auto field = transformed(picture, kSize);
    // Any line of the spectrum would stand out of its neighbours, in the mean of 7 x 7 of which
    // noise is exponential.
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize / 2; ++x) {
        if (x == 0 && y == 0) continue;
        double around = 0;
        int n = 0;
        for (int dy = -3; dy <= 3; ++dy) {
          for (int dx = -3; dx <= 3; ++dx) {
            const int at = ((y + dy + kSize) % kSize) * kSize + (x + dx + kSize) % kSize;
            if ((dx == 0 && dy == 0) || at == 0) continue;
            around += std::norm(field[static_cast<std::size_t>(at)]);
            ++n;
          }
        }
        const double height =
            std::norm(field[static_cast<std::size_t>(y * kSize + x)]) / around * n;
        // P(height > h) = (1 + h/n)^-n: an exponential over the mean of n others.
        const double chance = std::pow(1 + height / n, -n);
        EXPECT_GT(chance * kSize * kSize / 2 * kPlanes, kFreshLevel) << x << ' ' << y;
      }
    }
  }
}

}  // namespace
