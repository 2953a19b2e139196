// SPDX-License-Identifier: Apache-2.0
//
// Random numbers by hash, bit for bit those of core/random.h.
#pragma once

float uniform_deviate(float x, float y, float z, float w)
{
  float value = noise("hash", point(x, y, z), w);
  return clamp(value, 1.16415322e-10, 0.999999940);
}

vector uniform_deviates(vector at, float w)
{
  return vector(uniform_deviate(at[0], at[1], at[2], w), uniform_deviate(at[2], at[0], w, at[1]), uniform_deviate(w, at[2], at[1], at[0]));
}

vector hashed(vector at, float w)
{
  return floor(uniform_deviates(at, w) * 4194304.0);
}

float wrapped(int whole)
{
  return (float)(whole & 4194303);
}

float wrapped(float whole)
{
  float bounded = clamp(whole, -1e30, 1e30);
  return bounded - floor(bounded * 2.38418579e-7) * 4194304.0;
}

vector stream_key(int kind, int instance, int frame, int seed)
{
  return hashed(vector(wrapped(kind), wrapped(instance), wrapped(frame)), wrapped(seed));
}

vector pixel_key(vector stream, int x, int y, int number)
{
  return hashed(stream + vector(wrapped(x), wrapped(y), 0.0), wrapped(number));
}
