# SPDX-License-Identifier: Apache-2.0
"""What a stack of plane, homogeneous films reflects and lets through, by characteristic matrices.

M. Born and E. Wolf, Principles of Optics, section 1.6: for fields exp(-i omega t) and indices
n + ik the tangential fields (U, V) on both sides of a film obey U = cos d U' - i sin d / q V' and
V = -i q sin d U' + cos d V', where d = 2 pi h n cos(theta) / lambda, and q = n cos(theta) for the
wave with E normal to the plane of incidence and cos(theta) / n for the other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Film = tuple[ArrayLike, float]  # complex index (at each wavelength), thickness in nm

OPAQUE = 50.0  # deeper than this phase nothing returns to double's precision: exp(-2 * 50) = 4e-44
GRAZING = 1e-9  # least cosine: at 0 the matrices say 0/0, and the limit is met to 1e-8


def reflect_and_transmit(
    films: Sequence[Film], medium: float, wavelength_nm: ArrayLike, cosine: ArrayLike
) -> tuple[Array, Array]:
    """R and T, (wavelengths, cosines), unpolarised, between two half spaces of index `medium`."""
    if not 1 <= medium <= 4:
        raise ValueError(f"index of the medium is {medium}, but must be from 1 to 4")
    for index, thickness in films:
        if not 0 <= thickness <= 1e6:
            raise ValueError(f"thickness of a film is {thickness}, but must be from 0 to 1e6 nm")
        if not np.all((np.imag(index) >= 0) & (np.abs(index) >= 0.01) & (np.abs(index) <= 100)):
            raise ValueError(
                f"index of a film is {index}, but must be from 0.01 to 100, with k >= 0"
            )
    wavelength = np.asarray(wavelength_nm, dtype=float)[:, np.newaxis]
    cosine = np.clip(np.asarray(cosine, dtype=float), GRAZING, 1)
    waves = [_one_wave(films, medium, wavelength, cosine, parallel) for parallel in (False, True)]
    (r_s, t_s), (r_p, t_p) = waves
    return (r_s + r_p) / 2, (t_s + t_p) / 2


def _one_wave(
    films: Sequence[Film], medium: float, wavelength: Array, cosine: Array, parallel: bool
) -> tuple[Array, Array]:
    outside = cosine / medium if parallel else medium * cosine
    u, v = np.ones_like(wavelength * cosine, dtype=complex), outside + 0j
    for index, thickness in reversed(films):
        square = (np.asarray(index, dtype=complex) ** 2).reshape(-1, 1)
        # Snell: (n cos)^2 = n^2 - m^2 sin^2, written so that a film of the medium's index is exact.
        normal_square = square - medium**2 + (medium * cosine) ** 2
        normal = np.sqrt(normal_square)
        path = 2 * np.pi * thickness / wavelength
        path = np.minimum(path, OPAQUE / np.maximum(normal.imag, 1e-9))
        phase = path * normal
        # sin(d) / (n cos), also where n cos vanishes: the critical angle.
        sine = path * np.sinc(phase / np.pi)
        weight = square if parallel else 1.0
        u, v = (
            np.cos(phase) * u - 1j * sine * weight * v,
            -1j * sine * normal_square / weight * u + np.cos(phase) * v,
        )
    # Equal media on both sides: no factor of their admittances in T.
    denominator = outside * u + v
    reflectance = np.abs((outside * u - v) / denominator) ** 2
    transmittance = np.abs(2 * outside / denominator) ** 2
    return reflectance, transmittance
