// SPDX-License-Identifier: Apache-2.0
//
// Many pixels at once, over all cores: what the bindings and the verification call.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <type_traits>
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
  // n x lights, of the flakes of one species; 0 for a light that does not lead.
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

// Stores what is drawn for a light that leads; `at` is its place in the results.
template <class T>
void store_draw(const PixelResults& results, std::size_t at, T count, const Rgb<T>& radiance) {
  results.count[at] = static_cast<double>(count);
  store_colour(results.radiance, at, radiance);
}

// Stores the results of a light in pixel i that does not lead. The leader comes first: its results
// are there to copy.
inline void store_follower(const PixelResults& results, std::size_t i, std::size_t lights,
                           std::size_t light, int leader) {
  const std::size_t at = i * lights + light;
  const std::size_t from = i * lights + static_cast<std::size_t>(std::max(leader, 0));
  results.leader[at] = leader;
  results.slots[at] = 0;
  results.count[at] = results.mean_count[at] = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    results.radiance[3 * at + c] = leader < 0 ? 0 : results.radiance[3 * from + c];
    results.mean_radiance[3 * at + c] = leader < 0 ? 0 : results.mean_radiance[3 * from + c];
    results.variance[3 * at + c] = leader < 0 ? 0 : results.variance[3 * from + c];
  }
}

// Those of pixel i, whose lights have these leaders; sparkles_of(light) are those of one that
// leads.
template <class Sparkles>
void store_pixel(const PixelResults& results, std::size_t i, std::size_t lights,
                 std::size_t species, const std::array<int, kLightSlots>& leaders,
                 const Sparkles& sparkles_of) {
  for (std::size_t light = 0; light < lights; ++light) {
    if (leaders[light] != static_cast<int>(light)) {
      store_follower(results, i, lights, light, leaders[light]);
      continue;
    }
    const auto& all = sparkles_of(light);
    const std::size_t at = i * lights + light;
    results.leader[at] = leaders[light];
    results.slots[at] = all.expected[species].slots;
    results.mean_count[at] = static_cast<double>(all.expected[species].mean_count);
    store_draw(results, at, all.count[species], all.radiance);
    store_colour(results.mean_radiance, at, all.mean_radiance);
    store_colour(results.variance, at, all.variance);
  }
}

using StreamKeys = std::array<std::array<HashWords, kSpecies>, kLightSlots>;

// A light in one of the pixels in float whose sparkles belong to the pixel: many are computed side
// by side (expect_lanes.cpp), bit for bit as one by one, but for the draws.
struct ExpectedLight {
  PixelSparkles<float> sparkles;    // radiance and count are to be drawn
  std::array<bool, kSpecies> dark;  // no sparkle of this species is drawn; only `ceiling` is told
};
// What is left to be done one by one. What is told of a light a second time takes the place of the
// first.
class LightsToDraw {
 public:
  // The light leads, and some species is not dark; all but the draw is stored.
  virtual void draw(std::size_t i, std::size_t light, ExpectedLight& expected) = 0;
  // The light does not lead. Lights of a pixel come in their order.
  virtual void follow(std::size_t i, std::size_t light, int leader) = 0;

 protected:
  ~LightsToDraw() = default;
};
// Does the pixels from `begin` up to `end`, in any order; `to` does the rest of each at once.
using ExpectInLanes = void (*)(const Paint& paint, const std::vector<Light<double>>& lights,
                               std::size_t species, const StreamKeys& keys, const PixelBatch& batch,
                               const PixelResults& results, std::size_t begin, std::size_t end,
                               LightsToDraw& to);
// Those that this processor can run, the one with the most lanes first; none where the standard
// library knows no lanes.
const std::vector<ExpectInLanes>& expect_in_lanes();

// As evaluate_pixels.
void evaluate_in_lanes(ExpectInLanes expect, const Paint& paint, const Layer<float>& layer,
                       const std::vector<Light<double>>& lights, std::size_t species,
                       const PixelBatch& batch, const PixelResults& results,
                       const std::stop_token& stop);

// What the shader computes at each pixel, in T: float repeats it, double is the reference. The
// layer is the paint's. The counts are those of `species`. Once `stop` is requested, the rest of
// the results stays unset.
template <class T>
void evaluate_pixels(const Paint& paint, const Layer<T>& layer_of_paint,
                     const std::vector<Light<double>>& lights, std::size_t species,
                     const PixelBatch& batch, const PixelResults& results,
                     const std::stop_token& stop = {}) {
  const Layer<T> layer = layer_under(layer_of_paint, batch);
  if constexpr (std::is_same_v<T, float>) {
    if (layer.anchor == Anchor::pixel && !(paint.orange_peel > 0) && !expect_in_lanes().empty()) {
      return evaluate_in_lanes(expect_in_lanes().front(), paint, layer, lights, species, batch,
                               results, stop);
    }
  }
  const std::vector<Light<T>> slots = slots_of<T>(lights);
  const T turned = turned_by(layer);
  const auto evaluate_pixel = [&](std::size_t i) {
    const SurfacePoint<T> point = under_orange_peel(paint, point_at<T>(batch, i));
    const SlotView<T> view = view_slots(slots, point, turned);
    const auto firsts = look_close(layer, point, paint.frame, paint.seed);
    store_pixel(results, i, slots.size(), species, view.leader, [&](std::size_t light) {
      const Rgb<T> slant =
          batch.slant.given() ? vector_at<T>(batch.slant, i * slots.size() + light) : Rgb<T>{};
      const Passage<T> way =
          pass_between(layer, point, view.seen[light], batch.slant.given() ? &slant : nullptr);
      return sparkle(layer, point, firsts, way, static_cast<int>(light), paint.frame, paint.seed);
    });
  };
  parallel_for(batch.size, evaluate_pixel, 1024, stop);
}

}  // namespace metallic_paint
