// SPDX-License-Identifier: Apache-2.0
//
// Drawn sparkles against their closed form, and of one or two of them against sums that this file
// draws itself, flake by flake: z-tests over random paints, lights and pixels. Level 1e-6 for each
// test as a whole (Sidak's correction within), another seed in each run of --all.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "count_law.h"
#include "scenes.h"
#include "sparkles.h"
#include "support.h"

namespace {

using namespace core_tests;

template <class T>
using Species = std::vector<ExpectedSparkles<T>>;

// All species of a scene's pixel.
template <class T>
Species<T> expect(const TestScene& scene) {
  const Layer<T> layer = scene.layer<T>();
  const Passage<T> way = pass_between(layer, scene.point<T>(), scene.seen<T>());
  Species<T> species;
  for (int i = 0; i < layer.species; ++i) {
    species.push_back(expect_sparkles(layer, layer.flakes[static_cast<std::size_t>(i)],
                                      static_cast<T>(scene.footprint), way));
  }
  return species;
}

// What all of them are expected to do together.
template <class T>
struct Together {
  T mean_count{}, ceiling{};
  Rgb<T> mean{}, variance{};
};
template <class T>
Together<T> together(const Species<T>& species, T contrast = 1) {
  Together<T> all;
  for (const auto& one : species) {
    all.mean_count += one.mean_count;
    all.mean = all.mean + mean_radiance(one);
    all.variance = all.variance + radiance_variance(one, contrast);
    all.ceiling = all.ceiling + one.ceiling;
  }
  return all;
}

template <class T>
Sparkles<T> draw_one(const Species<T>& species, T contrast, HashKey key) {
  Sparkles<T> all;
  int number = 0;
  for (const auto& one : species) {
    const Sparkles<T> drawn = draw_sparkles(one, key, contrast, number);
    EXPECT_LE(max_component(drawn.radiance), one.ceiling);
    all.count += drawn.count;
    all.radiance = all.radiance + drawn.radiance;
    number += kDeviatesOfSpecies;
  }
  return all;
}

struct Drawn {
  Moments count;
  std::array<Moments, 3> radiance;
  double largest = 0, least = 0, at_ceiling = 0;
};

template <class T>
Drawn draw(const Species<T>& species, T contrast, int n, int stream) {
  Drawn drawn;
  const auto all = together(species);
  drawn.count.centre = static_cast<double>(all.mean_count);
  for (int c = 0; c < 3; ++c) {
    drawn.radiance[static_cast<std::size_t>(c)].centre = channel(Rgb<double>(all.mean), c);
  }
  const HashKey key = stream_key(stream, 0, 1, static_cast<int>(run_seed()));
  for (int i = 0; i < n; ++i) {
    const Sparkles<T> s = draw_one(species, contrast, pixel_key(key, i % 1000 - 500, i / 1000, 0));
    drawn.count.add(static_cast<double>(s.count));
    const Rgb<double> radiance(s.radiance);
    const double values[] = {radiance.x, radiance.y, radiance.z};
    for (std::size_t c = 0; c < 3; ++c) {
      drawn.radiance[c].add(values[c]);
      drawn.least = std::min(drawn.least, values[c]);
    }
    const T most = max_component(s.radiance);
    drawn.largest = std::max(drawn.largest, static_cast<double>(most / all.ceiling));
    drawn.at_ceiling += most >= all.ceiling ? 1 : 0;
  }
  return drawn;
}

// Whether the closed form, which knows no ceiling, leaves the sum room below it.
template <class T>
bool stays_below_ceiling(const Species<T>& species) {
  return std::all_of(species.begin(), species.end(), [](const auto& one) {
    const T deviation = std::sqrt(max_component(radiance_variance(one)));
    return one.slots == 1 || max_component(mean_radiance(one)) + 12 * deviation < one.ceiling;
  });
}

// Mean and central moments.
struct Central {
  double mean = 0, second = 0, third = 0, fourth = 0;
};

Central operator+(const Central& a, const Central& b) {  // of independent ones
  return {a.mean + b.mean, a.second + b.second, a.third + b.third,
          a.fourth + b.fourth + 6 * a.second * b.second};
}

// Of values with such probabilities.
Central moments_of(const std::vector<double>& values, const std::vector<double>& probability) {
  Central law;
  for (std::size_t i = 0; i < values.size(); ++i) law.mean += probability[i] * values[i];
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double d = values[i] - law.mean;
    law.second += probability[i] * d * d;
    law.third += probability[i] * d * d * d;
    law.fourth += probability[i] * d * d * d * d;
  }
  return law;
}

