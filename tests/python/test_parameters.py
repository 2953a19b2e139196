# SPDX-License-Identifier: Apache-2.0
"""parameters.toml is the one place for each parameter: what is made of it is fresh and whole."""

from __future__ import annotations

import re
from pathlib import Path

import parameters
import pytest

TABLE = parameters.read()


@pytest.mark.parametrize("path", parameters.made(TABLE))
def test_what_is_made_of_the_table_is_fresh(path: str) -> None:
    text = (parameters.ROOT / path).read_text(encoding="utf-8")
    assert text == parameters.made(TABLE)[path], "run python3 tools/parameters.py"


@pytest.mark.parametrize("row", TABLE.all, ids=lambda row: row.name)
def test_a_parameter_is_told_whole(row: parameters.Parameter) -> None:
    assert row.tooltip
    assert not row.tooltip.endswith(".")
    assert row.manual
    assert row.usual
    if row.choices:
        assert row.default in row.choices
        return
    least, most = row.range
    for number in row.default if row.is_triple else [row.default]:
        assert least <= number <= most
    if row.useful:
        assert least <= row.useful[0] < row.useful[1] <= most


def functions(folder: str) -> set[str]:
    texts = [file.read_text(encoding="utf-8") for file in (parameters.ROOT / folder).glob("*.h")]
    return {
        name for text in texts for name in re.findall(r"^[\w<>: ]+ (\w+)\(", text, re.MULTILINE)
    }


@pytest.mark.parametrize("row", TABLE.all, ids=lambda row: row.name)
def test_the_functions_that_a_parameter_acts_in_are_there(row: parameters.Parameter) -> None:
    assert row.functions
    for function in row.functions:
        assert function in functions("osl") | functions("core"), function


def test_an_unknown_column_is_named(tmp_path: Path) -> None:
    file = tmp_path / "parameters.toml"
    text = (parameters.ROOT / parameters.TABLE).read_text(encoding="utf-8")
    file.write_text(text.replace("[paint.seed]\n", '[paint.seed]\ncolour = "red"\n'))
    with pytest.raises(parameters.TableError, match=r"^parameters\.toml: seed: .*'colour'"):
        parameters.read(file)
