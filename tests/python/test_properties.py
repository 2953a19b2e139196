# SPDX-License-Identifier: Apache-2.0
"""What holds for every paint, light and pixel that the core takes: random ones, ends of the ranges
included. Each run has other examples; one that fails is printed whole."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import metallic_paint_core as core
import numpy as np
import parameters
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.long

settings.register_profile(
    "paint",
    database=None,
    deadline=None,
    max_examples=80,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("paint")

INT_MIN, INT_MAX = -(2**31), 2**31 - 1
FARTHEST = 1e30
EPSILON = float(np.finfo(float).eps)

UNIT = st.floats(0, 1)


def spanning(least: float, most: float, zero: bool = False) -> st.SearchStrategy[float]:
    """Evenly over the decades from least to most, the ends more often; and 0."""
    low, high = math.log(least) - 1, math.log(most) + 1

    def value(x: float) -> float:
        return 0.0 if x < low else min(max(math.exp(x), least), most)

    return st.floats(low - (2 if zero else 0), high).map(value)


def int32(x: float) -> int:
    return int(min(max(x, INT_MIN), INT_MAX))


INT32 = st.floats(1.2 * INT_MIN, 1.2 * INT_MAX).map(int32)


def color(channel: st.SearchStrategy[float]) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(channel, channel, channel)


INDICES = st.one_of(spanning(0.1, 10), st.sampled_from([1 - 1e-9, 1.0, 1 + 1e-9]))


PARAMETERS = {row.name: row for row in parameters.read().all}


def anywhere(row: parameters.Parameter) -> st.SearchStrategy[Any]:
    if row.choices:
        return st.sampled_from(list(getattr(core, row.choice)))
    if row.type == "int":
        return INT32
    least, most = row.range
    number = spanning(1e-9, most, zero=True) if least == 0 else spanning(least, most)
    return color(number) if row.is_triple else number


@st.composite
def paints(draw: st.DrawFn) -> dict[str, Any]:
    """The fields of a paint, each anywhere in its range; the flakes have colours of their own."""
    rows = [row for row in PARAMETERS.values() if not row.name.startswith("coating")]
    fields = {row.name: draw(anywhere(row)) for row in rows} | {"frame": draw(INT32)}
    if fields["orientation"] != core.Orientation.gaussian:
        fields["tilt"] = draw(spanning(*PARAMETERS["tilt"].as_roughness["range"]))
    fields["flake_transmission"] = draw(color(UNIT))
    for name in ("flake_color", "flake_edge_color"):
        shares = zip(draw(color(UNIT)), fields["flake_transmission"], strict=True)
        fields[name] = tuple(r * (1 - t) for r, t in shares)
    fields["binder_ior"] = draw(INDICES)
    fields["sparkle_contrast"] = draw(st.one_of(st.just(1.0), UNIT))
    return fields


def signed_power(x: float) -> float:
    """-FARTHEST to FARTHEST, evenly over the decades from 1e-6 on; 0 between."""
    return 0.0 if abs(x) < 1 else math.copysign(min(10 ** (abs(x) - 7), FARTHEST), x)


COORDINATES = color(st.floats(-38, 38).map(signed_power))


def direction(axis: np.ndarray, cosine: float, azimuth: float) -> np.ndarray:
    helper = np.eye(3)[np.abs(axis).argmin()]
    tangent = np.cross(axis, helper) / np.linalg.norm(np.cross(axis, helper))
    flat = math.cos(azimuth) * tangent + math.sin(azimuth) * np.cross(axis, tangent)
    return cosine * axis + math.sqrt((1 - cosine) * (1 + cosine)) * flat


def directions(axis: np.ndarray) -> st.SearchStrategy[np.ndarray]:
    """Unit, at any angle to the axis: along it, grazing down to 1e-9 degrees, below."""
    cosine = st.one_of(spanning(1.7e-11, 1), st.floats(-0.2, 1).map(lambda x: round(x, 3)))
    return st.builds(direction, st.just(axis), cosine, st.floats(0, 2 * math.pi))


@dataclass(frozen=True)
class Light:
    kind: core.LightKind
    vector: np.ndarray
    size: float

    def of_core(self) -> core.Light:
        return core.Light(self.kind, self.vector, self.size)


@st.composite
def lights(draw: st.DrawFn, position: np.ndarray, normal: np.ndarray, view: np.ndarray) -> Light:
    """Suns and lamps, anywhere and of any size; also just where the observer is, and where its
    mirror image is."""
    mirrored = 2 * (normal @ view) * normal - view
    towards = draw(st.one_of(directions(normal), st.sampled_from([view, -view, mirrored])))
    if draw(st.booleans()):
        length = draw(st.one_of(st.just(1.0), spanning(1e-9, 1e9)))
        return Light(core.LightKind.parallel, towards * length, draw(spanning(1e-9, 1, zero=True)))
    place = position + towards * draw(spanning(1e-6, FARTHEST, zero=True))
    place = draw(st.one_of(st.just(place), COORDINATES.map(np.array)))
    size = draw(spanning(1e-9, FARTHEST, zero=True))
    return Light(core.LightKind.positional, np.clip(place, -FARTHEST, FARTHEST), size)


@dataclass(frozen=True)
class Case:
    paint: dict[str, Any]
    lights: list[Light]
    places: dict[str, np.ndarray]
    precision: str = "double"

    def evaluate(self, **places: np.ndarray) -> dict[str, np.ndarray]:
        lights = [light.of_core() for light in self.lights]
        all_places = self.places | places
        return core.evaluate(
            core.Paint(**self.paint), lights, **all_places, precision=self.precision
        )

    def but(self, **fields: object) -> Case:
        return Case(self.paint | fields, self.lights, self.places, self.precision)


FOOTPRINTS = spanning(1e-24, 1e30, zero=True)


@st.composite
def cases(draw: st.DrawFn, precisions: tuple[str, ...] = ("float", "double")) -> Case:
    pixels = draw(st.integers(1, 3))
    origin = st.just((0.0, 0.0, 0.0))
    positions = [np.array(draw(st.one_of(origin, COORDINATES))) for _ in range(pixels)]
    normals = [draw(directions(np.array([0.0, 0.0, 1.0]))) for _ in range(pixels)]
    views = [draw(directions(normal)) for normal in normals]
    at_first = lights(positions[0], normals[0], views[0])
    places = {
        "position": np.array(positions),
        "normal": np.array(normals),
        "view": np.array(views),
        "footprint": np.array([draw(FOOTPRINTS) for _ in range(pixels)], dtype=float),
        "pixel": np.array([[draw(INT32), draw(INT32)] for _ in range(pixels)]),
    }
    found = [draw(at_first) for _ in range(draw(st.integers(1, 3)))]
    return Case(draw(paints()), found, places, draw(st.sampled_from(precisions)))


def assert_same(found: dict[str, np.ndarray], want: dict[str, np.ndarray]) -> None:
    for name, values in want.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)


VALUES = ("mean_count", "count", "radiance", "mean_radiance", "variance")


@settings(max_examples=300)
@given(cases())
def test_every_value_is_finite_and_not_negative(case: Case) -> None:
    result = case.evaluate()
    for name in VALUES:
        assert np.isfinite(result[name]).all(), name
        assert (result[name] >= 0).all(), name
    count, slots = result["count"], result["slots"]
    assert (count == np.floor(count)).all()
    assert (count <= np.where(slots > 0, slots, np.inf)).all()
    leads = result["leader"] == np.arange(len(case.lights))
    if case.paint["sparkle_contrast"] == 1:
        assert not result["radiance"][leads & (count == 0)].any()
    for name in VALUES:
        assert not result[name][result["leader"] < 0].any(), name


@pytest.mark.parametrize("precision", ["float", "double"])
@pytest.mark.parametrize("grazed", ["view", "light"])
@given(spanning(1e-320, 1e-10), INDICES)
def test_a_direction_may_graze_the_surface_by_any_number(
    precision: str, grazed: str, cosine: float, eta: float
) -> None:
    low, high = np.array([1.0, 0.0, cosine]), np.array([0.6, 0.0, 0.8])
    view, light = (low, high) if grazed == "view" else (high, low)
    places = {
        "position": np.zeros((1, 3)),
        "normal": np.array([[0.0, 0.0, 1.0]]),
        "view": view[None],
        "footprint": np.array([1e-6]),
        "pixel": np.zeros((1, 2)),
    }
    sun = Light(core.LightKind.parallel, light, 0.1)
    result = Case({"binder_ior": eta, "tilt": 1.0}, [sun], places, precision).evaluate()
    for name in VALUES:
        assert np.isfinite(result[name]).all(), name
    assert np.isfinite(core.fresnel_transmittance(cosine, eta))


# --- no pixel outshines the light seen in a mirror ------------------------------------------------


def surface_most(case: Case, light: Light) -> tuple[np.ndarray, np.ndarray]:
    """For each pixel: the light's solid angle, and the most that the binder's surface lets through
    there and back, the cosines being known to rounding only."""
    single = case.precision == "float"
    towards = np.broadcast_to(light.vector, case.places["position"].shape)
    if light.kind == core.LightKind.positional:
        towards = towards - case.places["position"]
    distance = np.linalg.norm(towards, axis=1)
    sine = np.full(len(towards), light.size)
    with np.errstate(divide="ignore", invalid="ignore"):
        towards = towards / distance[:, None]
        if light.kind == core.LightKind.positional:
            sine = np.nan_to_num(np.minimum(light.size / distance, 1))
    half = sine**2 / (2 * (1 + np.sqrt((1 - sine) * (1 + sine))))  # sin²(Δ/2)
    published = case.paint["radiometry"] == core.Radiometry.published
    angle = math.pi * (2 * np.arcsin(np.sqrt(half))) ** 2 if published else 4 * math.pi * half
    eta = float(np.float32(case.paint["binder_ior"])) if single else case.paint["binder_ior"]
    rounding = 4 * float(np.finfo(np.float32 if single else float).eps)

    def most(direction: np.ndarray) -> np.ndarray:
        cosine = (case.places["normal"] * np.nan_to_num(direction)).sum(axis=1)
        return np.maximum(
            *(core.fresnel_transmittance(np.clip(cosine + off, 0, 1), eta)
              for off in (-rounding, rounding))
        )  # fmt: skip

    return angle, most(case.places["view"]) * most(towards)


def even(case: Case) -> Case:
    """Without orange peel, whose waves have a place, a size and no mirror image."""
    return case.but(orange_peel=0.0)


@settings(max_examples=200)
@given(cases().map(even))
def test_no_pixel_outshines_the_light_in_a_mirror(case: Case) -> None:
    """T ≤ (1-r)(1-r')/Ω: the flakes' own spread only widens Ω. And as 0 ≤ T ≤ mirror, Var[T] ≤
    E[T] mirror; where sparkles overlap beyond that, the mean is the BRDF's and no pixel's."""
    result = case.evaluate()
    # In float a few dozen roundings of 6e-8; in double of 1e-16.
    slack = 1 + (1e-5 if case.precision == "float" else 1e-12)
    for i, light in enumerate(case.lights):
        if case.precision == "float" and light.kind == core.LightKind.positional:
            continue  # far from the origin float knows neither place
        angle, most = surface_most(case, light)
        led = (result["leader"][:, i] == i)[:, None]  # others show their leader's light
        bound = (most * slack)[:, None]
        solid = angle[:, None]
        assert np.where(led, result["radiance"][:, i] * solid <= bound, True).all()
        variance, mean = result["variance"][:, i], result["mean_radiance"][:, i]
        apart = led & (mean * solid <= bound)
        assert np.where(apart, variance * solid <= mean * bound + 1e-300, True).all()


# --- the same pixels, looked at in another way ----------------------------------------------------


@given(cases())
def test_the_same_input_gives_the_same_bits(case: Case) -> None:
    assert_same(case.evaluate(), case.evaluate())


@given(cases(), st.randoms(use_true_random=False))
def test_pixels_do_not_know_of_one_another(case: Case, random: Any) -> None:  # noqa: ANN401
    """In another order and number, over several of the core's blocks: each is as it was alone."""
    alone = case.evaluate()
    rows = np.array([random.randrange(len(case.places["footprint"])) for _ in range(1500)])
    found = case.evaluate(**{name: values[rows] for name, values in case.places.items()})
    assert_same(found, {name: values[rows] for name, values in alone.items()})


@given(cases().map(even), st.integers(0, 2))
def test_a_mirror_image_sparkles_alike(case: Case, axis: int) -> None:
    flip = np.where(np.arange(3) == axis, -1.0, 1.0)
    lights = [Light(light.kind, light.vector * flip, light.size) for light in case.lights]
    places = case.places | {
        name: case.places[name] * flip for name in ("position", "normal", "view")
    }
    found = Case(case.paint, lights, places, case.precision).evaluate()
    assert_same(found, case.evaluate())


@given(cases().map(even), COORDINATES)
def test_a_sun_shines_alike_everywhere(case: Case, place: tuple[float, ...]) -> None:
    suns = [light for light in case.lights if light.kind == core.LightKind.parallel]
    lit = Case(case.paint, suns, case.places, case.precision)
    elsewhere = np.broadcast_to(place, case.places["position"].shape)
    assert_same(lit.evaluate(position=elsewhere), lit.evaluate())


@given(cases(("double",)).map(even), st.integers(-8, 8))
def test_the_scene_may_be_in_any_unit(case: Case, exponent: int) -> None:
    """Powers of two round nothing but subnormal numbers."""
    factor = 2.0**exponent
    position = case.places["position"] * factor
    assume(np.abs(position).max() <= FARTHEST)
    assume((position / factor == case.places["position"]).all())
    lights = []
    for light in case.lights:
        lamp = light.kind == core.LightKind.positional
        scaled = Light(light.kind, light.vector * factor, light.size * (factor if lamp else 1))
        assume(max(np.abs(scaled.vector).max(), scaled.size) <= FARTHEST)
        assume((scaled.vector / factor == light.vector).all())
        lights.append(scaled)
    found = Case(case.paint, lights, case.places | {"position": position}).evaluate()
    assert_same(found, case.evaluate())


# --- what a parameter does ------------------------------------------------------------------------

EXPECTED = ("leader", "slots", "mean_count", "mean_radiance", "variance")


@given(cases(), INT32, INT32, INT32)
def test_what_is_expected_has_no_chance_in_it(case: Case, seed: int, frame: int, x: int) -> None:
    pixel = np.full_like(case.places["pixel"], x)
    found = case.but(seed=seed, frame=frame).evaluate(pixel=pixel)
    want = case.evaluate()
    assert_same({name: found[name] for name in EXPECTED}, {name: want[name] for name in EXPECTED})


@given(cases())
def test_twice_the_flakes_sparkle_twice(case: Case) -> None:
    """<N> = Σ D H Pr where none hides another; thinned, the deeper ones hide, but never so that
    more flakes show fewer sparkles: D (1-e^-x)/x rises with D for x = aD + b.

    A pixel that gets more sparkles than it has places counts those alone that nothing hides, so
    its count falls there; its light does not.
    """
    flakes = case.paint["flakes_per_mm2"] / 2
    half, whole = case.but(flakes_per_mm2=flakes).evaluate(), case.evaluate()
    mean, twice = half["mean_count"], whole["mean_count"]
    poisson = (half["slots"] == 0) & (whole["slots"] == 0)
    rounding = 1e-6 if case.precision == "float" else 1e-14
    if case.paint["depth_model"] == core.DepthModel.attenuated:
        np.testing.assert_array_equal(twice[poisson], 2 * mean[poisson])
    fits = (whole["slots"] == 0) | (2 * mean <= whole["slots"])
    assert (twice >= mean * (1 - rounding))[fits].all()
    assert (twice <= 2 * mean * (1 + rounding)).all()
    light, more = half["mean_radiance"], whole["mean_radiance"]
    least = 1e-280 if case.precision == "double" else 1e-30  # what a denormal number may lose
    assert (more >= light * (1 - 100 * rounding) - least).all()
    assert (more <= 2 * light * (1 + 100 * rounding) + least).all()


@given(cases(("double",)), spanning(1e-24, 1e30))
def test_mean_radiance_does_not_depend_on_the_size_of_pixels(case: Case, footprint: float) -> None:
    found = case.evaluate(footprint=np.full_like(case.places["footprint"], footprint))
    seen = case.places["footprint"] > 0
    np.testing.assert_allclose(
        found["mean_radiance"][seen], case.evaluate()["mean_radiance"][seen], rtol=1e-9, atol=1e-280
    )


@given(cases(("double",)))
def test_perfectly_black_flakes_and_none_show_nothing(case: Case) -> None:
    black = case.but(flake_color=(0, 0, 0), flake_edge_color=(0, 0, 0)).evaluate()
    assert not black["radiance"].any()
    assert not black["mean_radiance"].any()
    none = case.but(flakes_per_mm2=0).evaluate()
    assert not none["count"].any()
    assert not none["radiance"].any()


# --- the pieces of the model ----------------------------------------------------------------------


@st.composite
def three_directions(draw: st.DrawFn) -> tuple[np.ndarray, ...]:
    normal = draw(directions(np.array([0.0, 0.0, 1.0])))
    return normal, draw(directions(normal)), draw(directions(normal))


@settings(max_examples=200)
@given(paints(), three_directions())
def test_the_brdf_is_sound_and_reciprocal(
    fields: dict[str, Any], vectors: tuple[np.ndarray, ...]
) -> None:
    normal, view, light = ([v] for v in vectors)
    paint = core.Paint(**fields)
    brdf = core.flake_brdf(paint, normal, view, light)
    assert np.isfinite(brdf).all()
    assert (brdf >= 0).all()
    if paint.radiometry == core.Radiometry.exact:
        np.testing.assert_allclose(core.flake_brdf(paint, normal, light, view), brdf, rtol=1e-12)


@settings(max_examples=400)
@given(spanning(1e-3, 1), spanning(1, 10))
def test_the_surface_lets_through_the_same_both_ways(cosine: float, eta: float) -> None:
    inside = math.sqrt((eta - 1) * (eta + 1) + cosine**2) / eta
    out = float(core.fresnel_transmittance(cosine, eta))
    back = float(core.fresnel_transmittance(min(inside, 1), 1 / eta))
    assert 0 < out <= 1 + EPSILON
    # From inside, the outer cosine² = 1 - η²(1 - inside²) is known to some η² ulp.
    assert back == pytest.approx(out, rel=16 * EPSILON * (eta / cosine) ** 2)


@given(spanning(1e-11, 1, zero=True), INDICES)
def test_transmittance_lies_between_0_and_1(cosine: float, eta: float) -> None:
    passed = float(core.fresnel_transmittance(cosine, eta))
    assert 0 <= passed <= 1 + EPSILON
    if cosine**2 < (1 - eta) * (1 + eta) - 4 * EPSILON:
        assert passed == 0
    if eta == 1 and cosine > 0:
        assert passed == pytest.approx(1, rel=4 * EPSILON)


@given(paints())
def test_the_orientation_is_a_density(fields: dict[str, Any]) -> None:
    """By trapezoids over ln β, 500 to the decade or more; below 1e-5 tilt lies 1e-10 of it."""
    paint = core.Paint(**fields)
    beta = np.geomspace(min(paint.tilt, 1) * 1e-5, math.pi / 2, 5000)
    beta[-1] = math.pi / 2
    density = core.orientation_density(paint, beta)
    assert np.isfinite(density).all()
    assert (density >= 0).all()
    weight = density * np.sin(beta) * beta
    total = ((weight[1:] + weight[:-1]) / 2 * np.diff(np.log(beta))).sum()
    assert total == pytest.approx(1, abs=1e-4)


@given(paints(), UNIT)
def test_a_flake_shows_between_its_edge_and_its_face(fields: dict[str, Any], cosine: float) -> None:
    """|cos a cos b| <= <s> <= 1: over the azimuth, the mean of |x + y cos φ| is at least |x|."""
    paint = core.Paint(**fields)
    shown, face = core.mean_projected_area(paint, [cosine, 1])
    assert 0 <= shown <= 1 + 1e-12
    assert shown >= cosine * face * (1 - 1e-9)


MEANS = st.one_of(spanning(1e-12, 1e40, zero=True), st.sampled_from([16, 32, 1e300, math.inf]))


@settings(max_examples=400)
@given(MEANS, st.integers(0, 16), st.data())
def test_a_count_is_whole_and_falls_with_its_deviate(
    mean: float, slots: int, data: st.DataObject
) -> None:
    one = spanning(2.0**-48, 1)
    uniform = np.array(sorted(data.draw(st.lists(one, min_size=2, max_size=6))))
    count = core.count_deviate(mean, slots, uniform)
    assert np.isfinite(count).all()
    assert (count >= 0).all()
    assert (count == np.floor(count)).all()
    assert (np.diff(count) <= 0).all()
    if slots:
        assert (count <= slots).all()


@settings(max_examples=400)
@given(spanning(2.0**-52, 0.5), spanning(1e-300, 1))
def test_the_normal_quantile_is_the_inverse_of_the_normal(even: float, p: float) -> None:
    dyadic = math.ceil(even * 2.0**52) / 2.0**52  # 1 - p is exact
    low, high = core.normal_quantile([dyadic, 1 - dyadic])
    # Where q is near 0 it inherits p's rounding against 1/2: 1 ulp of 1.
    assert low == pytest.approx(-high, rel=1e-14, abs=4 * EPSILON)
    x = float(core.normal_quantile(p))
    assert math.isfinite(x)
    # erfc magnifies the rounding of x by x².
    if p < 1:
        back = 0.5 * math.erfc(-x / math.sqrt(2))
        assert back == pytest.approx(p, rel=16 * EPSILON * (1 + x * x))


WORDS = st.integers(0, 1 << 23).map(float)  # of which keys are made


@given(st.tuples(*[WORDS] * 4), st.integers(0, 3), WORDS)
def test_every_word_of_the_key_changes_the_hash(
    key: tuple[float, ...], which: int, value: float
) -> None:
    def noise(x: float, y: float, z: float, w: float) -> np.ndarray:
        return core.white_noise([(x, y, z)], [w])

    found = noise(*key)
    assert found.shape == (1, 3)
    assert ((found >= 0) & (found <= 1)).all()
    np.testing.assert_array_equal(noise(*key), found)
    other = (*key[:which], value, *key[which + 1 :])
    if other != key:  # equal by chance once in 2^72
        assert (noise(*other) != found).any()


# --- what no paint, no light and no pixel can be --------------------------------------------------

NAN, INF = math.nan, math.inf
HUGE = 10**400  # no float
NO_NUMBERS = [None, "a", "", b"1", [], {}, object(), 1j, (1, 2), [1, 2], HUGE, -HUGE]


def beyond(least: float, most: float) -> st.SearchStrategy[object]:
    """Numbers out of the range and what is no number."""
    return st.one_of(
        st.sampled_from([NAN, INF, -INF, math.nextafter(least, -INF), math.nextafter(most, INF)]),
        st.floats(max_value=math.nextafter(least, -INF)),
        st.floats(min_value=math.nextafter(most, INF)),
        st.sampled_from(NO_NUMBERS),
    )


@st.composite
def bad_fields(draw: st.DrawFn) -> tuple[str, object]:
    name = draw(st.sampled_from([*PARAMETERS, "frame"]))
    row = PARAMETERS.get(name)
    if row is None or row.type == "int":
        far = st.one_of(st.integers(min_value=INT_MAX + 1), st.integers(max_value=INT_MIN - 1))
        return name, draw(st.one_of(far, st.floats(), st.sampled_from(NO_NUMBERS)))
    if row.choices:
        far = st.integers().filter(lambda i: not 0 <= i < len(row.choices))
        return name, draw(st.one_of(far, st.floats(), st.sampled_from([*NO_NUMBERS, "phong", ""])))
    bad = draw(beyond(*row.range))
    if not row.is_triple:
        return name, bad
    if draw(st.booleans()):
        return name, draw(st.sampled_from([bad, [0.0] * 2, [0.0] * 4, (bad,)]))
    channels = [0.0, 0.0, 0.0]
    channels[draw(st.integers(0, 2))] = bad
    return name, draw(st.sampled_from([tuple, list]))(channels)


@settings(max_examples=600)
@given(bad_fields())
def test_a_bad_field_is_a_value_error_that_names_it(bad: tuple[str, object]) -> None:
    name, value = bad
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        core.Paint(**{name: value})
    paint = core.Paint()
    with pytest.raises(ValueError, match=rf"^{name}\b"):  # noqa: PT012 # either may find it
        setattr(paint, name, value)
        paint.validate()


@settings(max_examples=300)
@given(st.sampled_from(["kind", "vector", "size"]), st.booleans(), beyond(0, FARTHEST), st.data())
def test_a_bad_light_is_a_value_error_that_names_it(
    name: str, parallel: bool, bad: object, data: st.DataObject
) -> None:
    kind = core.LightKind.parallel if parallel else core.LightKind.positional
    arguments = {"kind": kind, "vector": (0.0, 0.0, 1.0), "size": 0.1}
    if name == "kind":
        bad = data.draw(st.one_of(st.sampled_from(NO_NUMBERS), st.floats(), st.integers(3)))
    elif name == "vector":
        out = data.draw(st.one_of(beyond(-FARTHEST, FARTHEST), st.just((1, 2, 3))))
        bad = data.draw(st.sampled_from([out, (0, 0), (0, 0, 1, 0), (0, 0, out)]))
        assume(not isinstance(bad, tuple) or bad != (1, 2, 3))
    with pytest.raises(ValueError, match=rf"^light\.{name}\b"):
        core.Light(**(arguments | {name: bad}))


ROWS = 4
SHAPES = {"position": (3,), "normal": (3,), "view": (3,), "footprint": (), "pixel": (2,)}
ALLOWED = {
    "position": (-FARTHEST, FARTHEST),
    "normal": (-1.01, 1.01),
    "view": (-1.01, 1.01),
    "footprint": (0, FARTHEST),
    "pixel": (INT_MIN, INT_MAX),
}


@settings(max_examples=400)
@given(st.sampled_from(list(SHAPES)), st.data())
def test_a_bad_array_is_a_value_error_that_names_it(name: str, data: st.DataObject) -> None:
    good = {
        "position": np.zeros((ROWS, 3)),
        "normal": np.tile([0.0, 0.0, 1.0], (ROWS, 1)),
        "view": np.tile([0.0, 0.0, 1.0], (ROWS, 1)),
        "footprint": np.full(ROWS, 1e-7),
        "pixel": np.zeros((ROWS, 2)),
    }
    shape = (ROWS, *SHAPES[name])
    if data.draw(st.booleans()):
        bad = data.draw(beyond(*ALLOWED[name]))
        values = good[name].astype(object)
        where = tuple(data.draw(st.integers(0, n - 1)) for n in shape)
        values[where] = bad
        array: object = values.astype(float) if isinstance(bad, float) else values.tolist()
    else:
        sizes = data.draw(st.lists(st.integers(0, 5), max_size=4).map(tuple))
        # Another number of footprints makes every other array the wrong one.
        assume(sizes != shape and not (name == "footprint" and len(sizes) == 1))
        kinds = [np.float64, np.float32, np.int8, object, complex, "U1", "M8[s]", "V2"]
        array = np.zeros(sizes, data.draw(st.sampled_from(kinds)))
    with pytest.raises(ValueError, match=rf"{name}\b"):
        core.evaluate(core.Paint(), [], **(good | {name: array}))


def call_count(bad: object, which: int) -> object:
    return core.count_deviate(*(bad if i == which else 1 for i in range(3)))


FUNCTIONS: list[tuple[str, tuple[float, float], Callable[[object], object]]] = [
    ("mean", (0, INF), lambda bad: call_count(bad, 0)),
    ("slots", (0, 16), lambda bad: call_count(bad, 1)),
    ("uniform", (5e-324, 1), lambda bad: call_count(bad, 2)),
    ("probability", (5e-324, 1), core.normal_quantile),
    ("cos_theta", (0, 1), lambda bad: core.fresnel_transmittance(bad, 1.5)),
    ("eta", (0.1, 10), lambda bad: core.fresnel_transmittance(1, bad)),
    ("beta", (0, math.pi / 2), lambda bad: core.orientation_density(core.Paint(), bad)),
    ("cos_theta", (0, 1), lambda bad: core.mean_projected_area(core.Paint(), bad)),
]


@settings(max_examples=400)
@given(st.sampled_from(FUNCTIONS), st.data())
def test_a_bad_argument_is_a_value_error_that_names_it(
    function: tuple[str, tuple[float, float], Callable[[object], object]],
    data: st.DataObject,
) -> None:
    name, ends, call = function
    bad = data.draw(beyond(*ends))
    # An array broadcasts, and infinity is a mean.
    assume(not isinstance(bad, list | tuple) and not (name == "mean" and bad == INF))
    with pytest.raises(ValueError, match=rf"^{name}\b"):
        call(bad)
