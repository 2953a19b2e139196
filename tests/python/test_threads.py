# SPDX-License-Identifier: Apache-2.0
"""While the core works on arrays, other threads of Python do."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable

import metallic_paint_core as core
import numpy as np
import pytest

N = 1 << 15
UNIFORM = np.linspace(0.01, 1, N)
SLOTS, INDICES = np.full(N, 16.0), np.full(N, 1.5)
WHOLE = np.arange(N, dtype=np.int32)
GOLD = np.full(N, int(core.CoatingKind.gold), np.int32)
UP = np.tile([0.0, 0.0, 1.0], (N, 1))
PAINT = core.Paint()

# All arrays as the core reads them: where numpy converts one, it lets go of the lock itself.
CALLS: list[Callable[[], object]] = [
    lambda: core.white_noise(UP, UNIFORM),
    lambda: core.count_deviate(UNIFORM, SLOTS, UNIFORM),
    lambda: core.normal_quantile(UNIFORM),
    lambda: core.fresnel_transmittance(UNIFORM, INDICES),
    lambda: core.orientation_density(PAINT, UNIFORM),
    lambda: core.mean_projected_area(PAINT, UNIFORM),
    lambda: core.flake_brdf(PAINT, UP, UP, UP),
    lambda: core.library_coating(GOLD, UNIFORM, UNIFORM),
    lambda: core.pixel_texture(0.1, UNIFORM, WHOLE, WHOLE),
    lambda: core.mixture(PAINT, (0.8, 0.8, 0.8), UNIFORM[:1000]),
]


@pytest.mark.parametrize("call", CALLS)
def test_another_thread_runs_meanwhile(call: Callable[[], object]) -> None:
    go, ran = threading.Event(), threading.Event()
    other = threading.Thread(target=lambda: (go.wait(), ran.set()))
    other.start()
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e6)  # s: from here on no thread has to hand over the lock
    try:
        go.set()
        for _ in range(100):  # on a busy machine the other one may be late
            call()
            if ran.is_set():
                break
        meanwhile = ran.is_set()
    finally:
        sys.setswitchinterval(interval)
        other.join()
    assert meanwhile
