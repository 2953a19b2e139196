// SPDX-License-Identifier: Apache-2.0
//
// Pixels side by side, compiled once for each processor (CMakeLists.txt): METALLIC_PAINT_LANES_FOR
// is its name. What is compiled here depends on the width of the lanes by its type, or is inlined:
// a linker that took it for the same function elsewhere would call what the processor lacks
// (tests/core/lanes_test.cmake).
#include <array>
#include <bit>
#include <cstddef>
#include <memory>
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
constexpr std::experimental::element_aligned_tag kInTurn{};  // of numbers in memory

// Of each lane the element `at` in its row, which is `row` after that of the lane before, of so
// many rows.
Many gather(const Column& column, std::size_t at, std::size_t row, std::size_t rows) {
  return column.as_they_are([&](const auto* first) {
    const auto* number = first + at;
    if (rows == kCount) {  // in numbers that the compiler knows
      return Many(Simd([&](auto lane) { return static_cast<float>(number[lane * row]); }));
    }
    return Many(
        Simd([&](auto lane) { return lane < rows ? static_cast<float>(number[lane * row]) : 0; }));
  });
}

using Vector = Many::Vector;
using Places [[gnu::vector_size(sizeof(Simd))]] = int;

// x, y and z of the vectors that lie in turn in a, b and c.
Vec3<Many> every_third(Simd a, Simd b, Simd c) {
  const auto component = [&](int at) {
    Places in_a_b, in_all;
    for (int lane = 0, count = kCount; lane < count; ++lane) {
      const int place = 3 * lane + at;
      in_a_b[lane] = place < 2 * count ? place : 0;
      in_all[lane] = place < 2 * count ? lane : place - count;
    }
    const Vector ab = __builtin_shuffle(std::bit_cast<Vector>(a), std::bit_cast<Vector>(b), in_a_b);
    return Many(std::bit_cast<Simd>(__builtin_shuffle(ab, std::bit_cast<Vector>(c), in_all)));
  };
  return {component(0), component(1), component(2)};
}

Vec3<Many> gather_vectors(const Column& column, std::size_t at, std::size_t row, std::size_t rows) {
  if (row == 1 && rows == kCount) {
    return column.as_they_are([&](const auto* first) {
      const auto* from = first + 3 * at;
      const auto in_turn = [&](std::size_t part) { return Simd(from + part * kCount, kInTurn); };
      return every_third(in_turn(0), in_turn(1), in_turn(2));
    });
  }
  return {gather(column, 3 * at, 3 * row, rows), gather(column, 3 * at + 1, 3 * row, rows),
          gather(column, 3 * at + 2, 3 * row, rows)};
}

// The colours of all lanes, one behind the other: what every_third takes apart.
void store_in_turn(double* array, const Rgb<Many>& colours) {
  const auto part = [&]<int kPart>(std::integral_constant<int, kPart>) {
    Places in_x_y, in_all;
    for (int lane = 0, count = kCount; lane < count; ++lane) {
      const int place = kPart * count + lane, pixel = place / 3, at = place % 3;
      in_x_y[lane] = at == 1 ? count + pixel : pixel;
      in_all[lane] = at == 2 ? count + pixel : lane;
    }
    const Vector x_y = __builtin_shuffle(std::bit_cast<Vector>(colours.x.all()),
                                         std::bit_cast<Vector>(colours.y.all()), in_x_y);
    const Vector all = __builtin_shuffle(x_y, std::bit_cast<Vector>(colours.z.all()), in_all);
    std::bit_cast<Simd>(all).copy_to(array + kPart * kCount, kInTurn);
  };
  part(std::integral_constant<int, 0>{});
  part(std::integral_constant<int, 1>{});
  part(std::integral_constant<int, 2>{});
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

// Words of a hash side by side.
struct LaneWords {
  Many::Words x, y, z, w;
};

// Where the draw of a count ends at its first comparison, with no sparkle: the deviate is not below
// the probability of any (draw_sparkles, count_deviate). Where that is not known, no lane.
Many::Mask dark_lanes(const ExpectedSparkles<Many>& expected, HashWords key,
                      const std::int32_t* pixel, std::size_t rows) {
  const Many mean = expected.mean_count;
  const auto word = [&](std::size_t at) {
    const auto of_lane = [&](auto lane) {
      return static_cast<std::uint32_t>(pixel[2 * lane + at]);
    };
    if (rows == kCount) return Many::Words(of_lane);
    return Many::Words([&](auto lane) { return lane < rows ? of_lane(lane) : 0; });
  };
  const auto dark = [&](Many chance) {
    const LaneWords words =
        pcg4d(LaneWords{word(0) ^ key.x, word(1) ^ key.y, Many::Words(key.z), Many::Words(key.w)});
    const Many u = uniform_48<Many>(words.x, words.y);
    return u.all() >= chance.all() && expected.contrast.all() == 1.0f;
  };
  const Many::Mask none = !(mean.all() > 0.0f);
  if (expected.slots == 0) {
    // Beyond, few pixels are dark.
    if (!Many::in_all_followed(mean.all() < 1.0f)) return none;
    return none || dark(mean * mean_transmittance(mean));
  }
  const Many p = mean / static_cast<Many>(expected.slots);
  Many survival = 0;
  for (int k = 0; k < expected.slots; ++k) survival = survival * (1 - p) + p;
  return none || (p.all() <= 0.5f && dark(survival));
}

struct Made {
  Paint paint{};
  Layer<Many> layer{};
};

// The paint's layer, kept for the next call, mostly of the same paint: making it takes as long as
// eight pixels. Behind a pointer, as a module's thread-local memory may be less than it takes.
const Layer<Many>& layer_of(const Paint& paint) {
  static thread_local std::unique_ptr<Made> last;
  if (last == nullptr || !(last->paint == paint)) {
    last = std::make_unique<Made>(Made{.paint = paint});
    Many::in_lanes(kCount, [] { last->layer = make_layer<Many>(last->paint); });
  }
  return last->layer;
}

}  // namespace

