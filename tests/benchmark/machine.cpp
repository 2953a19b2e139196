// SPDX-License-Identifier: Apache-2.0
//
// The limits of this machine, beside which the core's speed stands. Compiled for this processor, as
// the core is not.
#include "machine.h"

#include <cstring>

namespace machine {

#if defined(__AVX512F__)
constexpr int kBytes = 64;
#elif defined(__AVX__)
constexpr int kBytes = 32;
#else
constexpr int kBytes = 16;
#endif
using Vector [[gnu::vector_size(kBytes)]] = float;
constexpr int kLanes = kBytes / static_cast<int>(sizeof(float));
constexpr int kChains = 12;  // more than latency times ports, and no more than the registers hold

double multiply_and_add(int rounds, float factor, float summand) {
  Vector chain[kChains];
  for (int i = 0; i < kChains; ++i) chain[i] = Vector{} + static_cast<float>(i);
  for (int round = 0; round < rounds; ++round) {
    for (Vector& each : chain) each = each * factor + summand;
  }
  float sum = 0;
  for (const Vector& each : chain) {
    for (int lane = 0; lane < kLanes; ++lane) sum += each[lane];
  }
  return static_cast<double>(sum);
}

double operations(int rounds) { return 2.0 * kLanes * kChains * rounds; }

void copy(std::vector<char>& to, const std::vector<char>& from) {
  std::memcpy(to.data(), from.data(), from.size());
}

}  // namespace machine
