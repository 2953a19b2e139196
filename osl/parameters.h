// SPDX-License-Identifier: Apache-2.0
// Made by tools/parameters.py from parameters.toml: do not edit.
//
// A paint as core/parameters.h has it, of the shader's inputs: each within its range; what is no number becomes the default.
#pragma once

#include "choices.h"
#include "sound.h"

struct FlakeSpecies {
  float flakes_per_mm2;
  float flake_diameter_um;
  float flake_area_spread;
  int orientation;
  float tilt;
  float flake_spread;
  color flake_color;
  color flake_edge_color;
  color flake_transmission;
  int coating;
  float coating_nm;
};

struct Paint {
  float binder_ior;
  float layer_thickness_um;
  color binder_absorption_per_mm;
  float rayleigh_per_mm;
  int diffraction;
  int depth_model;
  int radiometry;
  int composition;
  int anchor;
  float cells_per_pixel;
  int instances;
  float sparkle_contrast;
  int seed;
  color substrate_color;
  float texture_contrast;
  float coat_roughness;
  float orange_peel;
  float orange_peel_mm;
};

FlakeSpecies sound_species(float flakes_per_mm2, float default_flakes_per_mm2, float flake_diameter_um,
                           float flake_area_spread, int orientation, float tilt, float flake_spread, color flake_color,
                           color flake_edge_color, color flake_transmission, int coating, float coating_nm)
{
  FlakeSpecies given;
  given.flakes_per_mm2 = sound(flakes_per_mm2, 0.0, 1e9, default_flakes_per_mm2);
  given.flake_diameter_um = sound(flake_diameter_um, 0.001, 100000.0, 20.0);
  given.flake_area_spread = sound(flake_area_spread, 0.0, 100.0, 0.3);
  given.orientation = clamp(orientation, 0, 2);
  if (given.orientation == ORIENTATION_GAUSSIAN)
    given.tilt = sound(tilt, 1e-6, 100.0, 0.15);
  else
    given.tilt = sound(tilt, 1e-6, 1.0, 0.15);
  given.flake_spread = sound(flake_spread, 0.0, 0.5, 0.005);
  given.flake_color = sound(flake_color, 0.0, 1.0, color(0.91, 0.92, 0.92));
  given.flake_edge_color = sound(flake_edge_color, 0.0, 1.0, color(1.0, 1.0, 1.0));
  given.flake_transmission = sound(flake_transmission, 0.0, 1.0, color(0.0, 0.0, 0.0));
  given.coating = clamp(coating, 0, 14);
  given.coating_nm = sound(coating_nm, 0.0, 200.0, 60.0);
  return given;
}

Paint sound_paint(float binder_ior, float layer_thickness_um, color binder_absorption_per_mm, float rayleigh_per_mm,
                  int diffraction, int depth_model, int radiometry, int composition, int anchor, float cells_per_pixel,
                  int instances, float sparkle_contrast, int seed, color substrate_color, float texture_contrast,
                  float coat_roughness, float orange_peel, float orange_peel_mm)
{
  Paint given;
  given.binder_ior = sound(binder_ior, 0.1, 10.0, 1.5);
  given.layer_thickness_um = sound(layer_thickness_um, 0.0, 1e6, 30.0);
  given.binder_absorption_per_mm = sound(binder_absorption_per_mm, 0.0, 1e6, color(0.0, 0.0, 0.0));
  given.rayleigh_per_mm = sound(rayleigh_per_mm, 0.0, 1e6, 0.0);
  given.diffraction = clamp(diffraction, 0, 1);
  given.depth_model = clamp(depth_model, 0, 2);
  given.radiometry = clamp(radiometry, 0, 1);
  given.composition = clamp(composition, 0, 1);
  given.anchor = clamp(anchor, 0, 1);
  given.cells_per_pixel = sound(cells_per_pixel, 1.0, 64.0, 5.0);
  given.instances = clamp(instances, 0, 1);
  given.sparkle_contrast = sound(sparkle_contrast, 0.0, 1.0, 1.0);
  given.seed = seed;
  given.substrate_color = sound(substrate_color, 0.0, 1.0, color(0.02, 0.02, 0.02));
  given.texture_contrast = sound(texture_contrast, 0.0, 1.0, 0.0);
  given.coat_roughness = sound(coat_roughness, 0.0, 1.0, 0.0);
  given.orange_peel = sound(orange_peel, 0.0, 1.0, 0.0);
  given.orange_peel_mm = sound(orange_peel_mm, 0.001, 1e6, 3.0);
  return given;
}

// The calls, inside the shader.
#define SOUND_FIRST_SPECIES \
  sound_species(FlakesPerMm2, 3000.0, FlakeDiameterUm, FlakeAreaSpread, Orientation, Tilt, FlakeSpread, FlakeColor, \
                FlakeEdgeColor, FlakeTransmission, FlakeCoating, FlakeCoatingNm)
#define SOUND_SECOND_SPECIES \
  sound_species(SecondFlakesPerMm2, 0.0, SecondFlakeDiameterUm, SecondFlakeAreaSpread, SecondOrientation, SecondTilt, \
                SecondFlakeSpread, SecondFlakeColor, SecondFlakeEdgeColor, SecondFlakeTransmission, SecondFlakeCoating, \
                SecondFlakeCoatingNm)
#define SOUND_THIRD_SPECIES \
  sound_species(ThirdFlakesPerMm2, 0.0, ThirdFlakeDiameterUm, ThirdFlakeAreaSpread, ThirdOrientation, ThirdTilt, \
                ThirdFlakeSpread, ThirdFlakeColor, ThirdFlakeEdgeColor, ThirdFlakeTransmission, ThirdFlakeCoating, \
                ThirdFlakeCoatingNm)
#define SOUND_PAINT \
  sound_paint(BinderIor, LayerThicknessUm, BinderAbsorptionPerMm, RayleighPerMm, Diffraction, DepthModel, Radiometry, \
              Composition, Anchor, CellsPerPixel, Instances, SparkleContrast, Seed, SubstrateColor, TextureContrast, \
              CoatRoughness, OrangePeel, OrangePeelMm)
