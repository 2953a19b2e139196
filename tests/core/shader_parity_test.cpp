// SPDX-License-Identifier: Apache-2.0
//
// The shader's text, compiled as C++, repeats core<float> bit for bit: every inner value, over
// random scenes with every parameter anywhere in its range. What only a renderer can break
// (transforms, closures, folded constants, Blender's own functions) is left to renders.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "composition.h"
#include "cones.h"
#include "diffuse_lobe.h"
#include "flake_lobe.h"
#include "light_slots.h"
#include "mixture.h"
#include "orange_peel.h"
#include "osl_shim.h"
#include "scenes.h"
#include "sparkles.h"
#include "support.h"
#include "texture.h"
#include "whole_paint.h"

namespace {

using namespace core_tests;

osl::Triple to_osl(Vec3<float> v) { return {v.x, v.y, v.z}; }

// Compares bit for bit and tells the first value that differs.
class Same {
 public:
  void operator()(const char* name, float shader, float core) {
    ++seen_;
    if (std::bit_cast<std::uint32_t>(shader) == std::bit_cast<std::uint32_t>(core)) return;
    if (!different_.empty()) return;
    std::ostringstream text;
    text.precision(9);
    text << name << " is " << shader << " in osl/, " << core << " in core/";
    different_ = text.str();
  }
  void operator()(const char* name, int shader, int core) {
    ++seen_;
    if (shader == core || !different_.empty()) return;
    different_ = std::string(name) + " is " + std::to_string(shader) + " in osl/, " +
                 std::to_string(core) + " in core/";
  }
  void operator()(const char* name, osl::Triple shader, Vec3<float> core) {
    (*this)(name, shader[0], core.x);
    (*this)(name, shader[1], core.y);
    (*this)(name, shader[2], core.z);
  }
  void operator()(const char* name, const std::vector<std::uint32_t>& shader,
                  const std::vector<std::uint32_t>& core) {
    (*this)((std::string("number of words of ") + name).c_str(), static_cast<int>(shader.size()),
            static_cast<int>(core.size()));
    for (std::size_t i = 0; i < std::min(shader.size(), core.size()); ++i) {
      (*this)((std::string(name) + ", word " + std::to_string(i)).c_str(),
              std::bit_cast<float>(shader[i]), std::bit_cast<float>(core[i]));
    }
  }
  const std::string& different() const { return different_; }
  long seen() const { return seen_; }

 private:
  long seen_ = 0;
  std::string different_;
};

std::vector<float> shader_library() {
  return {std::begin(kCoatingLibrary), std::end(kCoatingLibrary)};
}

// A struct of the shader's from one of the core's: the table of parameters gives both the same
// fields in the same order, each of 32 bits or a colour of three.
class Words {
 public:
  void operator()(double x) {
    words_.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(x)));
  }
  void operator()(int x) { words_.push_back(static_cast<std::uint32_t>(x)); }
  template <class Choice>
    requires std::is_enum_v<Choice>
  void operator()(Choice x) {
    (*this)(static_cast<int>(x));
  }
  void operator()(Rgb<double> c) {
    for (const double x : {c.x, c.y, c.z}) (*this)(x);
  }
  template <class Struct>
  Struct as() const {
    std::array<std::uint32_t, sizeof(Struct) / 4> words{};
    EXPECT_EQ(words_.size(), words.size());
    std::copy_n(words_.begin(), std::min(words_.size(), words.size()), words.begin());
    return std::bit_cast<Struct>(words);
  }

 private:
  std::vector<std::uint32_t> words_;
};

osl::FlakeSpecies to_osl(const FlakeSpecies& species) {
  Words words;
  each_flake_parameter([&](auto, auto member, auto) { words(species.*member); });
  return words.as<osl::FlakeSpecies>();
}

struct ShaderPaint {
  osl::Paint given;
  osl::Layer layer;
  std::array<osl::Flakes, kSpecies> flakes;
};

