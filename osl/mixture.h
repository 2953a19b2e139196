// SPDX-License-Identifier: Apache-2.0
//
// What the substrate, pigment and several flakes scatter: see core/mixture.h for the model, its derivation and its
// error.
#pragma once

#include "coating.h"
#include "elementary.h"
#include "optical_thickness.h"
#include "orientation.h"
#include "refraction.h"
#include "hot_spot.h"
#include "layer.h"

#define MIXTURE_POINTS 3
#define FORGETTING 400.0
#define EDGE 0.185
#define EDGE_ABSORPTION 1.25
#define FEW_FLAKES 1e-3
#define NARROW_TILT 0.25
#define PAIR_NODE 0.211324865
#define PAIR_OTHER 0.788675135

void mixture_rule(output float node[3], output float weight[3])
{
  float nodes[3] = {0.112701665, 0.5, 0.887298335};
  float weights[3] = {0.277777778, 0.444444444, 0.277777778};
  node = nodes;
  weight = weights;
}

float escape_over_cosine(float cos_in, float eta)
{
  float g = eta * cos_in;
  float square = (1.0 - eta) * (1.0 + eta) + g * g;
  if (!(square > 0.0) || !(g > 1e-4))
    return 0.0;
  float cos_out = sqrt(square);
  float index = eta * eta;
  float s = cos_out + g;
  float p = index * cos_out + g;
  float both = s * p;
  return 2.0 * eta * cos_out * (p * p + index * (s * s)) / (both * both);
}

struct DiffuseSurface {
  float cone;
  float critical;
  float transmittance;
};

float flux_through(float cos_theta, float index)
{
  return 2.0 * cos_theta * fresnel_transmittance(cos_theta, eta_cos_refracted(cos_theta, index), index);
}

DiffuseSurface diffuse_surface(float eta)
{
  DiffuseSurface surface;
  surface.cone = 1.0;
  surface.critical = 0.0;
  surface.transmittance = 0.0;
  float index = max(eta, 1.0 / eta);
  if (eta > 1.0) {
    surface.cone = 1.0 / (eta * eta);
    surface.critical = critical_cosine(eta);
  }
  // Written out: OSL folds no loop.
  surface.transmittance = 0.277777778 * flux_through(0.112701665, index) + 0.444444444 * flux_through(0.5, index) +
                          0.277777778 * flux_through(0.887298335, index);
  return surface;
}

float tilt_deviate(OrientationDensity density, float sin2_half_beta)
{
  float square = density.tilt * density.tilt;
  float h = sin2_half_beta;
  if (density.kind == ORIENTATION_BECKMANN) {
    float cos_beta = 1.0 - 2.0 * h;
    return exponential(-4.0 * h * (1.0 - h) / max(cos_beta * cos_beta, 1e-9) / square);
  }
  if (density.kind == ORIENTATION_GGX)
    return 2.0 * h / (square + (1.0 - density.tilt) * (1.0 + density.tilt) * 2.0 * h);
  if (density.tilt > 0.5)
    return 2.0 * h;
  return (1.0 - exponential(-0.5 * squared_angle(h) / square)) / density.below;
}

float edge_deviate(OrientationDensity density, float versine)
{
  float cos_beta = sqrt(max(1.0 - versine / 2.0, 0.0));
  return tilt_deviate(density, versine / (4.0 * (1.0 + cos_beta)));
}

struct SingleShares {
  color independent;
  color correlated;
};

struct Mirroring {
  float cone;
  float escaping;
  float cos_alpha;
  float cos_exit;
  float in_common;
  float in_common2;
  float delta;
  SingleShares on_silica;
};

