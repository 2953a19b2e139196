// SPDX-License-Identifier: Apache-2.0
//
// The orientation of the flakes, P(beta), and their mean projected area <s>: see core/orientation.h.
#pragma once

#include "choices.h"
#include "elementary.h"
#include "quadrature.h"

#define GAUSSIAN_REACH 5.5
#define HALF_PI 1.57079633
#define POINT_CAP 0.0625
#define NARROW_BACK 0.4

struct OrientationDensity {
  int kind;
  float tilt;
  float norm;
  float mean_cos;
  float below;
  float back_cosine;
  int narrow;  // whether narrow_back_area holds
};

float dawson_series(float y)
{
  return 1.0 - y / 3.0 * (1.0 - y / 5.0 * (1.0 - y / 7.0 * (1.0 - y / 9.0 * (1.0 - y / 11.0 *
         (1.0 - y / 13.0 * (1.0 - y / 15.0))))));
}

void add_ring(float limit, float tilt, float node, float weight, output float sum, output float sum_cos)
{
  float beta = limit * node;
  float x = beta / tilt;
  float term = weight * exponential(-0.5 * x * x) * sine(beta);
  sum = sum + term;
  sum_cos = sum_cos + term * cosine(beta);
}

OrientationDensity make_orientation(int kind, float tilt)
{
  OrientationDensity density;
  density.kind = kind;
  density.tilt = tilt;
  density.below = 1.0;
  density.back_cosine = 1.0;
  density.narrow = tilt <= NARROW_BACK;
  float square = tilt * tilt;
  if (kind == ORIENTATION_GAUSSIAN) {
    density.below = 1.0 - exponential(-0.5 * HALF_PI * HALF_PI / square);
    density.back_cosine = sine(min(GAUSSIAN_REACH * tilt, HALF_PI));
    if (square <= 0.08) {
      density.norm = square * dawson_series(square);
      density.mean_cos = dawson_series(4.0 * square) / dawson_series(square);
    }
    else {
      // Written out: OSL folds no loop.
      float limit = min(HALF_PI, GAUSSIAN_REACH * tilt);
      float sum = 0.0;
      float sum_cos = 0.0;
      add_ring(limit, tilt, 0.00921968288, 0.0235876682, sum, sum_cos);
      add_ring(limit, tilt, 0.0479413718, 0.053469663, sum, sum_cos);
      add_ring(limit, tilt, 0.115048663, 0.0800391643, sum, sum_cos);
      add_ring(limit, tilt, 0.206341023, 0.101583713, sum, sum_cos);
      add_ring(limit, tilt, 0.316084251, 0.116746268, sum, sum_cos);
      add_ring(limit, tilt, 0.437383296, 0.124573523, sum, sum_cos);
      add_ring(limit, tilt, 0.562616704, 0.124573523, sum, sum_cos);
      add_ring(limit, tilt, 0.683915749, 0.116746268, sum, sum_cos);
      add_ring(limit, tilt, 0.793658977, 0.101583713, sum, sum_cos);
      add_ring(limit, tilt, 0.884951337, 0.0800391643, sum, sum_cos);
      add_ring(limit, tilt, 0.952058628, 0.053469663, sum, sum_cos);
      add_ring(limit, tilt, 0.990780317, 0.0235876682, sum, sum_cos);
      density.norm = limit * sum;
      density.mean_cos = sum_cos / sum;
    }
  }
  else if (kind == ORIENTATION_BECKMANN) {
    float root_half = 0.707106781;
    density.mean_cos = 1.0 / (1.0 + root_half * tilt * mills_ratio(2.0 * root_half / tilt));
    density.norm = square / (2.0 * density.mean_cos);
  }
  else {
    float w2 = (1.0 - tilt) * (1.0 + tilt);
    float artanh_over_w = 1.0 + w2 * (1.0 / 3.0 + w2 * (1.0 / 5.0 + w2 * (1.0 / 7.0 + w2 / 9.0)));
    if (w2 > 0.0025) {
      float w = sqrt(w2);
      artanh_over_w = logarithm((1.0 + w) / tilt) / w;
    }
    float ratio = 1.0 + square * artanh_over_w;
    density.norm = ratio / (2.0 * square);
    density.mean_cos = 1.0 / ratio;
  }
  return density;
}

float gaussian_density(OrientationDensity density, float sin2_half_beta)
{
  float square = density.tilt * density.tilt;
  return exponential(-0.5 * (squared_angle(sin2_half_beta) / square)) / density.norm;
}

