# SPDX-License-Identifier: Apache-2.0
"""docs/manual/from-other-renderers.md names parameters that exist, and its numbers are right."""

from __future__ import annotations

import math
import re

import parameters
import pytest
from common.processes import ROOT

TEXT = (ROOT / "docs" / "manual" / "from-other-renderers.md").read_text(encoding="utf-8")
TABLES = [
    [[cell.strip() for cell in line.strip("|").split(" |")] for line in table.splitlines()]
    for table in re.findall(r"(?:^\|.*\n)+", TEXT, re.MULTILINE)
]
WITH_UNIT = re.compile(r" \([^)]*\)$")
LABELS = {WITH_UNIT.sub("", row.label) for row in parameters.read().all}
BESIDE = {"Model Scale", "Rest Position", "Normal", "Coat Normal", "Second Flakes", "Third Flakes"}
CELLS = [row[1] for table in TABLES if table[0][1] == "here" for row in table[2:]]


@pytest.mark.parametrize("cell", sorted(set(CELLS) - {"—"}))
def test_every_name_is_a_parameter(cell: str) -> None:
    rest = re.sub(r"\[([^]]*)\]\([^)]*\)| \([^)]*\)", r"\1", cell)
    for name in sorted(LABELS | BESIDE, key=len, reverse=True):
        rest = rest.replace(name, "")
    assert set(re.findall(r"[\w-]+", rest)) <= {"or", "a", "with", "0", "ggx"}, rest


def test_there_is_a_table_for_each_renderer() -> None:
    assert len(CELLS) > 50
    assert sum(table[0][1] == "here" for table in TABLES) == 5


def test_flakes_per_mm2_by_coverage() -> None:
    """To two digits: n = -ln(1 - C) 4/(pi d^2)."""
    [head, _, *rows] = next(table for table in TABLES if table[0][0] == "coverage")
    diameters = [float(cell.removesuffix(" µm")) / 1000 for cell in head[1:]]
    assert len(rows) > 4
    for coverage, *cells in rows:
        for d, cell in zip(diameters, cells, strict=True):
            n = -math.log(1 - float(coverage)) * 4 / (math.pi * d * d)
            assert float(cell) == pytest.approx(n, rel=0.05), (coverage, d)
