// SPDX-License-Identifier: Apache-2.0
//
// The light slots as seen from one point.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "light.h"
#include "passage.h"
#include "vector.h"

namespace metallic_paint {

// What the shader finds for all light slots at one point. leader: see share_cones; -1 for a light
// that is unused, below the horizon, or has melted. At most kLightSlots lights.
template <class T>
struct SlotView {
  std::array<SeenLight<T>, kLightSlots> seen;
  std::array<int, kLightSlots> leader;
};

// turned: by the paint's flakes (expected_sparkles.h).
template <class T>
SlotView<T> view_slots(const std::vector<Light<T>>& lights, const SurfacePoint<T>& point,
                       T turned) {
  SlotView<T> slots;
  const int count = min(static_cast<int>(lights.size()), kLightSlots);
  slots.leader.fill(-1);
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    slots.seen[at] = see_light(lights[at], point.position);
    if (slots.seen[at].visible && dot(Vec3<Wide<T>>(point.normal), slots.seen[at].direction) > 0) {
      slots.leader[at] = i;
    }
  }
  share_cones(slots.seen.data(), slots.leader.data(), count, turned);
  return slots;
}

}  // namespace metallic_paint