ShaderPaint to_osl(const Paint& paint, float* library) {
  Words words;
  each_paint_parameter([&](auto, auto member, auto) { words(paint.*member); });
  ShaderPaint shader;
  const osl::Paint& given = shader.given = words.as<osl::Paint>();
  for (int i = 0; i < kSpecies; ++i) {
    shader.flakes[static_cast<std::size_t>(i)] =
        osl::make_flakes(to_osl(paint.species(i)), given.binder_ior, given.diffraction);
  }
  shader.layer =
      osl::make_layer(given, shader.flakes[0], shader.flakes[1], shader.flakes[2], library);
  return shader;
}

// Whole structs, word by word: both texts have the same fields in the same order, each of 32 bits
// or of such, so that none can be left out here.
template <class Struct>
std::vector<std::uint32_t> words_of(const Struct& all) {
  const auto words = std::bit_cast<std::array<std::uint32_t, sizeof(Struct) / 4>>(all);
  return {words.begin(), words.end()};
}

void compare(Same& same, const osl::Layer& shader, const Layer<float>& core) {
  same("species", shader.species, core.species);
  // Before these the species' flakes, which are compared on their own.
  using Core = Layer<float>;
  static_assert(offsetof(Core, coverage) == sizeof(Core::flakes) + sizeof(Core::species));
  const auto from_coverage = [](const auto& layer, std::size_t offset) {
    std::vector<std::uint32_t> words = words_of(layer);
    words.erase(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(offset / 4));
    return words;
  };
  same("Layer from coverage on", from_coverage(shader, offsetof(osl::Layer, coverage)),
       from_coverage(core, offsetof(Core, coverage)));
}

void compare(Same& same, const osl::Flakes& shader, const Flakes<float>& core) {
  std::vector<std::uint32_t> words = words_of(shader);
  // Only the shader notes it: the core asks where it is needed.
  words.erase(words.begin() +
              (offsetof(osl::Flakes, orientation) + offsetof(osl::OrientationDensity, narrow)) / 4);
  same("Flakes", words, words_of(core));
}

struct ParityScene {
  Paint paint;
  SurfacePoint<float> point;
  std::vector<Light<float>> lights;
};

Vec3<float> at_cosine(Random& random, double z) {
  const double phi = random.uniform(0, 6.2831853);
  const double sine = std::sqrt((1 - z) * (1 + z));
  return Vec3<float>(turned({sine * std::cos(phi), sine * std::sin(phi), z}));
}

Vec3<float> unit(Random& random, double least_cosine) {
  return at_cosine(random, random.uniform(least_cosine, 1));
}

ParityScene random_scene(Random& random) {
  ParityScene scene;
  // Ordinary paints reach more of the model than those from anywhere.
  scene.paint = random.below(2) == 0 ? any_paint(random) : random_paint(random);
  if (random.below(4) == 0) scene.paint.more[0] = library_species(random, 0.5, 0.2);
  // The shader lets flakes give back no more than they get; the core refuses those that do.
  if (max_component(scene.paint.flake_edge_color + scene.paint.flake_transmission) > 1) {
    scene.paint.flake_transmission = {};
  }
  scene.point = {Vec3<float>{static_cast<float>(random.uniform(-1, 1)),
                             static_cast<float>(random.uniform(-1, 1)),
                             static_cast<float>(random.uniform(-1, 1))},
                 Vec3<float>(turned({0, 0, 1})),
                 unit(random, random.below(8) == 0 ? -1e-3 : 0.05),
                 static_cast<float>(random.log_uniform(1e-30, 1e30)),
                 static_cast<int>(random.bits()),
                 static_cast<int>(random.bits())};
  if (random.below(16) == 0) {
    // All but along the surface, where an index of 1 bends the view no steeper.
    scene.point.view = at_cosine(random, random.log_uniform(1e-7, 1e-3));
    scene.paint.binder_ior = 1;
  }
  if (random.below(2) == 0)
    scene.point.footprint = static_cast<float>(random.log_uniform(1e-12, 1e-2));
  scene.paint.anchor = random.below(3) == 0 ? Anchor::pixel : Anchor::surface;
  scene.paint.instances = random.below(2) == 0 ? Instances::same : Instances::own;
  // Anywhere in an object of any size, turned anyhow.
  const double far = random.log_uniform(1e-9, random.below(8) == 0 ? 1e30 : 1e3);
  scene.point.own.position = {static_cast<float>(far * random.uniform(-1, 1)),
                              static_cast<float>(far * random.uniform(-1, 1)),
                              static_cast<float>(far * random.uniform(-1, 1))};
  if (random.below(4) != 0) {
    const Vec3<float> x = unit(random, -1), other = unit(random, -1);
    const Vec3<float> across = other - x * dot(x, other);
    if (length(across) > 1e-3f) {
      const Vec3<float> y = across / length(across);
      scene.point.own.x = x;
      scene.point.own.y = y;
      scene.point.own.z = cross(x, y);
    }
  }
  scene.point.own.instance = static_cast<int>(random.bits());
  for (int i = 0; i < kLightSlots; ++i) {
    Light<float> light;
    light.kind = static_cast<LightKind>(random.below(5));
    light.vector = unit(random, -0.3);
    if (random.below(2) == 0) {
      // About the mirror direction, where it glitters.
      const Vec3<float> n = scene.point.normal, v = scene.point.view;
      const double off = random.log_uniform(1e-4, 1);
      light.vector = n * (2 * dot(n, v)) - v + unit(random, -1) * static_cast<float>(off);
    }
    light.size = random.below(4) == 0 ? 0 : static_cast<float>(random.log_uniform(1e-6, 1));
    if (random.below(8) == 0) light.size = static_cast<float>(random.uniform(0, 3));
    if (random.below(8) != 0) {
      light.facing = unit(random, -1) * (light.size * static_cast<float>(random.uniform(0.8, 3)));
      if (dot(light.facing, light.vector - scene.point.position) > 0 && random.below(4) != 0) {
        light.facing = light.facing * -1.0f;
      }
    }
    scene.lights.push_back(light);
  }
  return scene;
}

