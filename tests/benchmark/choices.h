// SPDX-License-Identifier: Apache-2.0
//
// The choices: groups of options for one and the same thing. Each option is the shipped model with
// that thing alone changed.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "alternatives.h"
#include "hot_spot.h"
#include "paint.h"
#include "scene.h"
#include "tables.h"

namespace trade {

struct Drawn {
  double count;
  Rgb<double> radiance;
};

class Model {
 public:
  virtual ~Model() = default;
  virtual void load(const std::vector<SurfacePoint<double>>& points) = 0;
  // Every loaded pixel once, from its geometry on: what a picture costs.
  virtual void draw(int seed, std::vector<Drawn>& drawn) const = 0;
  // A loaded pixel again and again, one seed after the other.
  virtual std::vector<Drawn> draw_again(std::size_t pixel, int first_seed, int count) const = 0;
};

// How the model differs from the paint's own. 0 intervals: no table.
struct Change {
  std::function<void(Paint&)> paint = [](Paint&) {};
  int orientation_intervals = 0, projection_intervals = 0;
};

template <class T, class Draw>
class ModelOf : public Model {
 public:
  ModelOf(const Scene& scene, const Change& change, Draw draw)
      : paint_(scene.paint),
        light_{scene.light.kind, Vec3<T>(scene.light.vector), static_cast<T>(scene.light.size)},
        draw_(draw) {
    change.paint(paint_);
    layer_ = make_layer<T>(paint_);
    const Flakes<T>& flakes = layer_.flakes[0];
    if (change.orientation_intervals > 0) {
      orientation_.emplace(flakes.orientation, change.orientation_intervals);
    }
    if (change.projection_intervals > 0) {
      projection_.emplace(flakes.orientation, flakes.coating, change.projection_intervals);
    }
  }

  void load(const std::vector<SurfacePoint<double>>& points) override {
    points_.clear();
    for (const SurfacePoint<double>& p : points) {
      points_.push_back({Vec3<T>(p.position), Vec3<T>(p.normal), Vec3<T>(p.view),
                         static_cast<T>(p.footprint), p.pixel_x, p.pixel_y});
    }
  }

  void draw(int seed, std::vector<Drawn>& drawn) const override {
    const HashKey key = key_of(seed);
    drawn.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      drawn[i] = draw_one(expect(points_[i]), key, points_[i]);
    }
  }

  std::vector<Drawn> draw_again(std::size_t pixel, int first_seed, int count) const override {
    const ExpectedSparkles<T> expected = expect(points_[pixel]);
    std::vector<Drawn> drawn;
    for (int i = 0; i < count; ++i) {
      drawn.push_back(draw_one(expected, key_of(first_seed + i), points_[pixel]));
    }
    return drawn;
  }

 private:
  static HashKey key_of(int seed) { return stream_key(kFlakeStream, 0, 0, seed); }
  ExpectedSparkles<T> expect(const SurfacePoint<T>& point) const {
    const SeenLight<T> seen = see_light(light_, point.position);
    const Flakes<T>& flakes = layer_.flakes[0];
    if (orientation_) {
      const Passage<T> way = pass_between(layer_, point, seen);
      const Wide<T> inside = way.open ? cone_in_binder(flakes, way) : 0;
      if (!(inside > 0)) return {};
      // At the centre of the cone of normals, as in the paper's eq. 4.
      const Wide<T> p = orientation_->at(static_cast<T>(way.mirror.sin2_half_beta));
      const auto probability =
          static_cast<T>(std::min(2 * p * quarter_cone(inside, way), Wide<T>(1)));
      return expect_sparkles(layer_, flakes, point.footprint, way, inside, probability);
    }
    if (projection_) {
      const Rgb<T> none{};  // the layer's own depth is not computed
      Passage<T> way = pass_between(layer_, point, seen, &none);
      if (way.open) {
        const auto& m = way.mirror;
        const T apart = ways_apart(point.normal, point.view, static_cast<T>(m.cos_view),
                                   static_cast<T>(m.g_view), Vec3<T>(seen.direction),
                                   static_cast<T>(m.cos_light), static_cast<T>(m.g_light));
        const Rgb<T> in = tabulated_depth(m.g_view), out = tabulated_depth(m.g_light);
        way.ways = both_ways(layer_, in, out, apart);
        way.slant = there_and_back(layer_, way.ways);
        way.given = false;
      }
      return expect_sparkles(layer_, flakes, point.footprint, way);
    }
    return expect_sparkles(layer_, point, seen);
  }
  Rgb<T> tabulated_depth(Wide<T> g) const {
    const T cosine = static_cast<T>(std::min(g / layer_.eta, Wide<T>(1)));
    return slant_depth(projection_->at(cosine) * layer_.coverage, layer_.binder_depth, cosine);
  }
  Drawn draw_one(const ExpectedSparkles<T>& expected, HashKey key,
                 const SurfacePoint<T>& point) const {
    const Sparkles<T> sparkles = draw_(expected, pixel_key(key, point.pixel_x, point.pixel_y, 0));
    return {static_cast<double>(sparkles.count), Rgb<double>(sparkles.radiance)};
  }