Mirroring mirror_out(Layer layer, Flakes some, float library[], DiffuseSurface surface, float cos_in, color slant_view)
{
  OrientationDensity density = some.orientation;
  int on_silica = is_on_silica(some.coating.kind);
  Mirroring sum;
  sum.cone = 0.0;
  sum.escaping = 0.0;
  sum.cos_alpha = 0.0;
  sum.cos_exit = 0.0;
  sum.in_common = 0.0;
  sum.in_common2 = 0.0;
  sum.delta = 0.0;
  sum.on_silica.independent = color(0.0);
  sum.on_silica.correlated = color(0.0);
  float node[3];
  float weight[3];
  mixture_rule(node, weight);
  float sin_in = sqrt((1.0 - cos_in) * (1.0 + cos_in));
  float critical = surface.critical;
  float sin_critical = sqrt((1.0 - critical) * (1.0 + critical));
  float across = cos_in - critical;
  float way_in = 1.0 / cos_in;
  float depth = max(max(slant_view[0], slant_view[1]), slant_view[2]) * cos_in;
  int four = density.kind == ORIENTATION_GGX || on_silica;
  int narrow = !four && density.tilt <= NARROW_TILT;
  int points = MIXTURE_POINTS;
  if (narrow)
    points = 2;
  if (four)
    points = 4;
  float pair[2] = {PAIR_NODE, PAIR_OTHER};
  float four_node[4] = {0.0694318442, 0.330009478, 0.669990522, 0.930568156};
  float four_weight[4] = {0.173927423, 0.326072577, 0.326072577, 0.173927423};
  float arc_node[2] = {0.319658371, 0.897008296};
  float arc_weight[2] = {1.37527767, 0.624722325};
  float start = 0.0;
  if (density.kind == ORIENTATION_BECKMANN)
    start = 1.0;
  for (int piece = 0; piece < 2; ++piece) {
    float along = sin_in - sin_critical;
    if (piece == 1)
      along = sin_in + sin_critical;
    float end = edge_deviate(density, (across * across + along * along) / 2.0);
    float begin = start;
    float span = end - start;
    float width = fabs(span);
    start = end;
    if (!(width > FEW_FLAKES) || (piece == 0 && cos_in <= critical))
      continue;
    float shown = width * min(width / FEW_FLAKES - 1.0, 1.0);
    for (int i = 0; i < points; ++i) {
      float x = 0.0;
      float part = 0.5;
      if (narrow) {
        x = pair[i];
      }
      else if (four) {
        x = four_node[i];
        part = four_weight[i];
      }
      else {
        x = node[i];
        part = weight[i];
      }
      float place = x * (1.0 + x * (1.0 - x));
      float slope = 1.0 + x * (2.0 - 3.0 * x);
      SampledTilt tilt = sample_tilt(density, begin + span * place);
      float h = tilt.sin2_half_beta;
      float cos_beta = 1.0 - 2.0 * h;
      float p = cos_beta * cos_in;
      float sin_beta = 2.0 * sqrt(h * (1.0 - h));
      float q = sin_beta * sin_in;
      float a = 2.0 * p * cos_beta - cos_in;
      float b = 2.0 * q * cos_beta;
      float limit = HALF_PI;
      if (piece == 1 && a - b < critical) {
        if (a + b <= critical)
          continue;
        limit = arccosine(sqrt(clamp(((b - a) + critical) / (2.0 * b), 0.0, 1.0)));
      }
      float ring = part * slope * shown * tilt.weight * limit * (1.0 / M_PI);
      for (int j = 0; j < 2; ++j) {
        float cos_phi = 0.707106781;
        if (j == 1)
          cos_phi = -cos_phi;
        float arc = 1.0;
        if (limit < HALF_PI) {
          float half_sine = sine(limit * arc_node[j]);
          cos_phi = 1.0 - 2.0 * half_sine * half_sine;
          arc = arc_weight[j];
        }
        float cos_alpha = clamp(p + q * cos_phi, 0.0, 1.0);
        float cos_exit = min(a + b * cos_phi, 1.0);
        float share = ring * arc * cos_alpha;
        float escaping = share * (escape_over_cosine(cos_exit, layer.eta) * cos_exit);
        sum.cone = sum.cone + share;
        sum.escaping = sum.escaping + escaping;
        sum.cos_alpha = sum.cos_alpha + escaping * cos_alpha;
        sum.cos_exit = sum.cos_exit + escaping * cos_exit;
        if (!(escaping > 0.0))
          continue;
        float delta = 0.0;
        if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
          float way_out = 1.0 / cos_exit;
          float turned = 2.0 * cos_alpha * way_out * sin_beta;
          float apart = sin_in * (way_in + way_out) - turned * cos_phi;
          float aside = turned * turned * ((1.0 - cos_phi) * (1.0 + cos_phi));
          delta = sqrt(apart * apart + aside);
          float in_common = share_in_common(layer, delta, depth * (way_in + way_out));
          sum.in_common = sum.in_common + escaping * in_common;
          sum.in_common2 = sum.in_common2 + escaping * in_common * in_common;
          sum.delta = sum.delta + escaping * delta;
        }
        if (on_silica) {
          color slant_out = slant_depth_of(layer, library, max(cos_exit, LEAST_COSINE));
          color r = coating_reflectance(some.coating, library, cos_alpha) * escaping;
          color both = there_and_back(layer, slant_view, slant_out, delta);
          sum.on_silica.independent = sum.on_silica.independent + r * mean_transmittance(slant_view + slant_out);
          sum.on_silica.correlated = sum.on_silica.correlated + r * mean_transmittance(both);
        }
      }
    }
  }
  return sum;
}

