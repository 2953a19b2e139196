// SPDX-License-Identifier: Apache-2.0
//
// Pixels side by side, compiled once for each processor (CMakeLists.txt): METALLIC_PAINT_LANES_FOR
// is its name. What is compiled here depends on the width of the lanes by its type, or is inlined:
// a linker that took it for the same function elsewhere would call what the processor lacks
// (tests/core/lanes_test.cmake).
#include <array>
#include <cstddef>
#include <vector>

#include "batch.h"
#include "lanes.h"

#define METALLIC_PAINT_NAME_(processor) expect_in_lanes_##processor
#define METALLIC_PAINT_NAME(processor) METALLIC_PAINT_NAME_(processor)

namespace metallic_paint {
namespace {

using Simd = std::experimental::native_simd<float>;
using Many = Lanes<Simd>;
constexpr std::size_t kCount = Many::kCount;

// Of each lane the element `at` in its row, which is `row` after that of the lane before, of so
// many rows.
Many gather(const Column& column, std::size_t at, std::size_t row, std::size_t rows) {
  alignas(std::experimental::memory_alignment_v<Simd>) float lanes[kCount] = {};
  column.as_they_are([&](const auto* first) {
    const auto* number = first + at;
    if (rows == kCount) {  // in numbers that the compiler knows
      for (std::size_t lane = 0; lane < kCount; ++lane) {
        lanes[lane] = static_cast<float>(number[lane * row]);
      }
    } else {
      for (std::size_t lane = 0; lane < rows; ++lane) {
        lanes[lane] = static_cast<float>(number[lane * row]);
      }
    }
  });
  return Many(Simd(lanes, std::experimental::vector_aligned));
}

Vec3<Many> gather_vectors(const Column& column, std::size_t at, std::size_t row, std::size_t rows) {
  return {gather(column, 3 * at, 3 * row, rows), gather(column, 3 * at + 1, 3 * row, rows),
          gather(column, 3 * at + 2, 3 * row, rows)};
}

Rgb<float> of_lane(const Rgb<Many>& v, std::size_t lane) {
  return {v.x[lane], v.y[lane], v.z[lane]};
}

ExpectedSparkles<float> of_lane(const ExpectedSparkles<Many>& e, std::size_t lane) {
  return {e.mean_count[lane],
          e.slots,
          e.fill[lane],
          {e.area.mean[lane], e.area.square[lane], e.area.cube[lane]},
          of_lane(e.slant, lane),
          e.hidden[lane],
          of_lane(e.transmitted, lane),
          of_lane(e.reflectance, lane),
          of_lane(e.mirror, lane),
          e.ceiling[lane],
          e.contrast[lane],
          e.share[lane]};
}

}  // namespace

void METALLIC_PAINT_NAME(METALLIC_PAINT_LANES_FOR)(const Paint& paint,
                                                   const std::vector<Light<double>>& lights,
                                                   const PixelBatch& batch, std::size_t begin,
                                                   std::size_t end, ExpectedPixels& to) {
  Layer<Many> layer;
  std::vector<Light<Many>> slots;
  Many::in_lanes(kCount, [&] {
    layer = make_layer<Many>(paint);
    slots = slots_of<Many>(lights);
  });
  std::array<ExpectedPixel, kCount> pixels;
  for (std::size_t i = begin; i < end; i += kCount) {
    const std::size_t rows = std::min(kCount, end - i);
    const SurfacePoint<Many> point{gather_vectors(batch.position, i, 1, rows),
                                   gather_vectors(batch.normal, i, 1, rows),
                                   gather_vectors(batch.view, i, 1, rows),
                                   gather(batch.footprint, i, 1, rows),
                                   0,
                                   0};
    // What is stored of a lane that is left behind later, its own pass overwrites.
    Many::in_lanes(rows, [&] {
      const SlotView<Many> view = view_slots(slots, point);
      Many::each_followed([&](std::size_t lane) { pixels[lane].leader = view.leader; });
      for (std::size_t light = 0; light < slots.size(); ++light) {
        if (view.leader[light] != static_cast<int>(light)) continue;
        Rgb<Many> slant{};
        if (batch.slant.given()) {
          slant = gather_vectors(batch.slant, i * slots.size() + light, slots.size(), rows);
        }
        const Passage<Many> way =
            pass_between(layer, point, view.seen[light], batch.slant.given() ? &slant : nullptr);
        for (std::size_t at = 0; at < static_cast<std::size_t>(layer.species); ++at) {
          const ExpectedSparkles<Many> expected =
              expect_sparkles(layer, layer.flakes[at], point.footprint, way);
          const Rgb<Many> mean = mean_radiance(expected), variance = radiance_variance(expected);
          Many::each_followed([&](std::size_t lane) {
            PixelSparkles<float>& one = pixels[lane].sparkles[light];
            if (at == 0) one.clear();
            one.expect(at, of_lane(expected, lane), of_lane(mean, lane), of_lane(variance, lane));
          });
        }
      }
    });
    for (std::size_t lane = 0; lane < rows; ++lane) to.take(i + lane, pixels[lane]);
  }
}

}  // namespace metallic_paint