// What one sparkle adds in a colour; `relative` is its variance as draw.h has it.
template <class T>
Central moments_of_sparkle(const ExpectedSparkles<T>& one, int colour, double& relative) {
  const long double fill = one.fill, hidden = one.hidden;
  const long double slant = channel(Rgb<double>(one.slant), colour);
  const long double mirror = channel(Rgb<double>(one.mirror), colour) / fill;
  const auto faded = [&](int k) { return independent::averaged(k * slant - (k - 1) * hidden); };
  const auto raw = [&](int k) {
    return static_cast<double>(std::pow(mirror, k) * faded(k) *
                               independent::area_moment(one.area_spread, k, fill));
  };
  const double m = raw(1), m2 = raw(2), m3 = raw(3);
  relative =
      static_cast<double>(std::max(one.area_square * faded(2) / (faded(1) * faded(1)) - 1, 0.0L));
  return {m, m2 - m * m, m3 - m * (3 * m2 - 2 * m * m),
          raw(4) - m * (4 * m3 - m * (6 * m2 - 3 * m * m))};
}

// The drawn sum of a colour as draw.h has it, its gamma sums by integration over w.
template <class T>
Central law_of_sum(const ExpectedSparkles<T>& one, const CountLaw& counts, int colour) {
  double relative[3];
  for (int c = 0; c < 3; ++c) moments_of_sparkle(one, c, relative[c]);
  const double v = relative[colour], most = *std::max_element(relative, relative + 3);
  double ignored;
  const Central y = moments_of_sparkle(one, colour, ignored);
  std::vector<double> weight, means;
  for (double w = -8; w < 8; w += 0.1) weight.push_back(std::exp(-w * w / 2) * 0.039894228);
  std::vector<Central> sums;
  for (const double n : counts.n) {
    Central sum;
    const double others = n - 1, s = std::sqrt(std::max(others, 0.0));
    if (n > 0) sum = y;
    if (others > 0 && others <= 1 + most) {
      sum = sum + Central{others * y.mean, others * y.second, others * s * y.third,
                          others * others * y.fourth};
    } else if (others > 0) {
      std::vector<double> values;
      const double r = v / others;
      for (std::size_t j = 0; j < weight.size(); ++j) {
        const double w = -8 + 0.1 * static_cast<double>(j);
        const double root = std::max(1 - r / 9 + w * std::sqrt(r) / 3, 0.0);
        values.push_back(others * y.mean * root * root * root);
      }
      sum = sum + moments_of(values, weight);
    }
    sums.push_back(sum);
    means.push_back(sum.mean);
  }
  // Whole: of the means, and about them.
  Central law = moments_of(means, counts.probability);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double p = counts.probability[i], d = means[i] - law.mean;
    law.second += p * sums[i].second;
    law.fourth += p * (sums[i].fourth + 4 * d * sums[i].third + 6 * d * d * sums[i].second);
  }
  const double k = counts.scale;
  return {k * law.mean, k * k * law.second, 0, k * k * k * k * law.fourth};
}

// The draws against their own law, and that against the closed form: the mean within 0.48 %, the
// variance within 2.3 %, as those of the count (poisson_test.cpp).
template <class T>
void expect_closed_form(const TestScene& scene, int stream, double threshold, Worst& worst,
                        Variances& variances, Worst& mean_off, Worst& variance_off) {
  const Species<T> species = expect<T>(scene);
  const T contrast = static_cast<T>(scene.paint.sparkle_contrast);
  const int n = 40'000;  // 400 sparkles or more
  const Drawn drawn = draw(species, contrast, n, stream);
  std::array<Central, 3> sums;
  Central count;
  std::ostringstream where;
  for (const auto& one : species) {
    if (!(one.mean_count > 0)) continue;
    const CountLaw counts = law_of_counts(one.mean_count, one.slots);
    where << "<N> " << one.mean_count << ", slots " << one.slots << ", fill " << one.fill << ", ";
    count = count + moments_of(counts.n, counts.probability);
    for (int c = 0; c < 3; ++c) {
      const Central law = law_of_sum(one, counts, c);
      sums[static_cast<std::size_t>(c)] = sums[static_cast<std::size_t>(c)] + law;
      mean_off.see(relative_error(law.mean, channel(Rgb<double>(mean_radiance(one)), c)),
                   where.str(), scene);
      variance_off.see(relative_error(law.second, channel(Rgb<double>(radiance_variance(one)), c)),
                       where.str(), scene);
    }
  }
  where << scene;
  // What shows `left` of a law's fluctuation about the mean of the closed form.
  const auto see = [&](const Moments& found, const Central& law, double left) {
    const double off = (law.mean - found.centre) * left, variance = law.second * left * left;
    const double error = found.mean() - found.centre;
    const double z = variance > 0 ? (error - off) / std::sqrt(variance / n) : 0;
    EXPECT_LT(std::fabs(z), threshold) << "mean, z " << z << ", " << where.str();
    worst.see(std::fabs(z), "stream", stream);
    variances.see(found.variance() - 2 * off * error + off * off, variance,
                  law.fourth * std::pow(left, 4), n, where.str());
  };
  see(drawn.count, count, 1);
  for (std::size_t c = 0; c < 3; ++c) {
    see(drawn.radiance[c], sums[c], static_cast<double>(contrast));
  }
  EXPECT_GE(drawn.least, 0) << scene;
  EXPECT_LE(drawn.largest, 1 + 1e-6) << scene;
}