struct LayerShares {
  float mirrored;
  float passed;
  float lost;
};

LayerShares layer_shares(float mirror, float loss)
{
  float x = sqrt(loss) * sqrt(loss + 2.0 * mirror);
  float mean = mean_transmittance(x);
  float dimmed = x * mean;
  float h = max(1.0 - dimmed, 0.0);
  float each = 1.0 / (1.0 + h * h);
  float q = mean * (1.0 + h) * each;
  float share = 1.0 / (1.0 + (mirror + loss) * q);
  LayerShares shares;
  shares.mirrored = mirror * q * share;
  shares.passed = 2.0 * h * each * share;
  shares.lost = (dimmed * dimmed * each + loss * q) * share;
  return shares;
}

struct DiffuseRates {
  float coverage;
  float cos_sum;
  color cone_mirror;
  color cone_loss;
  color trapped_mirror;
  color trapped_loss;
};

struct FlakeRates {
  color escaping;
  color inside;
  color outside;
  color loss;
  SingleShares single;
  float all_escaping;
  float in_common;
};

FlakeRates no_flakes()
{
  FlakeRates rates;
  rates.escaping = color(0.0);
  rates.inside = color(0.0);
  rates.outside = color(0.0);
  rates.loss = color(0.0);
  rates.single.independent = color(0.0);
  rates.single.correlated = color(0.0);
  rates.all_escaping = 0.0;
  rates.in_common = 0.0;
  return rates;
}

color lost_colour(color mirrored, color passed)
{
  return max(color(1.0) - mirrored - passed, color(0.0));
}

SingleShares mean_single(Layer layer, Coating coating, float library[], Mirroring mirrored, color slant_view)
{
  SingleShares mean;
  mean.independent = color(0.0);
  mean.correlated = color(0.0);
  float escaping = mirrored.escaping;
  if (!(escaping > 0.0))
    return mean;
  if (is_on_silica(coating.kind)) {
    mean.independent = mirrored.on_silica.independent / escaping;
    mean.correlated = mirrored.on_silica.correlated / escaping;
    return mean;
  }
  float cos_exit = clamp(mirrored.cos_exit / escaping, LEAST_COSINE, 1.0);
  color both = slant_view + slant_depth_of(layer, library, cos_exit);
  color r = coating_reflectance(coating, library, min(mirrored.cos_alpha / escaping, 1.0));
  mean.independent = r * mean_transmittance(both);
  if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
    float in_common = mirrored.in_common / escaping;
    float apart = sqrt(max(mirrored.in_common2 / escaping - in_common * in_common, 0.0));
    color of_most = color(1.0);
    if (channels_of(both) > 1) {
      float delta = mirrored.delta / escaping;
      float most = share_in_common(layer, delta, max(max(both[0], both[1]), both[2]));
      for (int c = 0; c < 3; ++c)
        of_most[c] = share_in_common(layer, delta, both[c]) / max(most, 1e-20);
    }
    color more = mean_transmittance(less_in_common(layer, both, of_most * (in_common + apart)));
    color less = mean_transmittance(less_in_common(layer, both, of_most * (in_common - apart)));
    mean.correlated = r * ((more + less) * 0.5);
  }
  return mean;
}

