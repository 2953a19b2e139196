// SPDX-License-Identifier: Apache-2.0
//
// The hash as a source of random numbers. Statistical tests use fixed keys, for which it always
// draws the same, and level 1e-3 for each test as a whole (Sidak's correction within).
#include "random.h"

#include <algorithm>
#include <array>
#include <bit>
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

std::array<float, 3> values(Vec3<float> v) { return {v.x, v.y, v.z}; }

// The deviates of a draw of a pixel.
std::array<float, 3> deviates(HashKey stream, int x, int y, int draw) {
  return values(uniform_deviates(pixel_key(stream, x, y, 0), static_cast<float>(draw)));
}

TEST(Random, HashGivesThePublishedBits) {
  // From Jenkins' hashword, of four words with the start value 13, in Python's integers.
  using Words = std::array<std::uint32_t, 4>;
  const std::pair<Words, std::uint32_t> known[] = {
      {{0, 0, 0, 0}, 0x1c900bccu},
      {{1, 2, 3, 4}, 0x0584dec1u},
      {{0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu}, 0xe69a7d06u},
      {{0x80000000u, 0, 1, 0x7fffffffu}, 0x90bf6d5bu},
  };
  for (const auto& [in, out] : known) {
    EXPECT_EQ(lookup3(in[0], in[1], in[2], in[3]), out) << "input " << in[0];
  }
  // Blender's White Noise of (1, 2, 3) and 4.
  const std::array<float, 3> noise{0.0847689733f, 0.470878571f, 0.622283518f};
  EXPECT_EQ(hash_value(1, 2, 3, 4), noise[0]);
  EXPECT_EQ(values(uniform_deviates({1, 2, 3}, 4)), noise);
}

TEST(Random, DrawsOfAPixelAreTheDocumentedHash) {
  // From the same evaluation in Python.
  const HashKey stream = stream_key(2, 1, 250, -7);
  EXPECT_EQ(values(stream), (std::array{1729915.0f, 3780734.0f, 4098083.0f}));
  EXPECT_EQ(values(pixel_key(stream, -5, 123456, 3)),
            (std::array{815505.0f, 3926784.0f, 531441.0f}));
  EXPECT_EQ(values(uniform_deviates({815505, 3926784, 531441}, 1)),
            (std::array{0.23595792f, 0.30150488f, 0.149468780f}));
}

TEST(Random, WholeNumbersCountModulo2To22) {
  Random random = fresh(3);
  for (int i = 0; i < 100'000; ++i) {
    const auto any = static_cast<int>(random.bits());
    const int turns = random.below(512) << 22;
    const auto other = static_cast<int>(static_cast<unsigned>(any) + static_cast<unsigned>(turns));
    const float w = wrapped(any);
    ASSERT_TRUE(w >= 0 && w < 0x1p22f && w == std::floor(w) && !std::signbit(w)) << any;
    ASSERT_EQ(wrapped(other), w) << any;
    ASSERT_EQ(wrapped(static_cast<double>(any)), w) << any;
    const int of_float = any >> 8;  // a float holds it
    ASSERT_EQ(wrapped(static_cast<float>(of_float)), wrapped(of_float)) << of_float;
  }
  for (double huge : {1e15, -1e20, 1e30, -1e300, std::numeric_limits<double>::infinity()}) {
    const float w = wrapped(huge), f = wrapped(static_cast<float>(huge));
    EXPECT_TRUE(w >= 0 && w < 0x1p22f && f >= 0 && f < 0x1p22f) << huge;
  }
  EXPECT_EQ(values(stream_key(0, 5, 1, 2)), values(stream_key(1 << 22, 5 - (1 << 22), 1, 2)));
}

