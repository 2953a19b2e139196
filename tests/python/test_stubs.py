# SPDX-License-Identifier: Apache-2.0
"""The stubs give each function the names, kinds and defaults of arguments that the module has."""

from __future__ import annotations

import ast
from pathlib import Path

import metallic_paint_core as core
import pytest

STUBS = ast.parse((Path(core.__file__).parent / "_native.pyi").read_text())
STUBBED = {node.name: node for node in STUBS.body if isinstance(node, ast.FunctionDef)}
FUNCTIONS = [
    name
    for name in core.__all__
    if callable(getattr(core, name)) and not isinstance(getattr(core, name), type)
]


def arguments(function: ast.FunctionDef) -> list[tuple[str, bool, object]]:
    """Name, whether by keyword only, and default of each."""
    given = function.args
    plain = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(plain) - len(given.defaults)) + list(given.defaults)
    both = [(arg, False, value) for arg, value in zip(plain, defaults, strict=True)]
    both += [(arg, True, v) for arg, v in zip(given.kwonlyargs, given.kw_defaults, strict=True)]
    return [(a.arg, only, "none" if v is None else ast.literal_eval(v)) for a, only, v in both]


def test_every_function_has_a_stub_and_every_stub_a_function() -> None:
    assert set(STUBBED) == set(FUNCTIONS)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_stub_has_the_arguments_of_its_function(name: str) -> None:
    # pybind11 writes the signature that it checks calls against into the first line.
    signature = (getattr(core, name).__doc__ or "").splitlines()[0]
    [function] = ast.parse(f"def {signature}: ...").body
    assert isinstance(function, ast.FunctionDef)
    assert arguments(STUBBED[name]) == arguments(function)
