// SPDX-License-Identifier: Apache-2.0
//
// The drawn sum of sparkles against compound Poisson and binomial sums that this file draws itself,
// flake by flake with std's distributions, and against moments integrated numerically. Level 1e-6
// for each test as a whole (Sidak's correction within), another seed in each run of --all.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <ostream>
#include <random>
#include <vector>

#include "independent.h"
#include "sparkles.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::chi_square_z;
using core_tests::kFreshLevel;
using core_tests::Moments;
using core_tests::run_seed;
using core_tests::sidak_threshold;
using core_tests::Variances;
using core_tests::Worst;
using Real = long double;

// The law of a pixel's sum: its count, and what one sparkle adds, Y = min(X, fill)/fill e^(-x u)
// with X = max(0, 1 + s w), of which `hidden` hides whole; the mirror cuts the sum.
struct Law {
  double mean_count, area_spread, depth;
  int slots = 0;
  double fill = 1e7;
  double hidden = 0;

  double ceiling() const { return slots > 0 ? 1 : 1e30; }
  // E[Y^power]; u averages e^(-hu) e^(-power (x - h) u).
  Real moment(int power) const {
    return independent::area_moment(area_spread, power, fill) / std::pow(Real(fill), power) *
           independent::averaged(power * Real(depth) - (power - 1) * Real(hidden));
  }
  Real mean() const { return mean_count * moment(1); }
  Real variance() const {
    const Real m = moment(1);
    return mean_count * (moment(2) - (slots > 0 ? mean_count * m * m / slots : 0));
  }
  double fourth() const {
    const auto m = [&](int power) { return static_cast<double>(moment(power)); };
    return core_tests::fourth_moment_of_sum(mean_count, slots, m(1), m(2), m(3), m(4));
  }
};

std::ostream& operator<<(std::ostream& out, const Law& law) {
  return out << "[<N> " << law.mean_count << ", area spread " << law.area_spread << ", depth "
             << law.depth << ", hidden " << law.hidden << ", slots " << law.slots << ", fill "
             << law.fill << ']';
}

// The sums of a law's sparkles in three colours of these depths.
template <class T>
std::vector<Rgb<T>> drawn_colours(const Law& law, std::array<double, 3> depth, int n, int stream) {
  ExpectedSparkles<T> expected;
  expected.mean_count = static_cast<T>(law.mean_count);
  expected.slots = law.slots;
  expected.fill = static_cast<T>(law.fill);
  expected.area = {static_cast<T>(independent::area_moment(law.area_spread, 1, law.fill)),
                   static_cast<T>(independent::area_moment(law.area_spread, 2, law.fill)),
                   static_cast<T>(independent::area_moment(law.area_spread, 3, law.fill))};
  expected.slant = {static_cast<T>(depth[0]), static_cast<T>(depth[1]), static_cast<T>(depth[2])};
  expected.hidden = static_cast<T>(law.hidden);
  expected.transmitted = map(expected.slant, [](T x) { return mean_transmittance(x); });
  expected.mirror = {1, 1, 1};
  expected.ceiling = static_cast<T>(law.ceiling());
  const HashWords key = stream_key(stream, 0, 1, static_cast<int>(run_seed()));
  const T spread = static_cast<T>(law.area_spread);
  std::vector<Rgb<T>> sums;
  for (int i = 0; i < n; ++i) {
    sums.push_back(draw_sparkles(expected, spread, key, i % 1000 - 500, i / 1000).radiance);
  }
  return sums;
}

template <class T>
std::vector<double> drawn(const Law& law, int n, int stream) {
  std::vector<double> sums;
  for (const Rgb<T>& sum : drawn_colours<T>(law, {law.depth, law.depth, law.depth}, n, stream)) {
    sums.push_back(static_cast<double>(sum.y));
  }
  return sums;
}

