# SPDX-License-Identifier: Apache-2.0
"""The shader's benchmark is run by hand: its cuts still fit the shader's text, and compile."""

from __future__ import annotations

import pytest
import shader_parts

CUTS = {**shader_parts.cuts(), "mixture": shader_parts.only_the_substrate}


@pytest.mark.parametrize("name", [name for name, edit in CUTS.items() if edit is not str])
def test_a_shader_without_the_part_compiles(name: str) -> None:
    bench = shader_parts.Bench(8, lit=not shader_parts.is_unlit(name))
    bench.painted(CUTS[name])
