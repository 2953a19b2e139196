// SPDX-License-Identifier: Apache-2.0
// Made by tools/parameters.py from parameters.toml: do not edit.
//
// What a paint can choose from, and the words by which people do; kinds of light.
#pragma once

#include <array>

namespace metallic_paint {

// How the flakes' tilts are distributed: 0 Gaussian, 1 Beckmann, 2 GGX
enum class Orientation { gaussian = 0, beckmann = 1, ggx = 2 };
inline constexpr std::array kOrientationWords{"gaussian", "beckmann", "ggx"};

// What the flakes are made of
enum class CoatingKind {
  colors = 0,
  aluminium = 1,
  silver = 2,
  gold = 3,
  copper = 4,
  bronze = 5,
  brass = 6,
  chromium = 7,
  nickel = 8,
  tio2_on_mica = 9,
  tio2_on_silica = 10,
  tio2_on_thin_silica = 11,
  fe2o3_on_mica = 12,
  fe2o3_on_silica = 13,
  fe2o3_on_aluminium = 14
};
// clang-format off
inline constexpr std::array kCoatingKindWords{"colors", "aluminium", "silver", "gold", "copper",
                                              "bronze", "brass", "chromium", "nickel",
                                              "tio2-on-mica", "tio2-on-silica",
                                              "tio2-on-thin-silica", "fe2o3-on-mica",
                                              "fe2o3-on-silica", "fe2o3-on-aluminium"};
// clang-format on

// What spreads the light of a flake besides Flake Spread: 0 none, 1 disc, the diffraction at its
// edge
enum class Diffraction { none = 0, disc = 1 };
inline constexpr std::array kDiffractionWords{"none", "disc"};

// How flakes are hidden by those above them
enum class DepthModel { attenuated = 0, thinned = 1, correlated = 2 };
inline constexpr std::array kDepthModelWords{"attenuated", "thinned", "correlated"};

// 0 exact: the paint sends back as much light as it should
enum class Radiometry { exact = 0, published = 1 };
inline constexpr std::array kRadiometryWords{"exact", "published"};

// 0 exact: sparkles add to the rest of the light
enum class Composition { exact = 0, published = 1 };
inline constexpr std::array kCompositionWords{"exact", "published"};

// What the sparkles belong to
enum class Anchor { pixel = 0, surface = 1 };
inline constexpr std::array kAnchorWords{"pixel", "surface"};

// 0 same: copies of an object sparkle alike
enum class Instances { same = 0, own = 1 };
inline constexpr std::array kInstancesWords{"same", "own"};

// Nothing, a sun lamp, a point or spot, an area light, or the sun of a world
enum class LightKind { unused = 0, parallel = 1, positional = 2, area = 3, sky = 4 };
inline constexpr std::array kLightKindWords{"unused", "parallel", "positional", "area", "sky"};

// Calls visit(name, Choice{}, words, explanation) for each of them.
template <class Visit>
void each_choice(const Visit& visit) {
  visit("Orientation", Orientation{}, kOrientationWords,
        "How the flakes' tilts are distributed: 0 Gaussian, 1 Beckmann, 2 GGX. GGX has the "
        "longest tail, a narrow flop with a wide veil");
  visit("CoatingKind", CoatingKind{}, kCoatingKindWords,
        "What the flakes are made of. 0 colors: the three above. Otherwise a measured metal, or a "
        "pearl pigment with the interference colours of its film, as in a binder of index 1.5: 1 "
        "aluminium, 2 silver, 3 gold, 4 copper, 5 bronze, 6 brass, 7 chromium, 8 nickel, 9 "
        "tio2-on-mica, 10 tio2-on-silica, 11 tio2-on-thin-silica, 12 fe2o3-on-mica, 13 "
        "fe2o3-on-silica, 14 fe2o3-on-aluminium");
  visit("Diffraction", Diffraction{}, kDiffractionWords,
        "What spreads the light of a flake besides Flake Spread: 0 none, 1 disc, the diffraction "
        "at its edge. Sparkles of flakes under 20 micrometres grow wider and dimmer by it");
  visit("DepthModel", DepthModel{}, kDepthModelWords,
        "How flakes are hidden by those above them. 0 attenuated: the deeper a flake lies, the "
        "dimmer its sparkle. 1 thinned: deep flakes are left out instead, and the paint stays as "
        "bright on average. 2 correlated: most flakes that the camera sees are lit as well, so "
        "dense paints are brighter, as real ones are");
  visit("Radiometry", Radiometry{}, kRadiometryWords,
        "0 exact: the paint sends back as much light as it should. 1 published: the formulas of "
        "the paper that this paint comes from, to the letter, which differ in brightness");
  visit("Composition", Composition{}, kCompositionWords,
        "0 exact: sparkles add to the rest of the light. 1 published: a pixel shows the brighter "
        "of both, for each light in the slots");
  visit("Anchor", Anchor{}, kAnchorWords,
        "What the sparkles belong to. 0 pixel: each pixel of the picture has its own, as in the "
        "paper, and they stay there when the object moves. 1 surface: they lie on the paint and "
        "move with it");
  visit("Instances", Instances{}, kInstancesWords,
        "0 same: copies of an object sparkle alike. 1 own: every object and instance has flakes "
        "of its own, by its Random of Object Info. Only with Anchor 1 surface");
  visit("LightKind", LightKind{}, kLightKindWords,
        "Nothing, a sun lamp, a point or spot, an area light, or the sun of a world");
}

}  // namespace metallic_paint
