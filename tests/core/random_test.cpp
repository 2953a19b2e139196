// SPDX-License-Identifier: Apache-2.0
//
// The hash as a source of random numbers. Statistical tests use fixed keys, for which it always
// draws the same, and level 1e-3 for each test as a whole (Sidak's correction within).
#include "random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <tuple>
#include <vector>

#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::chi_square_z;
using core_tests::fresh;
using core_tests::kLevel;
using core_tests::Random;
using core_tests::sidak_threshold;
using core_tests::Worst;

std::array<std::uint32_t, 4> words(HashWords h) { return {h.x, h.y, h.z, h.w}; }

using Words = std::array<std::uint32_t, 4>;

TEST(Random, HashGivesThePublishedBits) {
  // From an evaluation of pcg4d in Python's integers.
  const std::pair<Words, Words> known[] = {
      {{0, 0, 0, 0}, {0x0f02f829u, 0x2d568769u, 0x32b0c43bu, 0xd32548eau}},
      {{1, 2, 3, 4}, {0x3622cd16u, 0xf11471d8u, 0xe1109b3fu, 0x02b94c2fu}},
      {{0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu},
       {0x974ed892u, 0xc015dc67u, 0x9f955760u, 0xa1bba208u}},
      {{0x80000000u, 0, 1, 0x7fffffffu}, {0x657a6e0cu, 0x23fd5de6u, 0x7db63ff2u, 0xb51ada6fu}},
      {{1920, 0u - 1080, 7, 42}, {0xd76b3447u, 0xd2fff59au, 0xd9b2680eu, 0x55461155u}},
  };
  for (const auto& [in, out] : known) {
    EXPECT_EQ(words(pcg4d({in[0], in[1], in[2], in[3]})), out) << "input " << in[0];
  }
}

TEST(Random, DrawsOfAPixelAreTheDocumentedHash) {
  const HashWords key = stream_key(2, 1, 250, -7);
  EXPECT_EQ(words(key), (Words{0x8498c7f8u, 0x450e1ee4u, 0xf8a7af48u, 0x644cd0e0u}));
  EXPECT_EQ(words(draw_words(key, -5, 123456, 3)),
            (Words{0x7fab04fcu, 0x0ec0fa03u, 0x24d25db0u, 0x40ce9ff2u}));
}

TEST(Random, DrawsDependOnNothingButTheirIntegers) {
  const HashWords key = stream_key(0, 0, 1, 0);
  const Words first = words(draw_words(key, 10, 20, 0));
  for (int i = 0; i < 100; ++i) draw_words(key, i, -i, i);
  EXPECT_EQ(words(draw_words(stream_key(0, 0, 1, 0), 10, 20, 0)), first);
}

TEST(Random, UniformsAreTheMiddlesOf2To48EqualSteps) {
  // In double exactly: so a probability p is met to 2^-48, 3.6e-15, whatever p is.
  Random random = fresh(3);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint64_t m = i == 0   ? 0
                            : i == 1 ? (1ull << 48) - 1
                                     : (random.bits() >> 16) >> random.below(48);
    const auto high = static_cast<std::uint32_t>(m >> 24) << 8 | (random.bits() & 255u);
    const auto low = static_cast<std::uint32_t>(m & 0xffffffu) << 8 | (random.bits() & 255u);
    const long double exact = (static_cast<long double>(m) + 0.5L) * 0x1p-48L;
    const auto h = static_cast<std::uint32_t>(high), l = static_cast<std::uint32_t>(low);
    ASSERT_EQ(uniform_48<double>(h, l), exact) << "m " << m;
    // A float keeps 24 bits of it, however small it is: twice rounded.
    ASSERT_LE(std::fabs(uniform_48<float>(h, l) - exact), exact * 0x1.8p-24L) << "m " << m;
  }
}

TEST(Random, UniformsAreNeverZeroAndAtMostOne) {
  EXPECT_EQ(uniform_48<float>(0, 0), 0x1p-49f);
  EXPECT_EQ(uniform_48<double>(0, 0), 0x1p-49);
  EXPECT_EQ(uniform_48<float>(0xffffffffu, 0xffffffffu), 1.0f);
  EXPECT_EQ(uniform_48<double>(0xffffffffu, 0xffffffffu), 1 - 0x1p-49);
  EXPECT_EQ(uniform_23<float>(0), 0x1p-24f);
  EXPECT_EQ(uniform_23<float>(0xffffffffu), 1 - 0x1p-24f);
  EXPECT_EQ(uniform_23<double>(0xffffffffu), 1 - 0x1p-24);
}

