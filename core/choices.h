// SPDX-License-Identifier: Apache-2.0
// Made by tools/parameters.py from parameters.toml: do not edit.
//
// What a paint can choose from, and the words by which people do; and what lights there are.
#pragma once

#include <array>

namespace metallic_paint {

// How the flakes' tilt is distributed: 0 Gaussian in the tilt angle, 1 Beckmann, 2 GGX
enum class Orientation { gaussian = 0, beckmann = 1, ggx = 2 };
inline constexpr std::array kOrientationWords{"gaussian", "beckmann", "ggx"};

// 0 colors: the three above. Otherwise a measured metal, or a pearl pigment with the interference
// colours of its film, as in a binder of index 1.5: 1 aluminium, 2 silver, 3 gold, 4 copper, 5
// bronze, 6 brass, 7 chromium, 8 nickel, 9 tio2-on-mica, 10 tio2-on-silica, 11 tio2-on-thin-silica,
// 12 fe2o3-on-mica, 13 fe2o3-on-silica, 14 fe2o3-on-aluminium
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

// 0 none. 1 disc: a flake spreads light as a disc of its diameter diffracts it, besides its own
// Flake Spread
enum class Diffraction { none = 0, disc = 1 };
inline constexpr std::array kDiffractionWords{"none", "disc"};

// 0 attenuated: every sparkle is dimmed by its own depth. 1 thinned: deep flakes are left out
// instead, with the same mean. 2 correlated: what hides a flake from the observer often hides it
// from the light as well, so dense layers are brighter, as real ones are
enum class DepthModel { attenuated = 0, thinned = 1, correlated = 2 };
inline constexpr std::array kDepthModelWords{"attenuated", "thinned", "correlated"};

// 0 exact: energy is conserved. 1 published: the formulas of the paper to the letter
enum class Radiometry { exact = 0, published = 1 };
inline constexpr std::array kRadiometryWords{"exact", "published"};

// 0 exact: sparkles add to the rest of the light. 1 published: of each light in the slots a pixel
// takes the brighter of both
enum class Composition { exact = 0, published = 1 };
inline constexpr std::array kCompositionWords{"exact", "published"};

// What the sparkles belong to. 0 pixel: every pixel draws its own, as in the paper; they stay where
// they are in the picture. 1 surface: they ride on the paint
enum class Anchor { pixel = 0, surface = 1 };
inline constexpr std::array kAnchorWords{"pixel", "surface"};

// With Anchor surface. 0 same: copies of an object have the same flakes. 1 own: each has flakes of
// its own, by the Random of Object Info
enum class Instances { same = 0, own = 1 };
inline constexpr std::array kInstancesWords{"same", "own"};

// Nothing, a sun lamp, a point or spot, an area light, or the sun of a world
enum class LightKind { unused = 0, parallel = 1, positional = 2, area = 3, sky = 4 };
inline constexpr std::array kLightKindWords{"unused", "parallel", "positional", "area", "sky"};

// Calls visit(name, Choice{}, words, explanation) for each of them.
template <class Visit>
void each_choice(const Visit& visit) {
  visit("Orientation", Orientation{}, kOrientationWords,
        "How the flakes' tilt is distributed: 0 Gaussian in the tilt angle, 1 Beckmann, 2 GGX");
  visit("CoatingKind", CoatingKind{}, kCoatingKindWords,
        "0 colors: the three above. Otherwise a measured metal, or a pearl pigment with the "
        "interference colours of its film, as in a binder of index 1.5: 1 aluminium, 2 silver, 3 "
        "gold, 4 copper, 5 bronze, 6 brass, 7 chromium, 8 nickel, 9 tio2-on-mica, 10 "
        "tio2-on-silica, 11 tio2-on-thin-silica, 12 fe2o3-on-mica, 13 fe2o3-on-silica, 14 "
        "fe2o3-on-aluminium");
  visit("Diffraction", Diffraction{}, kDiffractionWords,
        "0 none. 1 disc: a flake spreads light as a disc of its diameter diffracts it, besides "
        "its own Flake Spread");
  visit("DepthModel", DepthModel{}, kDepthModelWords,
        "0 attenuated: every sparkle is dimmed by its own depth. 1 thinned: deep flakes are left "
        "out instead, with the same mean. 2 correlated: what hides a flake from the observer "
        "often hides it from the light as well, so dense layers are brighter, as real ones are");
  visit("Radiometry", Radiometry{}, kRadiometryWords,
        "0 exact: energy is conserved. 1 published: the formulas of the paper to the letter");
  visit("Composition", Composition{}, kCompositionWords,
        "0 exact: sparkles add to the rest of the light. 1 published: of each light in the slots "
        "a pixel takes the brighter of both");
  visit("Anchor", Anchor{}, kAnchorWords,
        "What the sparkles belong to. 0 pixel: every pixel draws its own, as in the paper; they "
        "stay where they are in the picture. 1 surface: they ride on the paint");
  visit("Instances", Instances{}, kInstancesWords,
        "With Anchor surface. 0 same: copies of an object have the same flakes. 1 own: each has "
        "flakes of its own, by the Random of Object Info");
  visit("LightKind", LightKind{}, kLightKindWords,
        "Nothing, a sun lamp, a point or spot, an area light, or the sun of a world");
}

}  // namespace metallic_paint