// A paint of one species or of several of about as many sparkles.
Paint random_species(Random& random, int species) {
  Paint paint = random_paint(random);
  for (int i = 1; i < species; ++i) {
    FlakeSpecies other = random_paint(random);
    other.tilt = paint.tilt;
    other.orientation = paint.orientation;
    paint.more[static_cast<std::size_t>(i - 1)] = other;
  }
  return paint;
}

// As set_count, of all species.
void set_all_counts(TestScene& scene, double count) {
  scene.footprint = 1;
  scene.footprint =
      rounded(std::clamp(count / together(expect<double>(scene)).mean_count, 1e-20, 1e6));
}

TEST(Draws, ContrastDrawsTheRadianceToItsMean) {
  Random random = fresh(44);
  Worst worst;
  int dark = 0;
  for (int k = 0; k < 400; ++k) {
    TestScene scene;
    scene.paint = random_species(random, 1 + k % 3);
    aim(scene, random, 2.5);
    scene.light_sine = random.log_uniform(1e-3, 0.2);
    set_all_counts(scene, random.log_uniform(0.1, 2e5));
    const double contrast = random.uniform(0, 1);
    const auto species = expect<double>(scene);
    if (!stays_below_ceiling(species)) continue;
    const HashKey key = pixel_key(stream_key(0, 0, 0, 1), k, 2, 0);
    const auto all = draw_one(species, 1.0, key), part = draw_one(species, contrast, key);
    EXPECT_EQ(part.count, all.count) << scene;
    const auto full = together(species);
    const double mean = full.mean.y;
    const double blended = mean + contrast * (all.radiance.y - mean);
    worst.see(relative_error(part.radiance.y, blended), scene);
    EXPECT_NEAR(together(species, contrast).variance.y, contrast * contrast * full.variance.y,
                1e-12 * full.variance.y);
    dark += all.count == 0 && part.radiance.y > 0 ? 1 : 0;

    const auto none = draw_one(species, 0.0, key);
    if (species.size() == 1) {
      EXPECT_EQ(none.count, std::floor(full.mean_count + 0.5));
    }
    EXPECT_EQ(none.radiance.y, mean);
    EXPECT_EQ(together(species, 0.0).variance.y, 0);
  }
  EXPECT_GT(dark, 10);
  worst.expect_at_most(1e-10);
}