TEST(Random, DepthUniformsAreTheSameInFloatAndDouble) {
  Random random = fresh(5);
  for (int i = 0; i < 100'000; ++i) {
    const auto word = static_cast<std::uint32_t>(random.bits());
    ASSERT_EQ(static_cast<double>(uniform_23<float>(word)), uniform_23<double>(word));
  }
}

TEST(Random, EveryBitIsSetHalfTheTime) {
  constexpr int kSide = 1024;
  const double threshold = sidak_threshold(kLevel, 4 * 128);
  int stream = 0;
  for (const HashWords key : {stream_key(0, 0, 0, 0), stream_key(0, 0, 1, 0),
                              stream_key(7, 0, -1, 12345), HashWords{0, 0, 0, 0}}) {
    std::array<int, 128> ones{};
    for (int y = -kSide / 2; y < kSide / 2; ++y) {
      for (int x = -kSide / 2; x < kSide / 2; ++x) {
        const Words w = words(draw_words(key, x, y, 0));
        for (std::size_t bit = 0; bit < 128; ++bit) {
          ones[bit] += static_cast<int>((w[bit / 32] >> (bit % 32)) & 1u);
        }
      }
    }
    const double n = kSide * kSide;
    for (std::size_t bit = 0; bit < 128; ++bit) {
      EXPECT_LT(std::fabs(ones[bit] - n / 2) / std::sqrt(n / 4), threshold)
          << "stream " << stream << " bit " << bit;
    }
    ++stream;
  }
}

// The four deviates that a draw uses: count or area, normal, depth; and the last word.
std::array<double, 4> uniforms(HashWords h) {
  return {uniform_48<double>(h.x, h.y), uniform_48<double>(h.z, h.w), uniform_23<double>(h.z),
          uniform_23<double>(h.w)};
}

TEST(Random, DeviatesFillTheirIntervalEvenly) {
  constexpr int kSide = 1024, kBins = 4096;
  const double threshold = sidak_threshold(kLevel, 5 * 4);
  for (int frame = -2; frame <= 2; ++frame) {
    const HashWords key = stream_key(1, 0, frame, 3);
    std::array<std::vector<double>, 4> bins;
    bins.fill(std::vector<double>(kBins));
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const auto u = uniforms(draw_words(key, x, y, 0));
        for (std::size_t k = 0; k < 4; ++k) bins[k][static_cast<std::size_t>(u[k] * kBins)] += 1;
      }
    }
    const std::vector<double> expected(kBins, 1.0 * kSide * kSide / kBins);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT(std::fabs(chi_square_z(bins[k], expected)), threshold)
          << "frame " << frame << " deviate " << k;
    }
  }
}