DiffuseRates diffuse_rates(Flakes some, float library[], DiffuseSurface surface)
{
  float coverage = some.coverage;
  Coating coating = some.coating;
  float cone_area = some.orientation.mean_cos;
  float trapped_area = 0.0;
  if (surface.cone < 1.0)
    trapped_area = (1.0 - surface.cone * cone_area) / (1.0 - surface.cone);
  float cone_flux = coverage * cone_area;
  float trapped_flux = coverage * trapped_area;
  float cone_cosine = (1.0 + surface.critical) / 2.0;
  float trapped_cosine = surface.critical / 2.0;
  color r_cone = coating_reflectance(coating, library, cone_cosine);
  color r_trapped = coating_reflectance(coating, library, trapped_cosine);
  color t_cone = coating_transmittance(coating, library, cone_cosine);
  color t_trapped = coating_transmittance(coating, library, trapped_cosine);
  DiffuseRates rates;
  rates.coverage = coverage;
  rates.cos_sum = coverage * cone_area;
  rates.cone_mirror = r_cone * cone_flux;
  rates.cone_loss = lost_colour(r_cone, t_cone) * cone_flux;
  rates.trapped_mirror = r_trapped * trapped_flux;
  rates.trapped_loss = lost_colour(r_trapped, t_trapped) * trapped_flux;
  return rates;
}

DiffuseRates add_diffuse(DiffuseRates a, DiffuseRates b)
{
  DiffuseRates sum;
  sum.coverage = a.coverage + b.coverage;
  sum.cos_sum = a.cos_sum + b.cos_sum;
  sum.cone_mirror = a.cone_mirror + b.cone_mirror;
  sum.cone_loss = a.cone_loss + b.cone_loss;
  sum.trapped_mirror = a.trapped_mirror + b.trapped_mirror;
  sum.trapped_loss = a.trapped_loss + b.trapped_loss;
  return sum;
}

void add_flakes(output FlakeRates rates, Layer layer, int species, float library[],
                DiffuseSurface surface, float cos_in, float area, color slant_view)
{
  Flakes some = flakes_of(layer, species);
  Coating coating = some.coating;
  Mirroring mirrored = mirror_out(layer, some, library, surface, cos_in, slant_view);
  float flux = some.coverage / cos_in;
  color r = coating_reflectance(coating, library, cos_in);
  color t = coating_transmittance(coating, library, cos_in);
  rates.escaping = rates.escaping + r * (flux * mirrored.escaping);
  rates.inside = rates.inside + r * (flux * (mirrored.cone - mirrored.escaping));
  rates.outside = rates.outside + r * (flux * max(area - mirrored.cone, 0.0));
  rates.loss = rates.loss + lost_colour(r, t) * (flux * area);
  rates.all_escaping = rates.all_escaping + flux * mirrored.escaping;
  rates.in_common = rates.in_common + flux * mirrored.in_common;
  SingleShares single = mean_single(layer, coating, library, mirrored, slant_view);
  rates.single.independent = rates.single.independent + single.independent * (flux * mirrored.escaping);
  rates.single.correlated = rates.single.correlated + single.correlated * (flux * mirrored.escaping);
}

