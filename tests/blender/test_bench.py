# SPDX-License-Identifier: Apache-2.0
"""./paint bench: the contenders are what they say, and the report is whole."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import bpy
import pytest
from bench import materials, shared
from bench.growth import mean_count_per_area
from bench.paints import of_flakes
from bench.stage import Stage
from common import bars
from common.processes import ROOT
from common.report_folder import BENCH, REPORT
from metallic_paint.paint import Paint, material, presets
from verification import scenes

pytestmark = pytest.mark.long

SECONDS = 1800  # a quick run that takes longer hangs


def test_every_contender_shows_the_sun() -> None:
    """A shader that does not compile renders black, without an error."""
    stage = Stage([scenes.SUN])
    paint = Paint()
    made = {
        "the paint": material.create(paint), "Principled": materials.principled(),
        "Voronoi flakes": materials.coated_voronoi(paint),
        "noise flakes": materials.noise_flakes(paint),
    }  # fmt: skip
    for name, each in made.items():
        stage.add(name, [each], 16)
    stage.add("Principled without OSL", [made["Principled"]], 16, osl=False)
    stage.fit()
    means = {name: stage.picture(name, 16).mean() for name in stage.views}
    assert all(mean > 0.01 for mean in means.values()), means
    # The same material, by another way to compute it.
    assert means["Principled without OSL"] == pytest.approx(means["Principled"], rel=1e-3)


def test_one_material_shows_each_object_its_own_paint() -> None:
    stage = Stage([scenes.SUN])
    made = shared.linked_paint()
    for name in ("candy-red", "lime"):
        stage.add(name, [made], 16)
        shared.give(bpy.data.objects[name], shared.sockets_of(presets.load(name)))
    stage.fit()
    red, green, _ = stage.picture("candy-red", 16).mean(axis=(0, 1))
    assert red > green > 0
    red, green, _ = stage.picture("lime", 16).mean(axis=(0, 1))
    assert green > red > 0


def test_more_flakes_of_the_same_coverage_sparkle_as_many_times() -> None:
    """So that pixels which shrink alike have equal ⟨N⟩."""
    stage = Stage([scenes.SUN])
    few, many = (mean_count_per_area(of_flakes(number), stage) for number in (1e3, 1e15))
    assert few > 0
    assert many / few == pytest.approx(1e12, rel=1e-3)


def test_a_report_holds_every_part_and_its_bars(tmp_path: Path) -> None:
    out, file = tmp_path / "new" / "bench", tmp_path / "bars.json"
    command = [ROOT / "paint", "bench", "--quick", "--out", out, "--json", file]
    done = subprocess.run(
        list(map(str, command)), capture_output=True, text=True, timeout=SECONDS, check=False
    )
    assert done.returncode in (0, 1), done.stdout + done.stderr  # 1: a rough value misses its bar
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bars.json", "new"]
    assert list(out.parent.iterdir()) == [out]
    assert sorted(path.name for path in out.iterdir()) == sorted([REPORT, *BENCH.pictures])
    text = (out / REPORT).read_text(encoding="utf-8")
    assert text.startswith(BENCH.mark)
    for picture in BENCH.pictures:
        assert f"]({picture})" in text
    found = [bars.Bar(**bar) for bar in json.loads(file.read_text())]
    assert len({bar.name for bar in found}) == len(found)
    assert all(bar.value is not None for bar in found)
    assert (done.returncode == 0) == all(bar.holds for bar in found)


def test_the_committed_report_is_one_of_the_commands() -> None:
    folder = ROOT / "docs" / "bench"
    text = (folder / REPORT).read_text(encoding="utf-8")
    assert text.startswith(BENCH.mark)
    for picture in BENCH.pictures:
        assert f"]({picture})" in text
        assert (folder / picture).stat().st_size < 500_000