TEST(Draws, RadianceHasItsMeanAndVariance) {
  Random random = fresh(45);
  Worst worst, mean_off, variance_off;
  Variances variances(4);
  const int scenes = 216;
  const double threshold = sidak_threshold(kFreshLevel, scenes * 4);
  for (int k = 0; k < scenes;) {
    TestScene scene;
    scene.paint = random_species(random, 1 + k % 5 % 3);
    // All eighteen combinations in turn.
    scene.paint.depth_model = static_cast<DepthModel>(k % 3);
    scene.paint.radiometry = static_cast<Radiometry>(k / 3 % 2);
    scene.paint.orientation = static_cast<Orientation>(k / 6 % 3);
    scene.paint.flake_area_spread = rounded(std::array{0.0, 0.3, 0.8, 2.0}[k / 18 % 4]);
    scene.paint.sparkle_contrast = k < scenes / 2 ? 1 : rounded(0.4);
    aim(scene, random, 2.5);
    scene.light_sine = rounded(random.log_uniform(1e-3, 0.2));
    scene = rounded(scene);
    if (random.below(4) == 0) {
      // A pixel between a thousandth of a flake and ten flakes.
      scene.footprint =
          rounded(scene.layer<double>().flakes[0].flake_area * random.log_uniform(1e-3, 10));
    } else {
      // Every other of few sparkles, where the law of the count is the least exact.
      set_all_counts(scene, random.log_uniform(0.01, random.below(2) == 0 ? 10 : 1e6));
    }
    const auto species = expect<double>(scene);
    // Rarer sparkles would need more draws than the test can afford.
    const bool rare = std::any_of(species.begin(), species.end(),
                                  [](const auto& one) { return one.mean_count < 0.01; });
    if (rare) continue;
    if (!stays_below_ceiling(species)) continue;
    if (random.below(2) == 0) {
      expect_closed_form<double>(scene, k, threshold, worst, variances, mean_off, variance_off);
    } else {
      expect_closed_form<float>(scene, k, threshold, worst, variances, mean_off, variance_off);
    }
    ++k;
  }
  worst.expect_at_most(threshold, "largest_z_of_a_mean");
  mean_off.expect_at_most(0.0048, "mean");
  variance_off.expect_at_most(0.0235, "variance");
  variances.expect_chance();
}

TEST(Draws, OthersKeepTheirMeanAndVariance) {
  // Of gamma sums, over all of their deviate, as draw.h states them.
  Worst mean, variance;
  for (double v = 0.01; v < 100; v *= 1.5) {
    ExpectedSparkles<double> expected;
    expected.area_square = 1 + v;
    for (double others = std::floor(1 + v) + 1; others < 1e4; others = std::ceil(others * 1.3)) {
      double weights = 0, first = 0, second = 0;
      for (double w = -5; w < 8; w += 0.01) {
        const auto u = static_cast<float>(std::erfc(w / std::numbers::sqrt2) / 2);
        const double sum = sum_of_others(expected, others, {0, 0, u}, {}).x / others - 1;
        const double weight = std::exp(-w * w / 2);
        weights += weight;
        first += weight * sum;
        second += weight * sum * sum;
      }
      const double r = v / others, off = first / weights;
      mean.see(std::fabs(off + r * r * r / 729), "v", v, "others", others);
      variance.see(std::fabs((second / weights - off * off) / r - 1), "v", v, "others", others);
    }
  }
  mean.expect_at_most(1e-4, "mean");
  variance.expect_at_most(4.1e-3, "variance");  // measured: 0.40 %
}

// Chi-square of two samples of one law over cells of as many of the second's values: a cell for 0,
// up to 40 of 25 values or more above it. Equal sums (equal flakes, undimmed) stay in one cell
// however they are rounded.
double likeness_z(const std::vector<double>& a, std::vector<double> b) {
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
  double chi_square = 0, degrees = -1;
  for (std::size_t k = 0; k < in_a.size(); ++k) {
    if (in_a[k] + in_b[k] == 0) continue;
    chi_square += (in_a[k] - in_b[k]) * (in_a[k] - in_b[k]) / (in_a[k] + in_b[k]);
    degrees += 1;
  }
  return degrees > 0 ? chi_square_z(chi_square, degrees) : 0;
}

