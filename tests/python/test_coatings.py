# SPDX-License-Identifier: Apache-2.0
"""Thin films against closed forms and another program; colours; the library."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import metallic_paint_core as core
import numpy as np
import pytest
import seeds
from coatings import table as coatings
from coatings.colorimetry import WAVELENGTHS, linear_srgb
from coatings.thin_film import reflect_and_transmit
from common.processes import ROOT, TOOLS

pytestmark = pytest.mark.long

ROUNDING = 1e-10  # far above double's rounding in a few products of matrices
COSINES = np.linspace(0, 1, 65)
METALS = [name for name in coatings.PLATELETS if "nk" in coatings.MATERIALS[name]]
OPAQUE_NM = 1500


def airy(
    n: complex, thickness: float, medium: float, wavelength: float, cosine: float
) -> tuple[float, float]:
    """One film: the sum over all its inner reflections (M. Born and E. Wolf, section 7.6)."""
    inside = np.sqrt(1 - (medium / n) ** 2 * (1 - cosine**2) + 0j)
    amplitudes = [
        (medium * cosine - n * inside) / (medium * cosine + n * inside),
        (n * cosine - medium * inside) / (n * cosine + medium * inside),
    ]
    passage = np.exp(2j * np.pi * n * thickness * inside / wavelength)
    reflected = transmitted = 0.0
    for r in amplitudes:
        rest = 1 - r**2 * passage**2
        reflected += abs(r * (1 - passage**2) / rest) ** 2 / 2
        transmitted += abs((1 - r**2) * passage / rest) ** 2 / 2
    return reflected, transmitted


def random_films(rng: np.random.Generator, count: int, absorbing: bool) -> list[tuple]:
    n = rng.uniform(0.1, 4, count) + 1j * absorbing * rng.uniform(0, 6, count)
    return list(zip(n, rng.uniform(0, 300, count), strict=True))


def test_a_single_film_is_airys() -> None:
    rng = seeds.fresh(1)
    for i in range(300):
        [(n, thickness)] = random_films(rng, 1, absorbing=i % 2 == 0)
        medium, wavelength, cosine = rng.uniform(1, 2), rng.uniform(380, 780), rng.uniform(0.01, 1)
        ours = reflect_and_transmit([(n, thickness)], medium, [wavelength], [cosine])
        expected = airy(n, thickness, medium, wavelength, cosine)
        np.testing.assert_allclose(np.ravel(ours), expected, rtol=ROUNDING, atol=ROUNDING)


@pytest.mark.parametrize(
    ("medium", "films", "wavelength", "angle", "expected"),
    [  # by tmm 0.2.0 (S. J. Byrnes), coh_tmm, mean of both polarisations
        (1.5, [(2.5, 60), (1.6, 500), (2.5, 60)], 550, 0.5,
         (0.5087326832936117, 0.491267316706388)),
        (1.5, [(3.3 + 0.5j, 40), (1.6, 400), (3.3 + 0.5j, 40)], 500, 1.0,
         (0.43961702638617367, 0.1531161892703299)),
        (1.52, [(0.05 + 3.5j, 30)], 560, 0.3, (0.7848837662339772, 0.18942511147807173)),
        (1.0, [(1 + 6.5j, 5), (1.46, 120), (2.4, 70)], 620, 1.4,
         (0.5157293770494946, 0.36698326890609007)),
    ],
)  # fmt: skip
def test_stacks_are_another_programs(
    medium: float, films: list, wavelength: float, angle: float, expected: tuple[float, float]
) -> None:
    ours = reflect_and_transmit(films, medium, [wavelength], [np.cos(angle)])
    np.testing.assert_allclose(np.ravel(ours), expected, rtol=ROUNDING)


@pytest.mark.parametrize(("n", "thickness"), [(2.5 + 1j, 0.0), (1.5, 700.0)])
def test_no_film_and_a_film_of_binder_are_invisible(n: complex, thickness: float) -> None:
    r, t = reflect_and_transmit([(n, thickness)], 1.5, WAVELENGTHS, COSINES)
    np.testing.assert_allclose(r, 0, atol=ROUNDING)
    np.testing.assert_allclose(t, 1, atol=ROUNDING)


@pytest.mark.parametrize("waves", [0.25, 0.5, 0.75, 1.0])
def test_quarter_waves_reflect_most_and_half_waves_nothing(waves: float) -> None:
    medium, n = 1.5, 2.4
    r, _ = reflect_and_transmit([(n, waves * 550 / n)], medium, [550.0], [1.0])
    most = ((medium**2 - n**2) / (medium**2 + n**2)) ** 2
    np.testing.assert_allclose(r, most if waves % 0.5 else 0, atol=ROUNDING)


def test_energy_is_kept_by_clear_films_and_lost_by_absorbing_ones() -> None:
    rng = seeds.fresh(2)
    for i in range(60):
        absorbing = i % 2 == 0
        films = random_films(rng, 4, absorbing)
        r, t = reflect_and_transmit(films, 1.5, WAVELENGTHS, COSINES)
        assert (r >= 0).all()
        assert (t >= 0).all()
        if absorbing:
            assert (r + t <= 1 + ROUNDING).all()
            assert (r + t < 1)[:, 1:].all()
        else:
            # Evanescent waves in several films let the matrices cancel.
            np.testing.assert_allclose(r + t, 1, atol=1e-8)


def test_light_passes_a_stack_alike_both_ways() -> None:
    rng = seeds.fresh(3)
    for absorbing in (False, True) * 10:
        films = random_films(rng, 4, absorbing)
        r, t = reflect_and_transmit(films, 1.5, WAVELENGTHS, COSINES)
        r_back, t_back = reflect_and_transmit(films[::-1], 1.5, WAVELENGTHS, COSINES)
        np.testing.assert_allclose(t_back, t, rtol=1e-8, atol=ROUNDING)
        if not absorbing:
            np.testing.assert_allclose(r_back, r, atol=1e-8)


def test_everything_is_finite_at_the_critical_angle_and_the_greatest_thickness() -> None:
    metal = coatings.index("aluminium")
    for films in ([(1.2, 200.0)], [(1.2, 1e6)], [(metal, 1e6)], [(100j, 1e6), (2.5, 1e6)] * 5):
        for cosine in (0.6, 0.0, 1.0):  # 1.5 · 0.8 = 1.2: the wave runs along the film
            r, t = reflect_and_transmit(films, 1.5, WAVELENGTHS, [cosine])
            assert np.isfinite(r).all()
            assert np.isfinite(t).all()
            assert (r + t <= 1 + ROUNDING).all()


def test_a_thick_metal_is_a_mirror_of_fresnel() -> None:
    for name in METALS:
        n = coatings.index(name)
        r, t = reflect_and_transmit([(n, OPAQUE_NM)], 1.5, WAVELENGTHS, [1.0])
        np.testing.assert_allclose(r[:, 0], np.abs((1.5 - n) / (1.5 + n)) ** 2, atol=ROUNDING)
        assert t.max() < ROUNDING


@pytest.mark.parametrize(
    ("name", "expected"),
    [  # at 450, 550, 650 nm in air, from n and k of other measurements than ours
        ("aluminium", (0.922, 0.916, 0.904)),  # K. M. McPeak et al., ACS Photonics 2 (2015)
        ("silver", (0.975, 0.985, 0.990)),  # S. Babar, J. H. Weaver, Appl. Opt. 54 (2015); also:
        ("gold", (0.363, 0.842, 0.967)),
        ("copper", (0.541, 0.656, 0.977)),
    ],
)
def test_metals_reflect_as_others_measured(name: str, expected: tuple[float, ...]) -> None:
    r, _ = reflect_and_transmit([(coatings.index(name), OPAQUE_NM)], 1.0, WAVELENGTHS, [1.0])
    ours = np.interp((450, 550, 650), WAVELENGTHS, r[:, 0])
    # Films of gold and copper differ by 0.05 from author to author, and the metals by more.
    np.testing.assert_allclose(ours, expected, atol=0.01 if name in METALS[:2] else 0.055)


def test_white_is_white_and_luminance_is_the_observers() -> None:
    np.testing.assert_allclose(linear_srgb(np.ones(len(WAVELENGTHS))), 1, rtol=1e-12)
    rows = json.loads((Path(coatings.__file__).parent / "data" / "observer.json").read_text())[
        "rows"
    ]
    _, _, y, _, d65 = np.array(rows).T
    spectra = seeds.fresh(4).uniform(0, 1, (len(WAVELENGTHS), 50))
    luminance = (y * d65) @ spectra / (y * d65).sum()
    # IEC 61966-2-1 gives its weights to four digits.
    np.testing.assert_allclose(
        linear_srgb(spectra) @ (0.2126, 0.7152, 0.0722), luminance, atol=2e-4
    )


def test_the_spread_of_the_platelets_is_an_average_over_a_gaussian() -> None:
    cosine = [0.3, 1.0]
    for mean, spread in ((500.0, 100.0), (300.0, 20.0), (1200.0, 300.0)):
        ours = coatings.spectra(coatings.Flake("mica", mean, spread, "tio2", 60), 1.5, cosine)
        nodes = np.linspace(mean - 4 * spread, mean + 4 * spread, 1601)
        weights = np.exp(-(((nodes - mean) / spread) ** 2) / 2)
        outer = (coatings.index("tio2"), 60)
        film = coatings.index("mica")
        each = [
            reflect_and_transmit([outer, (film, nm), outer], 1.5, WAVELENGTHS, cosine)
            for nm in nodes
        ]
        expected = np.tensordot(weights / weights.sum(), np.array(each), axes=(0, 0))
        np.testing.assert_allclose(ours, expected, atol=5e-5)  # half a table's digit


@pytest.mark.parametrize(
    ("coating_nm", "order"),
    [  # channels from the strongest to the weakest; the trade's series of TiO2 on mica
        (80, "RGB"),  # gold
        (100, "RBG"),  # red
        (110, "BRG"),  # violet
        (120, "BGR"),  # blue
        (155, "GBR"),  # green
    ],
)
def test_pearlescent_flakes_have_the_colours_of_the_trade(coating_nm: float, order: str) -> None:
    r, _ = coatings.colours(coatings.named_flake("tio2-on-mica", coating_nm), [1.0])
    assert "".join("RGB"[i] for i in np.argsort(-r[0])) == order


def test_thin_titania_on_mica_is_silver() -> None:
    silver, _ = coatings.colours(coatings.named_flake("tio2-on-mica", 55), [1.0])
    assert silver.min() > 0.3
    assert silver.max() / silver.min() < 1.25  # gold, at 80 nm, is at 15


def test_interpolating_the_table_errs_little_where_light_can_reach() -> None:
    """Within the binder no direction is more than asin(1/1.5) from the normal, so neither is alpha.

    Measured over all flakes and coatings from 40 to 160 nm: 0.013 (titania on silica).
    """
    nodes = np.linspace(0, 1, coatings.NODES)
    fine = np.linspace(np.sqrt(1 - 1 / coatings.BINDER_IOR**2), 1, 60)
    for name, coating_nm in (
        ("tio2-on-mica", 120), ("tio2-on-silica", 140), ("fe2o3-on-mica", 60), ("copper", None),
    ):  # fmt: skip
        flake = coatings.named_flake(name, coating_nm)
        table = coatings.table(flake)
        exact_r, exact_t = coatings.colours(flake, fine)
        exact_r = np.clip(exact_r, 0, 1)
        exact_t = np.clip(exact_t, 0, 1 - exact_r)
        for ours, exact in ((table.reflectance, exact_r), (table.transmittance, exact_t)):
            drawn = np.stack([np.interp(fine, nodes, channel) for channel in ours.T], axis=1)
            assert np.abs(drawn - exact).max() < 0.0135


@pytest.mark.parametrize("name", coatings.NAMES)
def test_no_coating_gives_back_more_than_falls_in(name: str) -> None:
    table = coatings.table(coatings.named_flake(name))
    assert table.reflectance.shape == (coatings.NODES, 3)
    assert (table.reflectance + table.transmittance <= 1 + 1e-12).all()


def test_a_paint_shows_the_coatings_colour() -> None:
    """View and light along the normal: alpha is 0, and nothing else has a colour."""
    scene = {
        "position": [[0, 0, 0]], "normal": [[0, 0, 1]], "view": [[0, 0, 1]], "footprint": [1e-6],
        "pixel": [[3, 4]],
    }  # fmt: skip
    sun = core.Light(core.LightKind.parallel, (0, 0, 1), 0.00465)
    number = [*coatings.METALS, *coatings.PEARLS].index("copper") + 1
    white = core.Paint(flake_color=(1, 1, 1), flake_edge_color=(1, 1, 1))
    mean = [
        core.evaluate(paint, [sun], **scene)["mean_radiance"].ravel()
        for paint in (core.Paint(coating=number), white)
    ]
    expected = core.library_coating([number], [0.0], [1.0])[0, 0]
    np.testing.assert_allclose(mean[0] / mean[1], expected, rtol=1e-6)


LIBRARY_FILE = ROOT / "core" / "coating_library.inc"


def test_the_library_is_what_the_tool_makes() -> None:
    assert LIBRARY_FILE.read_text() == coatings.library(), (
        "make it anew: python tools coatings.table --library > core/coating_library.inc"
    )


def test_the_library_s_order_is_the_core_s() -> None:
    """By name, at a node of the angle: the last, cos(alpha) = 1."""
    for i, name in enumerate([*coatings.METALS, *coatings.PEARLS]):
        table = coatings.table(coatings.library_flake(name, 60.0), cosines=[1.0])
        r, t = core.library_coating([i + 1], [60.0], [1.0])[:, 0]
        np.testing.assert_allclose(r, table.reflectance[0], atol=1e-6)
        # Metal lets a few parts in ten thousand through at its usual thickness, the library none.
        np.testing.assert_allclose(t, table.transmittance[0], atol=3e-4)


@pytest.mark.parametrize(
    ("name", "inside", "anywhere"),
    [  # largest error of any colour for cos(alpha) from 0.7 on, and from 0 on
        *((name, 0.0003, 0.08) for name in coatings.METALS),
        ("tio2-on-mica", 0.0125, 0.25),
        ("tio2-on-silica", 0.0355, 0.56),
        ("tio2-on-thin-silica", 0.0325, 0.41),
        ("fe2o3-on-mica", 0.042, 0.24),
        ("fe2o3-on-silica", 0.05, 0.48),
        ("fe2o3-on-aluminium", 0.018, 0.28),
    ],
)
def test_the_library_errs_as_stated(name: str, inside: float, anywhere: float) -> None:
    """Half way between the thicknesses, where a linear interpolation errs most."""
    kind = 1 + [*coatings.METALS, *coatings.PEARLS].index(name)
    cosine = np.concatenate([np.linspace(0, 0.7, 15)[:-1], np.linspace(0.7, 1, 37)])
    worst = np.zeros(len(cosine))
    for nm in (60.0,) if name in coatings.METALS else np.arange(2.5, 200, 7.5 * 2):
        exact = np.array(coatings.colours(coatings.library_flake(name, nm), cosine))
        exact[0] = np.clip(exact[0], 0, 1)
        exact[1] = np.clip(exact[1], 0, 1 - exact[0])
        ours = core.library_coating([kind] * len(cosine), [nm] * len(cosine), cosine)
        worst = np.maximum(worst, np.abs(ours - exact).max(axis=(0, 2)))
    assert worst[cosine >= 0.7].max() < inside
    assert worst.max() < anywhere


@pytest.mark.parametrize(
    ("name", "coating_nm", "orders"),
    [  # channels from the strongest to the weakest, alpha 0 and 40 degrees
        ("tio2-on-thin-silica", 70, ("GBR", "RBG")),  # green to purple
        ("tio2-on-silica", 80, ("RGB", "GBR")),  # gold to green
        ("tio2-on-silica", 120, ("BGR", "BRG")),  # blue to violet
    ],
)
def test_flakes_on_silica_flip(name: str, coating_nm: float, orders: tuple[str, str]) -> None:
    kind = 1 + [*coatings.METALS, *coatings.PEARLS].index(name)
    r = core.library_coating([kind] * 2, [coating_nm] * 2, np.cos(np.radians([0, 40])))[0]
    assert tuple("".join("RGB"[i] for i in np.argsort(-colour)) for colour in r) == orders


@pytest.mark.parametrize(
    ("coating", "nm", "message"),
    [
        (15, 60, r"coating is 15, but must be from 1 \(aluminium\) to 14 \(fe2o3-on-aluminium\)"),
        (0, 60, r"coating is 0, but must be from 1 \(aluminium\)"),
        (-1, 60, "coating is -1"),
        (9, 200.5, "coating_nm is 200.5, but must be from 0 to 200 nm"),
        (9, np.nan, "coating_nm is nan"),
    ],
)
def test_bad_coatings_are_named(coating: int, nm: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        core.library_coating([coating], [nm], [1.0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: coatings.named_flake("tin"), "name is 'tin', but must be one of mica, silica"),
        (lambda: coatings.named_flake("gold", 60), "coating_nm is 60, but gold has no coating"),
        (lambda: coatings.named_flake("tio2-on-mica", -1), "coating_nm is -1, but must be from 0"),
        (lambda: coatings.named_flake("mica", None, np.nan), "platelet_nm is nan, but must be"),
        (lambda: coatings.named_flake("mica", None, 100, 50), "spread_nm is 50, but must be from"),
        (lambda: coatings.Flake("tin", 100), "platelet is 'tin', but must be one of"),
        (lambda: coatings.Flake("mica", 100, 0, "tin", 9), "coating is 'tin', but must be None or"),
        (lambda: coatings.table(coatings.named_flake("mica"), 0.5), "medium is 0.5, but must be"),
        (lambda: coatings.table(coatings.named_flake("mica"), 1.5, 1), "nodes is 1, but must be"),
        (
            lambda: reflect_and_transmit([(1.5, -1)], 1, [500], [1]),
            "thickness of a film is -1, but",
        ),
        (
            lambda: reflect_and_transmit([(1 - 1j, 9)], 1, [500], [1]),
            "index of a film is .1-1j., but",
        ),
    ],
)
def test_bad_input_is_named(call: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()


def test_the_command_prints_a_table() -> None:
    tool = (TOOLS, "coatings.table")
    command = [sys.executable, *tool, "tio2-on-mica", "--thickness", "80", "--nodes", "17"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    table = coatings.table(coatings.named_flake("tio2-on-mica", 80), nodes=17)
    np.testing.assert_array_equal(json.loads(printed)["reflectance"], table.reflectance)
    np.testing.assert_array_equal(json.loads(printed)["transmittance"], table.transmittance)
