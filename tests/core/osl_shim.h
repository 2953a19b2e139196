// SPDX-License-Identifier: Apache-2.0
//
// The shader's headers as C++. CMakeLists.txt rewrites what C++ says otherwise (numbers without a
// suffix are floats, outputs references, arrays values); here is what OSL has built in and the
// headers use, in namespace osl. OSL's ints wrap: compile with -fwrapv.
#pragma once

#include <array>
#include <cmath>

#include "noise.h"
#include "random.h"

namespace osl {

// OSL's color, vector, point and normal.
struct Triple {
  float at[3]{};
  Triple() = default;
  Triple(float grey) : at{grey, grey, grey} {}
  Triple(float x, float y, float z) : at{x, y, z} {}
  float& operator[](int i) { return at[i]; }
  float operator[](int i) const { return at[i]; }
};
using color = Triple;
using vector = Triple;
using point = Triple;
using normal = Triple;

template <class F>
Triple each(Triple a, Triple b, F f) {
  return {f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2])};
}
inline Triple operator+(Triple a, Triple b) {
  return each(a, b, [](float x, float y) { return x + y; });
}
inline Triple operator-(Triple a, Triple b) {
  return each(a, b, [](float x, float y) { return x - y; });
}
inline Triple operator*(Triple a, Triple b) {
  return each(a, b, [](float x, float y) { return x * y; });
}
inline Triple operator/(Triple a, Triple b) {
  return each(a, b, [](float x, float y) { return x / y; });
}
inline Triple operator-(Triple a) { return Triple(0) - a; }
inline Triple& operator+=(Triple& a, Triple b) { return a = a + b; }
inline int operator==(Triple a, Triple b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

inline float sqrt(float x) { return std::sqrt(x); }
inline float floor(float x) { return std::floor(x); }
inline float fabs(float x) { return std::fabs(x); }
inline float sin(float x) { return std::sin(x); }
inline float cos(float x) { return std::cos(x); }
inline float asin(float x) { return std::asin(x); }
inline float exp2(float x) { return std::exp2(x); }
inline float logb(float x) { return std::logb(x); }
inline float ceil(float x) { return std::ceil(x); }
inline int getattribute(const char*, float&) { return 0; }
inline int isfinite(float x) { return std::isfinite(x); }
inline int min(int a, int b) { return a < b ? a : b; }
inline int max(int a, int b) { return a > b ? a : b; }
inline int clamp(int x, int least, int most) { return max(least, min(x, most)); }
inline float min(float a, float b) { return a < b ? a : b; }
inline float max(float a, float b) { return a > b ? a : b; }
inline float clamp(float x, float least, float most) { return max(least, min(x, most)); }
inline Triple min(Triple a, Triple b) {
  return each(a, b, [](float x, float y) { return min(x, y); });
}
inline Triple max(Triple a, Triple b) {
  return each(a, b, [](float x, float y) { return max(x, y); });
}
inline Triple cross(Triple a, Triple b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline float dot(Triple a, Triple b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline float length(Triple a) { return sqrt(dot(a, a)); }
inline Triple noise(const char*, Triple p) {
  const auto n = metallic_paint::perlin_noise<float>({p[0], p[1], p[2]});
  return {n.x, n.y, n.z};
}

inline float noise(const char*, Triple p, float w) {
  return metallic_paint::hash_value(p[0], p[1], p[2], w);
}
inline Triple sqrt(Triple a) { return {sqrt(a[0]), sqrt(a[1]), sqrt(a[2])}; }
inline Triple floor(Triple a) { return {floor(a[0]), floor(a[1]), floor(a[2])}; }

inline Triple normalize(Triple a) { return a / length(a); }

// What only a renderer has: no camera and no object here; a closure is its weight.
inline Triple transform(const char*, Triple p) { return p; }
inline Triple transform(const char*, const char*, Triple p) { return p; }
struct matrix {
  matrix(const char*, const char*) {}
  Triple operator[](int) const { return {}; }
};
inline Triple transform(matrix, Triple p) { return p; }
inline Triple Dx(Triple) { return {}; }
inline Triple Dy(Triple) { return {}; }
inline int raytype(const char*) { return 0; }
inline float glossy_toon(Triple, float, float) { return 1; }
inline float reflection(Triple) { return 1; }
inline float diffuse(Triple) { return 1; }
inline float diffuse_toon(Triple, float, float) { return 1; }
template <class Ramp>
float diffuse_ramp(Triple, const Ramp&) {
  return 1;
}
template <class Ramp>
float phong_ramp(Triple, float, const Ramp&) {
  return 1;
}
inline float microfacet(const char*, Triple, Triple, float, float, float, int) { return 1; }
#define closure

#undef M_PI
#undef M_PI_2
#define M_PI 3.14159265f
#define M_PI_2 1.57079633f
#define M_2PI 6.28318531f

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wshadow"
#include "osl/anchor.h"
#include "osl/close_up.h"
#include "osl/composition.h"
#include "osl/cones.h"
#include "osl/diffuse_lobe.h"
#include "osl/flake_lobe.h"
#include "osl/mixture.h"
#include "osl/mixture_lobes.h"
#include "osl/orange_peel.h"
#include "osl/phong_lobe.h"
#include "osl/sound.h"
#include "osl/sparkles.h"
#include "osl/texture.h"
#include "osl/whole_paint.h"
#pragma GCC diagnostic pop
#undef closure

}  // namespace osl