TEST(Random, UniformsAreNeverZeroNorOne) {
  // The first inputs whose hash is 0 and rounds to 1.
  EXPECT_EQ(hash_value(3284799, 0, 0, 2379), 0.0f);
  EXPECT_EQ(uniform_deviate(3284799, 0, 0, 2379), 0x1p-33f);
  EXPECT_EQ(hash_value(26185, 0, 0, 3), 1.0f);
  EXPECT_EQ(uniform_deviate(26185, 0, 0, 3), 1 - 0x1p-24f);
  EXPECT_EQ(hashed({26185, 0, 0}, 3).x, 0x1p22f - 1);
}

TEST(Random, EveryBitIsSetHalfTheTime) {
  // All 32 of the hash, before a float rounds them; at pixels' keys, and in the fields of keys from
  // which cells take theirs.
  constexpr int kSide = 1024;
  const HashKey streams[] = {
      stream_key(0, 0, 0, 0), stream_key(0, 0, 1, 0), stream_key(7, 0, -1, 12345), {0, 0, 0}};
  const double threshold = sidak_threshold(kLevel, std::size(streams) * 2 * 32);
  for (const HashKey& stream : streams) {
    for (const bool of_pixels : {true, false}) {
      std::array<int, 32> ones{};
      for (int y = -kSide / 2; y < kSide / 2; ++y) {
        for (int x = -kSide / 2; x < kSide / 2; ++x) {
          const HashKey at =
              of_pixels ? pixel_key(stream, x, y, 0) : stream + HashKey{wrapped(x), wrapped(y), 0};
          const std::uint32_t word =
              lookup3(std::bit_cast<std::uint32_t>(at.x), std::bit_cast<std::uint32_t>(at.y),
                      std::bit_cast<std::uint32_t>(at.z), 0);
          for (std::size_t bit = 0; bit < 32; ++bit)
            ones[bit] += static_cast<int>(word >> bit & 1u);
        }
      }
      const double n = kSide * kSide;
      for (std::size_t bit = 0; bit < 32; ++bit) {
        EXPECT_LT(std::fabs(ones[bit] - n / 2) / std::sqrt(n / 4), threshold)
            << "stream " << stream.x << " bit " << bit << " of pixels " << of_pixels;
      }
    }
  }
}

TEST(Random, DeviatesFillTheirIntervalEvenly) {
  constexpr int kSide = 1024, kBins = 4096;
  const double threshold = sidak_threshold(kLevel, 5 * 3);
  for (int frame = -2; frame <= 2; ++frame) {
    const HashKey stream = stream_key(1, 0, frame, 3);
    std::array<std::vector<double>, 3> bins;
    bins.fill(std::vector<double>(kBins));
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const auto u = deviates(stream, x, y, 0);
        for (std::size_t k = 0; k < 3; ++k) bins[k][static_cast<std::size_t>(u[k] * kBins)] += 1;
      }
    }
    const std::vector<double> expected(kBins, 1.0 * kSide * kSide / kBins);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT(std::fabs(chi_square_z(bins[k], expected)), threshold)
          << "frame " << frame << " deviate " << k;
    }
  }
}