float orientation_density(OrientationDensity density, float sin2_half_beta)
{
  float square = density.tilt * density.tilt;
  float cos_beta = 1.0 - 2.0 * sin2_half_beta;
  float sin2 = 4.0 * sin2_half_beta * (1.0 - sin2_half_beta);
  float found = 0.0;
  if (density.kind == ORIENTATION_GAUSSIAN)
    found = gaussian_density(density, sin2_half_beta);
  else if (density.kind == ORIENTATION_BECKMANN) {
    float cos2 = cos_beta * cos_beta;
    if (cos2 >= 1e-9)
      found = exponential(-(sin2 / cos2) / square) / (cos2 * cos2 * density.norm);
  }
  else {
    float d = square + (1.0 - square) * sin2;
    found = 1.0 / (d * d * density.norm);
  }
  return found;
}

float orientation_slope(OrientationDensity density, float sin2_half_beta)
{
  float square = density.tilt * density.tilt;
  float cos_beta = 1.0 - 2.0 * sin2_half_beta;
  float sin2 = 4.0 * sin2_half_beta * (1.0 - sin2_half_beta);
  float slope = 0.0;
  if (density.kind == ORIENTATION_GGX)
    slope = 4.0 * (1.0 - square) * cos_beta / (square + (1.0 - square) * sin2);
  else if (density.kind == ORIENTATION_BECKMANN) {
    float cosine = max(cos_beta, 1e-3);
    slope = 2.0 / (cosine * cosine * cosine * square) - 4.0 / cosine;
  }
  else
    slope = sqrt(squared_angle(sin2_half_beta) / max(sin2, 1e-30)) / square;
  return slope;
}

float core_variance(OrientationDensity density)
{
  float square = density.tilt * density.tilt;
  if (density.kind == ORIENTATION_GGX)
    square = square / 4.0;
  else if (density.kind == ORIENTATION_BECKMANN)
    square = square / 2.0;
  return square;
}

float orientation_reach(OrientationDensity density)
{
  if (density.kind == ORIENTATION_GAUSSIAN)
    return min(HALF_PI, GAUSSIAN_REACH * density.tilt);
  if (density.kind == ORIENTATION_BECKMANN)
    return min(HALF_PI, 6.5 * density.tilt);
  return HALF_PI;
}

float cap_probability(OrientationDensity density, float sin2_half_beta, float sin2_half_rho)
{
  float square = squared_angle(min(sin2_half_rho, 0.5));
  float point_cap = POINT_CAP * min(density.tilt, 1.0);
  if (square <= point_cap * point_cap)
    return 2.0 * orientation_density(density, sin2_half_beta) * sin2_half_rho;
  float node[12];
  float weight[12];
  gauss_rule(node, weight);
  float rho = sqrt(square);
  float beta = sqrt(squared_angle(sin2_half_beta));
  float sin_beta = sine(beta);
  float whole = rho - beta;
  float sum = 0.0;
  float from = max(-whole, 0.0);
  float reach = orientation_reach(density);
  float end = min(min(beta + rho, HALF_PI), sqrt(from * from + reach * reach));
  float edge = density.tilt;
  while (edge <= from)
    edge = edge * 4.0;
  while (from < end) {
    float to = min(edge, end);
    if (from < whole)
      to = min(to, whole);
    float width = to - from;
    for (int i = 0; i < GAUSS_POINTS; ++i) {
      float x = node[i];
      float b = from + width * (x * x * (3.0 - 2.0 * x));
      float sin_half = sine(b / 2.0);
      float sin_b = sine(b);
      float arc = 1.0;
      if (b > whole) {
        float near = sine(max((b + whole) / 2.0, 0.0));
        float far = sine(max((beta + rho - b) / 2.0, 0.0));
        float y = near * far / (sin_beta * sin_b);
        if (y < 1.0) {
          float nearer = sqrt(squared_angle(min(y, 1.0 - y))) / M_PI;
          arc = y < 0.5 ? nearer : 1.0 - nearer;
        }
      }
      float ring = weight[i] * (6.0 * x * (1.0 - x)) * width * arc;
      sum = sum + ring * sin_b * orientation_density(density, sin_half * sin_half);
    }
    from = to;
    if (edge <= to)
      edge = edge * 4.0;
  }
  return min(sum, 1.0);
}

struct SampledTilt {
  float sin2_half_beta;
  float weight;
};