// How often the scenes came to what is rare.
struct Visits {
  long led = 0, few = 0, many = 0, crowded = 0, sampled = 0, wide = 0, smooth = 0, grazed = 0,
       close = 0, covered = 0, lit = 0, melting = 0, melted = 0, bent = 0;
};

// Every value that the shader computes for the scene, by both texts.
void compare(Same& same, const ParityScene& scene, std::vector<float>& library_values,
             Visits& visits) {
  const Paint& paint = scene.paint;
  const SurfacePoint<float> point = under_orange_peel(paint, scene.point);
  float* library = library_values.data();
  const Layer<float> layer = make_layer<float>(paint);
  const auto [given, shader_layer, shader_flakes] = to_osl(paint, library);
  compare(same, shader_layer, layer);
  for (std::size_t i = 0; i < kSpecies; ++i) compare(same, shader_flakes[i], layer.flakes[i]);

  const float cos_view = osl::seen_cosine(to_osl(point.normal), to_osl(point.view));
  same("seen_cosine", cos_view, seen_cosine(point.normal, point.view));
  visits.grazed += cos_view < 1e-4f;
  osl::SurfacePoint surface;
  surface.position = to_osl(point.position);
  surface.n = to_osl(point.normal);
  surface.view = to_osl(point.view);
  surface.footprint = point.footprint;
  surface.pixel_x = point.pixel_x;
  surface.pixel_y = point.pixel_y;
  surface.own = {to_osl(point.own.position), to_osl(point.own.x), to_osl(point.own.y),
                 to_osl(point.own.z), point.own.instance};
  surface.plane = osl::lattice_plane(surface.own, surface.n);
  surface.bends = point.bends;
  surface.below = surface.view;
  if (surface.bends) {
    surface.waves =
        osl::waves_at(surface.own.position, static_cast<float>(paint.orange_peel_mm) * 0.001f);
    surface.wave =
        osl::orange_peel(surface.n, surface.waves, static_cast<float>(paint.orange_peel));
    surface.below = osl::through_wave(surface.view, surface.n, surface.wave, layer.eta);
    same("wave", surface.wave, point.wave);
    ++visits.bent;
  }
  same("view under the wave", surface.below, view_below(point));
  const float cos_below = osl::seen_cosine(surface.n, surface.below);
  surface.cos_in = osl::min(osl::eta_cos_refracted(cos_below, layer.eta) / layer.eta, 1.0f);
  surface.slant = osl::slant_depth_of(shader_layer, library, surface.cos_in, surface.areas);
  same("slant to the observer", surface.slant, slant_depth_of(layer, surface.cos_in));

  const SlotView<float> slots = view_slots(scene.lights, point, turned_by(layer));
  std::array<osl::SeenLight, 8> seen;
  std::array<int, 8> leader, slot;
  int lights = 0;
  for (int i = 0; i < kLightSlots; ++i) {
    const Light<float>& light = scene.lights[static_cast<std::size_t>(i)];
    const auto found = osl::see_light(static_cast<int>(light.kind), to_osl(light.vector),
                                      light.size, to_osl(light.facing), surface.position);
    const SeenLight<float>& expected = slots.seen[static_cast<std::size_t>(i)];
    same("visible", found.visible, expected.visible);
    if (!found.visible) continue;
    same("direction", found.direction, expected.direction);
    same("sin2_half_radius", found.sin2_half_radius, expected.sin2_half_radius);
    same("reach", found.reach, see_light(light, point.position).reach);
    same("breadth", found.breadth, expected.breadth);
    if (!(osl::inner_product(surface.n, found.direction) > 0)) continue;
    const auto at = static_cast<std::size_t>(lights);
    seen[at] = found;
    leader[at] = lights;
    slot[at] = i;
    ++lights;
  }
  osl::share_cones(seen, leader, lights, osl::turned_by(shader_layer));

  // The flakes that are seen themselves.
  const auto firsts = look_close(layer, point, paint.frame, paint.seed);
  std::array<osl::FirstFlake, kSpecies> shader_firsts;
  shader_firsts.fill(osl::no_flake());
  osl::look_close(shader_layer, library, surface, paint.frame, paint.seed, shader_firsts);
  for (std::size_t i = 0; i < kSpecies; ++i) {
    const osl::FirstFlake& first = shader_firsts[i];
    same("close", first.close, firsts[i].close);
    same("seen", first.seen, firsts[i].seen);
    same("flake's normal", first.m, firsts[i].normal);
    same("flake's facing", first.facing, firsts[i].facing);
    same("flake's depth", first.depth, firsts[i].depth);
    same("flake's hiding", first.hiding, firsts[i].hiding);
    same("flakes passed over", first.passed, firsts[i].passed);
    visits.close += first.close;
    visits.covered += first.seen;
  }
  const Cell<float> cell = cell_of_counts(layer, point, firsts, paint.frame, paint.seed);
  const osl::Cell shader_cell =
      osl::cell_of_counts(shader_layer, surface, shader_firsts, paint.frame, paint.seed);
  same("cell's area", shader_cell.area, cell.area);
  same("cell's key", shader_cell.key, cell.key);
  for (int i = 0; i < lights; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int core_leader = slots.leader[static_cast<std::size_t>(slot[at])];
    same("apart", seen[at].apart, slots.seen[static_cast<std::size_t>(slot[at])].apart);
    if (leader[at] < 0) {
      same("leader of a melted light", -1, core_leader);
      ++visits.melted;
      continue;
    }
    same("leader", slot[static_cast<std::size_t>(leader[at])], core_leader);
    if (leader[at] != i) {
      ++visits.led;
      continue;
    }
    const auto core_seen = slots.seen[static_cast<std::size_t>(slot[at])];
    same("reach with those it leads", seen[at].reach, core_seen.reach);
    same("widest cone", seen[at].widest, core_seen.widest);
    const auto shader_way = osl::pass_between(shader_layer, library, surface, seen[at], 1);
    const Passage<float> way = pass_between(layer, point, core_seen);
    same("open", shader_way.open, way.open);
    if (way.open) {
      same("cos_alpha", shader_way.mirror.cos_alpha, way.mirror.cos_alpha);
      same("sin2_half_beta", shader_way.mirror.sin2_half_beta, way.mirror.sin2_half_beta);
      same("cone in the binder", shader_way.inside, way.inside);
      same("surface transmittance", shader_way.surface_transmittance, way.surface);
      same("cos_exit", shader_way.cos_exit, way.cos_exit);
      same("passage's slant", shader_way.slant, way.slant);
      same("flake_normal", shader_way.mirror.flake_normal, way.mirror.flake_normal);
    }
    for (int species = 0; species < layer.species; ++species) {
      const auto of = static_cast<std::size_t>(species);
      const auto expected = expect_sparkles(layer, layer.flakes[of], cell.area, way);
      const auto shader_expected =
          osl::expect_sparkles(shader_layer, shader_flakes[of], library, cell.area, shader_way, 1);
      same("ExpectedSparkles", words_of(shader_expected), words_of(expected));
      visits.melting += expected.share > 0 && expected.share < 1;
      visits.lit += firsts[of].close && mirrors(layer.flakes[of], firsts[of], way);
    }
    const auto core_all =
        sparkle(layer, point, firsts, cell, way, slot[at], paint.frame, paint.seed);
    const auto all = osl::sparkle(shader_layer, library, surface, shader_firsts, shader_cell,
                                  shader_way, 1, slot[at], paint.frame, paint.seed, 0);
    same("count", all.count, core_all.count);
    same("mean_count", all.mean_count, core_all.mean_count);
    same("radiance", all.radiance, core_all.radiance);
    same("mean_radiance", all.mean_radiance, core_all.mean_radiance);
    visits.few += all.count > 0 && all.count <= kCountSteps;
    visits.many += all.count > kCountSteps;
    visits.crowded += core_all.slots > 0;
    // The cone that carries them, and its weight where it is kept.
    const Rgb<float> shown = core_all.radiance;
    const float average = (shown.x + shown.y + shown.z) / 3;
    const float least = std::min(core_seen.reach, 1.5f);
    const float rho = cone_half_angle(average, least, 1.0f);
    same("rho", osl::cone_half_angle(average, least, 1.0f), rho);
    const float keep = cone_roulette(average, cone_solid_angle(rho));
    for (const float deviate : {1e-6f, 0.5f}) {
      const auto weight =
          osl::sparkle_cone(to_osl(shown), surface.view, seen[at].direction, rho, deviate);
      const Rgb<float> whole = shown * cone_solid_angle(rho);
      if (!(average > 0) || (keep < 1 && deviate > keep)) {
        same("weight of a cone by lot", weight, {});
      } else {
        same("weight of a cone", weight, keep < 1 ? whole / keep : whole);
      }
    }
    // Composition.
    const float alpha = static_cast<float>(paint.coat_roughness * paint.coat_roughness);
    const float shine = osl::highlight(surface.n, surface.view, seen[at].direction,
                                       seen[at].sin2_half_radius, alpha, 0.5f);
    same("highlight", shine,
         highlight(point.normal, point.view, core_seen.direction, core_seen.sin2_half_radius, alpha,
                   0.5f));
    same("greatest", osl::greatest(to_osl(core_all.radiance), osl::color(shine)),
         greatest(core_all.radiance, grey(shine)));
  }

  const auto substrate = static_cast<Rgb<float>>(paint.substrate_color);
  const auto shader_mixture = osl::mixture(shader_layer, library, surface.areas, surface.slant,
                                           to_osl(substrate), cos_below);
  const Mixture<float> core_mixture = mixture(layer, substrate, cos_below);
  same("diffuse", shader_mixture.diffuse_albedo, core_mixture.diffuse);
  same("glossy", shader_mixture.glossy_albedo, core_mixture.glossy);
  same("returned", shader_mixture.returned_albedo, core_mixture.returned);
  same("alpha of the glossy lobe", shader_mixture.alpha, core_mixture.alpha);
  same("exponent of the returning lobe", shader_mixture.exponent, core_mixture.exponent);
  same("share above of the returning lobe", shader_mixture.above, core_mixture.above);

  // The stack of all that.
  const Stack<float> stack = make_stack(paint, layer, point, point.normal);
  const osl::Stack shader_stack =
      osl::make_stack(given, shader_layer, library, surface, to_osl(point.normal), paint.frame);
  same("coat.reflected", shader_stack.coat.reflected, stack.coat.reflected);
  same("coat.rest", shader_stack.coat.rest, stack.coat.rest);
  same("coat_normal", shader_stack.coat_normal, stack.coat_normal);
  same("coat_alpha", shader_stack.coat_alpha, stack.coat_alpha);
  if (paint.composition == Composition::published) {
    same("facets", shader_stack.facets, stack.facets);
  }
  same("stack's diffuse", shader_stack.diffuse, stack.diffuse);
  same("stack's glossy", shader_stack.glossy, stack.glossy);
  same("stack's returned", shader_stack.returned, stack.returned);
  same("stack's alpha", shader_stack.alpha, stack.alpha);
  same("stack's exponent", shader_stack.exponent, stack.exponent);
  same("stack's glossy exponent", shader_stack.glossy_exponent, stack.glossy_exponent);
  same("glossy_scale", shader_stack.glossy_scale, stack.glossy_scale);
  same("returned_scale", shader_stack.returned_scale, stack.returned_scale);
  same("returning_normal", osl::returning_normal(surface.n, surface.view),
       returning_normal(point.normal, point.view));
  same("texture", shader_stack.texture, stack.texture);
  std::array<osl::color, kRampColours> ramp;
  osl::color foot;
  osl::make_ramp(shader_layer, ramp, foot);
  for (std::size_t i = 0; i < ramp.size(); ++i) same("ramp", ramp[i], stack.ramp.colours[i]);
  same("ramp's foot", foot, stack.ramp.foot);

  // Of glossy lobe, foot and returning lobe the one that is drawn stands for all in the mean.
  const auto mixed = [&](int by_chance, float deviate) {
    return osl::mixture_lobes(given, shader_layer, shader_stack, surface.n, surface.view, by_chance,
                              deviate);
  };
  const osl::color whole = mixed(0, 0), last = mixed(1, 1 - 0x1p-24f);
  osl::color mean = 0;
  float from = 0;  // where what is drawn begins
  for (int lobes = 0; lobes < 3; ++lobes) {
    const osl::color drawn = mixed(1, from);
    float before = from, after = 1;  // it ends between
    for (int i = 0; i < 24 && !(drawn == last); ++i) {
      const float middle = (before + after) / 2;
      (mixed(1, middle) == drawn ? before : after) = middle;
    }
    mean = mean + drawn * (after - from);
    from = after;
    if (drawn == last) break;
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], whole[c], 1e-5 * (1 + whole[c]));

  const Vec3<float> n = point.normal, v = point.view;
  const auto slope = static_cast<float>(paint.orange_peel);
  const auto size = static_cast<float>(paint.orange_peel_mm);
  const Vec3<float> bent = orange_peel(n, waves_at(point.position, size), slope);
  same("orange_peel",
       osl::orange_peel(to_osl(n), osl::waves_at(to_osl(point.position), size), slope), bent);
  same("above_surface", osl::above_surface(to_osl(bent), to_osl(n), to_osl(v)),
       above_surface(bent, n, v));
  const HashKey stream = stream_key(8, 0, paint.frame, paint.seed);
  const Deviates drawn = uniform_deviates(pixel_key(stream, point.pixel_x, point.pixel_y, 0), 0);
  same("uniform_deviates",
       osl::uniform_deviates(osl::pixel_key(osl::stream_key(8, 0, paint.frame, paint.seed),
                                            point.pixel_x, point.pixel_y, 0),
                             0),
       drawn);
  const float u = drawn.x, w = drawn.y;
  const float rise = point.pixel_x % 2 != 0 ? 0.6F : 0;
  const auto shader_sample = osl::sample_flake(shader_layer, library, surface, shader_firsts,
                                               osl::inside_unit(u), w, rise);
  const MirroredSample<float> sample =
      sample_flake(layer, point.normal, view_below(point), inside_unit(u), w, firsts.data(), rise);
  same("sample's weight", shader_sample.weight, sample.weight);
  same("sample's spread", shader_sample.spread, sample.spread);
  if (max_component(sample.weight) > 0) {
    ++visits.sampled;
    same("sample's direction", shader_sample.direction, sample.direction);
    same("sample's variance", shader_sample.variance, sample.variance);
    same("sample's density", shader_sample.density, sample.density);
    same("sample's species", shader_sample.species, sample.species);
    if (!surface.bends) {
      const auto species = static_cast<std::size_t>(sample.species);
      const auto shader_part =
          osl::smooth_part(shader_layer, shader_flakes[species], library, surface);
      const SmoothPart<float> part =
          smooth_part(layer, layer.flakes[species], point.normal, point.view);
      const auto same_lobe = [&](const osl::Facets& shader_lobe, const Facets<float>& lobe) {
        same("smooth lobe's weight", shader_lobe.weight, lobe.weight);
        if (!(max_component(lobe.weight) > 0)) return;
        same("smooth lobe's normal", shader_lobe.facing, lobe.normal);
        same("smooth lobe's direction", shader_lobe.along, lobe.along);
        same("smooth lobe's other direction", shader_lobe.across, lobe.across);
        same("view by a smooth lobe",
             osl::vector(shader_lobe.view_along, shader_lobe.view_across, shader_lobe.view_up),
             {lobe.view_along, lobe.view_across, lobe.view_up});
        same("view's masking by a smooth lobe", shader_lobe.view_masked, lobe.view_masked);
        same("how narrow a smooth lobe got", shader_lobe.narrowed, lobe.narrowed);
        same("smooth lobe's alphas", osl::vector(shader_lobe.alpha_x, shader_lobe.alpha_y, 0),
             {lobe.alpha_x, lobe.alpha_y, 0});
      };
      same_lobe(shader_part.narrow, part.narrow);
      same_lobe(shader_part.wide, part.wide);
      if (max_component(part.narrow.weight) > 0) {
        ++visits.smooth;
        std::array<SmoothPart<float>, kSpecies> parts;
        std::array<osl::SmoothPart, kSpecies> shader_parts;
        parts.fill(part);
        shader_parts.fill(shader_part);
        SmoothPart<float> leaning = part;  // from one light after another
        osl::SmoothPart shader_leaning = shader_part;
        for (int i = 0; i < lights; ++i) {
          const auto at = static_cast<std::size_t>(i);
          const Rgb<float> lobes =
              smooth_sparkles(layer, parts.data(), slots.seen[static_cast<std::size_t>(slot[at])]);
          same("the lobes' part of sparkles",
               osl::smooth_sparkles(shader_layer, shader_parts, seen[at], 1), lobes);
          const Rgb<float> some = lobes * 0.5f, around = grey(lobes.x);
          same("what of the lobes may be shown",
               osl::may_show(to_osl(lobes), to_osl(some), to_osl(around)),
               may_show(lobes, some, around));
          const Rgb<float> may = grey(0.9f / (1 + 10 * lobes.y));
          const float fall = fall_for(may);
          same("the fall for it", osl::fall_for(to_osl(may)), fall);
          const auto towards = slots.seen[static_cast<std::size_t>(slot[at])].direction;
          leaning = lean_away(leaning, point.view, towards, fall);
          shader_leaning = osl::lean_away(shader_leaning, surface.view, seen[at].direction, fall);
          same_lobe(shader_leaning.narrow, leaning.narrow);
          same_lobe(shader_leaning.wide, leaning.wide);
          parts.fill(leaning);
          shader_parts.fill(shader_leaning);
        }
        const auto same_left = [&](const osl::SmoothPart& shader_beside,
                                   const SmoothPart<float>& beside) {
          auto shader_left = shader_sample;
          MirroredSample<float> left = sample;
          const Rgb<float> to_lobes = leave_beside(left, beside, point.normal, point.view);
          same("what the lobes are given",
               osl::leave_beside(shader_left, shader_beside, surface.n, to_osl(point.view)),
               to_lobes);
          const Rgb<float> less = metallic_paint::least(to_lobes, Rgb<float>{}),
                           more = to_lobes - less;
          const auto shader_given = osl::give_to_lobes(shader_beside, to_osl(more), to_osl(less));
          const SmoothPart<float> with = give_to_lobes(beside, more, less);
          same("the narrow lobe with it", shader_given.narrow.weight, with.narrow.weight);
          same("the wide lobe with it", shader_given.wide.weight, with.wide.weight);
          same("what is left beside it", shader_left.weight, left.weight);
          same("its variance", shader_left.variance, left.variance);
          same("its drift", shader_left.drift, left.drift);
          same("its deviations", osl::vector(shader_left.along, shader_left.across, 0),
               {left.along, left.across, 0});
        };
        same_left(shader_part, part);
        same_left(shader_leaning, leaning);
      }
    }
    same("sample's drift", shader_sample.drift, sample.drift);
    same("sample's deviations", osl::vector(shader_sample.along, shader_sample.across, 0),
         {sample.along, sample.across, 0});
    const float e = inside_unit(drawn.z);
    const LobeCone<float> wide = wide_cone(sample, point.normal, inside_unit(u), w, e);
    const auto shader_wide = osl::wide_cone(shader_sample, surface.n, osl::inside_unit(u), w, e);
    same("wide cone", shader_wide.direction, wide.direction);
    same("wide cone's half-angle", shader_wide.half_angle, wide.half_angle);
    same("direction beyond the wave",
         osl::back_through_wave(shader_wide.direction, surface.n, to_osl(bent), layer.eta),
         back_through_wave(wide.direction, point.normal, bent, layer.eta));
    if (wide.half_angle > 0) ++visits.wide;
  }
}

