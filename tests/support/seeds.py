# SPDX-License-Identifier: Apache-2.0
"""Random draws that are others in each run; METALLIC_PAINT_TEST_SEED repeats those of one."""

from __future__ import annotations

import os
import secrets

import numpy as np

# Workers of pytest inherit it.
SEED = int(os.environ.setdefault("METALLIC_PAINT_TEST_SEED", str(secrets.randbits(32))))


def fresh(stream: int) -> np.random.Generator:
    """A test's own stream; the seed is among what pytest shows of a failed test."""
    print(f"METALLIC_PAINT_TEST_SEED={SEED} repeats this run")
    return np.random.default_rng([SEED, stream])
