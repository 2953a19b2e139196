// SPDX-License-Identifier: Apache-2.0
//
// Regular texture: mean 1 and the stated deviation at any size of the pixel.
#include "texture.h"

#include <cmath>

#include "support.h"

namespace {

using namespace core_tests;
using namespace metallic_paint;

constexpr double kLevel = 1e-4;

TEST(Texture, HasMeanOneAndTheContrastOfTheReferenceArea) {
  // Pixels of 1 mm2, 100 mm2, 0.01 mm2: 1/sqrt(Sigma).
  const int n = 200'000;
  const double threshold = sidak_threshold(kLevel, 12);
  int seed = 0;
  for (double contrast : {0.02, 0.1}) {
    for (double square_mm : {1.0, 100.0, 0.04}) {
      const double deviation = contrast / std::sqrt(square_mm);
      Moments found{1};
      for (int i = 0; i < n; ++i) {
        found.add(pixel_texture<double>(contrast, square_mm * 1e-6, i % 500, i / 500, 0, seed));
      }
      ++seed;
      EXPECT_LT(std::fabs(found.mean() - 1) / (deviation / std::sqrt(n)), threshold) << contrast;
      EXPECT_LT(std::fabs(found.variance() - deviation * deviation) / found.error_of_variance(),
                threshold)
          << contrast << ' ' << square_mm;
    }
  }
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