template <class T>
void expect_like_flake_by_flake(std::uint64_t stream) {
  // Of every scene one sparkle and two, each colour. Below 15 degrees of freedom (equal, undimmed
  // flakes) chi_square_z overstates the tail, by less than a factor of 2.
  constexpr int kScenes = 36, kDraws = 60'000;
  const double threshold = sidak_threshold(kFreshLevel, 6 * kScenes);
  Random random = fresh(stream);
  std::mt19937_64 engine(run_seed() + stream);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  Worst worst;
  int compared = 0;
  for (int k = 0; k < kScenes; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    scene.paint.flake_area_spread = rounded(std::array{0.0, 0.3, 1.0}[k % 3]);
    scene.paint.depth_model = static_cast<DepthModel>(k / 3 % 3);
    if (k % 2 == 0) scene.paint.binder_absorption_per_mm = {0, 100, 1000};  // deep layers
    aim(scene, random, 2.5);
    scene.light_sine = rounded(random.log_uniform(1e-3, 0.2));
    set_count(scene, random.log_uniform(0.3, 2));
    if (k % 4 == 0) {  // a pixel that a flake or two fill
      scene.footprint =
          rounded(scene.layer<double>().flakes[0].flake_area * random.uniform(0.1, 3));
    }
    const ExpectedSparkles<T> expected = scene.expect<T>();
    const auto scale =
        static_cast<double>(draw_count(expected.mean_count, expected.slots, T(0x1p-33)).scale);
    const auto fill = static_cast<double>(expected.fill);
    const auto hidden = static_cast<double>(expected.hidden);
    const HashKey key = stream_key(k, 0, 1, static_cast<int>(run_seed()));
    for (const double number : {1.0, 2.0}) {
      std::array<std::vector<double>, 3> drawn, own;
      for (int i = 0; i < kDraws; ++i) {
        const auto sparkles = draw_sparkles(expected, pixel_key(key, i % 1000, i / 1000, 0));
        if (static_cast<double>(sparkles.count) != number) continue;
        std::array<double, 3> sums{};
        for (int flake = 0; flake < static_cast<int>(number); ++flake) {
          const double area =
              std::max(0.0, 1 + static_cast<double>(expected.area_spread) * normal(engine));
          const double u = uniform(engine);
          if (uniform(engine) > std::exp(-hidden * u)) continue;
          for (int c = 0; c < 3; ++c) {
            sums[static_cast<std::size_t>(c)] +=
                channel(Rgb<double>(expected.mirror), c) * std::min(area, fill) / fill *
                std::exp((hidden - channel(Rgb<double>(expected.slant), c)) * u);
          }
        }
        for (std::size_t c = 0; c < 3; ++c) {
          const int colour = static_cast<int>(c);
          // A float is black below e^-87, and so is what is below a millionth of an undimmed flake.
          const double least =
              1e-6 * channel(Rgb<double>(expected.mirror), colour) / std::max(fill, 1.0);
          const double found = channel(Rgb<double>(sparkles.radiance), colour);
          const double sum = std::min(sums[c] * scale, static_cast<double>(expected.ceiling));
          drawn[c].push_back(found < least ? 0 : found);
          own[c].push_back(sum < least ? 0 : sum);
        }
      }
      for (std::size_t c = 0; c < 3; ++c) {
        if (drawn[c].size() < 500) continue;
        ++compared;
        const double z = likeness_z(drawn[c], own[c]);
        EXPECT_LT(std::fabs(z), threshold) << number << " of " << scene << " colour " << c;
        worst.see(std::fabs(z), number, "of", scene);
      }
    }
  }
  EXPECT_GT(compared, 100);
  worst.expect_at_most(threshold, "largest_z");
}

TEST(Draws, UpToTwoSparklesAreDistributedAsFlakeByFlake) {
  expect_like_flake_by_flake<double>(47);
  expect_like_flake_by_flake<float>(48);
}

TEST(Draws, RareSparklesAreAsRareAsTheyShouldBe) {
  // Two deviates decide: some 50 sparkles of 50 million pixels.
  Species<float> species(1);
  species[0].mean_count = 0.99f * static_cast<float>(kRareCount);
  species[0].mirror = {1, 1, 1};
  species[0].ceiling = 1;
  constexpr int kPixels = 50'000'000;
  const HashKey stream = stream_key(1, 2, 3, static_cast<int>(run_seed()));
  double found = 0;
  for (int i = 0; i < kPixels; ++i) {
    const HashKey at = stream + HashKey{wrapped(i), wrapped(i >> 22), 0};
    found += static_cast<double>(draw_one(species, 1.0f, at).count);
  }
  const double expected = 1.0 * kPixels * static_cast<double>(species[0].mean_count);
  EXPECT_NEAR(found, expected, 6 * std::sqrt(expected));  // by chance once in 3e7 runs
}

TEST(Draws, SumIsNeverNegativeNorAboveTheCeiling) {
  Random random = fresh(42);
  for (int k = 0; k < 300; ++k) {
    TestScene scene;
    scene.paint = random_species(random, 1 + k % 3);
    scene.paint.flake_area_spread = rounded(random.log_uniform(0.1, 100));
    scene.paint.binder_absorption_per_mm = {0, 100, 1000};
    aim(scene, random, 4);
    scene.light_sine = random.log_uniform(1e-3, 1);
    set_all_counts(scene, random.log_uniform(0.1, 1e4));
    for (const Drawn& drawn :
         {draw(expect<double>(scene), 1.0, 500, k), draw(expect<float>(scene), 1.0f, 500, k)}) {
      EXPECT_GE(drawn.least, 0) << scene;
      EXPECT_LE(drawn.largest, 1 + 1e-6) << scene;
    }
  }
}

