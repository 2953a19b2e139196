// SPDX-License-Identifier: Apache-2.0
//
// Many pixels at once, over all cores: what the bindings and the verification call.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

#include "paint.h"

namespace metallic_paint {

// Calls work(i) for i in [0, count) on all cores, in blocks. work must not throw.
template <class Work>
void parallel_for(std::size_t count, const Work& work) {
  constexpr std::size_t kBlock = 1024;
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  const std::size_t workers = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1,
                                                      std::max<std::size_t>(blocks, 1));
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    for (std::size_t block = next++; block < blocks; block = next++) {
      const std::size_t end = std::min(count, (block + 1) * kBlock);
      for (std::size_t i = block * kBlock; i < end; ++i) work(i);
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t i = 1; i < workers; ++i) threads.emplace_back(run);
  run();
}

inline constexpr int kLightSlots = 8;

// What the shader finds for all light slots at one point. Lights too close together to be told
// apart share the cone of the first of them, the leader; a leader leads itself, an unseen light
// leads nothing (-1).
template <class T>
struct SlotView {
  std::array<SeenLight<T>, kLightSlots> seen;
  std::array<int, kLightSlots> leader;
};

template <class T>
SlotView<T> view_slots(const std::vector<Light<T>>& lights, const SurfacePoint<T>& point) {
  SlotView<T> slots;
  slots.leader.fill(-1);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    slots.seen[i] = see_light(lights[i], point.position);
    if (!slots.seen[i].visible || !(dot(point.normal, slots.seen[i].direction) > 0)) continue;
    slots.leader[i] = static_cast<int>(i);
    for (std::size_t j = 0; j < i; ++j) {
      if (slots.leader[j] == static_cast<int>(j) && lights_overlap(slots.seen[i], slots.seen[j])) {
        slots.leader[i] = static_cast<int>(j);
        break;
      }
    }
  }
  return slots;
}

}  // namespace metallic_paint
