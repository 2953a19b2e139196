// SPDX-License-Identifier: Apache-2.0
//
// Many pixels at once, over all cores: what the bindings and the verification call.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "light_slots.h"
#include "paint.h"
#include "parallel.h"
#include "sparkles.h"

namespace metallic_paint {

// An array of numbers where the caller has it, doubles or floats.
class Column {
 public:
  Column() = default;
  Column(const double* doubles) : doubles_(doubles) {}
  Column(const float* floats) : floats_(floats) {}

  bool given() const { return doubles_ != nullptr || floats_ != nullptr; }
  // use(pointer to the first), whichever it is.
  template <class Use>
  auto as_they_are(const Use& use) const {
    return floats_ != nullptr ? use(floats_) : use(doubles_);
  }
  double operator[](std::size_t i) const {
    return floats_ != nullptr ? static_cast<double>(floats_[i]) : doubles_[i];
  }

 private:
  const double* doubles_ = nullptr;
  const float* floats_ = nullptr;
};

// Arrays over n pixels, and the lights' slots behind them; row-major.
struct PixelBatch {
  std::size_t size;
  Column position;                         // n x 3, scene units
  Column normal;                           // n x 3, unit
  Column view;                             // n x 3, unit, towards the observer
  Column footprint;                        // n, m2
  const std::int32_t* pixel;               // n x 2
  Column own_position{};                   // n x 3, m: position, and Anchor::pixel, if not given
  Column own_axes{};                       // n x 3 x 3, unit: the world's axes if not given
  const std::int32_t* instance = nullptr;  // n: 0 if not given
  Column slant{};  // n x lights x 3: optical depth t H in place of the layer's own
};

template <class T>
Vec3<T> vector_at(const Column& column, std::size_t i) {
  return {static_cast<T>(column[3 * i]), static_cast<T>(column[3 * i + 1]),
          static_cast<T>(column[3 * i + 2])};
}

// Sparkles of pixels that do not know where on the paint they lie belong to the pixels.
template <class T>
Layer<T> layer_under(Layer<T> layer, const PixelBatch& batch) {
  if (!batch.own_position.given()) layer.anchor = Anchor::pixel;
  return layer;
}

template <class T>
std::vector<Light<T>> slots_of(const std::vector<Light<double>>& lights) {
  std::vector<Light<T>> slots;
  for (const Light<double>& light : lights) {
    slots.push_back(
        {light.kind, Vec3<T>(light.vector), static_cast<T>(light.size), Vec3<T>(light.facing)});
  }
  return slots;
}

template <class T>
SurfacePoint<T> point_at(const PixelBatch& batch, std::size_t i) {
  SurfacePoint<T> point{vector_at<T>(batch.position, i),
                        vector_at<T>(batch.normal, i),
                        vector_at<T>(batch.view, i),
                        static_cast<T>(batch.footprint[i]),
                        batch.pixel[2 * i],
                        batch.pixel[2 * i + 1]};
  point.own.position =
      vector_at<T>(batch.own_position.given() ? batch.own_position : batch.position, i);
  if (batch.own_axes.given()) {
    point.own.x = vector_at<T>(batch.own_axes, 3 * i);
    point.own.y = vector_at<T>(batch.own_axes, 3 * i + 1);
    point.own.z = vector_at<T>(batch.own_axes, 3 * i + 2);
  }
  if (batch.instance != nullptr) point.own.instance = batch.instance[i];
  return point;
}

struct PixelResults {
  std::int32_t* leader;  // n x lights
  // n x lights, of all species, but `slots` of the first; 0 for a light that does not lead.
  std::int32_t* slots;  // 0 for a Poisson count, k for a binomial one
  double* mean_count;
  double* count;
  // n x lights x 3, the leader's, of all species.
  double* radiance;  // T
  double* mean_radiance;
  double* variance;
};

// Throws std::invalid_argument that names the array, the row and the value. lights: of batch.slant.
void validate(const PixelBatch& batch, std::size_t lights = 0);

template <class T>
void store_colour(double* array, std::size_t at, const Rgb<T>& value) {
  array[3 * at] = static_cast<double>(value.x);
  array[3 * at + 1] = static_cast<double>(value.y);
  array[3 * at + 2] = static_cast<double>(value.z);
}

// Stores those of pixel i, whose lights have these leaders; sparkles_of(light) are those of one
// that leads. The leader comes first: a follower's results are there to copy.
template <class Sparkles>
void store_pixel(const PixelResults& results, std::size_t i, std::size_t lights,
                 const std::array<int, kLightSlots>& leaders, const Sparkles& sparkles_of) {
  for (std::size_t light = 0; light < lights; ++light) {
    const int leader = leaders[light];
    const std::size_t at = i * lights + light;
    results.leader[at] = leader;
    if (leader != static_cast<int>(light)) {
      const std::size_t from = i * lights + static_cast<std::size_t>(std::max(leader, 0));
      results.slots[at] = 0;
      results.count[at] = results.mean_count[at] = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        results.radiance[3 * at + c] = leader < 0 ? 0 : results.radiance[3 * from + c];
        results.mean_radiance[3 * at + c] = leader < 0 ? 0 : results.mean_radiance[3 * from + c];
        results.variance[3 * at + c] = leader < 0 ? 0 : results.variance[3 * from + c];
      }
      continue;
    }
    const auto& all = sparkles_of(light);
    results.slots[at] = all.slots;
    results.mean_count[at] = static_cast<double>(all.mean_count);
    results.count[at] = static_cast<double>(all.count);
    store_colour(results.radiance, at, all.radiance);
    store_colour(results.mean_radiance, at, all.mean_radiance);
    store_colour(results.variance, at, all.variance);
  }
}

// What the shader computes at each pixel, in T: float repeats it, double is the reference. The
// layer is the paint's. Once `stop` is requested, the rest of the results stays unset.
template <class T>
void evaluate_pixels(const Paint& paint, const Layer<T>& layer_of_paint,
                     const std::vector<Light<double>>& lights, const PixelBatch& batch,
                     const PixelResults& results, const std::stop_token& stop = {}) {
  const Layer<T> layer = layer_under(layer_of_paint, batch);
  const std::vector<Light<T>> slots = slots_of<T>(lights);
  const T turned = turned_by(layer);
  const auto evaluate_pixel = [&](std::size_t i) {
    const SurfacePoint<T> point = under_orange_peel(paint, point_at<T>(batch, i));
    const SlotView<T> view = view_slots(slots, point, turned);
    const auto firsts = look_close(layer, point, paint.frame, paint.seed);
    const Cell<T> cell = cell_of_counts(layer, point, firsts, paint.frame, paint.seed);
    store_pixel(results, i, slots.size(), view.leader, [&](std::size_t light) {
      const Rgb<T> slant =
          batch.slant.given() ? vector_at<T>(batch.slant, i * slots.size() + light) : Rgb<T>{};
      const Passage<T> way =
          pass_between(layer, point, view.seen[light], batch.slant.given() ? &slant : nullptr);
      return sparkle(layer, point, firsts, cell, way, static_cast<int>(light), paint.frame,
                     paint.seed);
    });
  };
  parallel_for(batch.size, evaluate_pixel, 1024, stop);
}

}  // namespace metallic_paint