float mean_cosine(DiffuseRates diffuse_light)
{
  float mean = 1.0;
  if (diffuse_light.coverage > 0.0)
    mean = min(diffuse_light.cos_sum / diffuse_light.coverage, 1.0);
  return mean;
}

float lambertian_escape(DiffuseSurface surface)
{
  return surface.cone * surface.transmittance;
}

float pigment_escape(DiffuseSurface surface)
{
  return (lambertian_escape(surface) + (1.0 - surface.critical) * surface.transmittance) / 2.0;
}

struct DiffuseShares {
  float trapped_out;
  float trapped_down;
  float below;
  float straight;
  float lost;
};

DiffuseShares diffuse_channel(DiffuseRates diffuse_light, int c, DiffuseSurface surface, float absorption, float rayleigh,
                              float substrate)
{
  float pigment_back = rayleigh / 2.0;
  float cone_path = 2.0 / (1.0 + surface.critical);
  float trapped_path = 0.0;
  if (surface.critical > 0.0)
    trapped_path = 2.0 / surface.critical;
  float trapped_mirror = diffuse_light.trapped_mirror[c] + pigment_back * trapped_path;
  LayerShares cone = layer_shares(diffuse_light.cone_mirror[c] + pigment_back * cone_path,
                                  diffuse_light.cone_loss[c] + absorption * cone_path);
  LayerShares trapped = layer_shares(trapped_mirror, diffuse_light.trapped_loss[c] + absorption * trapped_path);

  float mean_cos = mean_cosine(diffuse_light);
  float z2 = (1.0 - mean_cos) * (1.0 + mean_cos);
  float turned = lambertian_escape(surface) * 2.0 * sqrt(z2) / (1.0 + 2.0 * z2);
  if (pigment_back > 0.0 && trapped_mirror > 0.0)
    turned = turned + (pigment_escape(surface) - turned) * (pigment_back * trapped_path / trapped_mirror);
  float trapped_exits = trapped.passed + trapped.lost + turned * trapped.mirrored;
  float trapped_out = trapped.mirrored * turned / trapped_exits;
  float trapped_down = trapped.passed / trapped_exits;
  float trapped_rest = (trapped.lost + trapped.mirrored * turned) / trapped_exits;

  float beyond = 1.0 - surface.cone;
  float leaving = surface.cone * cone.passed * surface.transmittance;
  float returned = surface.cone * cone.passed * (1.0 - surface.transmittance) + beyond * trapped.passed;
  float not_back = surface.cone * cone.lost + beyond * trapped.lost + leaving + returned * trapped_rest;
  DiffuseShares shares;
  shares.trapped_out = trapped_out;
  shares.trapped_down = trapped_down;
  shares.below = (leaving + returned * trapped_out) / ((1.0 - substrate) + substrate * not_back);
  shares.straight = lambertian_escape(surface) * exponential(-(diffuse_light.cone_mirror[c] + diffuse_light.cone_loss[c] +
                                                               (absorption + rayleigh) * cone_path));
  shares.lost = max(1.0 - shares.below, 0.0) / max(1.0 - shares.straight, 1e-6);
  return shares;
}

#define LEAN 0.09
#define MOST_EXPONENT 1e4

struct Returning {
  color free;
  color far;
  color near;
  float lobe;
  float above;
  float exponent;
};

Returning no_returning()
{
  Returning none;
  none.free = color(0.0);
  none.far = color(0.0);
  none.near = color(0.0);
  none.lobe = 0.0;
  none.above = 1.0;
  none.exponent = 1.0;
  return none;
}

