// SPDX-License-Identifier: Apache-2.0
//
// Several floats side by side as one number of the model: the same text computes as many pixels at
// once as the processor has lanes, each to the bit of float.
//
// The model branches, and a processor's lanes cannot. A comparison of lanes says what it is in the
// first of those that are followed. Where it is otherwise in another, that lane is left behind:
// what it computes from there on counts for nothing, and it is followed later, in a pass of its
// own (`in_lanes`). In most paints the pixels of a picture go the same way.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <experimental/simd>
#include <numbers>
#include <type_traits>

#include "vector.h"

namespace metallic_paint {

// Simd: std::experimental::native_simd<float>, another type in each translation unit that is
// compiled for another processor.
template <class Simd>
class Lanes {
 public:
  using Mask = typename Simd::mask_type;
  using Ints = std::experimental::rebind_simd_t<int, Simd>;
  using Words = std::experimental::rebind_simd_t<std::uint32_t, Simd>;
  using Vector [[gnu::vector_size(sizeof(Simd))]] = float;
  static constexpr std::size_t kCount = Simd::size();

  Lanes() : all_(0.0f) {}
  template <class Number>
    requires std::is_arithmetic_v<Number>
  Lanes(Number same) : all_(static_cast<float>(same)) {}
  explicit Lanes(Simd all) : all_(all) {}
  explicit Lanes(Words all) : all_(std::experimental::static_simd_cast<Simd>(all)) {}

  // Where the lanes lie in memory: Simd's own operator takes them through a copy.
  float operator[](std::size_t lane) const {
    using Float [[gnu::may_alias]] = float;
    return reinterpret_cast<const Float*>(&all_)[lane];
  }
  Simd all() const { return all_; }

  friend Lanes operator+(Lanes a, Lanes b) { return Lanes(a.all_ + b.all_); }
  friend Lanes operator-(Lanes a, Lanes b) { return Lanes(a.all_ - b.all_); }
  friend Lanes operator*(Lanes a, Lanes b) { return Lanes(a.all_ * b.all_); }
  friend Lanes operator/(Lanes a, Lanes b) { return Lanes(a.all_ / b.all_); }
  Lanes operator-() const { return Lanes(-all_); }
  Lanes& operator*=(Lanes b) { return *this = *this * b; }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }

  friend bool operator<(Lanes a, Lanes b) { return follow(a.all_ < b.all_); }
  friend bool operator>(Lanes a, Lanes b) { return follow(a.all_ > b.all_); }
  friend bool operator<=(Lanes a, Lanes b) { return follow(a.all_ <= b.all_); }
  friend bool operator>=(Lanes a, Lanes b) { return follow(a.all_ >= b.all_); }
  friend bool operator==(Lanes a, Lanes b) { return follow(a.all_ == b.all_); }

  // The whole number, towards 0; others than the first lane's are left behind.
  explicit operator int() const {
    const auto whole = std::experimental::static_simd_cast<Ints>(all_);
    const int one = whole[first()];
    return follow(all_ == all_ && std::experimental::static_simd_cast<Simd>(whole) ==
                                      Simd(static_cast<float>(one))),
           one;
  }

  // As std::min and std::max have it. Those of std::experimental ignore NaN and signed zeros.
  friend Lanes min(Lanes a, Lanes b) {
    const auto x = std::bit_cast<Vector>(a.all_), y = std::bit_cast<Vector>(b.all_);
    return Lanes(std::bit_cast<Simd>(y < x ? y : x));
  }
  friend Lanes max(Lanes a, Lanes b) {
    const auto x = std::bit_cast<Vector>(a.all_), y = std::bit_cast<Vector>(b.all_);
    return Lanes(std::bit_cast<Simd>(x < y ? y : x));
  }
  friend Lanes clamp(Lanes x, Lanes least, Lanes most) { return min(max(x, least), most); }
  friend Lanes abs(Lanes x) { return Lanes(std::experimental::abs(x.all_)); }
  friend Lanes sqrt(Lanes x) { return Lanes(std::experimental::sqrt(x.all_)); }
  friend Lanes floor(Lanes x) { return Lanes(std::experimental::floor(x.all_)); }

  // As those of elementary.h.
  friend Lanes power_of_two(Lanes k) {
    const Ints biased = std::experimental::static_simd_cast<Ints>(k.all_) + 127;
    return Lanes(std::bit_cast<Simd>(biased << 23));
  }
  friend Lanes binary_exponent(Lanes x) { return Lanes(std::experimental::logb(x.all_)); }
  friend Lanes significand(Lanes x) {
    return Lanes(std::bit_cast<Simd>((std::bit_cast<Ints>(x.all_) & 0x7fffff) | 0x3f800000));
  }

  // Calls pass() until each of the first `count` lanes has been followed to its end.
  template <class Pass>
  static void in_lanes(std::size_t count, const Pass& pass) {
    const Simd number([](auto lane) { return static_cast<float>(lane); });
    Mask wanted = number < static_cast<float>(count);
    while (any_of(wanted)) {
      followed_ = wanted;
      pass();
      wanted = wanted && !followed_;
    }
  }
  // At that end, calls work(lane) for those that are, and of which the condition holds.
  template <class Work>
  static void each_followed(const Work& work, Mask condition = Mask(true)) {
    for (Mask left = followed_ && condition; any_of(left);) {
      const auto lane = static_cast<std::size_t>(find_first_set(left));
      left[lane] = false;
      work(lane);
    }
  }
  // Whether the condition holds in all that are followed: none is left behind.
  static bool in_all_followed(Mask condition) { return none_of(followed_ && !condition); }
  static bool all_followed() { return all_of(followed_); }

 private:
  static std::size_t first() { return static_cast<std::size_t>(find_first_set(followed_)); }
  static bool follow(Mask condition) {
    const Mask yes = condition && followed_;
    if (none_of(yes)) return false;
    const Mask no = followed_ && !condition;
    if (none_of(no)) return true;
    const bool one = condition[first()];
    followed_ = one ? yes : no;
    return one;
  }

  Simd all_;
  inline static thread_local Mask followed_;
};

template <class Simd>
inline constexpr bool kSingle<Lanes<Simd>> = true;

}  // namespace metallic_paint

template <class Simd>
inline constexpr float std::numbers::pi_v<metallic_paint::Lanes<Simd>> = std::numbers::pi_v<float>;
