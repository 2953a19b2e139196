# SPDX-License-Identifier: Apache-2.0
"""./paint bench cuts parts from the shader: the cuts still fit its text, which compiles."""

from __future__ import annotations

import pytest
from bench import absent_parts

pytestmark = pytest.mark.long

CUTS = {**absent_parts.cuts(), **absent_parts.PRESENT}


@pytest.mark.parametrize("name", [name for name, edit in CUTS.items() if edit is not str])
def test_a_shader_without_the_part_compiles(name: str) -> None:
    absent_parts.painted(CUTS[name])
