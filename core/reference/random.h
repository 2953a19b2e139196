// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace metallic_paint::reference {

// SplitMix64 (Steele, Lea and Flood 2014, Fast splittable pseudorandom number generators).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : state_(seed) {}

  // In (0, 1), 52 bits: odd multiples of 2^-53.
  double operator()() { return (static_cast<double>(next() >> 12) + 0.5) * 0x1p-52; }

  // Another stream for each key; hashed, so that neither neighbouring keys nor keys of keys meet.
  RandomStream substream(std::uint64_t key) const {
    return RandomStream(mixed(RandomStream(*this).next() + key));
  }

 private:
  std::uint64_t next() { return mixed(state_ += 0x9e3779b97f4a7c15u); }  // 2^64/phi, odd

  static std::uint64_t mixed(std::uint64_t word) {
    word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
    word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
    return word ^ (word >> 31);
  }

  std::uint64_t state_;
};

}  // namespace metallic_paint::reference
