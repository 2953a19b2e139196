# SPDX-License-Identifier: Apache-2.0
"""docs/model names functions that exist, in the header of core/ and in that of osl/."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "model" / "README.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\|.*\| (?:(core|osl): )?`([\w.]+)` \| `(\w+)` \|$", re.MULTILINE)
ROWS = [(room, *where) for only, *where in ROW.findall(PAGE)
        for room in ([only] if only else ["core", "osl"])]  # fmt: skip


def defines(text: str, function: str) -> bool:
    """Whether C++ or OSL defines it: a type, the name, its parameters, a body."""
    return bool(re.search(rf"^[\w:<>]+(?: \w+)? {function}\([^;{{]*\)\s*\{{", text, re.MULTILINE))


def test_each_row_of_the_formulas_is_read() -> None:
    formulas = PAGE.split("## Formulas")[1]
    rows = [line for line in formulas.splitlines() if line.startswith("| ")][2:]
    assert len(rows) == len(ROW.findall(PAGE)) > 30


@pytest.mark.parametrize(("room", "header", "function"), ROWS)
def test_the_function_stands_where_the_page_says(room: str, header: str, function: str) -> None:
    assert defines((ROOT / room / header).read_text(encoding="utf-8"), function)


def test_a_missing_function_is_found_out() -> None:
    assert not defines("color slant_depth(color a);\n  x = blocked_area(y);\n", "slant_depth")
    assert not defines("color slant_depth(color a);\n  x = blocked_area(y);\n", "blocked_area")
