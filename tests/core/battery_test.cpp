// SPDX-License-Identifier: Apache-2.0
//
// The hash under the named tests of random number generators (Marsaglia's, Knuth's), and the
// picture that it makes: its spectrum, its neighbours up to 8 pixels, lights, instances, frames,
// seeds and words away. What is tested is the field of keys itself, whole numbers side by side, as
// cells of the paint take it; pixels hash it once more (random_test.cpp). Keys are fixed: the hash
// has no chance in it, and what it once drew for them it always draws, so that the level can be
// 1e-3 for each test as a whole (Sidak's correction within). A longer battery by hand, on the same
// words in the same order (tools/verification/hash_stream.cpp):
//   build/hash_stream | dieharder -g 200 -a
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "random.h"
#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::chi_square_z;
using core_tests::fresh;
using core_tests::kFreshLevel;
using core_tests::kLevel;
using core_tests::Random;
using core_tests::sidak_threshold;
using core_tests::Worst;

constexpr std::size_t kWords = 3;  // a Vec3 of deviates
using Words = std::array<std::uint32_t, kWords>;

// The hashes of which uniform_deviates(at, word) are the upper bits.
Words words_of(HashKey at, float word) {
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  const std::uint32_t x = bits(at.x), y = bits(at.y), z = bits(at.z), w = bits(word);
  return {lookup3(x, y, z, w), lookup3(z, x, w, y), lookup3(w, z, y, x)};
}
Words words_at(HashKey stream, int x, int y, int word = 0) {
  return words_of(stream + HashKey{wrapped(x), wrapped(y), 0}, static_cast<float>(word));
}

TEST(Battery, DeviatesAreTheWords) {
  for (int i = 0; i < 1000; ++i) {
    const HashKey stream = stream_key(1, i, 2, 3);
    const Words words = words_at(stream, i, -i, i);
    const Deviates u =
        uniform_deviates(stream + HashKey{wrapped(i), wrapped(-i), 0}, static_cast<float>(i));
    ASSERT_EQ(u.x, static_cast<float>(words[0]) * 0x1p-32f);
    ASSERT_EQ(u.y, static_cast<float>(words[1]) * 0x1p-32f);
    ASSERT_EQ(u.z, static_cast<float>(words[2]) * 0x1p-32f);
  }
}

// One word of every point in raster order, about the origin, where pictures are.
std::vector<std::uint32_t> raster(HashKey key, int side, std::size_t word, int draw = 0) {
  std::vector<std::uint32_t> stream;
  stream.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      stream.push_back(words_at(key, x - side / 2, y - side / 2, draw)[word]);
    }
  }
  return stream;
}

double uniform(std::uint32_t word) { return (word + 0.5) * 0x1p-32; }
// As a deviate of mean 0 and variance 1.
double centred(std::uint32_t word) { return (uniform(word) - 0.5) * std::sqrt(12.0); }
std::vector<double> picture(HashKey key, int side, std::size_t word, int draw = 0) {
  std::vector<double> values;
  for (std::uint32_t w : raster(key, side, word, draw)) values.push_back(centred(w));
  return values;
}

// The z of a chi-square test of counts under Poisson's law of that mean, cells 0 ... 9 and more.
double poisson_z(const std::vector<int>& counts, double mean) {
  constexpr std::size_t kCells = 10;
  std::vector<double> found(kCells), expected(kCells);
  for (int count : counts) found[std::min(static_cast<std::size_t>(count), kCells - 1)] += 1;
  double p = std::exp(-mean), rest = 1;
  for (std::size_t k = 0; k + 1 < kCells; ++k) {
    expected[k] = p * static_cast<double>(counts.size());
    rest -= p;
    p *= mean / static_cast<double>(k + 1);
  }
  expected[kCells - 1] = rest * static_cast<double>(counts.size());
  return chi_square_z(found, expected);
}

const HashKey kStreams[] = {stream_key(0, 0, 1, 0), stream_key(1, 0, 1, 0),
                            stream_key(0, 1, 1, 0), stream_key(0, 0, 2, 0),
                            stream_key(0, 0, 1, 1), stream_key(7, 3, -250, 2147483647)};

