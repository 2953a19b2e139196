# SPDX-License-Identifier: Apache-2.0
"""Types of the native module; its docstrings are in the module itself."""

from collections.abc import Sequence
from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._paint import Anchor as Anchor
from ._paint import CoatingKind as CoatingKind
from ._paint import Composition as Composition
from ._paint import DepthModel as DepthModel
from ._paint import Diffraction as Diffraction
from ._paint import FlakeSpecies as FlakeSpecies
from ._paint import Instances as Instances
from ._paint import LightKind as LightKind
from ._paint import Orientation as Orientation
from ._paint import Paint as Paint
from ._paint import Radiometry as Radiometry

__version__: str

class Light:
    def __init__(
        self,
        kind: LightKind,
        vector: Sequence[float],
        size: float,
        facing: Sequence[float] | None = None,
    ) -> None: ...
    @property
    def kind(self) -> LightKind: ...
    @property
    def vector(self) -> tuple[float, float, float]: ...
    @property
    def size(self) -> float: ...
    @property
    def facing(self) -> tuple[float, float, float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

class Pixels(TypedDict):
    """n pixels, m lights.

    A light below the horizon, and an area light that has melted into the mean, have the leader -1
    and zeros; one that melts shows here what still sparkles of it. One too close to an earlier
    light to be told apart has that light as its leader, its radiance, and no count of its own.
    All but the slots are of all species together.
    """

    leader: NDArray[np.int32]  # (n, m)
    # (n, m), of the first species' count: 0 for a Poisson count, k for a binomial one of k places
    slots: NDArray[np.int32]
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
    own_position: ArrayLike | None = None,
    own_axes: ArrayLike | None = None,
    instance: ArrayLike | None = None,
    slant_depth: ArrayLike | None = None,
    precision: Literal["float", "double"] = "double",
) -> Pixels: ...

class Shades(TypedDict):
    radiance: NDArray[np.float64]  # (n, m, 3): of the whole paint, 1/sr
    mean_radiance: NDArray[np.float64]  # (n, m, 3): with the sparkles' mean
    sparkles: NDArray[np.float64]  # (n, m, 3): as Composition joins them
    scattered: NDArray[np.float64]  # (n, m, 3): the mixture's lobes
    shine: NDArray[np.float64]  # (n, m): the coat's
    coat_reflected: NDArray[np.float64]  # (n,)
    coat_rest: NDArray[np.float64]  # (n,): the factor of all but the shine, which may exceed 1
    coat_normal: NDArray[np.float64]  # (n, 3): with the orange peel
    diffuse: NDArray[np.float64]  # (n, 3): albedo of the diffuse lobe, with the texture
    glossy: NDArray[np.float64]  # (n, 3): of the glossy one
    returned: NDArray[np.float64]  # (n, 3): of the one that goes back to the light
    alpha: NDArray[np.float64]  # (n,): roughness of the glossy one
    texture: NDArray[np.float64]  # (n,)

def shade(
    paint: Paint,
    lights: Sequence[Light],
    *,
    position: ArrayLike,
    normal: ArrayLike,
    view: ArrayLike,
    footprint: ArrayLike,
    pixel: ArrayLike,
    own_position: ArrayLike | None = None,
    own_axes: ArrayLike | None = None,
    instance: ArrayLike | None = None,
    coat_normal: ArrayLike | None = None,
) -> Shades:
    """The whole paint under up to 8 listed lights in n pixels, on all cores.

    Places as in evaluate; coat_normal (n, 3): unit normals of the coat where they are others,
    before the orange peel, whose waves are fixed to the own space.

    What it says of lights is per unit of their irradiance on a plane normal to them:
    radiance = shine + coat_rest (sparkles + scattered). 0 where a light is below the surface. A
    light is narrow against the lobes; its radius counts where a coat without roughness mirrors it.
    """

class Reflectances(TypedDict):
    reflectance: NDArray[np.float64]  # (n, m, 3): f cos(theta'), 1/sr
    mirror: NDArray[np.float64]  # (n,): what a coat without roughness reflects besides
    albedo: NDArray[np.float64]  # (n, 3): the radiance under a world of radiance 1

def reflectance(
    paint: Paint,
    light: ArrayLike,
    *,
    position: ArrayLike,
    normal: ArrayLike,
    view: ArrayLike,
    footprint: ArrayLike,
    pixel: ArrayLike,
    own_position: ArrayLike | None = None,
    own_axes: ArrayLike | None = None,
    instance: ArrayLike | None = None,
    coat_normal: ArrayLike | None = None,
) -> Reflectances:
    """The whole paint under light that is not listed: world, area lights, neighbours.

    light (m, 3): unit vectors towards it; places as in shade. reflectance times radiance and solid
    angle is what that light adds, with the flakes in their mean. A coat without roughness is a
    mirror besides, about shade's coat_normal. albedo is the integral of both, to 0.003.
    """