std::vector<double> flake_by_flake(const Law& law, int n, int seed) {
  std::mt19937_64 engine(run_seed() + static_cast<std::uint64_t>(seed));
  std::poisson_distribution<int> poisson(law.mean_count);
  std::binomial_distribution<int> binomial(std::max(law.slots, 1),
                                           law.slots > 0 ? law.mean_count / law.slots : 0);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<double> sums;
  for (int i = 0; i < n; ++i) {
    const int count = law.slots > 0 ? binomial(engine) : poisson(engine);
    double sum = 0;
    for (int k = 0; k < count; ++k) {
      double area = 1;
      if (law.area_spread > 0) area = std::max(0.0, 1 + law.area_spread * normal(engine));
      const double u = uniform(engine);
      const bool seen = law.hidden == 0 || uniform(engine) < std::exp(-law.hidden * u);
      const double dimmed = std::exp(-(law.depth - law.hidden) * u);
      if (seen) sum += std::min(area, law.fill) / law.fill * dimmed;
    }
    sums.push_back(std::min(sum, law.ceiling()));
  }
  return sums;
}

// n sums' mean in standard errors, their variance to the others.
template <class T>
double mean_deviation(const Law& law, int n, int stream, Variances& variances) {
  const auto variance = static_cast<double>(law.variance());
  Moments sums{static_cast<double>(law.mean())};
  for (double sum : drawn<T>(law, n, stream)) sums.add(sum);
  variances.see(sums.variance(), variance, law.fourth(), n, law);
  return (sums.mean() - sums.centre) / std::sqrt(variance / n);
}

// Chi-square of two samples of one law over cells of as many of the second's values: a cell for 0,
// up to 40 of 25 values or more above it. Equal sums (equal flakes, undimmed) stay in one cell
// however they are rounded.
struct Likeness {
  double chi_square = 0, degrees = 0;
};
Likeness compare(std::vector<double> a, std::vector<double> b) {
  std::sort(b.begin(), b.end());
  const auto positive = std::upper_bound(b.begin(), b.end(), 0.0);
  const auto values = b.end() - positive;
  const auto cells = std::min<std::ptrdiff_t>(40, values / 25);
  std::vector<double> edges;
  for (std::ptrdiff_t k = 0; k < cells; ++k) {
    const double edge = positive[k * values / cells] * (1 - 1e-5);
    if (edges.empty() || edge > edges.back() * (1 + 1e-4)) edges.push_back(edge);
  }
  const auto histogram = [&](const std::vector<double>& sums) {
    std::vector<double> found(edges.size() + 1);
    for (double sum : sums) {
      found[static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), sum) -
                                     edges.begin())] += 1;
    }
    return found;
  };
  const auto in_a = histogram(a), in_b = histogram(b);
  const double ratio = std::sqrt(static_cast<double>(b.size()) / static_cast<double>(a.size()));
  Likeness result;
  double filled = 0;
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    if (in_a[k] + in_b[k] == 0) continue;
    const double d = in_a[k] * ratio - in_b[k] / ratio;
    result.chi_square += d * d / (in_a[k] + in_b[k]);
    filled += 1;
  }
  result.degrees = filled - 1;
  return result;
}

std::vector<Law> laws(std::initializer_list<double> counts) {
  std::vector<Law> made;
  for (double count : counts) {
    for (double spread : {0.0, 0.3, 1.0}) {
      for (double depth : {0.0, 1.0, 5.0}) made.push_back({count, spread, depth});
      for (double hidden : {0.5, 1.8}) made.push_back({count, spread, 3, 0, 1e7, hidden});
    }
  }
  return made;
}

// Layers so deep that few flakes near the surface make the sum: x against 2 <N>.
std::vector<Law> deep_laws() {
  return {{17, 0, 50},
          {24, 0, 200},
          {24, 1, 200},
          {24, 0.3, 30},
          {40, 100, 20},
          {45, 0.5, 12},
          {60, 1, 200},
          {300, 0.3, 40},
          {500, 1, 1e4},
          // What hides, hides whole.
          {24, 0.3, 20, 0, 1e7, 12},
          {60, 0.5, 50, 0, 1e7, 10},
          {300, 0, 40, 0, 1e7, 24}};
}