SampledTilt sample_tilt(OrientationDensity density, float deviate)
{
  SampledTilt sampled;
  float square = density.tilt * density.tilt;
  if (density.kind == ORIENTATION_GGX) {
    float w = (1.0 - density.tilt) * (1.0 + density.tilt);
    float x = deviate * square / (1.0 - deviate * w);
    float ratio = (square + w * x) / (square + w * x * (2.0 - x));
    sampled.sin2_half_beta = x / 2.0;
    sampled.weight = ratio * ratio / (density.norm * square);
  }
  else if (density.kind == ORIENTATION_BECKMANN) {
    float tan2 = square * -logarithm(deviate);
    float cos_beta = 1.0 / sqrt(1.0 + tan2);
    sampled.sin2_half_beta = 0.5 * tan2 * cos_beta * cos_beta / (1.0 + cos_beta);
    sampled.weight = density.mean_cos / cos_beta;
  }
  else if (density.tilt > 0.5) {
    sampled.sin2_half_beta = deviate / 2.0;
    sampled.weight = gaussian_density(density, deviate / 2.0);
  }
  else {
    float beta = density.tilt * sqrt(-2.0 * logarithm(1.0 - deviate * density.below));
    float half = sine(beta / 2.0);
    float sinc = 1.0;
    if (beta > 0.0)
      sinc = sine(beta) / beta;
    sampled.sin2_half_beta = half * half;
    sampled.weight = sinc * square * density.below / density.norm;
  }
  return sampled;
}

float most_tilt_weight(OrientationDensity density)
{
  float square = density.tilt * density.tilt;
  if (density.kind == ORIENTATION_BECKMANN)
    return density.mean_cos * sqrt(1.0 + 16.0 * square);
  if (density.kind == ORIENTATION_GGX)
    return 1.0 / (density.norm * square);
  if (density.tilt > 0.5)
    return 1.0 / density.norm;
  return square * density.below / density.norm;
}

float narrow_back_area(OrientationDensity density, float b0)
{
  float s = density.tilt;
  float c0 = 0.999948561 + s * (0.00132694806 + s * (-0.680161595 + s * (0.061232321 + s * 0.267149389)));
  float c1 = 0.00140373979 + s * (0.410378277 + s * (-0.00062495051 + s * (-0.265823483 + s * -0.132559106)));
  float c2 = -0.00404177979 + s * (0.326647073 + s * (-2.23132157 + s * (7.13950872 + s * -7.62903643)));
  float c3 = 0.480474234 + s * (-1.7636373 + s * (2.3438592 + s * -1.36711812));
  float c4 = -0.544060051 + s * (2.23223352 + s * -1.72242761);
  float c5 = 0.24584423 + s * -0.777165353;
  float curved = c0 + b0 * (c1 + b0 * (c2 + b0 * (c3 + b0 * (c4 + b0 * (c5 + b0 * 0.0480376258)))));
  float beyond = -0.109831154 + b0 * (-0.0525594763 + b0 * 0.0711019114);
  float y = b0 / s;
  return s * normal_density(y) * (1.0 - y * mills_ratio(y)) * curved + (1.0 - density.below) * beyond;
}

float gaussian_back_area(OrientationDensity density, float cos_theta)
{
  if (cos_theta >= density.back_cosine)
    return 0.0;
  float b0 = HALF_PI - arccosine(cos_theta);
  float area = 0.0;
  if (density.narrow)
    area = narrow_back_area(density, b0);
  else {  // OSL drops no text behind a return
    float limit = min(HALF_PI, b0 + GAUSSIAN_REACH * density.tilt);
    float node[12];
    float weight[12];
    gauss_rule(node, weight);
    float sin_theta = sqrt((1.0 - cos_theta) * (1.0 + cos_theta));
    float sum = 0.0;
    for (int i = 0; i < GAUSS_POINTS; ++i) {
      float x = node[i];
      float b = b0 + (limit - b0) * x * x;
      float sin_b = sine(b);
      float a = cos_theta * cosine(b);
      float c = sin_theta * sin_b;
      if (a < c) {
        float back = sqrt((c - a) * (c + a)) - a * arccosine(a / c);
        float tilts = b / density.tilt;
        sum = sum + weight[i] * x * exponential(-0.5 * tilts * tilts) * sin_b * back;
      }
    }
    area = 2.0 * (limit - b0) * sum / (M_PI * density.norm);
  }
  return area;
}

float mean_projected_area(OrientationDensity density, float cos_theta)
{
  float area = cos_theta * density.mean_cos;
  float spread = density.tilt * sqrt((1.0 - cos_theta) * (1.0 + cos_theta));
  if (density.kind == ORIENTATION_GAUSSIAN) {
    if (density.back_cosine > 0.0)
      area = area + 2.0 * gaussian_back_area(density, cos_theta);
  }
  else if (density.kind == ORIENTATION_GGX)
    area = density.mean_cos * sqrt(cos_theta * cos_theta + spread * spread);
  else if (cos_theta <= 6.0 * spread) {
    float x = 1.41421356 * cos_theta / spread;
    float tail = 2.0 * normal_density(x);
    area = density.mean_cos * (cos_theta * (1.0 - tail * mills_ratio(x)) + 0.707106781 * spread * tail);
  }
  return area;
}
