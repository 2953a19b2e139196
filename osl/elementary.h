// SPDX-License-Identifier: Apache-2.0
//
// Elementary functions from + - * /, sqrt, exp2 of whole numbers and logb, operation for operation the float versions
// of core/elementary.h, where their errors stand: Blender's own exp, expm1 and acos are approximate.
#pragma once

// OSL's own dot() rounds once less where Blender was built with fused multiply-add.
float inner_product(vector a, vector b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

float exponential(float x)
{
  if (x < -87.0)
    return 0.0;
  float y = min(x, 87.0);
  float k = floor(y * 1.44269504 + 0.5);
  float r = (y - k * 0.693145752) - k * 1.42860677e-6;
  float e_r = 1.0 + r * (1.0 + r * (0.499999911 + r * (0.166664198 + r * (0.0416682251 +
              r * (0.00837482233 + r * 0.00138368341)))));
  return e_r * exp2(k);
}

float logarithm(float x)
{
  float e = logb(x);
  float m = x * exp2(-e);
  if (m >= 1.41421356) {
    m *= 0.5;
    e += 1.0;
  }
  float s = (m - 1.0) / (m + 1.0);
  float z = s * s;
  float ln_m = s * (2.0 + z * (0.666668177 + z * (0.399746835 + z * 0.299286366)));
  return e * 0.693147181 + ln_m;
}

float sine(float x)
{
  float z = x * x;
  return x * (1.0 + z * (-0.166666672 + z * (0.00833333097 + z * (-0.000198408321 +
         z * (2.75239722e-6 + z * -2.38683491e-8)))));
}

float cosine(float x)
{
  float z = x * x;
  return 1.0 + z * (-0.5 + z * (0.0416666679 + z * (-0.00138888846 + z * (2.48010401e-5 +
         z * (-2.75246975e-7 + z * 1.99078687e-9)))));
}

float arccosine(float x)
{
  float a = 1.57079625 + x * (-0.2145987 + x * (0.0889773071 + x * (-0.0501641743 +
            x * (0.0308627058 + x * (-0.0170450341 + x * (0.00663856883 + x * -0.00125344284))))));
  return sqrt(1.0 - x) * a;
}

float squared_angle(float y)
{
  float q = 1.0 + y * (0.333333671 + y * (0.177756384 + y * (0.114809297 + y * (0.0748232305 +
            y * (0.10653042 + y * (-0.138072118 + y * (0.50241071 + y * (-0.609925389 +
            y * 0.436604947))))))));
  return 4.0 * y * q;
}

float mean_transmittance(float x)
{
  if (x < 1.0)
    return 1.0 + x * (-0.5 + x * (0.166666493 + x * (-0.0416653343 + x * (0.00832814351 +
           x * (-0.00137776637 + x * (0.000184942284 + x * -1.59309293e-5))))));
  return (1.0 - exponential(-x)) / x;
}

color mean_transmittance(color x)
{
  return color(mean_transmittance(x[0]), mean_transmittance(x[1]), mean_transmittance(x[2]));
}

float mills_ratio(float x)
{
  float t = 3.0 / (3.0 + x);
  return 9.77922355e-6 + t * (0.333045393 + t * (0.336978942 + t * (0.270209223 + t * (0.338728666 +
         t * (-0.213797688 + t * (0.655997455 + t * (-0.768586218 + t * (0.365994066 +
         t * -0.0652654618))))))));
}

float normal_density(float x)
{
  return 0.398942280 * exponential(-0.5 * x * x);
}

float normal_cdf(float x)
{
  float tail = normal_density(x) * mills_ratio(fabs(x));
  if (x < 0.0)
    return tail;
  return 1.0 - tail;
}

float normal_quantile(float probability)
{
  float q = probability - 0.5;
  if (fabs(q) <= 0.425) {
    float r = 0.180625 - q * q;
    float num = ((((((2509.08093 * r + 33430.5756) * r + 67265.7709) * r + 45921.9540) * r +
                   13731.6938) * r + 1971.59095) * r + 133.141668) * r + 3.38713287;
    float den = ((((((5226.49528 * r + 28729.0857) * r + 39307.8958) * r + 21213.7943) * r +
                   5394.19602) * r + 687.187007) * r + 42.3133307) * r + 1.0;
    return q * num / den;
  }
  float tail = probability;
  if (q >= 0.0)
    tail = max(1.0 - probability, 2.98023224e-8);
  float r = sqrt(-logarithm(tail));
  float x = 0.0;
  if (r <= 5.0) {
    float s = r - 1.6;
    float num = ((((((7.74545014e-4 * s + 0.0227238449) * s + 0.241780725) * s + 1.27045825) * s +
                   3.64784832) * s + 5.76949722) * s + 4.63033785) * s + 1.42343711;
    float den = ((((((1.05075007e-9 * s + 5.47593808e-4) * s + 0.0151986666) * s + 0.148103976) * s +
                   0.689767335) * s + 1.67638483) * s + 2.05319163) * s + 1.0;
    x = num / den;
  }
  else {
    float s = r - 5.0;
    float num = ((((((2.01033440e-7 * s + 2.71155557e-5) * s + 0.00124266095) * s + 0.0265321895) * s +
                   0.296560572) * s + 1.78482654) * s + 5.46378491) * s + 6.65790464;
    float den = ((((((2.04426310e-15 * s + 1.42151176e-7) * s + 1.84631832e-5) * s +
                   7.86869131e-4) * s + 0.0148753613) * s + 0.136929881) * s + 0.599832207) * s + 1.0;
    x = num / den;
  }
  if (q < 0.0)
    return -x;
  return x;
}