template <class T>
void expect_like_flake_by_flake(const std::vector<Law>& all, int n) {
  // Below 15 degrees of freedom (equal, undimmed flakes) chi_square_z overstates the tail, by
  // less than a factor of 2.
  const double threshold = sidak_threshold(kFreshLevel, static_cast<double>(all.size()));
  Worst worst;
  int stream = 0;
  for (const Law& law : all) {
    ++stream;
    // A float is black below e^-87, and so is what is below a millionth of the mean.
    const double black = 1e-6 * static_cast<double>(law.mean());
    const auto seen = [black](std::vector<double> sums) {
      for (double& sum : sums) sum = sum < black ? 0 : sum;
      return sums;
    };
    const Likeness found =
        compare(seen(drawn<T>(law, n, stream)), seen(flake_by_flake(law, n, 700 + stream)));
    ASSERT_GE(found.degrees, 1) << law;
    const double z = chi_square_z(found.chi_square, found.degrees);
    EXPECT_LT(std::fabs(z), threshold) << law << " degrees " << found.degrees;
    worst.see(std::fabs(z), "at", law);
  }
  worst.expect_at_most(threshold, "largest_z");
}

TEST(Compound, FewSparklesAreDistributedAsFlakeByFlake) {
  // All but 1e-7 of the sums hold up to 16 sparkles, which are drawn one by one.
  expect_like_flake_by_flake<double>(laws({0.01, 0.5, 3}), 80'000);
}

TEST(Compound, FewSparklesAreDistributedAsFlakeByFlakeInFloat) {
  expect_like_flake_by_flake<float>(laws({0.01, 0.5, 3}), 80'000);
}

TEST(Compound, DozensOfSparklesAreDistributedAsFlakeByFlake) {
  // Beyond 16 sparkles the sum is one deviate with the law's mean, variance and skewness.
  expect_like_flake_by_flake<double>(laws({18, 30, 100, 200}), 20'000);
}

TEST(Compound, DeepLayersAreDistributedAsFlakeByFlake) {
  // Also as often black.
  expect_like_flake_by_flake<double>(deep_laws(), 20'000);
  expect_like_flake_by_flake<float>(deep_laws(), 20'000);
}

// Three colours of one sum: depths that differ little and much, and two that are the same.
struct Colours {
  double mean_count, area_spread;
  std::array<double, 3> depth;
  double hidden;

  Law law(std::size_t c) const { return {mean_count, area_spread, depth[c], 0, 1e7, hidden}; }
  // <N> E[Y_a Y_b].
  double covariance(std::size_t a, std::size_t b) const {
    const Law both{mean_count, area_spread, (depth[a] + depth[b]) / 2, 0, 1e7, hidden};
    return static_cast<double>(both.mean_count * both.moment(2));
  }
};
std::ostream& operator<<(std::ostream& out, const Colours& c) {
  return out << "[<N> " << c.mean_count << ", area spread " << c.area_spread << ", depths "
             << c.depth[0] << ' ' << c.depth[1] << ' ' << c.depth[2] << ", hidden " << c.hidden
             << ']';
}

TEST(Compound, ColoursHaveTheirCovariance) {
  constexpr std::size_t n = 100'000;
  Variances variances(6);
  int stream = 300;
  for (double count : {2.0, 18.0, 25.0, 60.0, 500.0, 1e4}) {
    for (double spread : {0.0, 0.3, 1.0}) {
      for (const auto& depth : {std::array{0.0, 4.0, 8.0}, std::array{2.0, 3.0, 5.0},
                                std::array{0.0, 20.0, 200.0}, std::array{5.0, 1.0, 5.0}}) {
        const double least = std::min({depth[0], depth[1], depth[2]});
        const Colours colours{count, spread, depth, least / 2};
        std::array<Moments, 3> sums;
        std::array<std::array<double, 3>, 3> square{};
        for (std::size_t c = 0; c < 3; ++c) {
          sums[c].centre = static_cast<double>(colours.law(c).mean());
        }
        std::array<std::array<double, 3>, 3> products{};
        for (const Rgb<float>& sum : drawn_colours<float>(colours.law(0), depth, n, ++stream)) {
          const std::array<double, 3> d{sum.x - sums[0].centre, sum.y - sums[1].centre,
                                        sum.z - sums[2].centre};
          for (std::size_t a = 0; a < 3; ++a) {
            sums[a].add(d[a] + sums[a].centre);
            for (std::size_t b = 0; b < a; ++b) {
              products[a][b] += d[a] * d[b];
              square[a][b] += d[a] * d[b] * d[a] * d[b];
            }
          }
        }
        for (std::size_t a = 0; a < 3; ++a) {
          const Law law = colours.law(a);
          variances.see(sums[a].variance(), static_cast<double>(law.variance()), law.fourth(), n,
                        colours);
          for (std::size_t b = 0; b < a; ++b) {
            const double found = products[a][b] / n, exact = colours.covariance(a, b);
            variances.see((found - exact) / std::sqrt((square[a][b] / n - exact * exact) / n),
                          colours);
          }
        }
      }
    }
  }
  variances.expect_chance();
}

TEST(Compound, ColoursOfOneDepthAreOneColour) {
  int stream = 400;
  for (double count : {20.0, 60.0, 1e4}) {
    for (double depth : {0.0, 3.0, 50.0}) {
      const Law law{count, 0.3, depth};
      for (const Rgb<float>& sum :
           drawn_colours<float>(law, {depth, depth, depth}, 2'000, ++stream)) {
        ASSERT_TRUE(sum.x == sum.y && sum.y == sum.z) << law;
      }
      for (const Rgb<float>& sum : drawn_colours<float>(law, {depth, 1, depth}, 2'000, ++stream)) {
        ASSERT_EQ(sum.x, sum.z) << law;
      }
    }
  }
}

// What the clamp at 0 takes where the sum is drawn as one, by integration over the normal deviate:
// at its worst for the least count that is. `part` of the depth hides whole.
struct Cut {
  Worst mean, variance, skewness, black;
};
Cut cut_at_zero(double part) {
  Cut cut;
  for (double spread : {0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 5.0, 100.0}) {
    for (double depth = 0; depth < 2e4; depth = depth * 1.2 + 0.1) {
      ExpectedSparkles<double> expected;
      expected.area = area_moments(spread);
      expected.slant = {depth, depth, depth};
      expected.hidden = part * depth;
      double count = kDrawnSparkles + 1;
      while (drawn_one_by_one(expected, count) > 0) count = std::floor(count * 1.05) + 1;
      const double m = expected.area.mean;
      const SumLaw<double> law =
          sum_law(expected.area.square / (m * m), expected.area.cube / (m * m * m), depth,
                  expected.hidden, count);
      if (!(law.spread > 0)) continue;
      double first = 0, second = 0, third = 0, dark = 0;
      constexpr int kSteps = 2'000;
      for (int i = -kSteps; i <= kSteps; ++i) {
        const double w = 9.0 * i / kSteps;
        const double weight = std::exp(-w * w / 2) / std::sqrt(2 * std::numbers::pi) * 9 / kSteps;
        const double sum = law.mean + law.spread * (w + law.c * (w * w - 1)) / law.root;
        const double d = std::max(sum, 0.0) - law.mean;
        first += weight * d;
        second += weight * d * d;
        third += weight * d * d * d;
        if (sum <= 0) dark += weight;
      }
      const Law exact{count, spread, depth, 0, 1e7, expected.hidden};
      // Of `count` sparkles, no more and no fewer.
      const Real m1 = exact.moment(1), m2 = exact.moment(2), m3 = exact.moment(3);
      const Real variance = (m2 - m1 * m1) / (m1 * m1 * count) * law.mean * law.mean;
      const Real skewness =
          (m3 - 3 * m2 * m1 + 2 * m1 * m1 * m1) / std::pow(m2 - m1 * m1, 1.5L) / std::sqrt(count);
      cut.mean.see(std::fabs(first) / law.mean, exact);
      cut.variance.see(std::fabs(second / variance - 1), exact);
      cut.skewness.see(std::fabs(third / std::pow(second, 1.5) - skewness), exact);
      cut.black.see(dark, exact);
    }
  }
  return cut;
}

TEST(Compound, TheLawOfASumLeavesNothingBelowZero) {
  Cut cut = cut_at_zero(0);
  cut.mean.expect_at_most(1e-6, "mean");
  cut.variance.expect_at_most(2e-5, "variance");
  cut.skewness.expect_at_most(5e-3, "skewness");
  cut.black.expect_at_most(3e-5, "black");
}

TEST(Compound, WhereFlakesHideWholeTheLawOfASumLeavesLittleBelowZero) {
  // The most that hot_spot.h hides so. Of a few flakes hidden among equal ones c ends at 1/4, and
  // the skewness is less than theirs.
  Cut cut = cut_at_zero(0.65);
  cut.mean.expect_at_most(1e-5, "mean");
  cut.variance.expect_at_most(3e-4, "variance");
  cut.skewness.expect_at_most(0.2, "skewness");
  cut.black.expect_at_most(2e-4, "black");
}

std::vector<Law> small_pixels() {
  std::vector<Law> made;
  for (int slots : {1, 2, 5, 15}) {
    for (double spread : {0.0, 0.3, 1.0}) {
      for (double share : {0.05, 0.6})
        made.push_back({share * slots, spread, 1, slots, slots + .3});
    }
  }
  made.push_back({0.02, 0.3, 0, 1, 1e-3});  // far below a flake: the mirror or nothing
  return made;
}

TEST(Compound, PixelsOfFewFlakesAreDistributedAsFlakeByFlake) {
  // Binomial, the sum cut at the mirror.
  expect_like_flake_by_flake<double>(small_pixels(), 40'000);
}

TEST(Compound, NoPixelOfFewFlakesOutshinesTheMirror) {
  int stream = 500;
  for (const Law& law : small_pixels()) {
    for (double sum : drawn<float>(law, 20'000, ++stream)) {
      ASSERT_TRUE(sum >= 0 && sum <= 1) << sum << ' ' << law;
    }
  }
}

TEST(Compound, PixelOfOneFlakeKeepsItsMeanAndVariance) {
  // One place never meets the ceiling: z-tests against integrated moments.
  const int n = 200'000;
  std::vector<Law> all;
  for (double fill : {1e-3, 0.3, 1.0, 1.9}) {
    for (double spread : {0.0, 0.3, 1.0}) {
      for (double share : {0.01, 0.5, 0.97}) all.push_back({share, spread, 1, 1, fill});
    }
  }
  const double threshold = sidak_threshold(kFreshLevel, static_cast<double>(all.size()));
  Variances variances;
  int stream = 600;
  for (const Law& law : all) {
    const double z = mean_deviation<double>(law, n, ++stream, variances);
    EXPECT_LT(std::fabs(z), threshold) << "mean of " << law;
  }
  variances.expect_chance();
}

template <class T>
void expect_mean_and_variance() {
  auto all = laws({0.01, 0.5, 3, 20, 200, 1e4, 3e4});
  for (const Law& law : deep_laws()) all.push_back(law);
  const double threshold = sidak_threshold(kFreshLevel, static_cast<double>(all.size()));
  Variances variances;
  Worst worst;
  int stream = 100;
  for (const Law& law : all) {
    const int n = law.mean_count < 1 ? 200'000 : 20'000;
    const double z = mean_deviation<T>(law, n, ++stream, variances);
    EXPECT_LT(std::fabs(z), threshold) << "mean of " << law;
    worst.see(std::fabs(z), "at", law);
  }
  worst.expect_at_most(threshold, "largest_z_of_a_mean");
  variances.expect_chance();
}

TEST(Compound, AnyCountHasTheMeanAndVarianceOfTheLaw) { expect_mean_and_variance<double>(); }
TEST(Compound, AnyCountHasTheMeanAndVarianceOfTheLawInFloat) { expect_mean_and_variance<float>(); }

TEST(Compound, SumsOfVeryManySparklesFollowTheLawsOwnExpansion) {
  // Edgeworth to the skewness g = m3/(m2^1.5 sqrt <N>): P(z) = Phi(z) - g/6 (z^2 - 1) phi(z), the
  // rest of order 1/<N>. 40 cells of equal normal probability.
  constexpr int kCells = 40, n = 40'000;
  const auto all = laws({1e4, 3e4});
  const double threshold = sidak_threshold(kFreshLevel, static_cast<double>(all.size()));
  int stream = 200;
  for (const Law& law : all) {
    const double mean = static_cast<double>(law.mean());
    const double deviation = static_cast<double>(std::sqrt(law.variance()));
    // The third moment of the area by the same integral over the normal deviate.
    const Real s = law.area_spread;
    const Real cubed =
        s == 0 ? 1
               : independent::integrate(
                     [&](Real w) {
                       const Real x = std::max<Real>(0, 1 + s * w);
                       return x * x * x * std::exp(-w * w / 2) / std::sqrt(2 * independent::kPi);
                     },
                     {-20, -1 / s, 0, 20});
    const Real m3 =
        cubed / std::pow(Real(law.fill), 3) * independent::averaged(3 * Real(law.depth));
    const auto skewness = static_cast<double>(m3 / std::pow(law.moment(2), 1.5L) /
                                              std::sqrt(static_cast<Real>(law.mean_count)));
    const auto cdf = [&](double z) {
      const double phi = std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi);
      return std::erfc(-z / std::numbers::sqrt2) / 2 - skewness / 6 * (z * z - 1) * phi;
    };
    // Equal flakes, undimmed, make sums of whole steps: a cell ends between two of them.
    const double step = 1 / law.fill;
    const bool whole = law.area_spread == 0 && law.depth == 0;
    std::vector<double> edges;
    double low = -8;
    for (int k = 1; k < kCells; ++k) {
      while (std::erfc(-low / std::numbers::sqrt2) / 2 < 1.0 * k / kCells) low += 1e-4;
      double edge = mean + low * deviation;
      if (whole) edge = (std::floor(edge / step) + 0.5) * step;
      edges.push_back(edge);
    }
    std::vector<double> found(kCells), expected;
    for (double sum : drawn<double>(law, n, ++stream)) {
      found[static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), sum) -
                                     edges.begin())] += 1;
    }
    double below = 0;
    for (std::size_t k = 0; k < kCells; ++k) {
      const double upto = k + 1 < kCells ? cdf((edges[k] - mean) / deviation) : 1;
      expected.push_back(n * (upto - below));
      below = upto;
    }
    EXPECT_LT(std::fabs(chi_square_z(found, expected)), threshold) << law;
  }
}

// Mean^2/variance of a law is how many equal flakes would fluctuate like it.
double equal_flakes(const Law& law) {
  return static_cast<double>(law.mean() * law.mean() / law.variance());
}

TEST(Compound, FarAwayTheFluctuationFadesIntoTheMean) {
  // Full up to 32768 equal flakes, none from 65536 on, linear in between; the mean stays.
  const int n = 20'000;
  Variances variances;
  const double threshold = sidak_threshold(kFreshLevel, 36);
  int stream = 900;
  for (double spread : {0.0, 0.5, 2.0}) {
    for (double depth : {0.0, 1.0, 8.0}) {
      for (double flakes : {32'000.0, 36'000.0, 49'152.0, 60'000.0, 66'000.0, 1e6}) {
        Law law{1, spread, depth};
        law.mean_count = flakes / equal_flakes(law);
        const double left = std::clamp(2 - flakes / 32'768, 0.0, 1.0);
        const auto mean = static_cast<double>(law.mean());
        const double deviation = static_cast<double>(std::sqrt(law.variance())) * left;
        Moments sums{mean};
        for (double sum : drawn<double>(law, n, ++stream)) sums.add(sum);
        if (left == 0) {
          EXPECT_NEAR(sums.mean(), mean, 1e-12 * mean) << law;
          EXPECT_LE(sums.variance(), 1e-20 * mean * mean) << law;
          continue;
        }
        EXPECT_LT(std::fabs(sums.mean() - mean), threshold * deviation / std::sqrt(n)) << law;
        variances.see(sums.variance(), deviation * deviation, law.fourth() * std::pow(left, 4), n,
                      law);
      }
    }
  }
  variances.expect_chance();
}

}  // namespace