Returning returning(Layer layer, DiffuseSurface surface, color slant_view, float cos_in, float cos_view)
{
  color thickness = layer.hiding * layer.thickness_in_flakes;
  float over_flakes = thickness[0] + thickness[1] + thickness[2];
  float narrow = 1.0 + 0.03 * over_flakes;
  float exponent = 8.6 * (narrow * narrow);
  float steep = (1.0 - cos_in) * (1.0 + cos_in) / (cos_in * cos_in);
  float beyond = 1.0 - surface.cone;
  float apart = sqrt(0.71 * surface.cone / max(beyond, 1e-3) + steep);
  float axis = 2.0 * (1.0 + LEAN * cos_view) * (cos_view + LEAN) / (1.0 + LEAN * (LEAN + 2.0 * cos_view)) - cos_view;
  Returning back;
  float far = holes_in_common(layer, apart);
  color shared = min(layer.shared_blocking, slant_view);
  int channels = max(channels_of(slant_view), channels_of(shared));
  for (int c = 0; c < channels; ++c) {
    back.free[c] = exponential(-slant_view[c]);
    back.far[c] = exponential(shared[c] * far - slant_view[c]);
    back.near[c] = exponential(shared[c] - slant_view[c]);
  }
  if (channels == 1) {
    back.free = color(back.free[0]);
    back.far = color(back.far[0]);
    back.near = color(back.near[0]);
  }
  back.lobe = 2.6 / ((exponent + 2.0) * (1.0 + 0.27 * over_flakes)) * lambertian_escape(surface) * axis;
  back.above = 1.0 - 0.5 * exponential(-0.93 * (exponent + 1.0) * (axis * axis));
  back.exponent = min(exponent, MOST_EXPONENT);
  return back;
}

#define PIGMENT_BACK 2.0
#define HOLES 0.67
#define CROWDED 0.6
#define BETWEEN_FLAKES 1.25

struct MixtureShares {
  float whole;
  float glossy;
  float returned;
};

