# SPDX-License-Identifier: Apache-2.0
"""./paint gallery: its index and pictures come whole or not at all."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO
import pytest
from common.processes import ROOT, TOOLS
from common.report_folder import GALLERY
from metallic_paint.paint import presets
from pictures import car_body, car_cabin, gallery

pytestmark = pytest.mark.long

SECONDS = 120  # a gallery of one swatch that takes longer hangs


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, TOOLS, "pictures.gallery", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)


def test_a_part_of_it_is_a_whole_folder(tmp_path: Path) -> None:
    out = tmp_path / "out" / "gallery"
    done = run("--out", out, "--quick", "--only", "silver-fine")
    assert done.returncode == 0, done.stderr
    assert "swatches (1 of 1)" in done.stdout
    assert sorted(p.name for p in out.iterdir()) == ["README.md", "swatches.jpg"]
    assert list(out.parent.iterdir()) == [out]

    index = (out / "README.md").read_text()
    assert index.startswith(GALLERY.mark)
    assert "(swatches.jpg)" in index
    assert "| silver-fine | Silver, fine aluminium" in index

    image = OpenImageIO.ImageBuf(str(out / "swatches.jpg")).get_pixels(OpenImageIO.FLOAT)
    assert image.shape == (105, 140, 3)
    panel, board = image[15:70, 10:66], image[80:90, :]
    assert panel.mean() > 1.2 * board.mean()  # silver on dark grey


def test_what_is_not_there_is_said(tmp_path: Path) -> None:
    done = run("--out", tmp_path / "gallery", "--only", "mauve")
    assert done.returncode == 1
    assert "--only mauve: no picture or preset has that in its name; " in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_with_other_things_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("mine")
    done = run("--out", tmp_path, "--quick", "--only", "silver-fine")
    assert done.returncode == 1
    assert "letter.txt, which ./paint gallery did not make" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["letter.txt"]


def test_only_chooses_pictures_before_presets() -> None:
    assert set(gallery.chosen("")) == set(gallery.CAPTIONS)
    assert set(gallery.chosen("car-s")) == {"car-sun", "car-sky", "car-surroundings", "car-studio"}
    assert gallery.chosen("silver") == {"swatches": [n for n in presets.names() if "silver" in n]}


def test_the_folder_owns_the_pictures_that_have_captions() -> None:
    assert [gallery.file_of(name) for name in gallery.CAPTIONS] == list(GALLERY.pictures)


def test_the_committed_gallery_shows_every_preset() -> None:
    folder = ROOT / "docs" / "gallery"
    index = (folder / "README.md").read_text(encoding="utf-8")
    assert index.startswith(GALLERY.mark)
    for name in presets.names():
        assert f"| {name} | " in index
    for picture in GALLERY.pictures:
        assert f"({picture})" in index
        film = picture.endswith(".webp")
        assert (folder / picture).stat().st_size < (2_000_000 if film else 500_000)
        assert OpenImageIO.ImageBuf(str(folder / picture)).spec().width >= (400 if film else 800)


def test_the_cabin_of_the_car_lies_within_its_body() -> None:
    """What stands out of it would hang in the air beside the bonnet."""
    car_cabin.build(bpy.context.scene)
    for thing in bpy.context.scene.objects:
        places = np.array([vertex.co for vertex in thing.data.vertices])
        assert car_body.shell(*places.T).max() < 0, thing.name