// Flat: what is called there would else hand the lanes over through memory.
[[gnu::flatten]] void METALLIC_PAINT_NAME(METALLIC_PAINT_LANES_FOR)(
    const Paint& paint, const std::vector<Light<double>>& lights, std::size_t species,
    const StreamKeys& keys, const PixelBatch& batch, const PixelResults& results, std::size_t begin,
    std::size_t end, LightsToDraw& to) {
  const Layer<Many>& layer = layer_of(paint);
  Many turned;
  std::vector<Light<Many>> slots;
  Many::in_lanes(kCount, [&] {
    turned = turned_by(layer);
    slots = slots_of<Many>(lights);
  });
  // Made once: to clear them for each pixel took 7 % of the time.
  SurfacePoint<Many> point{};
  std::array<ExpectedSparkles<Many>, kSpecies> expected;
  std::array<Many::Mask, kSpecies> dark;
  ExpectedLight one{};
  SlotView<Many> view;
  for (std::size_t i = begin; i < end; i += kCount) {
    const std::size_t rows = std::min(kCount, end - i);
    point.position = gather_vectors(batch.position, i, 1, rows);
    point.normal = gather_vectors(batch.normal, i, 1, rows);
    point.view = gather_vectors(batch.view, i, 1, rows);
    point.footprint = gather(batch.footprint, i, 1, rows);
    // What is stored of a lane that is left behind later, its own pass overwrites.
    Many::in_lanes(rows, [&] {
      view_slots(slots, point, turned, view);
      for (std::size_t light = 0; light < slots.size(); ++light) {
        const int leader = view.leader[light];
        if (leader != static_cast<int>(light)) {
          Many::each_followed([&](std::size_t lane) { to.follow(i + lane, light, leader); });
          continue;
        }
        Rgb<Many> slant{};
        if (batch.slant.given()) {
          slant = gather_vectors(batch.slant, i * slots.size() + light, slots.size(), rows);
        }
        const Passage<Many> way =
            pass_between(layer, point, view.seen[light], batch.slant.given() ? &slant : nullptr);
        Rgb<Many> mean{}, variance{};
        Many::Mask lit(false);
        for (std::size_t at = 0; at < static_cast<std::size_t>(layer.species); ++at) {
          expected[at] = expect_sparkles(layer, layer.flakes[at], point.footprint, way);
          mean = mean + mean_radiance(expected[at]);
          variance = variance + radiance_variance(expected[at]);
          dark[at] = dark_lanes(expected[at], keys[light][at], batch.pixel + 2 * i, rows);
          lit = lit || !dark[at];
        }
        const ExpectedSparkles<Many>& told = expected[species];
        if (slots.size() == 1 && Many::all_followed()) {
          Many::Ints(leader).copy_to(results.leader + i, kInTurn);
          Many::Ints(told.slots).copy_to(results.slots + i, kInTurn);
          told.mean_count.all().copy_to(results.mean_count + i, kInTurn);
          Simd(0).copy_to(results.count + i, kInTurn);
          store_in_turn(results.radiance + 3 * i, {});
          store_in_turn(results.mean_radiance + 3 * i, mean);
          store_in_turn(results.variance + 3 * i, variance);
        } else {
          Many::each_followed([&](std::size_t lane) {
            const std::size_t at = (i + lane) * slots.size() + light;
            results.leader[at] = leader;
            results.slots[at] = told.slots;
            results.mean_count[at] = static_cast<double>(told.mean_count[lane]);
            results.count[at] = 0;
            store_colour(results.radiance, at, Rgb<float>{});
            store_colour(results.mean_radiance, at, of_lane(mean, lane));
            store_colour(results.variance, at, of_lane(variance, lane));
          });
        }
        const auto draw = [&](std::size_t lane) {
          for (std::size_t at = 0; at < static_cast<std::size_t>(layer.species); ++at) {
            one.dark[at] = dark[at][lane];
            if (one.dark[at]) {
              one.sparkles.expected[at].ceiling = expected[at].ceiling[lane];
            } else {
              one.sparkles.expected[at] = of_lane(expected[at], lane);
            }
          }
          to.draw(i + lane, light, one);
        };
        Many::each_followed(draw, lit);
      }
    });
  }
}

}  // namespace metallic_paint
