// SPDX-License-Identifier: Apache-2.0
//
// Random numbers by hash of integers, bit for bit those of core/random.h. OSL's ints wrap like unsigned ones in + and *;
// >> copies the sign, so the shifted bits are masked.
#pragma once

struct HashWords {
  int x;
  int y;
  int z;
  int w;
};

HashWords pcg4d(int x, int y, int z, int w)
{
  HashWords h;
  h.x = x * 1664525 + 1013904223;
  h.y = y * 1664525 + 1013904223;
  h.z = z * 1664525 + 1013904223;
  h.w = w * 1664525 + 1013904223;
  h.x += h.y * h.w;
  h.y += h.z * h.x;
  h.z += h.x * h.y;
  h.w += h.y * h.z;
  h.x = h.x ^ ((h.x >> 16) & 65535);
  h.y = h.y ^ ((h.y >> 16) & 65535);
  h.z = h.z ^ ((h.z >> 16) & 65535);
  h.w = h.w ^ ((h.w >> 16) & 65535);
  h.x += h.y * h.w;
  h.y += h.z * h.x;
  h.z += h.x * h.y;
  h.w += h.y * h.z;
  return h;
}

HashWords stream_key(int light, int species, int frame, int seed)
{
  return pcg4d(light, species, frame, seed);
}

HashWords draw_words(HashWords key, int x, int y, int draw)
{
  return pcg4d(x ^ key.x, y ^ key.y, key.z, key.w + draw);
}

float uniform_48(int high, int low)
{
  float step = 5.96046448e-8;
  return ((float)((high >> 8) & 16777215) + ((float)((low >> 8) & 16777215) + 0.5) * step) * step;
}

float uniform_23(int word)
{
  return ((float)((word >> 9) & 8388607) + 0.5) * 1.19209290e-7;
}

float uniform_16(int word)
{
  return ((float)(word & 65535) + 0.5) * 1.52587891e-5;
}