  Paint paint_;
  Light<T> light_;
  Draw draw_;
  Layer<T> layer_;
  std::optional<OrientationTable<T>> orientation_;
  std::optional<ProjectionTable<T>> projection_;
  std::vector<SurfacePoint<T>> points_;
};

using MakeModel = std::function<std::unique_ptr<Model>(const Scene&)>;

template <class T, class Draw>
MakeModel model(Change change = {}, Draw draw = {}) {
  return
      [=](const Scene& scene) { return std::make_unique<ModelOf<T, Draw>>(scene, change, draw); };
}

// Which random numbers an option shares with the exact one of its group.
enum class Numbers { same, counts, own };

struct Option {
  std::string name;
  MakeModel make;
  Numbers numbers = Numbers::same;
};

// The exact option is what the others are measured against.
struct Group {
  std::string name;
  std::string exact, shipped;
  std::vector<Option> options;
  bool default_paint = true;  // the shipped option draws what the other groups' draw
};

template <class T = float>
MakeModel shipped(Change change = {}) {
  return model<T, Shipped>(change);
}
inline MakeModel with_paint(const std::function<void(Paint&)>& change) {
  return shipped({.paint = change});
}

inline std::vector<Group> groups() {
  const auto orientation = [](int n) { return shipped({.orientation_intervals = n}); };
  const auto projection = [](int n) { return shipped({.projection_intervals = n}); };
  return {
      {"number type",
       "long double",
       "float",
       {{"float", shipped()},
        {"double", shipped<double>()},
        {"double, table of 256 for ⟨s⟩", shipped<double>({.projection_intervals = 256})},
        {"long double", shipped<long double>()}}},
      // The paper has P at the centre of the cone of normals, from a table.
      {"orientation P(β)",
       "integrated over the cone",
       "integrated over the cone",
       {{"integrated over the cone", shipped()},
        {"at the centre, table of 256", orientation(256)},
        {"at the centre, table of 1024", orientation(1024)},
        {"at the centre, table of 4096", orientation(4096)},
        {"at the centre, table of 16384", orientation(16384)}}},
      {"blocked area ⟨s⟩ − ⟨t⟩",
       "exact",
       "exact",
       {{"exact", shipped()},
        {"table of 64", projection(64)},
        {"table of 256", projection(256)},
        {"table of 1024", projection(1024)}}},
      {"draw",
       "sparkle by sparkle",
       "one drawn, the others as a sum",
       {{"one drawn, the others as a sum", shipped(), Numbers::counts},
        {"sparkle by sparkle", model<float, OneByOne>()},
        {"N × mean sparkle", model<float, CountTimesMean>(), Numbers::counts},
        {"mean only, no draw", model<float, MeanOnly>(), Numbers::own}}},
      {"radiometry",
       "exact",
       "exact",
       {{"exact", shipped()},
        {"published", with_paint([](Paint& p) { p.radiometry = Radiometry::published; })}}},
      {"depth",
       "correlated",
       "correlated",
       {{"correlated", shipped()},
        {"attenuated", with_paint([](Paint& p) { p.depth_model = DepthModel::attenuated; })},
        {"thinned", with_paint([](Paint& p) { p.depth_model = DepthModel::thinned; }),
         Numbers::own}}},
      // Not another way to compute the same but another paint.
      {"flake spread ε",
       "0.005",
       "0.005",
       {{"0.005", shipped()},
        {"0", with_paint([](Paint& p) { p.flake_spread = 0; }), Numbers::own},
        {"0.02", with_paint([](Paint& p) { p.flake_spread = 0.02; }), Numbers::own}}},
      {"all together",
       "everything exact, in double",
       "as shipped",
       {{"as shipped", shipped(), Numbers::counts},
        {"everything exact, in double", model<double, OneByOne>()}}},
  };
}

}  // namespace trade
