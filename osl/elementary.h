// SPDX-License-Identifier: Apache-2.0
//
// Elementary functions from + - * /, sqrt, exp2 of whole numbers and logb, operation for operation the float versions
// of core/elementary.h, where their errors stand: Blender's own exp, expm1 and acos are approximate.
#pragma once

// OSL's own dot() rounds once less where Blender was built with fused multiply-add.
float inner_product(vector a, vector b)
{
  vector product = a * b;
  return product[0] + product[1] + product[2];
}

// No `return` before the end of what OSL is to fold, and no `?:`, in which oslc takes the end for one more.
float exponential(float x)
{
  float power = 0.0;
  if (!(x < -87.0)) {
    float y = min(x, 87.0);
    float k = floor(y * 1.44269504 + 0.5);
    float r = (y - k * 0.693145752) - k * 1.42860677e-6;
    float e_r = 1.0 + r * (1.0 + r * (0.499999911 + r * (0.166664198 + r * (0.0416682251 +
                r * (0.00837482233 + r * 0.00138368341)))));
    power = e_r * exp2(k);
  }
  return power;
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
  float mean = 1.0;
  if (x < 1.0)
    mean = 1.0 + x * (-0.5 + x * (0.166666493 + x * (-0.0416653343 + x * (0.00832814351 +
           x * (-0.00137776637 + x * (0.000184942284 + x * -1.59309293e-5))))));
  else
    mean = (1.0 - exponential(-x)) / x;
  return mean;
}

// How many channels need computing: one of a grey. LLVM would copy a loop that it knows to run three times.
int channels_of(color x)
{
  int channels = 3;
  if (x == color(x[0]))
    channels = 1;
  return channels;
}

color exponential(color x)
{
  int channels = channels_of(x);
  color power = color(0.0);
  for (int c = 0; c < channels; ++c)
    power[c] = exponential(x[c]);
  if (channels == 1)
    power = color(power[0]);
  return power;
}

color mean_transmittance(color x)
{
  int channels = channels_of(x);
  color mean = color(0.0);
  for (int c = 0; c < channels; ++c)
    mean[c] = mean_transmittance(x[c]);
  if (channels == 1)
    mean = color(mean[0]);
  return mean;
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

float normal_cdf(float x, float density)
{
  float tail = density * mills_ratio(fabs(x));
  if (x < 0.0)
    return tail;
  return 1.0 - tail;
}

float normal_cdf(float x)
{
  return normal_cdf(x, normal_density(x));
}

float normal_quantile(float probability)
{
  float tail = probability;
  if (probability >= 0.5)
    tail = max(1.0 - probability, 2.98023224e-8);
  float s = sqrt(-logarithm(tail)) - 0.832554638;
  float x = s * (2.08690047 + s * (3.06331158 + s * (1.21001446 + s * 0.121097498))) /
            (1.0 + s * (1.69982719 + s * (0.786421716 + s * 0.0855965614)));
  if (probability < 0.5)
    x = -x;
  return x;
}
