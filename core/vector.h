// SPDX-License-Identifier: Apache-2.0
//
// The little that the model needs of vectors and colours: what OSL has built in.
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace metallic_paint {

// By their names alone, as the shader has them, these are found for every number type.
using std::abs;
using std::clamp;
using std::floor;
using std::max;
using std::min;
using std::sqrt;

// A direction or a point (x, y, z), or a colour (R, G, B) in linear light.
template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  bool operator==(const Vec3&) const = default;

  template <class U>
  explicit operator Vec3<U>() const {
    return {static_cast<U>(x), static_cast<U>(y), static_cast<U>(z)};
  }
};

template <class T>
Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
Vec3<T> operator*(Vec3<T> a, Vec3<T> b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <class T>
Vec3<T> operator*(Vec3<T> a, T s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
Vec3<T> operator/(Vec3<T> a, Vec3<T> b) {
  return {a.x / b.x, a.y / b.y, a.z / b.z};
}
template <class T>
Vec3<T> operator/(Vec3<T> a, T s) {
  return {a.x / s, a.y / s, a.z / s};
}

// What T computes directions and angles in: P(beta) multiplies their rounding by beta/tilt^2, more
// than a double has to spare. float keeps to itself, as the shader does.
template <class T>
using Wide = std::conditional_t<std::is_same_v<T, double>, long double, T>;

template <class T>
T dot(Vec3<T> a, Vec3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
T length(Vec3<T> a) {
  return sqrt(dot(a, a));
}

template <class T>
Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// f of each component: colours go channel by channel.
template <class T, class F>
Vec3<T> map(Vec3<T> a, F f) {
  return {f(a.x), f(a.y), f(a.z)};
}
template <class T>
Vec3<T> least(Vec3<T> a, Vec3<T> b) {
  return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}

template <class T>
T max_component(Vec3<T> a) {
  return max(max(a.x, a.y), a.z);
}

template <class T>
using Rgb = Vec3<T>;
template <class T>
Rgb<T> grey(T value) {
  return {value, value, value};
}

}  // namespace metallic_paint
