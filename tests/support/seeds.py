# SPDX-License-Identifier: Apache-2.0
"""Random draws: the same in each run, or those of METALLIC_PAINT_TEST_SEED, as --all has them."""

from __future__ import annotations

import os

import numpy as np

SEED = int(os.environ.get("METALLIC_PAINT_TEST_SEED", "0"))


def fresh(stream: int) -> np.random.Generator:
    """A test's own stream; the seed is among what pytest shows of a failed test."""
    print(f"METALLIC_PAINT_TEST_SEED={SEED} repeats this run")
    return np.random.default_rng([SEED, stream])