TEST(Random, NeighboursInEveryCoordinateAreUncorrelated) {
  // Against the neighbour in x, y, both, at a power of two, mirrored, in light, species, frame,
  // seed, draw: product-moment correlation, and joint chi-square over 32 x 32 cells.
  struct At {
    int x, y, light, species, frame, seed, draw;
  };
  const std::pair<const char*, std::function<At(At)>> neighbours[] = {
      {"x + 1", [](At a) { return At{a.x + 1, a.y, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"y + 1", [](At a) { return At{a.x, a.y + 1, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"x + 1, y + 1",
       [](At a) { return At{a.x + 1, a.y + 1, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"x + 1024",
       [](At a) { return At{a.x + 1024, a.y, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"y + 65536",
       [](At a) { return At{a.x, a.y + 65536, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"-x", [](At a) { return At{-a.x - 1, a.y, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"x and y swapped",
       [](At a) { return At{a.y, a.x + 2048, a.light, a.species, a.frame, a.seed, a.draw}; }},
      {"light + 1",
       [](At a) { return At{a.x, a.y, a.light + 1, a.species, a.frame, a.seed, a.draw}; }},
      {"species + 1",
       [](At a) { return At{a.x, a.y, a.light, a.species + 1, a.frame, a.seed, a.draw}; }},
      {"frame + 1",
       [](At a) { return At{a.x, a.y, a.light, a.species, a.frame + 1, a.seed, a.draw}; }},
      {"seed + 1",
       [](At a) { return At{a.x, a.y, a.light, a.species, a.frame, a.seed + 1, a.draw}; }},
      {"draw + 1",
       [](At a) { return At{a.x, a.y, a.light, a.species, a.frame, a.seed, a.draw + 1}; }},
      {"next frame, previous seed",
       [](At a) { return At{a.x, a.y, a.light, a.species, a.frame + 1, a.seed - 1, a.draw}; }},
  };
  const auto draw = [](At a) {
    return uniforms(draw_words(stream_key(a.light, a.species, a.frame, a.seed), a.x, a.y, a.draw));
  };
  constexpr int kSide = 512, kCells = 32;
  const double n = kSide * kSide;
  const double threshold = sidak_threshold(kLevel, static_cast<double>(std::size(neighbours)) * 8);
  for (const auto& [name, move] : neighbours) {
    std::array<double, 4> product{};
    std::array<std::vector<double>, 4> cells;
    cells.fill(std::vector<double>(kCells * kCells));
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const At here{x, y, 0, 0, 1, 0, 0};
        const auto a = draw(here), b = draw(move(here));
        for (std::size_t k = 0; k < 4; ++k) {
          product[k] += (a[k] - 0.5) * (b[k] - 0.5) * 12;
          cells[k][static_cast<std::size_t>(a[k] * kCells) * kCells +
                   static_cast<std::size_t>(b[k] * kCells)] += 1;
        }
      }
    }
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT(std::fabs(product[k]) / std::sqrt(n), threshold) << name << ", deviate " << k;
      const std::vector<double> expected(kCells * kCells, n / (kCells * kCells));
      EXPECT_LT(std::fabs(chi_square_z(cells[k], expected)), threshold)
          << name << ", deviate " << k;
    }
  }
}

TEST(Random, DeviatesOfOneDrawAreUncorrelated) {
  constexpr int kSide = 1024;
  const HashWords key = stream_key(0, 0, 1, 0);
  double count_normal = 0, area_depth = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto u = uniforms(draw_words(key, x, y, 0));
      count_normal += (u[0] - 0.5) * (u[1] - 0.5) * 12;
      area_depth += (u[0] - 0.5) * (u[2] - 0.5) * 12;
    }
  }
  const double threshold = sidak_threshold(kLevel, 2);
  EXPECT_LT(std::fabs(count_normal) / kSide, threshold);
  EXPECT_LT(std::fabs(area_depth) / kSide, threshold);
}

TEST(Random, NoTwoStreamsShareTheirDraws) {
  // Streams with the same z and nearly the same w would repeat each other's pixels, shuffled.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> keys;
  for (int light = 0; light < 8; ++light) {
    for (int species = 0; species < 4; ++species) {
      for (int frame = -10; frame < 250; ++frame) {
        for (int seed = -5; seed < 45; ++seed) {
          const HashWords key = stream_key(light, species, frame, seed);
          keys.emplace_back(key.z, key.w);
        }
      }
    }
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 1; i < keys.size(); ++i) {
    ASSERT_FALSE(keys[i].first == keys[i - 1].first && keys[i].second - keys[i - 1].second < 20)
        << "z " << keys[i].first;
  }
}

TEST(Random, RareEventsHappenAsOftenAsTheyShould) {
  // 1e8 hashes, two deviates of each, in float as in the shader. Counts are Poisson; level 1e-3.
  constexpr int kRows = 10'000, kColumns = 10'000;
  const float probability[] = {1e-4f, 1e-6f, 1e-7f};
  std::array<double, 3> found{};
  const HashWords key = stream_key(3, 0, 17, 1);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const HashWords h = draw_words(key, x - 5000, y, 0);
      const float u = uniform_48<float>(h.x, h.y), v = uniform_48<float>(h.z, h.w);
      if (u >= probability[0] && v >= probability[0]) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        found[k] += (u < probability[k] ? 1 : 0) + (v < probability[k] ? 1 : 0);
      }
    }
  }
  const double threshold = sidak_threshold(kLevel, 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const double expected = 2.0 * kRows * kColumns * static_cast<double>(probability[k]);
    EXPECT_LT(std::fabs(found[k] - expected) / std::sqrt(expected), threshold)
        << "probability " << probability[k] << ": " << found[k] << " of " << expected;
  }
}

TEST(Random, ProbabilityOf1e9thIsResolved) {
  // How many of the 2^48 deviates lie under it: exact to one step in double, and in float, whose
  // rounding moves single steps over the threshold only.
  for (const double p : {1e-9, 1e-12, 3e-7}) {
    const auto steps = [&](auto type) {
      using T = decltype(type);
      std::uint64_t low = 0, high = 1ull << 48;  // first m whose deviate is not under p
      while (low < high) {
        const std::uint64_t m = (low + high) / 2;
        const auto u = uniform_48<T>(static_cast<std::uint32_t>(m >> 24) << 8,
                                     static_cast<std::uint32_t>(m & 0xffffffu) << 8);
        if (u < static_cast<T>(p)) {
          low = m + 1;
        } else {
          high = m;
        }
      }
      return static_cast<double>(low) * 0x1p-48;
    };
    EXPECT_NEAR(steps(0.0), p, 0x1p-48);
    EXPECT_NEAR(steps(0.0f) / p, 1, 1.3e-7 + 0x1p-48 / p) << "p " << p;
  }
}

}  // namespace
