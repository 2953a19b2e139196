# SPDX-License-Identifier: Apache-2.0
"""The demo subject, a small coupé of the sixties in curves that show paint, and its studio.

The body is the zero set of one smooth function of space, solid(): super-elliptic sections along
splines, blended by a soft minimum, the wheel arches cut by a soft maximum. A grid finds the faces;
then each vertex is moved onto the surface exactly and given the exact normal, so reflections are
as smooth as the function. Glass, lamps and trim are outlines projected onto the same function.

Metres; the nose points to +X, the left side to +Y, the ground is z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

Array = NDArray[np.float64]

HALF_LENGTH = 2.08
AXLES = (1.27, -1.16)  # x of the front and rear wheels
WHEEL_RADIUS = 0.315
TRACK = 0.70  # y of a wheel's middle
ARCH_RADIUS = 0.365
CELL = 0.013  # of the grid that finds the body's faces


# ---- The body as a function of space: negative inside, about the distance in metres ----


def spline(x: Array, first: float, last: float, controls: Sequence[float]) -> Array:
    """The uniform cubic B-spline with these controls at even steps of x: no wiggles, C2."""
    c = np.array([2 * controls[0] - controls[1], *controls, 2 * controls[-1] - controls[-2]])
    u = np.clip((x - first) / (last - first), 0, 1) * (len(controls) - 1)
    i = np.minimum(u.astype(int), len(controls) - 2)
    t = u - i
    return (
        c[i] * (1 - t) ** 3
        + c[i + 1] * (3 * t**3 - 6 * t**2 + 4)
        + c[i + 2] * (1 + 3 * (t + t**2 - t**3))
        + c[i + 3] * t**3
    ) / 6


def norm(p: float, *terms: Array) -> Array:
    """The p-norm, whose unit ball is a super-ellipsoid."""
    return sum(np.abs(t) ** p for t in terms) ** (1 / p)


def union(a: Array, b: Array, k: float) -> Array:
    """The smooth minimum; k is about the radius of the fillet."""
    return np.minimum(a, b) - k * np.log1p(np.exp(-np.abs(a - b) / k))


def solid(x: Array, y: Array, z: Array) -> Array:
    """The car's body with its greenhouse."""
    y = np.sqrt(y * y + 1e-4)  # |y| without its kink
    # Hull: from sill to waist.
    half_width = spline(x, -2.1, 2.1, (0.66, 0.76, 0.80, 0.79, 0.79, 0.80, 0.76, 0.66))
    top = spline(x, -2.1, 2.1, (0.62, 0.80, 0.89, 0.91, 0.91, 0.86, 0.76, 0.62))
    middle = 0.50
    height = np.where(z > middle, top - middle, 0.38)
    section = norm(2.5, y / half_width, (z - middle) / height)
    body = 0.5 * (norm(4.5, section, x / HALF_LENGTH) - 1)
    # Fenders: the front ones carry the head lamps.
    behind = np.where(x > 1.15, 0.83, 1.5)
    front = norm(2.4, (x - 1.15) / behind, (y - 0.59) / 0.19, (z - 0.54) / 0.28)
    rear = norm(2.4, (x + 1.12) / 0.95, (y - 0.58) / 0.25, (z - 0.56) / 0.27)
    body = union(body, 0.2 * (front - 1), 0.03)
    body = union(body, 0.2 * (rear - 1), 0.04)
    # Greenhouse: a fastback.
    roof = spline(x, -2.2, 1.2, (0.45, 0.70, 0.93, 1.09, 1.20, 1.26, 1.27, 1.15, 0.80, 0.45))
    half_width = spline(x, -2.2, 1.2, (0.36, 0.50, 0.58, 0.64, 0.67, 0.68, 0.67, 0.65, 0.62, 0.55))
    house = norm(2.7, y / half_width, (z - 0.55) / np.maximum(roof - 0.55, 0.01))
    house = norm(8, house, (x + 0.45) / 1.6)
    body = union(body, 0.35 * (house - 1), 0.02)
    # Floor and wheel arches with their lips.
    body = -union(-body, z - 0.19, 0.012)
    for axle in AXLES:
        r = np.hypot(x - axle, z - WHEEL_RADIUS)
        body = body - 0.018 * np.exp(-(((r - ARCH_RADIUS) / 0.05) ** 2))
        well = -union(ARCH_RADIUS - r, y - 0.48, 0.01)
        body = -union(-body, well, 0.006)
    return body


def gradient(p: Array) -> tuple[Array, Array]:
    """Value and gradient of solid() at points (n, 3), from the corners of a tetrahedron."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    h = 1e-4
    values = np.array([solid(*(p + h * c).T) for c in corners])
    return values.mean(0), values.T @ corners / (4 * h)


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def body_mesh() -> tuple[Array, Array]:
    """Vertices and quads of solid()'s surface: surface nets, relaxed along the surface."""
    ny = int(0.95 / CELL)
    axes = (
        np.arange(-2.2, 2.2, CELL),
        np.arange(-ny, ny + 1) * CELL,
        np.arange(0.1, 1.4, CELL),
    )
    half = solid(axes[0][:, None, None], axes[1][None, ny:, None], axes[2][None, None, :])
    inside = np.concatenate([half[:, :0:-1], half], axis=1) < 0

    # One vertex in each cell that has corners on both sides.
    count = sum(
        inside[i : i - 1 or None, j : j - 1 or None, k : k - 1 or None].astype(np.int8)
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    )
    mixed = (count > 0) & (count < 8)
    index = np.full(mixed.shape, -1)
    index[mixed] = np.arange(mixed.sum())
    points = np.stack([a[i] for a, i in zip(axes, np.nonzero(mixed), strict=True)], 1) + CELL / 2

    # One quad across each grid edge whose ends differ.
    quads = []
    for axis in range(3):
        s = np.moveaxis(inside, axis, 0)
        n = np.moveaxis(index, axis, 0)
        i, j, k = np.nonzero(s[1:] != s[:-1])
        quad = np.stack([n[i, j - 1, k - 1], n[i, j, k - 1], n[i, j, k], n[i, j - 1, k]], 1)
        flip = s[i, j, k] ^ (axis == 1)
        quad[~flip] = quad[~flip, ::-1]
        quads.append(quad)
    faces = np.concatenate(quads)

    for step in range(5):
        if step:
            total = np.zeros_like(points)
            for a in range(4):
                for d in range(3):
                    total[:, d] += np.bincount(
                        faces[:, a],
                        points[faces[:, a - 1], d] + points[faces[:, a - 3], d],
                        len(points),
                    )
            points = total / (2 * np.bincount(faces.ravel(), minlength=len(points))[:, None])
        for _ in range(2):
            value, g = gradient(points)
            points = points - (value / (g * g).sum(1))[:, None] * g
    return points, faces
