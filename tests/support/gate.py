# SPDX-License-Identifier: Apache-2.0
"""What of a parametrized test runs without --all."""

from __future__ import annotations

from collections.abc import Iterable

import pytest


def first_of(values: Iterable[object]) -> list[object]:
    """The first value stands for all in the gate."""
    first, *others = values
    return [first, *(pytest.param(each, marks=pytest.mark.long) for each in others)]
