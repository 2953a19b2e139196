# SPDX-License-Identifier: Apache-2.0
"""The manual names all that the add-on shows, and its pictures are those of ./paint manual."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from pathlib import Path

import bpy
import metallic_paint
import numpy as np
import OpenImageIO
import pytest
from common.processes import ROOT, TOOLS
from metallic_paint.paint import PANELS, PARAMETERS, material, presets, value_of
from metallic_paint.scene import quality
from pictures import manual, manual_pictures
from pictures.manual import Strip

pytestmark = pytest.mark.long

FOLDER = ROOT / "docs" / "manual"
TEXTS = {file.stem: file.read_text(encoding="utf-8") for file in sorted(FOLDER.glob("*.md"))}
TEXT = "\n".join(TEXTS.values())
ROWS = {cells[1]: cells[2:4] for cells in (
    [cell.strip() for cell in line.split("|")]
    for line in TEXTS["parameters"].splitlines() if line[:2] == "| "
)}  # fmt: skip
RANGE = re.compile(r"([\d.]+)°? to ([\d.]+)°?")
MOST_BYTES = 60_000
SECONDS = 60
OWN = {name: each for name, each in PARAMETERS.items() if "." not in name}
FLAKES = {name.partition(".")[2] for name in PARAMETERS} - {""}


def classes(base: type) -> list[type]:
    return [
        each for module in metallic_paint._modules() for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, base) and each.__module__ == module.__name__
        and hasattr(each, "bl_label")
    ]  # fmt: skip


# ---- The words ----


@pytest.mark.parametrize("name", OWN)
def test_every_parameter_has_a_row(name: str) -> None:
    label = OWN[name].label
    assert label in ROWS
    usual, description = ROWS[label]
    assert usual
    assert len(description) > 10
    for number, word in enumerate(OWN[name].choices):
        assert f"{number} {word}" in TEXT, f"the choice {word} of {label}"


@pytest.mark.parametrize("name", OWN)
def test_presets_lie_in_the_usual_range(name: str) -> None:
    usual, _ = ROWS[OWN[name].label]
    if not (match := RANGE.fullmatch(usual)):
        return
    least, most = map(float, match.groups())
    if "°" in usual:
        least, most = math.radians(least), math.radians(most)
    if OWN[name].choices:
        assert (least, most) == (0, len(OWN[name].choices) - 1)
        return
    slider = OWN[name].slider
    assert OWN[name].minimum <= slider[0] <= least < most <= slider[1] <= OWN[name].maximum
    for preset in presets.names():
        paint = presets.load(preset)
        for flakes in paint.species if name in FLAKES else (paint,):
            values = np.ravel(value_of(flakes, name))
            in_use = flakes is paint or flakes.flakes_per_mm2 > 0
            assert not in_use or ((values >= least) & (values <= most)).all(), preset


def test_further_species_are_the_same_with_a_number() -> None:
    for name, parameter in PARAMETERS.items():
        if "." in name:
            label, _, number = parameter.label.rpartition(" ")
            assert label in ROWS
            assert number in ("2", "3")
    assert "with a 2 or a 3 behind each name" in TEXT


def test_every_other_socket_and_panel_of_the_node_is_named() -> None:
    items = material.node_group().interface.items_tree
    own = {parameter.label for parameter in PARAMETERS.values()}
    others = [item.name for item in items if item.name not in own]
    assert set(PANELS) < set(others)
    assert manual.BESIDE.keys() < set(others)
    for name in others:
        assert name in TEXT


def test_every_button_and_panel_is_named() -> None:
    operators, panels = classes(bpy.types.Operator), classes(bpy.types.Panel)
    assert len(operators) > 10
    assert len(panels) > 3
    for each in operators:
        assert f"**{each.bl_label}**" in TEXT
    for each in panels:
        assert each.bl_label in TEXT


def test_every_choice_of_the_panel_is_named_where_the_manual_tells_of_it() -> None:
    [sentence] = [
        line for line in TEXT.splitlines() if "the panel Metallic Paint set them by words" in line
    ]
    for name, parameter in OWN.items():
        assert (parameter.label in sentence) == bool(parameter.choices), name
    assert "of each species" in sentence


def test_buttons_of_the_quality_are_named_by_what_they_read() -> None:
    for text in map(str.title, quality.QUALITIES):
        assert f"**{text}**" in TEXT
    assert "Set Quality" not in TEXTS["trouble"]


# ---- The pictures ----


def test_the_manual_shows_every_strip() -> None:
    shown = re.findall(r"!\[[^\]]+\]\(([\w-]+)\.jpg\)", TEXT)
    assert sorted(shown) == sorted(manual.STRIPS)
    assert {file.stem for file in FOLDER.glob("*.jpg")} == set(shown)
    for name, strip in manual.STRIPS.items():
        file = FOLDER / f"{name}.jpg"
        assert file.stat().st_size < MOST_BYTES
        spec = OpenImageIO.ImageBuf(str(file)).spec()
        assert spec.height == manual_pictures.PIXELS
        assert spec.width == manual_pictures.PIXELS * len(strip.shots)


@pytest.mark.parametrize("name", manual.STRIPS)
def test_the_shots_of_a_strip_differ(name: str) -> None:
    shots = list(manual.STRIPS[name].sockets().values())
    assert len(shots) in (2, 3, 4)
    assert len({repr(shot) for shot in shots}) == len(shots)


def test_a_shot_is_its_paint(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether its values come from the object or stand in the node."""
    monkeypatch.setattr(manual_pictures, "PIXELS", 32)
    monkeypatch.setattr(manual_pictures, "SAMPLES", 4)
    first = {"coating": "gold"}
    second = {
        "coating": "colors", "flake_color": (0.2, 0.3, 0.9), "tilt": 0.3, "binder_ior": 1.3,
        "binder_absorption_per_mm": (0.0, 1.0, 20.0),
        "second": presets.Flakes(flakes_per_mm2=500.0, coating="copper"),
    }  # fmt: skip
    for near in (False, True):
        both = manual_pictures.shoot(Strip("silver-coarse", {"a": first, "b": second}, near))
        alone = manual_pictures.shoot(Strip("silver-coarse", {"b": second}, near))
        assert both.shape == (32, 64, 3)
        differ = np.abs(both[:, 32:].astype(int) - alone).max(axis=-1)
        assert np.count_nonzero(differ > 2) <= 0.01 * differ.size
        differ = np.abs(both[:, :32].astype(int) - alone).max(axis=-1)
        assert np.count_nonzero(differ > 10) > 0.1 * differ.size


def test_what_is_beside_the_paint_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first shot has none of it, though the others do."""
    monkeypatch.setattr(manual_pictures, "PIXELS", 32)
    monkeypatch.setattr(manual_pictures, "SAMPLES", 4)
    others = {label: {label: 5.0} for label in manual.BESIDE}
    plain = manual_pictures.shoot(Strip("deep-blue", {"none": {}}))
    every = manual_pictures.shoot(Strip("deep-blue", {"none": {}, **others}))
    for number, shot in enumerate(np.split(every, 1 + len(others), axis=1)):
        differ = np.abs(shot.astype(int) - plain).max(axis=-1)[:24]  # above the words
        if number == 0:
            assert np.count_nonzero(differ > 2) <= 0.01 * differ.size
        else:
            assert np.count_nonzero(differ > 10) > 0.1 * differ.size, number


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    program = [sys.executable, TOOLS, "pictures.manual"]
    command = [*program, "--out", tmp_path / "manual", "--only", "mauve"]
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, timeout=SECONDS, check=False
    )
    assert done.returncode == 1
    assert "--only mauve: no picture has that in its name; the pictures are" in done.stderr
    assert list(tmp_path.iterdir()) == []