// ---------------------------------------------------------------------------------------------
// The picture.

TEST(Battery, PixelsUpToEightApartAreUncorrelated) {
  constexpr int kSide = 384, kReach = 8;
  Worst worst;
  const double offsets = (2 * kReach + 1) * (kReach + 1) - kReach - 1;
  const double threshold = sidak_threshold(kLevel, kWords * kWords * offsets);
  for (std::size_t a = 0; a < kWords; ++a) {
    const std::vector<double> first = picture(kStreams[0], kSide, a);
    for (std::size_t b = 0; b < kWords; ++b) {
      const std::vector<double> second = picture(kStreams[0], kSide, b);
      for (int dy = 0; dy <= kReach; ++dy) {
        for (int dx = dy == 0 ? 1 : -kReach; dx <= kReach; ++dx) {
          double sum = 0, pairs = 0;
          for (int y = 0; y + dy < kSide; ++y) {
            const int from = std::max(0, -dx), to = std::min(kSide, kSide - dx);
            const double* here = &first[static_cast<std::size_t>(y * kSide)];
            const double* there = &second[static_cast<std::size_t>((y + dy) * kSide)];
            for (int x = from; x < to; ++x) sum += here[x] * there[x + dx];
            pairs += to - from;
          }
          worst.see(std::fabs(sum) / std::sqrt(pairs), "words", a, b, "dx", dx, "dy", dy);
        }
      }
    }
  }
  worst.expect_at_most(threshold, "largest_z");
}

TEST(Battery, StreamsUpToEightApartAreUncorrelated) {
  // Lights, instances, frames, seeds and words, every deviate with every other, and those of one.
  constexpr int kSide = 256, kReach = 8;
  Worst worst;
  const double threshold = sidak_threshold(kLevel, 9 * 5 * kReach + 3);
  const auto see = [&](const std::array<std::vector<double>, kWords>& first,
                       const std::array<std::vector<double>, kWords>& second, int kind, int step) {
    for (std::size_t a = 0; a < kWords; ++a) {
      for (std::size_t b = kind == 5 ? a + 1 : 0; b < kWords; ++b) {
        double sum = 0;
        for (std::size_t i = 0; i < first[a].size(); ++i) sum += first[a][i] * second[b][i];
        worst.see(std::fabs(sum) / kSide, "words", a, b, "kind", kind, "step", step);
      }
    }
  };
  const auto pictures = [&](HashKey key, int draw) {
    std::array<std::vector<double>, kWords> made;
    for (std::size_t word = 0; word < kWords; ++word) made[word] = picture(key, kSide, word, draw);
    return made;
  };
  const auto origin = pictures(stream_key(0, 0, 0, 0), 0);
  see(origin, origin, 5, 0);
  for (int step = 1; step <= kReach; ++step) {
    for (int kind = 0; kind < 5; ++kind) {
      std::array<int, 5> at{};
      at[static_cast<std::size_t>(kind)] = step;
      see(origin, pictures(stream_key(at[0], at[1], at[2], at[3]), at[4]), kind, step);
    }
  }
  worst.expect_at_most(threshold, "largest_z");
}