// In the colour channel c: 0, 1, 2.
MixtureShares mixture_channel(Layer layer, FlakeRates flakes, DiffuseRates diffuse_light, DiffuseShares diffused,
                              Returning back, int c, DiffuseSurface surface, float absorption, float rayleigh,
                              float substrate, float cos_in)
{
  float pigment_back = rayleigh / 2.0;
  float flake_mirror = flakes.escaping[c] + flakes.inside[c] + flakes.outside[c];
  float mirror = flake_mirror + pigment_back / cos_in;
  float loss = flakes.loss[c] + absorption / cos_in;
  LayerShares about = layer_shares(mirror, loss);
  float met_once = mean_transmittance(mirror + loss);
  float lambertian = lambertian_escape(surface);
  float from_pigment = pigment_escape(surface);

  float escape = 0.0;
  float inside = 0.0;
  if (flake_mirror > 0.0) {
    escape = flakes.escaping[c] / flake_mirror;
    inside = flakes.inside[c] / flake_mirror;
  }
  float outside = max(1.0 - escape - inside, 0.0);
  float unpigmented = 0.0;
  float twice = met_once * (1.0 - (mirror + loss) * met_once / 2.0);
  if (about.mirrored > 0.0) {
    float edge = min(EDGE / max(escape * (1.0 + EDGE_ABSORPTION * absorption), 1e-3), 1.0);
    inside = inside + outside * edge;
    outside = outside - outside * edge;
    float once = min(mirror * twice / about.mirrored, 1.0);
    float turn = 1.0 - mean_cosine(diffuse_light);
    float turns = FORGETTING * (turn * sqrt(turn));
    float forgotten = turns / (1.0 + turns) * (1.0 - once);
    escape = escape + (lambertian - escape) * forgotten;
    inside = inside - inside * forgotten;
    outside = outside + ((1.0 - lambertian) - outside) * forgotten;
    unpigmented = escape + outside * diffused.trapped_out;
    if (pigment_back > 0.0) {
      LayerShares pure = layer_shares(flake_mirror, loss + rayleigh / cos_in);
      float touched = 1.0 - min(pure.mirrored / about.mirrored, 1.0);
      unpigmented = unpigmented * (1.0 - touched);
      escape = escape + (from_pigment - escape) * touched;
      inside = inside - inside * touched;
      outside = outside + ((1.0 - from_pigment) - outside) * touched;
    }
  }
  float series = 1.0 / (about.passed + about.lost + about.mirrored * (escape + outside));
  float upwards = about.mirrored * (escape + outside * diffused.trapped_out) * series;
  float down = (about.passed + about.mirrored * outside * diffused.trapped_down) * series;
  float albedo = upwards + substrate * down * diffused.below;

  float from_substrate = substrate * exponential(-(mirror + loss)) * diffused.below;
  float twice_clear = twice;
  if (pigment_back > 0.0)
    twice_clear = mean_transmittance(2.0 * (mirror + loss + pigment_back / cos_in));
  float first = mirror * met_once;
  float by_flake = flake_mirror * met_once;
  float own = min(flakes.escaping[c] * twice_clear, by_flake);
  float out = clamp((albedo - from_substrate - own) / max(first - own, 1e-9), 0.0, 1.0);
  float glossy_out = clamp((about.mirrored * unpigmented * series - own) / max(by_flake - own, 1e-9), 0.0, out);
  float single = flakes.single.independent[c];
  float left = by_flake - single;
  float others = from_substrate + (first - by_flake) * out;
  MixtureShares shares;
  float rest = others + left;
  if (left > 0.0)
    rest = others + left * out;
  shares.whole = max(rest, 0.0);
  shares.glossy = max(left, 0.0) * glossy_out;
  shares.returned = 0.0;
  if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
    float correlated = flakes.single.correlated[c];
    float left_now = by_flake - correlated;
    float out_now = out;
    if (left > 0.0 && single > 0.0) {
      float rise = clamp(correlated * left / max(single * left_now, 1e-20), 1.0, 1e6);
      float in_common = flakes.in_common / max(flakes.all_escaping, 1e-20);
      float power = HOLES * in_common / (1.0 + CROWDED * layer.shared_blocking[c]) -
                    BETWEEN_FLAKES * (absorption / (1.0 + absorption));
      float odds = exponential(power * logarithm(rise));
      out_now = out * odds / ((1.0 - out) + out * odds);
    }
    float glossy = max(left_now, 0.0) * glossy_out;
    if (out > 0.0)
      glossy = glossy * (out_now / out);
    float free = back.free[c];
    float far = back.far[c];
    float near = back.near[c];
    float about_view = substrate * free * max(near - far, 0.0);
    float spread = substrate * diffused.straight * max(far - free, 0.0);
    if (rayleigh > 0.0) {
      float half_free = sqrt(free);
      float half_far = sqrt(far);
      float sent = PIGMENT_BACK * rayleigh * half_free;
      about_view = about_view + sent * max(sqrt(near) - half_far, 0.0);
      spread = spread + sent * lambertian * max(half_far - half_free, 0.0);
    }
    float returned = about_view * (back.lobe * back.above);
    float more = spread + returned;
    rest = others + left_now;
    if (left_now > 0.0)
      rest = others + left_now * out_now;
    shares.whole = clamp(rest + more * diffused.lost, 0.0, 1.0);
    shares.glossy = min(glossy, shares.whole);
    shares.returned = min(returned, max(shares.whole - shares.glossy, 0.0));
  }
  return shares;
}

#define STRETCH 1.65
#define LEAST_ROUGHNESS 0.005

float turn_of(Flakes some)
{
  float body = some.orientation.kind == ORIENTATION_GGX ? 0.5 : 1.0;
  return some.coverage * (1.0 - some.orientation.mean_cos) * body;
}

// Of the paint alone: no loop, so that OSL folds it.
float glossy_roughness(Layer layer)
{
  if (!(layer.coverage > 0.0))
    return 1.0;
  float mirrorings = 2.0 + layer.coverage / (1.0 + layer.coverage);
  float stretch = STRETCH * layer.eta;
  float turn = turn_of(layer.first) + turn_of(layer.second) + turn_of(layer.third);
  float square = turn / layer.coverage * mirrorings * (stretch * stretch);
  return max(sqrt(square / (1.0 + square)), LEAST_ROUGHNESS);
}