TEST(Draws, CeilingCostsLittleOfTheMeanWhereFlakesJustFit) {
  // Two to fifteen places, flakes of 30 % spread: large ones together may exceed the mirror and are
  // cut, which the closed form does not know. The share of the mean that this takes, less five
  // standard errors of it, which one of the 54 exceeds by chance in one run of 60,000: nothing that
  // shows unless most places are taken.
  Worst sparse, dense;
  for (double places : {1.2, 2.001, 2.5, 3.001, 4.001, 6.001, 8.001, 12.001, 15.5}) {
    for (double share : {0.01, 0.05, 0.2, 0.5, 0.8, 0.95}) {
      TestScene scene;
      scene.paint.flake_area_spread = 0.3;
      scene.paint.flake_color = scene.paint.flake_edge_color = {0.9, 0.9, 0.9};
      scene.paint.depth_model = DepthModel::thinned;
      scene.normal = {0, 0, 1};
      scene.view = {0.5, 0, std::sqrt(0.75)};
      scene.light = {-0.5, 0, std::sqrt(0.75)};
      scene.light_sine = 0.02;
      scene.footprint = 1e-10;
      scene.footprint = places * 1e-10 / scene.expect<double>().fill;
      auto expected = scene.expect<double>();
      expected.mean_count = share * places;
      if (expected.mean_count > expected.slots) continue;  // overlapping: Poisson, see below
      const int n = share <= 0.05 ? 400'000 : 50'000;      // few of them sparkle
      const Drawn drawn = draw(Species<double>{expected}, 1.0, n, static_cast<int>(places * 10));
      const double mean = mean_radiance(expected).x;
      const double error = drawn.radiance[0].error_of_mean() / mean;
      (share <= 0.05 ? sparse : dense)
          .see(std::max(0.0, 1 - drawn.radiance[0].mean() / mean - 5 * error), "places", places,
               "<N>/places", share, "cut", drawn.at_ceiling);
    }
  }
  sparse.expect_at_most(2e-3, "up_to_a_twentieth_taken");
  dense.expect_at_most(0.05, "up_to_all_taken");
}

TEST(Draws, OverlappingSparklesShowNoMoreThanTheMirror) {
  // More sparkles than places: the drawn mean falls short of the closed form, never beyond it.
  TestScene scene;
  scene.paint.flake_color = scene.paint.flake_edge_color = {1, 1, 1};
  scene.normal = scene.view = scene.light = {0, 0, 1};
  scene.light_sine = 0.5;
  scene.paint.flakes_per_mm2 = 1e6;
  scene.footprint = 1e-8;
  const auto expected = scene.expect<double>();
  ASSERT_GT(expected.mean_count * expected.area_mean, expected.fill) << "no overlap to test";
  const Drawn drawn = draw(Species<double>{expected}, 1.0, 20'000, 5);
  EXPECT_LE(drawn.largest, 1);
  EXPECT_LE(drawn.radiance[0].mean(), mean_radiance(expected).x * 1.01);
}

TEST(Draws, ColoursOfOneSparkleFollowTheirOwnDepths) {
  // A single sparkle is dimmed by e^(-x u) in each colour with one depth u.
  Random random = fresh(43);
  for (int k = 0; k < 2'000; ++k) {
    ExpectedSparkles<double> expected;
    expected.mean_count = 0.5;
    expected.slots = 1;
    expected.fill = 100;
    expected.slant = {0, random.uniform(0.1, 2), random.uniform(2, 5)};
    expected.mirror = {1, 1, 1};
    expected.ceiling = 1;
    const auto drawn = draw_sparkles(expected, stream_key(0, 0, k, 0));
    if (drawn.count == 0) continue;
    const double u_green = -std::log(drawn.radiance.y / drawn.radiance.x) / expected.slant.y;
    const double u_blue = -std::log(drawn.radiance.z / drawn.radiance.x) / expected.slant.z;
    EXPECT_NEAR(u_green, u_blue, 1e-9);
    EXPECT_GT(u_green, 0);
    EXPECT_LT(u_green, 1);
    EXPECT_DOUBLE_EQ(drawn.radiance.x, 0.01);
  }
}

}  // namespace