TEST(Battery, SpectrumOfThePictureIsFlat) {
  // The periodogram of white noise is exponential with mean 1, each pair of opposite frequencies
  // independent. Judged: its largest ordinate, its histogram (64 cells of equal probability), and
  // its mean in rings and in sectors, where lattices and stripes would show.
  constexpr int kSide = 256;
  constexpr std::size_t kRings = 16, kSectors = 16, kCells = 64;
  const double threshold =
      sidak_threshold(kLevel, kWords * std::size(kStreams) * (2 + kRings + kSectors));
  Worst worst;
  for (std::size_t stream = 0; stream < std::size(kStreams); ++stream) {
    for (std::size_t word = 0; word < kWords; ++word) {
      const std::vector<double> values = picture(kStreams[stream], kSide, word);
      const auto image = core_tests::transformed(values, kSide);
      double largest = 0, ordinates = 0;
      std::vector<double> cells(kCells), rings(kRings), sectors(kSectors), in_ring(kRings),
          in_sector(kSectors);
      const int half = kSide / 2;
      for (int y = 0; y < half; ++y) {
        for (int x = 1 - half; x < half; ++x) {
          if (y == 0 && x <= 0) continue;  // one of each pair of opposite frequencies
          const int column = (x + kSide) % kSide;
          const double power =
              std::norm(image[static_cast<std::size_t>(column * kSide + y)]) / (kSide * kSide);
          largest = std::max(largest, power);
          ordinates += 1;
          cells[static_cast<std::size_t>(std::exp(-power) * kCells)] += 1;
          const double radius = std::hypot(x, y), angle = std::atan2(y, x) / std::numbers::pi;
          // Innermost: waves longer than 23 pixels.
          const auto ring = std::min(static_cast<std::size_t>(radius / 182 * kRings), kRings - 1);
          const auto sector = std::min(static_cast<std::size_t>(angle * kSectors), kSectors - 1);
          rings[ring] += 2 * power;
          in_ring[ring] += 2;
          sectors[sector] += 2 * power;
          in_sector[sector] += 2;
        }
      }
      // P(largest < t) = (1 - e^-t)^n, as the normal deviate that is as improbable from both sides.
      const double unlikely = -std::expm1(ordinates * std::log1p(-std::exp(-largest)));
      double z = 0;
      while (std::erfc(z / std::numbers::sqrt2) > std::min(unlikely, 1 - unlikely) * 2) z += 0.01;
      worst.see(z, "largest ordinate, stream", stream, "word", word);
      const std::vector<double> even(kCells, ordinates / kCells);
      worst.see(std::fabs(chi_square_z(cells, even)), "histogram, stream", stream, "word", word);
      for (std::size_t k = 0; k < kRings; ++k) {
        worst.see(std::fabs(chi_square_z(rings[k], in_ring[k])), "ring", k, "stream", stream,
                  "word", word);
        worst.see(std::fabs(chi_square_z(sectors[k], in_sector[k])), "sector", k, "stream", stream,
                  "word", word);
      }
    }
  }
  worst.expect_at_most(threshold, "largest_z");
}

// ---------------------------------------------------------------------------------------------
// Named tests of the raster stream.

TEST(Battery, SerialPairsAndTriplesFillTheirCells) {
  // Knuth, serial test: consecutive pixels, 256^2 and 32^3 cells; and the words of one point.
  constexpr int kSide = 1024;
  Worst worst;
  const double threshold = sidak_threshold(kLevel, kWords * 2 + 1);
  const auto see = [&](const std::vector<double>& cells, double tuples, const char* what,
                       std::size_t word) {
    const std::vector<double> even(cells.size(), tuples / static_cast<double>(cells.size()));
    worst.see(std::fabs(chi_square_z(cells, even)), what, word);
  };
  std::array<std::vector<std::uint32_t>, kWords> streams;
  for (std::size_t word = 0; word < kWords; ++word) {
    streams[word] = raster(stream_key(2, 0, 5, 0), kSide, word);
    std::vector<double> pairs(65536), triples(32768);
    const auto& s = streams[word];
    for (std::size_t i = 0; i + 1 < s.size(); i += 2) {
      pairs[(s[i] >> 24 << 8) | (s[i + 1] >> 24)] += 1;
    }
    for (std::size_t i = 0; i + 2 < s.size(); i += 3) {
      triples[(s[i] >> 27 << 10) | (s[i + 1] >> 27 << 5) | (s[i + 2] >> 27)] += 1;
    }
    see(pairs, static_cast<double>(s.size() / 2), "pairs", word);
    see(triples, static_cast<double>(s.size() / 3), "triples", word);
  }
  std::vector<double> cells(32768);
  for (std::size_t i = 0; i < streams[0].size(); ++i) {
    cells[(streams[0][i] >> 27 << 10) | (streams[1][i] >> 27 << 5) | (streams[2][i] >> 27)] += 1;
  }
  see(cells, static_cast<double>(streams[0].size()), "words of a point", 0);
  worst.expect_at_most(threshold, "largest_z");
}

