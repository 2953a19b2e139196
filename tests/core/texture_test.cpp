// SPDX-License-Identifier: Apache-2.0
//
// Regular texture: mean 1 and the stated deviation at any size of the pixel.
#include "texture.h"

#include <cmath>
#include <cstdint>

#include "support.h"

namespace {

using namespace core_tests;
using namespace metallic_paint;

TEST(Texture, HasMeanOneAndTheContrastOfTheReferenceArea) {
  // Pixels of 1 mm2, 100 mm2, 0.01 mm2: 1/sqrt(Sigma).
  const int n = 200'000;
  const double threshold = sidak_threshold(kFreshLevel, 6);
  Variances variances;
  std::uint32_t seed = run_seed();
  for (double contrast : {0.02, 0.1}) {
    for (double square_mm : {1.0, 100.0, 0.04}) {
      const double deviation = contrast / std::sqrt(square_mm);
      Moments found{1};
      for (int i = 0; i < n; ++i) {
        found.add(pixel_texture<double>(contrast, square_mm * 1e-6, i % 500, i / 500, 0,
                                        static_cast<int>(seed)));
      }
      ++seed;
      EXPECT_LT(std::fabs(found.mean() - 1) / (deviation / std::sqrt(n)), threshold) << contrast;
      // The kurtosis of the lognormal law.
      const double square = deviation * deviation, q = 1 + square;
      const double kurtosis = q * q * q * q + 2 * q * q * q + 3 * q * q - 3;
      variances.see(found.variance(), square, square * square * kurtosis, n, contrast);
    }
  }
  variances.expect_chance();
}

TEST(Texture, IsFiniteAndPositiveAtTheExtremes) {
  for (double contrast : {0.0, 1e-6, 1.0}) {
    for (double footprint : {0.0, 1e-30, 1e-6, 1e30}) {
      for (int i = 0; i < 1000; ++i) {
        const float f =
            pixel_texture(static_cast<float>(contrast), static_cast<float>(footprint), i, -i, 0, 0);
        ASSERT_TRUE(std::isfinite(f) && f > 0) << contrast << ' ' << footprint;
        if (contrast == 0) {
          ASSERT_EQ(f, 1.0f);
        }
      }
    }
  }
}

TEST(Texture, EndsAtADeviationOfOne) {
  EXPECT_EQ(texture_deviation(0.5, 1e-8), 1);
  EXPECT_DOUBLE_EQ(texture_deviation(0.5, 4e-6), 0.25);
}

TEST(Texture, DrawsAnewWithFrameAndSeed) {
  const auto at = [](int x, int frame, int seed) {
    return pixel_texture(0.1, 1e-6, x, 3, frame, seed);
  };
  EXPECT_EQ(at(1, 2, 3), at(1, 2, 3));
  EXPECT_NE(at(1, 2, 3), at(2, 2, 3));
  EXPECT_NE(at(1, 2, 3), at(1, 3, 3));
  EXPECT_NE(at(1, 2, 3), at(1, 2, 4));
}

}  // namespace
