// SPDX-License-Identifier: Apache-2.0
// Made by tools/parameters.py from parameters.toml: do not edit.
//
// A metallic paint as artists and presets state it: real units in the names, the ranges
// that validate() holds them to (paint.h).
#pragma once

#include <array>
#include <cstddef>

#include "choices.h"
#include "vector.h"

namespace metallic_paint {

inline constexpr int kSpecies = 3;  // of flakes, in a paint

// One species of flakes.
struct FlakeSpecies {
  // How many flakes lie under a square millimetre of paint, in the whole depth of its layer; 0 to
  // 1e9 1/mm2
  double flakes_per_mm2 = 3000;
  // Diameter, in micrometres, of a disc with the mean area of the flakes; 0.001 to 100000 um
  double flake_diameter_um = 20;
  // How unequal the flakes are: the standard deviation of their area, divided by its mean; 0 to 100
  double flake_area_spread = 0.3;
  // How the flakes' tilts are distributed: 0 Gaussian, 1 Beckmann, 2 GGX
  Orientation orientation = Orientation::gaussian;
  // How far the flakes lie out of the surface: radians for 0 Gaussian, roughness (at most 1) for 1
  // Beckmann and 2 GGX; 1e-6 to 100 rad (gaussian), 1e-6 to 1 (roughness of beckmann and ggx)
  double tilt = 0.15;
  // Angle from the middle to the edge of the beam that one flake, being wavy, mirrors; 0 to 0.5 rad
  double flake_spread = 0.005;
  // Colour that a flake reflects when it is seen face on; 0 to 1
  Rgb<double> flake_color{0.91, 0.92, 0.92};
  // Colour that a flake reflects at a grazing angle, where one looks flat along it; 0 to 1
  Rgb<double> flake_edge_color{1, 1, 1};
  // Share of the light that a flake lets through, at every angle; 0 to 1
  Rgb<double> flake_transmission{0, 0, 0};
  // What the flakes are made of
  CoatingKind coating = CoatingKind::colors;
  // Thickness of a pearl pigment's film of titanium dioxide or iron oxide, in nanometres; 0 to 200
  // nm
  double coating_nm = 60;

  bool operator==(const FlakeSpecies&) const = default;
};

// The first species is the paint's own; most paints have no other.
struct Paint : FlakeSpecies {
  std::array<FlakeSpecies, kSpecies - 1> more{FlakeSpecies{.flakes_per_mm2 = 0},
                                              FlakeSpecies{.flakes_per_mm2 = 0}};
  // Refractive index of the binder, the lacquer that holds the flakes, relative to what surrounds
  // the paint; 0.1 to 10
  double binder_ior = 1.5;
  // Thickness of the layer that holds the flakes, in micrometres; 0 to 1e6 um
  double layer_thickness_um = 30;
  // How much red, green and blue the binder absorbs per millimetre of path; 0 to 1e6 1/mm
  Rgb<double> binder_absorption_per_mm{0, 0, 0};
  // How much light fine white pigment in the binder scatters, per millimetre; 0 to 1e6 1/mm
  double rayleigh_per_mm = 0;
  // What spreads the light of a flake besides Flake Spread: 0 none, 1 disc, the diffraction at its
  // edge
  Diffraction diffraction = Diffraction::disc;
  // How flakes are hidden by those above them
  DepthModel depth_model = DepthModel::correlated;
  // 0 exact: the paint sends back as much light as it should
  Radiometry radiometry = Radiometry::exact;
  // 0 exact: sparkles add to the rest of the light
  Composition composition = Composition::exact;
  // What the sparkles belong to
  Anchor anchor = Anchor::surface;
  // Into how many cells of the paint, each with sparkles of its own, a pixel is divided; 1 to 64
  double cells_per_pixel = 5;
  // 0 same: copies of an object sparkle alike
  Instances instances = Instances::own;
  // How much the sparkles of the lights in the slots stand out: 1 as those of real flakes, 0 not at
  // all, which leaves an even sheen; 0 to 1
  double sparkle_contrast = 1;
  // Another number gives the paint another set of flakes
  int seed = 0;
  // Colour of the matt ground under the flakes; 0 to 1
  Rgb<double> substrate_color{0.02, 0.02, 0.02};
  // Grain in the soft light between the sparkles, which the substrate and the layer scatter; 0 to 1
  double texture_contrast = 0;
  // Roughness of the binder's surface; 0 to 1
  double coat_roughness = 0;
  // Slope (root mean square) of the waves that spraying leaves in the binder's surface; 0 to 1 rad
  double orange_peel = 0;
  // Wavelength of the waves of Orange Peel, in millimetres; 0.001 to 1e6 mm
  double orange_peel_mm = 3;
  // Another number, another draw of the same flakes. The scene's, not the paint's.
  int frame = 0;

