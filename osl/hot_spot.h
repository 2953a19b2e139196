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

float hidden_one_way(float r)
{
  return 1.0 / (1.0 + r * (0.3259 + 0.8235 * r));
}

color hidden_at_once(float one_way, color share)
{
  float more = (1.0 - one_way) * (0.74 + 0.45 * one_way);
  return color(one_way) + more * (share * (color(1.0) - share));
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

struct BothWays {
  color sum;
  color first;
  color second;
  color third;
};

BothWays both_ways(Layer layer, color view_slant, color light_slant, float delta)
{
  BothWays ways;
  ways.sum = view_slant + light_slant;
  ways.first = color(0.0);
  ways.second = color(0.0);
  ways.third = color(0.0);
  if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
    ways.first = share_in_common(min(delta * layer.thickness_in_flakes[0], 1e9), ways.sum);
    if (layer.species > 1)
      ways.second = share_in_common(min(delta * layer.thickness_in_flakes[1], 1e9), ways.sum);
    if (layer.species > 2)
      ways.third = share_in_common(min(delta * layer.thickness_in_flakes[2], 1e9), ways.sum);
  }
  return ways;
}

color share_in_common(Layer layer, BothWays ways)
{
  color sum = ways.first;
  if (layer.species > 1)
    sum = layer.hiding[0] * sum + layer.hiding[1] * ways.second;
  if (layer.species > 2)
    sum = sum + layer.hiding[2] * ways.third;
  return sum;
}

color there_and_back(Layer layer, BothWays ways)
{
  color x = ways.sum;
  if (layer.depth_model == DEPTH_MODEL_CORRELATED)
    x = less_in_common(layer, x, share_in_common(layer, ways));
  return x;
}

color there_and_back(Layer layer, color view_slant, color light_slant, float delta)
{
  return there_and_back(layer, both_ways(layer, view_slant, light_slant, delta));
}

// By one species.
color hidden_whole(Layer layer, color c, color share, float r)
{
  return hidden_at_once(hidden_one_way(r), share) * (c * (color(2.0) - share) + layer.blocking_again * share);
}

float hidden_whole(Layer layer, Flakes flakes, color x, BothWays ways)
{
  float h = 0.0;
  if (layer.depth_model == DEPTH_MODEL_CORRELATED) {
    color c = min(layer.shared_blocking, ways.sum * 0.5);
    color r = color(flakes.diameter) / layer.diameters;
    color hidden = hidden_whole(layer, c, ways.first, r[0]);
    if (layer.species > 1)
      hidden = layer.hiding[0] * hidden + layer.hiding[1] * hidden_whole(layer, c, ways.second, r[1]);
    if (layer.species > 2)
      hidden = hidden + layer.hiding[2] * hidden_whole(layer, c, ways.third, r[2]);
    hidden = min(hidden, x);
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
