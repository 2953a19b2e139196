# SPDX-License-Identifier: Apache-2.0
"""Arrays may be anything numpy can turn into one; results are float64 unless stated.

Every function raises ValueError with a sentence that names the field, the value and the range.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class Orientation(IntEnum):
    """The shape of P(beta): the paper's Gaussian in beta, or the field's Beckmann and GGX."""

    gaussian = 0
    beckmann = 1
    ggx = 2

class DepthModel(IntEnum):
    """With (attenuated) or without (thinned) masking and shadowing: paper, 5.3.2."""

    attenuated = 0
    thinned = 1

class Radiometry(IntEnum):
    """The energy-conserving derivation, or the paper's formulas to the letter."""

    exact = 0
    published = 1

Colour = tuple[float, float, float]

class Paint:
    """A paint in real units; the defaults are the shader's. See struct Paint in core/paint.h.

    Fields given as keywords are checked on construction, all fields again on use.
    """

    flakes_per_mm2: float  # flakes per mm2 of painted surface (D H), 0 to 1e9
    flake_diameter_um: float  # of a disc of the mean flake area, 1e-3 to 1e5 um
    flake_area_spread: float  # standard deviation of the area over its mean, 0 to 100
    orientation: Orientation
    tilt: float  # gaussian: rad, 1e-6 to 100; beckmann and ggx: roughness, 1e-6 to 1
    flake_spread: float  # angular radius by which a flake spreads light, 0 to 0.5 rad
    flake_color: Colour  # reflectance at normal incidence, 0 to 1
    flake_edge_color: Colour  # reflectance at grazing incidence, 0 to 1
    flake_transmission: Colour  # transmittance, 0 to 1 less the reflectance
    binder_ior: float  # relative to the surroundings, 0.1 to 10
    layer_thickness_um: float  # 0 to 1e6 um
    binder_absorption_per_mm: Colour  # 0 to 1e6 1/mm
    rayleigh_per_mm: float  # 0 to 1e6 1/mm
    depth_model: DepthModel
    radiometry: Radiometry
    seed: int
    frame: int

    def __init__(self, **fields: object) -> None: ...
    def validate(self) -> None:
        """Raises ValueError where a field is out of its range."""

class CoatingTable:
    """Reflectance and transmittance of a flake, RGB, at cos(alpha) = 0, 1/(n-1), ..., 1.

    2 to 4096 rows, linear in between; each value and each sum of the two from 0 to 1.
    """

    def __init__(
        self, reflectance: Sequence[Sequence[float]], transmittance: Sequence[Sequence[float]]
    ) -> None: ...

class LightKind(IntEnum):
    unused = 0
    parallel = 1
    positional = 2

class Light:
    """A light that sparkles, as a slot of the shader holds it.

    parallel: `vector` points to the light (any length above 0), `size` is the sine of its angular
    radius, 0 to 1. positional: `vector` is the centre and `size` the radius, in scene units.
    """

    def __init__(self, kind: LightKind, vector: Sequence[float], size: float) -> None: ...
    @property
    def kind(self) -> LightKind: ...
    @property
    def vector(self) -> tuple[float, float, float]: ...
    @property
    def size(self) -> float: ...

class Pixels(TypedDict):
    """n pixels, m lights.

    A light below the horizon has the leader -1 and zeros; one too close to an earlier light to be
    told apart has that light as its leader, its radiance, and no count of its own.
    """

    leader: NDArray[np.int32]  # (n, m)
    slots: NDArray[np.int32]  # (n, m): 0 for a Poisson count, k for a binomial one of k places
    mean_count: NDArray[np.float64]  # (n, m): <N>
    count: NDArray[np.float64]  # (n, m): N
    radiance: NDArray[np.float64]  # (n, m, 3): T, per unit irradiance normal to the light, 1/sr
    mean_radiance: NDArray[np.float64]  # (n, m, 3): E[T]
    variance: NDArray[np.float64]  # (n, m, 3): Var[T]

def evaluate(
    paint: Paint,
    lights: Sequence[Light],
    *,
    position: ArrayLike,
    normal: ArrayLike,
    view: ArrayLike,
    footprint: ArrayLike,
    pixel: ArrayLike,
    coating: CoatingTable | None = None,
    slant_depth: ArrayLike | None = None,
    precision: Literal["float", "double"] = "double",
) -> Pixels:
    """The sparkles of up to 8 lights in n pixels, on all cores.

    position (n, 3) in scene units; normal and view (n, 3), unit, view towards the observer, zero
    for a pixel without surface; footprint (n,), the area of the pixel's projection on the surface
    in m2; pixel (n, 2), whole pixel coordinates x and y. The deviates depend on pixel, light
    number, paint.frame and paint.seed alone. coating replaces the paint's flake colours.
    slant_depth (n, m, 3) replaces the layer's own optical depth tau(view) H/cos + tau(light) H/cos.
    "float" repeats the shader operation by operation; "double" is the reference.
    """

def flake_brdf(
    paint: Paint, normal: ArrayLike, view: ArrayLike, light: ArrayLike
) -> NDArray[np.float64]:
    """The mean of the sparkles as a BRDF, 1/sr: (n, 3) from unit vectors (n, 3)."""

def hash_words(
    x: ArrayLike,
    y: ArrayLike,
    *,
    light: int = 0,
    species: int = 0,
    frame: int = 0,
    seed: int = 0,
    draw: int = 0,
) -> NDArray[np.uint32]:
    """The four random words (n, 4) of draw number `draw` at pixels (x, y), any 32-bit integers."""

def count_deviate(mean: ArrayLike, slots: ArrayLike, uniform: ArrayLike) -> NDArray[np.float64]:
    """The count of sparkles for a uniform deviate in (0, 1].

    slots = 0: Poisson; slots = k: binomial with k places and the same mean.
    """

def normal_quantile(probability: ArrayLike) -> NDArray[np.float64]:
    """The standard normal deviate at a probability in (0, 1]."""

def fresnel_transmittance(cos_theta: ArrayLike, eta: ArrayLike) -> NDArray[np.float64]:
    """1 - r_eta: unpolarised transmittance at the outside cosine, 0 under total reflection."""

def orientation_density(paint: Paint, beta: ArrayLike) -> NDArray[np.float64]:
    """P(beta) of the paint's flakes, beta in rad, 0 to pi/2; P sin(beta) integrates to 1."""

def mean_projected_area(paint: Paint, cos_theta: ArrayLike) -> NDArray[np.float64]:
    """<s>, the mean projected area of a flake of unit area along a ray of that cosine (binder)."""
