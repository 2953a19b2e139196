// SPDX-License-Identifier: Apache-2.0
//
// What hides a flake from the observer and from the light as well: see core/hot_spot.h.
#pragma once

#include "layer.h"

float share_in_common(float w, float x)
{
  float y = w / (1.0 + 0.0971 * x);
  return (1.0 + 1.6392 * y) / (1.0 + y * (2.0389 + y * (1.8717 / (1.0 + 0.1464 * x))));
}

color share_in_common(float w, color x)
{
  int channels = channels_of(x);
  color share = color(0.0);
  for (int c = 0; c < channels; ++c)
    share[c] = share_in_common(w, x[c]);
  if (channels == 1)
    share = color(share[0]);
  return share;
}

color hidden_one_way(color r)
{
  return color(1.0) / (color(1.0) + r * (color(0.3259) + 0.8235 * r));
}

float hidden_one_way(Layer layer, float diameter)
{
  color hidden = layer.hiding * hidden_one_way(color(diameter) / layer.diameters);
  return hidden[0] + hidden[1] + hidden[2];
}

color hidden_at_once(float one_way, color share)
{
  float more = (1.0 - one_way) * (0.74 + 0.45 * one_way);
  return color(one_way) + more * (share * (color(1.0) - share));
}

color share_in_common(Layer layer, float delta, color x)
{
  color sum = share_in_common(min(delta * layer.thickness_in_flakes[0], 1e9), x);
  if (layer.species > 1)
    sum = layer.hiding[0] * sum + layer.hiding[1] * share_in_common(min(delta * layer.thickness_in_flakes[1], 1e9), x);
  if (layer.species > 2)
    sum = sum + layer.hiding[2] * share_in_common(min(delta * layer.thickness_in_flakes[2], 1e9), x);
  return sum;
}

float share_in_common(Layer layer, float delta, float x)
{
  float sum = share_in_common(min(delta * layer.thickness_in_flakes[0], 1e9), x);
  if (layer.species > 1)
    sum = layer.hiding[0] * sum + layer.hiding[1] * share_in_common(min(delta * layer.thickness_in_flakes[1], 1e9), x);
  if (layer.species > 2)
    sum = sum + layer.hiding[2] * share_in_common(min(delta * layer.thickness_in_flakes[2], 1e9), x);
  return sum;
}

float holes_in_common(float w, float g)
{
  float way = max(w, 1e-3);
  float u = min(g, 1.0);
  float v = min(g + way, 1.0);
  float sum = u + v;
  float squares = u * u + v * v;
  float product = u * v;
  float mean = 1.0 - sum * (0.63662 - (0.05305 * squares + 0.00798 * (squares * squares - product * product)));
  return max((v - u) / way * mean, 0.0);
}

float holes_in_common(Layer layer, float delta)
{
  float sum = holes_in_common(min(delta * layer.thickness_in_flakes[0], 1e9), min(delta * layer.gap_in_flakes[0], 1e9));
  if (layer.species > 1)
    sum = layer.hiding[0] * sum + layer.hiding[1] * holes_in_common(min(delta * layer.thickness_in_flakes[1], 1e9),
                                                                    min(delta * layer.gap_in_flakes[1], 1e9));
  if (layer.species > 2)
    sum = sum + layer.hiding[2] * holes_in_common(min(delta * layer.thickness_in_flakes[2], 1e9),
                                                  min(delta * layer.gap_in_flakes[2], 1e9));
  return sum;
}

color less_in_common(Layer layer, color x, color share)
{
  return x - min(layer.shared_blocking, x * 0.5) * share;
}

color there_and_back(Layer layer, color view_slant, color light_slant, float delta)
{
  color x = view_slant + light_slant;
  if (layer.depth_model == DEPTH_MODEL_CORRELATED)
    x = less_in_common(layer, x, share_in_common(layer, delta, x));
  return x;
}

float hidden_whole(Layer layer, Flakes flakes, color x, color shared)
{
  float h = 0.0;
  if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
    color c = min(layer.shared_blocking, (x + shared) * 0.5);
    color share = min(max(shared / max(c, color(1e-30)), color(0.0)), color(1.0));
    color whole = c * (color(2.0) - share) + layer.blocking_again * share;
    color hidden = min(hidden_at_once(hidden_one_way(layer, flakes.diameter), share) * whole, x);
    h = min(min(hidden[0], hidden[1]), hidden[2]);
  }
  return h;
}

float ways_apart(vector n, vector view, float cos_view, float g_view, vector light, float cos_light, float g_light)
{
  vector between = (view - n * cos_view) * (1.0 / max(g_view, LEAST_COSINE)) -
                   (light - n * cos_light) * (1.0 / max(g_light, LEAST_COSINE));
  return sqrt(inner_product(between, between));
}