  const FlakeSpecies& species(int i) const {
    return i == 0 ? *this : more[static_cast<std::size_t>(i - 1)];
  }
  bool operator==(const Paint&) const = default;
};

struct Range {
  double least, most;
  const char* unit = "";  // as it stands behind the range
};

inline constexpr Range kTiltAsRoughness{1e-6, 1, " (roughness of beckmann and ggx)"};
// Of two colours; 1 but for the rounding of floats.
inline constexpr double kMostOfASum = 1.0000001192092896;

// Calls visit(name, member, range) for each parameter; for a choice, range is its words.
template <class Visit>
void each_flake_parameter(const Visit& visit) {
  visit("flakes_per_mm2", &FlakeSpecies::flakes_per_mm2, Range{0, 1e9, " 1/mm2"});
  visit("flake_diameter_um", &FlakeSpecies::flake_diameter_um, Range{0.001, 100000, " um"});
  visit("flake_area_spread", &FlakeSpecies::flake_area_spread, Range{0, 100});
  visit("orientation", &FlakeSpecies::orientation, kOrientationWords);
  visit("tilt", &FlakeSpecies::tilt, Range{1e-6, 100, " rad (gaussian)"});
  visit("flake_spread", &FlakeSpecies::flake_spread, Range{0, 0.5, " rad"});
  visit("flake_color", &FlakeSpecies::flake_color, Range{0, 1});
  visit("flake_edge_color", &FlakeSpecies::flake_edge_color, Range{0, 1});
  visit("flake_transmission", &FlakeSpecies::flake_transmission, Range{0, 1});
  visit("coating", &FlakeSpecies::coating, kCoatingKindWords);
  visit("coating_nm", &FlakeSpecies::coating_nm, Range{0, 200, " nm"});
}

template <class Visit>
void each_paint_parameter(const Visit& visit) {
  visit("binder_ior", &Paint::binder_ior, Range{0.1, 10});
  visit("layer_thickness_um", &Paint::layer_thickness_um, Range{0, 1e6, " um"});
  visit("binder_absorption_per_mm", &Paint::binder_absorption_per_mm, Range{0, 1e6, " 1/mm"});
  visit("rayleigh_per_mm", &Paint::rayleigh_per_mm, Range{0, 1e6, " 1/mm"});
  visit("diffraction", &Paint::diffraction, kDiffractionWords);
  visit("depth_model", &Paint::depth_model, kDepthModelWords);
  visit("radiometry", &Paint::radiometry, kRadiometryWords);
  visit("composition", &Paint::composition, kCompositionWords);
  visit("anchor", &Paint::anchor, kAnchorWords);
  visit("cells_per_pixel", &Paint::cells_per_pixel, Range{1, 64});
  visit("instances", &Paint::instances, kInstancesWords);
  visit("sparkle_contrast", &Paint::sparkle_contrast, Range{0, 1});
  visit("seed", &Paint::seed, Range{-2147483648, 2147483647});
  visit("substrate_color", &Paint::substrate_color, Range{0, 1});
  visit("texture_contrast", &Paint::texture_contrast, Range{0, 1});
  visit("coat_roughness", &Paint::coat_roughness, Range{0, 1});
  visit("orange_peel", &Paint::orange_peel, Range{0, 1, " rad"});
  visit("orange_peel_mm", &Paint::orange_peel_mm, Range{0.001, 1e6, " mm"});
}

}  // namespace metallic_paint
