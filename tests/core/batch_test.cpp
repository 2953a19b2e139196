// SPDX-License-Identifier: Apache-2.0
//
// Many pixels over all cores: each once, and each as if it were alone.
#include "batch.h"

#include <atomic>
#include <cmath>
#include <memory>
#include <new>
#include <stop_token>
#include <vector>

#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;

TEST(Batch, EveryIndexIsVisitedOnce) {
  for (std::size_t count : {0u, 1u, 2u, 1023u, 1024u, 1025u, 4096u, 100'003u}) {
    const auto visits = std::make_unique<std::atomic<int>[]>(count + 1);
    parallel_for(count, [&](std::size_t i) { ++visits[i]; });
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(visits[i], 1) << i << " of " << count;
    EXPECT_EQ(visits[count], 0) << "beyond the end of " << count;
  }
}

TEST(Batch, NoBlockBeginsOnceAStopIsRequested) {
  std::stop_source stop;
  std::atomic<std::size_t> visits{0};
  const auto work = [&](std::size_t i) {
    ++visits;
    if (i == 0) stop.request_stop();
  };
  parallel_for(100'000'000, work, 1, stop.get_token());
  EXPECT_LT(visits, 100'000'000u);
  visits = 0;
  parallel_for(1000, work, 1, stop.get_token());
  EXPECT_EQ(visits, 0u);
}

TEST(Batch, WhatWorkThrowsComesOut) {
  const auto work = [](std::size_t i) {
    if (i % 1000 == 999) throw std::bad_alloc();
  };
  EXPECT_THROW(parallel_for(10'000, work, 1), std::bad_alloc);
  EXPECT_NO_THROW(parallel_for(999, work, 1));
}

Light<double> sun(double degrees, double sine) {
  const double angle = degrees * 3.14159265358979 / 180;
  return {LightKind::parallel, {std::sin(angle), 0, std::cos(angle)}, sine};
}

SurfacePoint<double> flat_point() { return {{}, {0, 0, 1}, {0, 0, 1}, 1e-6, 0, 0}; }

TEST(Batch, LightsApartLeadThemselves) {
  const auto slots =
      view_slots<double>({sun(10, 0.01), sun(-30, 0.02), sun(60, 0)}, flat_point(), 1);
  EXPECT_EQ(slots.leader, (std::array<int, kLightSlots>{0, 1, 2, -1, -1, -1, -1, -1}));
}

TEST(Batch, UnseenLightsLeadNothing) {
  const Light<double> inside{LightKind::positional, {0, 0, 0}, 1};
  const auto slots = view_slots<double>(
      {Light<double>{}, sun(100, 0.01), sun(90.0001, 0.5), sun(20, 0.01), inside}, flat_point(), 1);
  EXPECT_EQ(slots.leader, (std::array<int, kLightSlots>{-1, -1, -1, 3, -1, -1, -1, -1}));
}

TEST(Batch, ARowOfLightsTooCloseIsOneGroup) {
  // 1.15 degrees of radius each, 2 degrees apart: each overlaps the next only.
  const auto slots = view_slots<double>(
      {sun(0, 0.02), sun(2, 0.02), sun(4, 0.02), sun(5.9, 0.02), sun(30, 0.02)}, flat_point(), 1);
  EXPECT_EQ(slots.leader, (std::array<int, kLightSlots>{0, 0, 0, 0, 4, -1, -1, -1}));
}

TEST(Batch, LightBelowTheHorizonDoesNotLeadItsNeighbour) {
  const auto slots = view_slots<double>({sun(90.01, 0.05), sun(89.9, 0.05)}, flat_point(), 1);
  EXPECT_EQ(slots.leader[0], -1);
  EXPECT_EQ(slots.leader[1], 1);
}

struct Arrays {
  std::vector<double> position, normal, view, footprint, slant;
  std::vector<std::int32_t> pixel;
  std::vector<std::int32_t> leader, slots;
  std::vector<double> mean_count, count, radiance, mean, variance;

  Arrays(int n, std::size_t lights) {
    Random random = fresh(70);
    const auto push = [](std::vector<double>& array, Vec3<double> v) {
      array.insert(array.end(), {v.x, v.y, v.z});
    };
    for (int i = 0; i < n; ++i) {
      push(position, {random.uniform(-1, 1), random.uniform(-1, 1), 0});
      push(normal, rounded(spherical(random.uniform(0, 0.3), random.uniform(0, 6))));
      push(view, rounded(spherical(random.uniform(0, 1), random.uniform(0, 6))));
      footprint.push_back(rounded(random.log_uniform(1e-10, 1e-4)));
      pixel.push_back(i % 64 - 32);
      pixel.push_back(i / 64);
      for (std::size_t light = 0; light < lights; ++light) {
        push(slant, {random.uniform(0, 2), random.uniform(0, 2), random.uniform(0, 2)});
      }
    }
    const std::size_t all = static_cast<std::size_t>(n) * lights;
    leader.resize(all);
    slots.resize(all);
    for (auto* array : {&mean_count, &count}) array->resize(all);
    for (auto* array : {&radiance, &mean, &variance}) array->resize(3 * all);
  }
  PixelBatch batch(bool with_slant) const {
    return {footprint.size(), position.data(),
            normal.data(),    view.data(),
            footprint.data(), pixel.data(),
            position.data(),  {},
            nullptr,          with_slant ? Column(slant.data()) : Column()};
  }
  PixelResults results() {
    return {leader.data(),   slots.data(), mean_count.data(), count.data(),
            radiance.data(), mean.data(),  variance.data()};
  }
};

template <class T>
void expect_each_pixel_alone(bool with_slant) {
  Paint paint = undiffracted();
  paint.frame = 5;
  const std::vector<Light<double>> lights{
      sun(10, 0.02), {}, {LightKind::positional, {0.5, 0.25, 2}, 0.125}, sun(11, 0.02)};
  const int n = 3000;
  Arrays arrays(n, lights.size());
  const Layer<T> layer = make_layer<T>(paint);
  evaluate_pixels(paint, layer, lights, arrays.batch(with_slant), arrays.results());
  const auto vector = [](const std::vector<double>& array, std::size_t i) {
    return Vec3<T>(Vec3<double>{array[3 * i], array[3 * i + 1], array[3 * i + 2]});
  };
  int followers = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const SurfacePoint<T> point{vector(arrays.position, i), vector(arrays.normal, i),
                                vector(arrays.view, i),     static_cast<T>(arrays.footprint[i]),
                                arrays.pixel[2 * i],        arrays.pixel[2 * i + 1]};
    for (std::size_t light = 0; light < lights.size(); ++light) {
      const std::size_t at = i * lights.size() + light;
      const int leader = arrays.leader[at];
      if (leader < 0) {
        ASSERT_EQ(arrays.radiance[3 * at], 0);
        continue;
      }
      const auto lead = static_cast<std::size_t>(leader);
      if (lead != light) ++followers;
      const Light<T> source{lights[lead].kind, Vec3<T>(lights[lead].vector),
                            static_cast<T>(lights[lead].size)};
      const Rgb<T> slant = vector(arrays.slant, i * lights.size() + lead);
      const auto expected = expect_sparkles(layer, point, see_light(source, point.position),
                                            with_slant ? &slant : nullptr);
      const HashKey stream = stream_key(kFlakeStream, leader, paint.frame, paint.seed);
      const auto drawn =
          draw_sparkles(expected, pixel_key(stream, point.pixel_x, point.pixel_y, 0));
      ASSERT_EQ(arrays.radiance[3 * at + 1], static_cast<double>(drawn.radiance.y)) << i;
      ASSERT_EQ(arrays.mean[3 * at + 2], static_cast<double>(mean_radiance(expected).z)) << i;
      ASSERT_EQ(arrays.variance[3 * at], static_cast<double>(radiance_variance(expected).x)) << i;
      ASSERT_EQ(arrays.count[at], lead == light ? static_cast<double>(drawn.count) : 0) << i;
      ASSERT_EQ(arrays.mean_count[at],
                lead == light ? static_cast<double>(expected.mean_count) : 0);
    }
  }
  EXPECT_GT(followers, 0) << "two of the lights are a degree apart";
}

TEST(Batch, EachPixelIsEvaluatedAsIfAlone) {
  expect_each_pixel_alone<double>(false);
  expect_each_pixel_alone<float>(false);
}

TEST(Batch, GivenOpticalDepthsReachTheirPixelAndLight) {
  expect_each_pixel_alone<double>(true);
  expect_each_pixel_alone<float>(true);
}

TEST(Batch, PixelsWithoutSurfaceAreBlack) {
  Arrays arrays(10, 1);
  for (double& v : arrays.normal) v = 0;
  evaluate_pixels(undiffracted(), make_layer<float>(undiffracted()), {sun(0, 0.1)},
                  arrays.batch(false), arrays.results());
  for (double radiance : arrays.radiance) EXPECT_EQ(radiance, 0);
  for (std::int32_t leader : arrays.leader) EXPECT_EQ(leader, -1);
}

}  // namespace
