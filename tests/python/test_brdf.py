# SPDX-License-Identifier: Apache-2.0
"""What ./paint measure --fit takes for measured: published fits, MERL's files, anyone's tables."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import pytest
import seeds
from measure import brdf
from measure.brdf import COLUMNS, FITS, MERL_SIDES, NAMES, BrdfError, direction
from measure.fit import lightness, rms

pytestmark = pytest.mark.long

HEAD = ",".join(COLUMNS)


def any_directions(stream: int, n: int = 200) -> tuple[np.ndarray, np.ndarray]:
    rng = seeds.fresh(stream)
    theta = np.arccos(rng.uniform(math.cos(brdf.GRAZING), 1, (2, n)))
    phi = rng.uniform(0, 2 * np.pi, (2, n))
    return direction(theta[0], phi[0]), direction(theta[1], phi[1])


@pytest.mark.parametrize("name", NAMES)
def test_facets_of_the_shifted_gamma_fits_cover_the_surface(name: str) -> None:
    # The integral of D cos is kap alpha Gamma(1 - p, alpha), one way to catch a wrong column.
    fit = {key: np.array(value) for key, value in FITS[name]["sgd"].items()}
    alpha, p = fit["alpha"], fit["p"]
    x = np.logspace(np.log10(alpha), np.log10(alpha + 60), 20001, axis=-1)
    y = np.exp(-x) * x ** -p[:, None]
    gamma = np.sum((y[:, 1:] + y[:, :-1]) * np.diff(x) / 2, axis=-1)
    np.testing.assert_allclose(fit["kap"] * alpha * gamma, 1, rtol=1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_published_fits_are_reciprocal_and_never_negative(name: str) -> None:
    light, view = any_directions(1)
    of = brdf.load(name)
    assert of.second is not None
    for value in (of.value, of.second):
        np.testing.assert_allclose(value(light, view), value(view, light), rtol=1e-9)
        assert (value(light, view) >= 0).all()


def test_two_papers_agree_on_the_paints_that_have_broad_lobes() -> None:
    # Independent fits of one measurement: a wrong formula, or a factor of pi, is 40 L* and more.
    for name in ("green-metallic-paint", "pearl-paint", "blue-metallic-paint"):
        of = brdf.load(name)
        assert of.second is not None
        first = lightness(of.value(of.light, of.view) * of.light[:, 2:])
        second = lightness(of.second(of.light, of.view) * of.light[:, 2:])
        assert rms(first - second) < 10


def merl_file(path: Path, planes: np.ndarray) -> Path:
    path.write_bytes(np.array(MERL_SIDES, "<i4").tobytes() + planes.astype("<f8").tobytes())
    return path


def test_a_merl_file_is_read_cell_by_cell(tmp_path: Path) -> None:
    planes = 1.0 + np.arange(3 * math.prod(MERL_SIDES)).reshape(3, *MERL_SIDES)
    of = brdf.load(str(merl_file(tmp_path / "mine.binary", planes)))
    rng = seeds.fresh(2)
    i, j, k = (rng.integers(0, side, 2000) for side in (60, 60, 180))
    theta_half = ((i + 0.5) / 90) ** 2 * np.pi / 2
    theta_difference = np.radians(j + 0.5)
    azimuth, turn = np.radians(k + 0.5), rng.uniform(0, 2 * np.pi, 2000)
    light, view = (
        turned(theta_half, turn, direction(theta_difference, azimuth + side))
        for side in (0, np.pi)
    )  # fmt: skip
    up = (light[:, 2] > 0) & (view[:, 2] > 0)
    assert up.sum() > 500
    expected = planes[:, i, j, k].T * np.array([1, 1.15, 1.66]) / 1500
    np.testing.assert_allclose(of.value(light, view)[up], expected[up], rtol=1e-12)


def turned(theta: np.ndarray, phi: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """From the frame whose z is the half vector of that angle and azimuth (Rusinkiewicz 1998)."""
    x, y, z = vectors.T
    x, z = x * np.cos(theta) + z * np.sin(theta), z * np.cos(theta) - x * np.sin(theta)
    return np.stack([x * np.cos(phi) - y * np.sin(phi), x * np.sin(phi) + y * np.cos(phi), z], -1)


def test_what_a_merl_file_does_not_know_is_left_out(tmp_path: Path) -> None:
    planes = np.ones((3, *MERL_SIDES))
    planes[:, :, 70:, :] = -1
    of = brdf.load(str(merl_file(tmp_path / "mine.binary", planes)))
    assert np.isfinite(of.value(of.light, of.view)).all()
    to_half = np.sum(of.light * of.view, axis=1)  # cos(2 theta_d)
    assert (to_half > math.cos(math.radians(2 * 70.001))).all()


def test_a_table_is_known_where_it_was_measured_and_turned_and_exchanged(tmp_path: Path) -> None:
    rng = seeds.fresh(3)
    angles = np.stack([rng.uniform(0, 79, 60), rng.uniform(0, 79, 60), rng.uniform(-180, 180, 60)])
    colours = rng.uniform(0, 1, (60, 3))
    path = tmp_path / "mine.csv"
    lines = [HEAD, *(",".join(map(repr, map(float, row))) for row in np.c_[angles.T, colours])]
    path.write_text("# by hand\n" + "\n".join(lines))
    of = brdf.load(str(path))
    turn = rng.uniform(0, 2 * np.pi, 60)
    theta_light, theta_view, phi = np.radians(angles)
    light, view = direction(theta_light, turn), direction(theta_view, turn + phi)
    np.testing.assert_allclose(of.value(light, view), colours, rtol=1e-6)
    np.testing.assert_allclose(of.value(view, light), colours, rtol=1e-6)
    grazing = direction(np.radians([89.0]))
    assert np.isnan(of.value(grazing, grazing)).all()


ROW = "10,20,180,0.1,0.1,0.1"


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("a.csv", "", "has no column theta_light"),
        ("a.csv", "theta_light,theta_view,phi,red,green\n", "has no column blue"),
        (
            "a.csv",
            f"{HEAD}\n{ROW}\n10,20,180,0.1,0.1\n",
            "line 3: blue is '', but must be",
        ),
        (
            "a.csv",
            f"{HEAD}\n# why\n10,95,0,1,1,1\n",
            "line 3: theta_view is 95, but must",
        ),
        ("a.csv", f"{HEAD}\n10,20,0,1,nan,1\n", "line 2: green is nan, but must be from 0"),
        ("a.csv", f"{HEAD}\n10,20,0,-1,1,1\n", "line 2: red is -1, but must be from 0"),
        ("a.csv", f"{HEAD}\n10,20,inf,1,1,1\n", "line 2: phi is inf, but must be from -360"),
        ("a.csv", f"{HEAD}\n{ROW},1\n", "line 2 has 7 fields for 6 columns"),
        ("a.csv", f"{HEAD},red\n{ROW},1\n", "has two columns red"),
        ("a.csv", f"{HEAD}\n{ROW}{'1' * 131072}\n", "line 2 is no CSV: field larger"),
        ("a.csv", "x" * 131073, "line 1 is no CSV: field larger"),
        ("a.csv", f"{HEAD}\n{ROW}\n", "has 1 rows, but a fit needs at least 30"),
        ("a.csv", f"{HEAD}\n" + "10,20,180,0,0,0\n" * 40, "is black in every row"),
        ("a.csv", f"{HEAD}\n" + "10,85,180,1,1,1\n" * 40, "0 rows of different angles up to 80°"),
        (
            "a.csv",
            f"{HEAD}\n" + f"{ROW}\n10,20,-180,1,1,1\n" * 40,
            "1 rows of different angles up to",
        ),
        ("a.binary", "short", "has 5 bytes, but a MERL file has 34992012"),
        ("a.txt", "", "a measured BRDF is a .csv or one of MERL's .binary files"),
    ],
)
def test_bad_files_are_refused_by_name(
    tmp_path: Path, name: str, text: str, complaint: str
) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(BrdfError) as refusal:
        brdf.load(str(path))
    assert str(path) in str(refusal.value)
    assert complaint in str(refusal.value)


def test_bad_merl_files_are_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "mine.binary"
    for planes, complaint in (
        (np.full((3, *MERL_SIDES), np.nan), "no numbers"),
        (np.full((3, *MERL_SIDES), 1.5e9), "values of 1000000 1/sr"),
        (np.full((3, *MERL_SIDES), -1.0), "no value above 0"),
    ):
        with pytest.raises(BrdfError, match=complaint):
            brdf.load(str(merl_file(path, planes)))
    path.write_bytes(np.array([90, 180, 90], "<i4").tobytes() + planes.tobytes())
    with pytest.raises(BrdfError, match="says that it has \\(90, 180, 90\\) cells"):
        brdf.load(str(path))


def test_an_unknown_name_is_told_those_that_are() -> None:
    with pytest.raises(BrdfError, match=r"'mauve' is neither a file nor .*green-metallic-paint"):
        brdf.load("mauve")


def test_what_is_closed_to_us_or_has_no_name_is_refused(closed: Path) -> None:
    with pytest.raises(BrdfError, match="mine cannot be read: Permission denied"):
        brdf.load(str(closed / "mine"))
    closed.chmod(0o700)
    for name in ("mine.csv", "mine.binary"):
        (closed / name).touch()
        os.truncate(closed / name, 12 + 3 * math.prod(MERL_SIDES) * 8 if "b" in name else 0)
        (closed / name).chmod(0)
        with pytest.raises(BrdfError, match=f"{name} cannot be read: Permission denied"):
            brdf.load(str(closed / name))
    with pytest.raises(BrdfError, match="cannot be read: File name too long"):
        brdf.load("x" * 300)
