# SPDX-License-Identifier: Apache-2.0
"""./paint measure, run as a user runs it. It needs no Blender: one Python is enough."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import seeds
from common.processes import ROOT
from common.report_folder import MEASURE, REPORT, fit_folder
from measure.brdf import COLUMNS, direction
from measure.fit import radiance
from metallic_paint.paint import Paint, presets

SECONDS = 900  # the first run builds and installs

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(sys.version_info[:2] != (3, 11), reason="runs with Python 3.11"),
]


def measure(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [ROOT / "paint", "measure", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)


def test_a_report_holds_every_number_with_its_error(tmp_path: Path) -> None:
    out, file = tmp_path / "new" / "report", tmp_path / "numbers.json"
    done = measure("silver-coarse", "--quick", "--out", out, "--json", file)
    assert done.returncode == 0, done.stdout + done.stderr
    assert list(out.parent.iterdir()) == [out]
    assert sorted(path.name for path in out.iterdir()) == sorted([REPORT, *MEASURE.pictures])
    assert (out / MEASURE.pictures[0]).read_bytes().startswith(b"\x89PNG")

    text = (out / REPORT).read_text()
    assert text.startswith(MEASURE.mark)
    assert f"]({MEASURE.pictures[0]})" in text
    figures = json.loads(file.read_text())
    assert len(figures) == 6 * 3 + 1 + 3 * 2 + 1
    for figure in figures:
        assert list(figure) == ["name", "value", "unit", "error"]
        if figure["value"] is not None:
            assert figure["error"] > 0, figure
    values = {figure["name"]: figure["value"] for figure in figures}
    assert 10 < values["flop index"] < 17
    assert values["L* at 15°"] > values["L* at 45°"] > values["L* at 110°"]
    printed = re.search(r"Flop index: (\S+) ± (\S+)", done.stdout)
    assert printed is not None
    assert float(printed[1]) == pytest.approx(values["flop index"], abs=float(printed[2]))
    assert str(out / REPORT) in done.stdout


def test_an_unknown_preset_is_named_and_nothing_is_written(tmp_path: Path) -> None:
    done = measure("mauve", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "'mauve' is neither a file nor a preset" in done.stderr
    assert "silver-fine" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_paint_that_the_references_cannot_trace_is_a_sentence(tmp_path: Path) -> None:
    dense = tmp_path / "dense.json"
    paint = {"flakes_per_mm2": 1e9, "flake_diameter_um": 1e3}
    dense.write_text(json.dumps({"schema_version": 1, "paint": paint}))
    done = measure(dense, "--quick", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "number of flakes" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [dense]


def test_what_cannot_be_written_is_said_before_measuring(tmp_path: Path) -> None:
    file, folder = tmp_path / "file", tmp_path / "folder"
    file.write_text("mine")
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    for arguments in (
        ["--out", file],
        ["--out", folder],
        ["--out", tmp_path / "a", "--json", file / "numbers.json"],
        ["--out", tmp_path / "a", "--json", tmp_path],
        ["--out", folder, "--fit", "pearl-paint"],
    ):
        of = [] if "--fit" in arguments else ["gold"]
        done = measure(*of, "--quick", *arguments)
        assert done.returncode == 1
        assert "Traceback" not in done.stderr
        assert not done.stdout
    assert sorted(tmp_path.iterdir()) == [file, folder]
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]


def table_of(paint: Paint, path: Path) -> None:
    """What a gonioreflectometer would find of the paint."""
    angles = np.array([
        (light, view, phi) for view in (10, 30, 50, 70) for light in (2, 10, 20, 30, 40, 50, 60, 72)
        for phi in (0, 120, 165, 180)
    ])  # fmt: skip
    theta_light, theta_view, phi = np.radians(angles).T
    light, view = direction(theta_light), direction(theta_view, phi)
    brdf = radiance(paint, light, view) / light[:, 2:]
    rows = (",".join(f"{x:.9g}" for x in row) for row in np.c_[angles, brdf])
    path.write_text("\n".join([",".join(COLUMNS), *rows]))


def test_a_paint_is_found_again_from_its_brdf(tmp_path: Path) -> None:
    rng = seeds.fresh(11)

    def colour(low: float, high: float) -> tuple[float, ...]:
        return tuple(map(float, rng.uniform(low, high, 3)))

    paint = Paint(
        flakes_per_mm2=rng.uniform(800, 4000), tilt=rng.uniform(0.08, 0.25),
        coat_roughness=rng.uniform(0.2, 0.5), binder_ior=rng.uniform(1.4, 1.7),
        flake_color=colour(0.4, 0.9), layer_thickness_um=rng.uniform(15, 60),
        binder_absorption_per_mm=colour(0, 30), substrate_color=colour(0.01, 0.3),
    )  # fmt: skip
    table_of(paint, tmp_path / "mine.csv")
    out, file = tmp_path / "out", tmp_path / "numbers.json"
    done = measure("--fit", tmp_path / "mine.csv", "--quick", "--out", out, "--json", file)
    assert done.returncode == 0, done.stdout + done.stderr
    kind = fit_folder("mine")
    assert sorted(path.name for path in out.iterdir()) == sorted([REPORT, *kind.pictures])
    assert (out / REPORT).read_text().startswith(kind.mark)

    found = presets.load(out / "mine.json")
    figures = {figure["name"]: figure["value"] for figure in json.loads(file.read_text())}
    # Of six paints: 0.2 to 0.3 steps of L*; tilt, roughness and index within 1.5 %.
    assert figures["RMS error"] < 1, paint
    # Beckmann's law, exp(-tan^2/alpha^2)/cos^4, falls as Gauss's does at small tilts, with
    # 1/(2 sigma^2) = 1/alpha^2 - 2.
    gaussian = found.tilt
    if found.orientation == "beckmann":
        gaussian = 1 / math.sqrt(2 * (found.tilt**-2 - 2))
    assert gaussian == pytest.approx(paint.tilt, rel=0.05), paint
    assert found.coat_roughness == pytest.approx(paint.coat_roughness, rel=0.05), paint
    assert found.binder_ior == pytest.approx(paint.binder_ior, abs=0.05), paint


def test_a_fit_of_what_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    for arguments, complaint in (
        (["--fit", "mauve"], "'mauve' is neither a file nor a measured paint"),
        (["--fit", "pearl-paint", "--diameter", "0"], "--diameter is 0, but must be from 1"),
    ):
        done = measure(*arguments, "--quick", "--out", tmp_path / "out")
        assert done.returncode == 1
        assert complaint in done.stderr
        assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