TEST(Battery, BirthdaySpacingsRepeatAsPoissonSays) {
  // Marsaglia: 512 birthdays in a year of 2^24 days; the repeated spacings are Poisson with mean
  // 512^3/(4 2^24) = 2. The top, middle and bottom 24 bits of each word.
  constexpr std::size_t kBirthdays = 512, kYears = 1000;
  Worst worst;
  for (std::size_t word = 0; word < kWords; ++word) {
    const auto stream = raster(stream_key(0, 0, 11, 0), 768, word);
    for (unsigned shift : {0u, 4u, 8u}) {
      std::vector<int> repeats;
      for (std::size_t year = 0; year < kYears; ++year) {
        std::vector<std::uint32_t> days(kBirthdays);
        for (std::size_t i = 0; i < kBirthdays; ++i) {
          days[i] = (stream[year * kBirthdays + i] >> shift) & 0xffffffu;
        }
        std::sort(days.begin(), days.end());
        for (std::size_t i = kBirthdays - 1; i > 0; --i) days[i] -= days[i - 1];
        std::sort(days.begin(), days.end());
        int repeated = 0;
        for (std::size_t i = 1; i < kBirthdays; ++i) repeated += days[i] == days[i - 1] ? 1 : 0;
        repeats.push_back(repeated);
      }
      worst.see(std::fabs(poisson_z(repeats, 2)), "word", word, "shift", shift);
    }
  }
  worst.expect_at_most(sidak_threshold(kLevel, kWords * 3), "largest_z");
}

TEST(Battery, BinaryMatricesHaveTheirRanks) {
  // Marsaglia: ranks of random 32 x 32 matrices over two elements: 32 with probability 0.288788,
  // 31 with 0.577576, 30 with 0.128350. Rows are pixels along x, along y, and draws.
  constexpr int kMatrices = 10'000;
  const std::vector<double> probability{0.2887880952, 0.5775761902, 0.1283502645, 0.0052854501};
  Worst worst;
  for (std::size_t word = 0; word < kWords; ++word) {
    for (int direction = 0; direction < 3; ++direction) {
      std::vector<double> found(4), expected;
      for (double p : probability) expected.push_back(p * kMatrices);
      for (int m = 0; m < kMatrices; ++m) {
        std::array<std::uint32_t, 32> rows{};
        for (int i = 0; i < 32; ++i) {
          const int along = m % 32 * 32 + i, across = m / 32;
          rows[static_cast<std::size_t>(i)] =
              direction == 0   ? words_at(kStreams[0], along, across)[word]
              : direction == 1 ? words_at(kStreams[0], across, along)[word]
                               : words_at(kStreams[0], m % 200, m / 200, i)[word];
        }
        std::size_t rank = 0;
        for (unsigned bit = 0; bit < 32 && rank < 32; ++bit) {
          std::size_t pivot = rank;
          while (pivot < 32 && ((rows[pivot] >> bit) & 1u) == 0) ++pivot;
          if (pivot == 32) continue;
          std::swap(rows[rank], rows[pivot]);
          for (std::size_t i = rank + 1; i < 32; ++i) {
            if (((rows[i] >> bit) & 1u) != 0) rows[i] ^= rows[rank];
          }
          ++rank;
        }
        found[std::min<std::size_t>(32 - rank, 3)] += 1;
      }
      worst.see(std::fabs(chi_square_z(found, expected)), "word", word, "direction", direction);
    }
  }
  worst.expect_at_most(sidak_threshold(kLevel, kWords * 3), "largest_z");
}

