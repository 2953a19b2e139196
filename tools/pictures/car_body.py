# SPDX-License-Identifier: Apache-2.0
"""The body of the demo's car, a coupé: one smooth function of space, and the mesh of its zero set.

The function is the soft maximum of what bounds a car: its side by height and length, its top by
length and width, nose, tail and floor; likewise the greenhouse, and a soft minimum joins both. A
grid finds the faces; then each vertex is moved onto the surface exactly and given the exact normal,
so reflections are as smooth as the function.

Metres; the nose points to +X, the left side to +Y, the ground is z = 0.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pictures.shapes import Array, spline, unit

AXLES = (1.29, -1.24)  # x of the front and rear wheels
WHEEL_RADIUS = 0.338
ARCH_RADIUS = 0.366
WELL_DEPTH = 0.55  # y where it ends
LOWEST = 0.15  # of the floor
CELL = 0.0115  # of the grid that finds the body's faces

ROOF = (
    0.80, 0.86, 0.915, 0.985, 1.05, 1.11, 1.165, 1.21, 1.245, 1.265, 1.272, 1.262, 1.205, 1.105,
    1.0, 0.895, 0.79, 0.68,
)  # fmt: skip
HOUSE_WIDTH = (
    0.46, 0.53, 0.59, 0.64, 0.68, 0.71, 0.73, 0.745, 0.755, 0.758, 0.76, 0.758, 0.75, 0.74, 0.725,
    0.70, 0.67, 0.63,
)  # fmt: skip
HULL_TOP = (0.87, 0.905, 0.92, 0.92, 0.905, 0.895, 0.89, 0.88, 0.85, 0.785, 0.70, 0.58)
HULL_WIDTH = (0.70, 0.80, 0.855, 0.865, 0.85, 0.845, 0.85, 0.86, 0.865, 0.85, 0.79, 0.69)


def soft_max(a: Array, b: Array, k: float | Array) -> Array:
    """The maximum with a fillet of a radius of about k."""
    return np.maximum(a, b) + k * np.log1p(np.exp(-np.abs(a - b) / k))


def soft_min(a: Array, b: Array, k: float | Array) -> Array:
    return -soft_max(-a, -b, k)


def ramp(x: Array, k: float) -> Array:
    """The soft maximum of x and 0."""
    return soft_max(x, 0 * x, k)


def bump(x: Array, width: float) -> Array:
    return np.exp(-((x / width) ** 2))


def crease(x: Array) -> Array:
    """The height of the line along the side at which it leans inwards."""
    return 0.715 + 0.022 * np.tanh((0.3 - x) / 0.9)


def hull(x: Array, y: Array, z: Array) -> Array:
    """From the sill to the waist; y is at the left."""
    half_width = spline(x, -2.2, 2.2, HULL_WIDTH)
    half_width = half_width - 0.40 * ramp(z - crease(x), 0.008)  # leans inwards above
    half_width = half_width - 0.6 * ramp(0.29 - z, 0.02)  # and below the sill
    door = np.exp(-(((x - 0.02) / 0.78) ** 6))
    half_width = half_width - 0.036 * door * bump(z - 0.46, 0.11)
    for axle, flare in zip(AXLES, (0.046, 0.066), strict=True):
        r = np.hypot(x - axle, 1.15 * (z - WHEEL_RADIUS))
        half_width = half_width + flare * bump(np.maximum(r - 0.30, 0), 0.19)
    side = y - half_width

    top = spline(x, -2.2, 2.2, HULL_TOP) + 0.22 * ramp(-1.84 - x, 0.035)  # a lip at the tail
    crest = 0.050 * bump(x - 1.32, 0.55) + 0.040 * bump(x + 1.22, 0.50)
    top = top + crest * bump(y - 0.68, 0.17) - 0.03 * bump(x - 1.3, 0.6) * (y / 0.5) ** 2
    line = 0.40 - 0.06 * (x - 0.8)  # two folds along the bonnet
    top = top + 0.016 * bump(x - 1.25, 0.55) * np.tanh((line - y) / 0.03)
    body = soft_max(side, z - top, 0.026)

    nose = 2.16 - 0.17 * (y / 0.8) ** 2 - 0.15 * (y / 0.8) ** 4
    nose = nose - 0.62 * ramp(z - 0.50, 0.03) - 0.35 * ramp(0.28 - z, 0.02)
    body = soft_max(body, x - nose, 0.034)
    tail = 2.08 - 0.10 * (y / 0.8) ** 2 - 0.09 * (y / 0.8) ** 4
    tail = tail + 0.045 * bump(z - 0.46, 0.13) + 0.05 * bump(z - 0.93, 0.09)
    return soft_max(body, -x - tail, 0.017)


def roof(x: Array, y: Array) -> Array:
    """The height of the greenhouse: screens and roof, bent about the vertical and along y."""
    front = 1 / (1 + np.exp(-(x + 0.4) / 0.15))
    bent = x + (0.24 * front - 0.16 * (1 - front)) * y * y
    return spline(bent, -2.2, 1.2, ROOF) - 0.07 * y * y


def house(x: Array, y: Array, z: Array) -> Array:
    """The greenhouse: a fastback."""
    half_width = spline(x, -2.2, 1.2, HOUSE_WIDTH) - 0.40 * (z - 0.9) - 0.3 * (z - 0.9) ** 2
    body = soft_max(0.92 * (y - half_width), 0.9 * (z - roof(x, y)), 0.022)
    return np.maximum(body, np.maximum(np.abs(x + 0.45) - 1.5, 0.7 - z))  # ends within the hull


def shell(x: Array, y: Array, z: Array) -> Array:
    """The car without what is cut from it or stands off: negative inside, metres."""
    y = np.sqrt(y * y + 1e-4)  # |y| without its kink
    # A crisp joint below the windows, a wide one behind them.
    joint = 0.009 + 0.05 / (1 + np.exp((x + 1.25) / 0.12))
    body = soft_min(hull(x, y, z), house(x, y, z), joint)
    return soft_max(body, LOWEST - z, 0.012)


def solid(x: Array, y: Array, z: Array) -> Array:
    """The shell with mirrors and wheel arches."""
    body = shell(x, y, z)
    y = np.abs(y)
    cap = 0.06 * (np.sqrt(((x - 0.53) / 0.085) ** 2 + ((y - 0.905) / 0.108) ** 2
                          + ((z - 0.985) / 0.062) ** 2) - 1)  # fmt: skip
    cap = soft_max(cap, 0.480 - x, 0.005)  # flat behind, where the glass is
    t = np.clip((y - 0.74) / 0.12, 0, 1)
    arm = np.hypot(np.hypot((x - 0.56) / 1.6, z - 0.895 - 0.07 * t), y - 0.74 - 0.12 * t) - 0.019
    body = soft_min(body, soft_min(cap, arm, 0.008), 0.006)
    for axle in AXLES:
        r = np.hypot(x - axle, z - WHEEL_RADIUS)
        body = body - 0.010 * bump(r - ARCH_RADIUS, 0.03) * (y > WELL_DEPTH)
        well = -soft_max(r - ARCH_RADIUS, WELL_DEPTH - y, 0.01)
        body = soft_max(body, well, 0.009)  # wide enough for the cells
    return body


def gradient(
    p: Array, function: Callable[[Array, Array, Array], Array] = solid
) -> tuple[Array, Array]:
    """Value and gradient of the function at points (n, 3), from the corners of a tetrahedron."""
    corners = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    h = 1e-4
    values = np.array([function(*(p + h * c).T) for c in corners])
    return values.mean(0), values.T @ corners / (4 * h)


def mesh() -> tuple[Array, Array, Array]:
    """Vertices, quads and normals of solid()'s surface: surface nets, relaxed along the surface."""
    ny = int(1.10 / CELL)
    axes = (
        np.arange(-2.3, 2.3, CELL),
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

    # Newton's steps on the left half; the other is its mirror image.
    left = np.flatnonzero(points[:, 1] > 0)
    right = index[:, ::-1][mixed][left]
    for step in range(5):
        if step in (1, 2, 3):
            total = np.zeros_like(points)
            for a in range(4):
                for d in range(3):
                    total[:, d] += np.bincount(
                        faces[:, a],
                        points[faces[:, a - 1], d] + points[faces[:, a - 3], d],
                        len(points),
                    )
            points = total / (2 * np.bincount(faces.ravel(), minlength=len(points))[:, None])
        value, g = gradient(points[left])
        move = np.clip(value / (g * g).sum(1), -CELL, CELL)
        points[left] -= move[:, None] * g
        points[right] = points[left] * (1, -1, 1)
    normals = np.empty_like(points)
    normals[left] = unit(gradient(points[left])[1])
    normals[right] = normals[left] * (1, -1, 1)
    return points, faces, normals


def in_lining(points: Array) -> Array:
    """Whether the surface there is not painted: the floor, and wheel arches behind their lips."""
    x, y, z = points.T
    return (z < LOWEST + 0.012) | (shell(x, y, z) < -0.03)


def projected(points: Array, axis: int, near: float, far: float, lift: float = 0) -> Array:
    """Points (..., 3) moved along an axis onto the shell, then `lift` along its normal.

    The surface is sought from near, a place within, to far, one without.
    """
    p = np.array(points, float).reshape(-1, 3)
    inside, outside = np.full(len(p), near), np.full(len(p), far)
    for _ in range(40):
        p[:, axis] = (inside + outside) / 2
        within = shell(*p.T) < 0
        inside = np.where(within, p[:, axis], inside)
        outside = np.where(within, outside, p[:, axis])
    p = p + lift * unit(gradient(p, shell)[1])
    return p.reshape(np.shape(points))