float glossy_exponent(float alpha)
{
  float square = alpha * alpha;
  return (1.0 - square) / (2.0 * square);
}

struct Mixture {
  color diffuse_albedo;
  color glossy_albedo;
  color returned_albedo;
  float alpha;
  float exponent;
  float above;
};

Mixture no_mixture()
{
  Mixture none;
  none.diffuse_albedo = color(0.0);
  none.glossy_albedo = color(0.0);
  none.returned_albedo = color(0.0);
  none.alpha = 1.0;
  none.exponent = 1.0;
  none.above = 1.0;
  return none;
}

// `areas`, `slant_view`: of the way to the observer.
Mixture mixture(Layer layer, float library[], color areas, color slant_view, color substrate,
                float cos_view)
{
  Mixture sum = no_mixture();
  float eta = layer.eta;
  float g = eta_cos_refracted(cos_view, eta);
  if (!(cos_view > LEAST_COSINE) || !(g > 0.0))
    return sum;
  float cos_in = clamp(g / eta, LEAST_COSINE, 1.0);
  DiffuseSurface surface = diffuse_surface(eta);
  // Diffuse light depends on the paint alone: no loop, and what is set once, so that OSL folds it.
  DiffuseRates diffuse_light = add_diffuse(add_diffuse(diffuse_rates(layer.first, library, surface),
                                                       diffuse_rates(layer.second, library, surface)),
                                           diffuse_rates(layer.third, library, surface));
  FlakeRates rates = no_flakes();
  for (int i = 0; i < layer.species; ++i) {
    Flakes some = flakes_of(layer, i);
    if (some.coverage > 0.0)
      add_flakes(rates, layer, i, library, surface, cos_in, areas[i], slant_view);
  }
  float entered = fresnel_transmittance(cos_view, g, eta);
  float rayleigh = layer.rayleigh_depth;
  color absorption = max(layer.binder_depth - color(rayleigh), color(0.0));
  DiffuseShares red = diffuse_channel(diffuse_light, 0, surface, absorption[0], rayleigh, substrate[0]);
  DiffuseShares green = diffuse_channel(diffuse_light, 1, surface, absorption[1], rayleigh, substrate[1]);
  DiffuseShares blue = diffuse_channel(diffuse_light, 2, surface, absorption[2], rayleigh, substrate[2]);
  color trapped_out = color(red.trapped_out, green.trapped_out, blue.trapped_out);
  color trapped_down = color(red.trapped_down, green.trapped_down, blue.trapped_down);
  color below = color(red.below, green.below, blue.below);
  color straight = color(red.straight, green.straight, blue.straight);
  color lost = color(red.lost, green.lost, blue.lost);
  Returning back = no_returning();
  if (layer.depth_model == DEPTH_MODEL_CORRELATED)
    back = returning(layer, surface, slant_view, cos_in, cos_view);
  sum.alpha = glossy_roughness(layer);
  float near = 1.0 - sum.alpha * sum.alpha;
  for (int c = 0; c < 3; ++c) {
    DiffuseShares diffused;
    diffused.trapped_out = trapped_out[c];
    diffused.trapped_down = trapped_down[c];
    diffused.below = below[c];
    diffused.straight = straight[c];
    diffused.lost = lost[c];
    MixtureShares shares =
        mixture_channel(layer, rates, diffuse_light, diffused, back, c, surface, absorption[c], rayleigh, substrate[c],
                        cos_in);
    float glossy = shares.glossy * near;
    sum.diffuse_albedo[c] = entered * (shares.whole - glossy - shares.returned);
    sum.glossy_albedo[c] = entered * glossy;
    sum.returned_albedo[c] = entered * shares.returned;
  }
  sum.exponent = back.exponent;
  sum.above = back.above;
  return sum;
}