TEST(ShaderParity, EveryInnerValueIsTheCoresToTheLastBit) {
  std::vector<float> library = shader_library();
  Random random = fresh(99);
  long values = 0;
  Visits visits;
  const int scenes = 200'000 / kFewer;
  for (int k = 0; k < scenes; ++k) {
    const ParityScene scene = random_scene(random);
    Same same;
    compare(same, scene, library, visits);
    values += same.seen();
    TestScene shown;
    shown.paint = scene.paint;
    shown.normal = Vec3<double>(scene.point.normal);
    shown.view = Vec3<double>(scene.point.view);
    shown.footprint = static_cast<double>(scene.point.footprint);
    ASSERT_EQ(same.different(), "") << "scene " << k << ": " << shown;
  }
  RecordProperty("values", std::to_string(values));
  // No branch is left out because the scenes never go there.
  for (const long visited :
       {visits.led, visits.few, visits.many, visits.crowded, visits.sampled, visits.wide,
        visits.smooth, visits.grazed, visits.close, visits.covered, visits.lit, visits.melting,
        visits.melted, visits.bent}) {
    EXPECT_GT(visited, scenes / 100);
  }
}

// Inputs out of range: the nearest end, and for what is no number the default.
TEST(ShaderParity, InputsAreMadeSound) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const float greatest = std::numeric_limits<float>::max();
  for (const float no_number : {nan, -nan, infinity, -infinity}) {
    EXPECT_EQ(osl::sound(no_number, 0.5f, 2.0f, 1.5f), 1.5f);
    const osl::color c =
        osl::sound(osl::color(no_number, 1, 3), 0.5f, 2.0f, osl::color(1.1f, 1.2f, 1.3f));
    EXPECT_EQ(c[0], 1.1f);
    EXPECT_EQ(c[1], 1.0f);
    EXPECT_EQ(c[2], 2.0f);
    // OSL's comparison with NaN, which is true, is no C++: renders show it (test_extremes.py).
    if (std::isnan(no_number)) continue;
    EXPECT_EQ(osl::sound_normal({no_number, 0, 1}, {0, 1, 0})[1], 1.0f);
  }
  for (const float x : {-greatest, -1.0f, 0.0f, 0.4999999f}) {
    EXPECT_EQ(osl::sound(x, 0.5f, 2.0f, 1.5f), 0.5f) << x;
  }
  for (const float x : {2.0000003f, 1e9f, greatest}) {
    EXPECT_EQ(osl::sound(x, 0.5f, 2.0f, 1.5f), 2.0f) << x;
  }
  for (const float x : {0.5f, 0.75f, 2.0f}) EXPECT_EQ(osl::sound(x, 0.5f, 2.0f, 1.5f), x);
  // Directions of any length have length 1; none is the usual one.
  for (const float size : {1e-29f, 1e-3f, 7.0f, 1e37f}) {
    const osl::vector n = osl::sound_normal({0, 3 * size, 4 * size}, {1, 0, 0});
    EXPECT_NEAR(n[1], 0.6f, 1e-6) << size;
    EXPECT_NEAR(n[2], 0.8f, 1e-6) << size;
  }
  EXPECT_EQ(osl::sound_normal({0, 0, 0}, {1, 0, 0})[0], 1.0f);
}

}  // namespace