TEST(Battery, GapsAreGeometric) {
  // Knuth, gap test: pixels between two below 1/8, in lengths 0 ... 39 and longer.
  constexpr std::size_t kCells = 41;
  constexpr double p = 0.125;
  Worst worst;
  for (std::size_t word = 0; word < kWords; ++word) {
    std::vector<double> found(kCells), expected(kCells);
    double gaps = 0;
    std::size_t gap = 0;
    for (std::uint32_t w : raster(stream_key(0, 2, 3, 0), 1024, word)) {
      if (uniform(w) >= p) {
        ++gap;
        continue;
      }
      found[std::min(gap, kCells - 1)] += 1;
      gaps += 1;
      gap = 0;
    }
    for (std::size_t k = 0; k < kCells; ++k) {
      expected[k] = gaps * std::pow(1 - p, k) * (k + 1 < kCells ? p : 1);
    }
    worst.see(std::fabs(chi_square_z(found, expected)), "word", word);
  }
  worst.expect_at_most(sidak_threshold(kLevel, kWords), "largest_z");
}

TEST(Battery, BallsCollideAsOftenAsTheyShould) {
  // Knuth, collision test: 2^14 balls in 2^21 urns, addressed by seven bits of each of three words.
  // The collisions have mean 64 and very nearly the variance of Poisson's law.
  constexpr double kBalls = 16384, kUrns = 2097152;
  const double mean = kBalls - kUrns * -std::expm1(kBalls * std::log1p(-1 / kUrns));
  Worst worst;
  int trials = 0;
  for (unsigned shift : {25u, 16u, 8u}) {
    for (int frame = 0; frame < 16; ++frame) {
      const HashKey key = stream_key(0, 0, frame, 9);
      std::vector<bool> taken(static_cast<std::size_t>(kUrns));
      double collisions = 0;
      for (int i = 0; i < static_cast<int>(kBalls); ++i) {
        std::size_t urn = 0;
        for (std::uint32_t w : words_at(key, i % 128, i / 128)) {
          urn = urn << 7 | ((w >> shift) & 127);
        }
        collisions += taken[urn] ? 1 : 0;
        taken[urn] = true;
      }
      worst.see(std::fabs(collisions - mean) / std::sqrt(mean), "shift", shift, "frame", frame);
      ++trials;
    }
  }
  worst.expect_at_most(sidak_threshold(kLevel, trials), "largest_z");
}

// ---------------------------------------------------------------------------------------------
// Avalanche.

TEST(Battery, EveryInputBitTurnsEveryBitHalfTheTime) {
  // Of the chain from light, instance, frame and seed to a pixel's first draw, all 22 bits each;
  // and of a key and its word.
  constexpr int kTrials = 4096;
  using Inputs = std::array<int, 7>;
  const auto chain = [](const Inputs& in) {
    return words_of(pixel_key(stream_key(in[0], in[1], in[2], in[3]), in[4], in[5], in[6]), 0);
  };
  const auto field = [](const Inputs& in) {
    return words_of({wrapped(in[0]), wrapped(in[1]), wrapped(in[2])}, wrapped(in[3]));
  };
  Random random = fresh(50);
  Worst worst;
  int bits = 0;
  const auto see = [&](const char* name, const auto& hash, std::size_t inputs) {
    for (std::size_t input = 0; input < inputs; ++input) {
      for (int bit = 0; bit < 22; ++bit, ++bits) {
        std::array<int, 32 * kWords> turned{};
        for (int trial = 0; trial < kTrials; ++trial) {
          // In turn anywhere, and small as most numbers are.
          Inputs in;
          for (int& number : in) number = random.below(trial % 2 == 0 ? 1 << 22 : 64);
          const Words before = hash(in);
          in[input] ^= 1 << bit;
          const Words after = hash(in);
          for (std::size_t k = 0; k < turned.size(); ++k) {
            turned[k] += static_cast<int>(((before[k / 32] ^ after[k / 32]) >> (k % 32)) & 1u);
          }
        }
        for (std::size_t k = 0; k < turned.size(); ++k) {
          worst.see(std::fabs(turned[k] - kTrials / 2.0) / std::sqrt(kTrials / 4.0), name, input,
                    "bit", bit, "turns bit", k);
        }
      }
    }
  };
  see("chain", chain, 7);
  see("field", field, 4);
  worst.expect_at_most(sidak_threshold(kFreshLevel, 32.0 * kWords * bits), "largest_z");
}

}  // namespace