class TracedFlakes(TypedDict):
    count: NDArray[np.float64]  # (n,): sparkles
    radiance: NDArray[np.float64]  # (n, 3): T, per unit irradiance normal to the light, 1/sr
    flakes: float  # traced in all pixels
    sparkles: NDArray[np.float64]  # (3,): sum of count for each species
    mean_share: NDArray[np.float64]  # (3,): E[s] over all sparkles, the share that shadowing leaves
    mean_square_share: NDArray[np.float64]  # (3,): E[s^2]

def explicit_flakes(
    paint: Paint,
    view: ArrayLike,
    light: ArrayLike,
    light_radius: float,
    footprint: float,
    pixels: int,
    *,
    shadowing: Literal["none", "attenuated", "thinned", "discs"] = "discs",
    points: int = 16,
    seed: int = 0,
) -> TracedFlakes: ...
def flake_brdf(
    paint: Paint, normal: ArrayLike, view: ArrayLike, light: ArrayLike
) -> NDArray[np.float64]: ...

class Mixture(TypedDict):
    diffuse: NDArray[np.float64]  # (..., 3): albedo of the diffuse lobe
    glossy: NDArray[np.float64]  # (..., 3): of the lobe about the mirror direction
    returned: NDArray[np.float64]  # (..., 3): of the lobe about the view
    alpha: NDArray[np.float64]  # (...): roughness of the glossy lobe
    exponent: NDArray[np.float64]  # (...): of the returning lobe
    above: NDArray[np.float64]  # (...): its share above the surface

def mixture(paint: Paint, substrate: ArrayLike, cos_view: ArrayLike) -> Mixture: ...
def white_noise(position: ArrayLike, w: ArrayLike) -> NDArray[np.float64]: ...
def count_deviate(mean: ArrayLike, slots: ArrayLike, uniform: ArrayLike) -> NDArray[np.float64]: ...
def normal_quantile(probability: ArrayLike) -> NDArray[np.float64]: ...
def fresnel_transmittance(cos_theta: ArrayLike, eta: ArrayLike) -> NDArray[np.float64]: ...
def orientation_density(paint: Paint, beta: ArrayLike) -> NDArray[np.float64]: ...
def pixel_texture(
    contrast: float,
    footprint: ArrayLike,
    x: ArrayLike,
    y: ArrayLike,
    *,
    frame: int = 0,
    seed: int = 0,
) -> NDArray[np.float32]: ...
def mean_projected_area(paint: Paint, cos_theta: ArrayLike) -> NDArray[np.float64]: ...
def library_coating(
    coating: ArrayLike, coating_nm: ArrayLike, cos_alpha: ArrayLike
) -> NDArray[np.float32]: ...

class Walk(TypedDict):
    """Shares of the flux that falls on the surface, RGB, each with its standard error."""

    specular: float  # mirrored by the surface
    albedo: NDArray[np.float64]  # (3,): comes back, without the specular; the sum of the next three
    albedo_error: NDArray[np.float64]
    albedo_single_flake: NDArray[np.float64]  # (3,)
    albedo_single_flake_error: NDArray[np.float64]
    albedo_substrate: NDArray[np.float64]  # (3,)
    albedo_substrate_error: NDArray[np.float64]
    albedo_mixture: NDArray[np.float64]  # (3,)
    albedo_mixture_error: NDArray[np.float64]
    absorbed: NDArray[np.float64]  # (3,)
    absorbed_error: NDArray[np.float64]
    truncated: NDArray[np.float64]  # (3,): still under way after 1e6 scatterings
    truncated_error: NDArray[np.float64]
    truncated_walks: int
    brdf: NDArray[np.float64]  # (n, 3): 1/sr, towards each detector; the sum of the next three
    brdf_error: NDArray[np.float64]
    brdf_single_flake: NDArray[np.float64]  # (n, 3)
    brdf_single_flake_error: NDArray[np.float64]
    brdf_substrate: NDArray[np.float64]  # (n, 3)
    brdf_substrate_error: NDArray[np.float64]
    brdf_mixture: NDArray[np.float64]  # (n, 3)
    brdf_mixture_error: NDArray[np.float64]
    bins: NDArray[np.float64]  # (theta_bins, phi_bins, 3): comes back into each bin
    bins_error: NDArray[np.float64]

def random_walk(
    paint: Paint,
    light: ArrayLike,
    *,
    substrate: ArrayLike = (0.8, 0.8, 0.8),
    detectors: ArrayLike | None = None,
    photons: int = 1_000_000,
    theta_bins: int = 0,
    phi_bins: int = 0,
    seed: int = 0,
) -> Walk: ...