TEST(Random, NeighboursInEveryCoordinateAreUncorrelated) {
  // Product-moment correlation, and joint chi-square over 32 x 32 cells.
  struct At {
    int x, y, light, instance, frame, seed, draw;
  };
  const std::pair<const char*, std::function<void(At&)>> neighbours[] = {
      {"x + 1", [](At& a) { a.x += 1; }},
      {"y + 1", [](At& a) { a.y += 1; }},
      {"x + 1, y + 1", [](At& a) { a.x += 1, a.y += 1; }},
      {"x + 1024", [](At& a) { a.x += 1024; }},
      {"y + 65536", [](At& a) { a.y += 65536; }},
      {"x + 2^21", [](At& a) { a.x += 1 << 21; }},
      {"-x", [](At& a) { a.x = -a.x - 1; }},
      {"x and y swapped", [](At& a) { a.y = std::exchange(a.x, a.y) + 2048; }},
      {"light + 1", [](At& a) { a.light += 1; }},
      {"instance + 1", [](At& a) { a.instance += 1; }},
      {"frame + 1", [](At& a) { a.frame += 1; }},
      {"seed + 1", [](At& a) { a.seed += 1; }},
      {"draw + 1", [](At& a) { a.draw += 1; }},
      {"next frame, previous seed", [](At& a) { a.frame += 1, a.seed -= 1; }},
  };
  const auto draw = [](const At& a) {
    return deviates(stream_key(a.light, a.instance, a.frame, a.seed), a.x, a.y, a.draw);
  };
  constexpr int kSide = 512, kCells = 32;
  const double n = kSide * kSide;
  const double threshold = sidak_threshold(kLevel, static_cast<double>(std::size(neighbours)) * 6);
  for (const auto& [name, move] : neighbours) {
    std::array<double, 3> product{};
    std::array<std::vector<double>, 3> cells;
    cells.fill(std::vector<double>(kCells * kCells));
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        At here{x, y, 0, 0, 1, 0, 0};
        const auto a = draw(here);
        move(here);
        const auto b = draw(here);
        for (std::size_t k = 0; k < 3; ++k) {
          product[k] += (static_cast<double>(a[k]) - 0.5) * (static_cast<double>(b[k]) - 0.5) * 12;
          cells[k][static_cast<std::size_t>(a[k] * kCells) * kCells +
                   static_cast<std::size_t>(b[k] * kCells)] += 1;
        }
      }
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT(std::fabs(product[k]) / std::sqrt(n), threshold) << name << ", deviate " << k;
      const std::vector<double> expected(kCells * kCells, n / (kCells * kCells));
      EXPECT_LT(std::fabs(chi_square_z(cells[k], expected)), threshold)
          << name << ", deviate " << k;
    }
  }
}

TEST(Random, NoTwoStreamsShareTheirDraws) {
  // Streams of one z and nearly the same x and y would repeat each other's pixels, shifted. Of two
  // streams anywhere, pictures 8192 pixels wide meet with the probability 4e-12.
  std::vector<std::tuple<float, float, float>> keys;
  for (int light = 0; light < 10; ++light) {
    for (int instance = 0; instance < 4; ++instance) {
      for (int frame = -10; frame < 250; ++frame) {
        for (int seed = -5; seed < 15; ++seed) {
          const HashKey key = stream_key(light, instance, frame, seed);
          keys.emplace_back(key.z, key.x, key.y);
        }
      }
    }
  }
  std::sort(keys.begin(), keys.end());
  const auto apart = [](float a, float b) {
    const float d = std::fabs(a - b);
    return std::min(d, 0x1p22f - d);
  };
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto [z, x, y] = keys[i];
    for (std::size_t k = i + 1; k < keys.size() && std::get<0>(keys[k]) == z; ++k) {
      ASSERT_FALSE(apart(std::get<1>(keys[k]), x) < 8192 && apart(std::get<2>(keys[k]), y) < 8192)
          << "z " << z;
    }
  }
}

TEST(Random, RareEventsHappenAsOftenAsTheyShould) {
  // 5e7 hashes, three deviates of each. Counts are Poisson; level 1e-3.
  constexpr int kRows = 5'000, kColumns = 10'000;
  const float probability[] = {1e-4f, 1e-6f, 1e-7f};
  std::array<double, 3> found{};
  const HashKey stream = stream_key(3, 0, 17, 1);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      for (float u : deviates(stream, x - 5000, y, 0)) {
        if (u >= probability[0]) continue;
        for (std::size_t k = 0; k < 3; ++k) found[k] += u < probability[k] ? 1 : 0;
      }
    }
  }
  const double threshold = sidak_threshold(kLevel, 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const double expected = 3.0 * kRows * kColumns * static_cast<double>(probability[k]);
    EXPECT_LT(std::fabs(found[k] - expected) / std::sqrt(expected), threshold)
        << "probability " << probability[k] << ": " << found[k] << " of " << expected;
  }
}

}  // namespace
