// SPDX-License-Identifier: Apache-2.0
#include "batch.h"

#include <algorithm>

#include "random.h"

namespace metallic_paint {

// expect_lanes.cpp, compiled for each of these processors.
#define METALLIC_PAINT_LANES_OF(processor)                                                       \
  void expect_in_lanes_##processor(const Paint&, const std::vector<Light<double>>&, std::size_t, \
                                   const StreamKeys&, const PixelBatch&, const PixelResults&,    \
                                   std::size_t, std::size_t, LightsToDraw&)
#ifdef METALLIC_PAINT_LANES
METALLIC_PAINT_LANES_OF(plain);
#ifdef METALLIC_PAINT_WIDE_LANES
METALLIC_PAINT_LANES_OF(avx2);
METALLIC_PAINT_LANES_OF(avx512);
#endif
#endif

const std::vector<ExpectInLanes>& expect_in_lanes() {
  static const std::vector<ExpectInLanes> widest_first = [] {
    std::vector<ExpectInLanes> found;
#ifdef METALLIC_PAINT_WIDE_LANES
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
      found.push_back(expect_in_lanes_avx512);
    }
    if (__builtin_cpu_supports("avx2")) found.push_back(expect_in_lanes_avx2);
#endif
#ifdef METALLIC_PAINT_LANES
    found.push_back(expect_in_lanes_plain);
#endif
    return found;
  }();
  return widest_first;
}

namespace {

// One by one come the draws: each has as much to do as there are sparkles.
class Draws final : public LightsToDraw {
 public:
  Draws(const Layer<float>& layer, const StreamKeys& keys, std::size_t lights, std::size_t species,
        const PixelBatch& batch, const PixelResults& results)
      : layer_(layer),
        keys_(keys),
        lights_(lights),
        species_(species),
        batch_(batch),
        results_(results) {}

  // Flat: with few sparkles there is little to do, in many small functions.
  [[gnu::flatten]] void draw(std::size_t i, std::size_t light, ExpectedLight& expected) override {
    PixelSparkles<float>& all = expected.sparkles;
    all.count = {};
    all.radiance = {};
    for (std::size_t at = 0; at < static_cast<std::size_t>(layer_.species); ++at) {
      if (expected.dark[at]) continue;
      all.draw(at, draw_sparkles(all.expected[at], layer_.flakes[at].area_spread, keys_[light][at],
                                 batch_.pixel[2 * i], batch_.pixel[2 * i + 1]));
    }
    all.bound_by_mirror();
    store_draw(results_, i * lights_ + light, all.count[species_], all.radiance);
  }

  void follow(std::size_t i, std::size_t light, int leader) override {
    store_follower(results_, i, lights_, light, leader);
  }

 private:
  const Layer<float>& layer_;
  const StreamKeys& keys_;
  std::size_t lights_, species_;
  const PixelBatch& batch_;
  const PixelResults& results_;
};

}  // namespace

void evaluate_in_lanes(ExpectInLanes expect, const Paint& paint, const Layer<float>& layer,
                       const std::vector<Light<double>>& lights, std::size_t species,
                       const PixelBatch& batch, const PixelResults& results,
                       const std::stop_token& stop) {
  StreamKeys keys{};
  for (std::size_t light = 0; light < lights.size(); ++light) {
    for (int i = 0; i < layer.species; ++i) {
      keys[light][static_cast<std::size_t>(i)] =
          stream_key(static_cast<int>(light), i, paint.frame, paint.seed);
    }
  }
  constexpr std::size_t kBlock = 1024;
  const auto evaluate_block = [&](std::size_t block) {
    Draws draws(layer, keys, lights.size(), species, batch, results);
    const std::size_t begin = block * kBlock;
    expect(paint, lights, species, keys, batch, results, begin,
           std::min(begin + kBlock, batch.size), draws);
  };
  parallel_for((batch.size + kBlock - 1) / kBlock, evaluate_block, 1, stop);
}

}  // namespace metallic_paint
