# SPDX-License-Identifier: Apache-2.0
"""The demo's car: the body with glass, lamps, shut lines, trim and wheels.

All that lies on the body is a curve or a patch in a view from the side, from above or from the
front, projected onto it.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from pictures import car_body, car_cabin
from pictures.car_body import AXLES, WHEEL_RADIUS, projected
from pictures.shapes import (
    Array,
    add_grid,
    add_mesh,
    glass_material,
    lathe,
    loft,
    plain_material,
    rounded,
    smooth_curve,
    unit,
)

TRACK = (0.775, 0.785)  # y of the wheels' middles
BELT = 0.935  # height of the side windows' lower edge


def build_car(scene: bpy.types.Scene) -> bpy.types.Object:
    """Adds the car, 4.3 m long, with all its parts; returns the body, unpainted."""
    points, faces, normals = car_body.mesh()
    lined = car_body.in_lining(points)[faces].all(1)
    glazed = behind_glass(points[faces].mean(1), normals[faces].mean(1))
    painted = ~lined & ~glazed
    # Seen through the glass: pillars and roof from within.
    trimmed = painted & (points[faces, 2].min(1) > BELT - 0.03)
    body = None
    for name, some, lift in (
        ("Lining", lined, 0), ("Headlining", trimmed, -0.012), ("Body", painted, 0)
    ):  # fmt: skip
        used, corners = np.unique(faces[some], return_inverse=True)
        where = points[used] + lift * normals[used]
        body = add_mesh(scene, name, where, corners.reshape(-1, 4), None)
        body.data.normals_split_custom_set_from_vertices(normals[used])
    parts = Parts(scene)
    for name in ("Lining", "Headlining"):
        scene.objects[name].data.materials.append(parts.black)
    car_cabin.build(scene)
    parts.add_glass()
    parts.add_shut_lines()
    parts.add_face()
    parts.add_tail()
    parts.add_trim()
    for axle, track in zip(AXLES, TRACK, strict=True):
        for side in (1, -1):
            parts.add_wheel(axle, side * track)
    return body


def behind_glass(places: Array, normals: Array) -> Array:
    """Whether the body is cut out there, for a window or a screen."""
    x, y, z = places.T
    upper = z > BELT - 0.1
    side = smooth_curve(SIDE_WINDOW, 240, closed=True)
    cut = upper & (np.abs(normals[:, 1]) > 0.5) & _within(side, x, z)
    for corners in (WINDSCREEN, REAR_WINDOW):
        cut |= upper & (np.abs(normals[:, 1]) < 0.7) & _within(_rounded_outline(corners), x, y)
    return cut


class Parts:
    """What is mounted on the body, each of one plain material."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        self.scene = scene
        self.glass = glass_material("Glass", (0.55, 0.60, 0.60))
        self.lamp = plain_material("Lamp glass", (0.006, 0.007, 0.008), roughness=0.01)
        self.black = plain_material("Black plastic", (0.006, 0.006, 0.006), roughness=0.4)
        self.gap = plain_material("Gap", (0.0015, 0.0015, 0.0015), roughness=0.9, mirrors=False)
        self.chrome = plain_material("Chrome", (0.75, 0.76, 0.78), roughness=0.06, metallic=1)
        self.alloy = plain_material("Alloy", (0.52, 0.53, 0.55), roughness=0.22, metallic=1)
        self.steel = plain_material("Steel", (0.35, 0.34, 0.33), roughness=0.35, metallic=1)
        self.rubber = plain_material("Rubber", (0.011, 0.011, 0.011), roughness=0.55)
        self.caliper = plain_material("Caliper", (0.55, 0.02, 0.01), roughness=0.25)
        self.light = plain_material("Daytime light", (0.9, 0.95, 1.0), roughness=0.3, glow=5)
        self.lens = plain_material("Lens", (0.30, 0.33, 0.36), roughness=0.03, metallic=1)
        self.red = plain_material("Tail lamp", (0.35, 0.004, 0.004), roughness=0.05)
        self.glow = plain_material("Tail light", (1.0, 0.03, 0.015), roughness=0.3, glow=2.5)

    # ---- On the body ----

    def strip(
        self, name: str, line: Array, axis: int, near: float, far: float, width: float,
        height: float, surface: bpy.types.Material, *, closed: bool = False,
    ) -> None:  # fmt: skip
        """A rounded strip along a line that is projected onto the body."""
        line = projected(line, axis, near, far)
        normal = unit(car_body.gradient(line, car_body.shell)[1])
        if closed:
            forward = np.roll(line, -1, 0) - np.roll(line, 1, 0)
        else:
            forward = np.gradient(line, axis=0)
        across = unit(np.cross(forward, normal))
        u = np.linspace(-1, 1, 7)[:, None, None]
        grid = line + u * width / 2 * across + (0.0004 + height * (1 - u**4)) * normal
        add_grid(self.scene, name, grid.swapaxes(0, 1), surface, closed=(closed, False))

    def patch(
        self, name: str, grid: Array, axis: int, near: float, far: float, lift: float,
        surface: bpy.types.Material,
    ) -> None:  # fmt: skip
        """A grid of points projected onto the body, a little proud of it."""
        add_grid(self.scene, name, projected(grid, axis, near, far, lift), surface)

    def add_pane(
        self, name: str, outline: Array, axis: int, near: float, far: float, trim: bool = False
    ) -> None:
        """Glass within an outline (n, 3) that runs there and back: its halves face one another."""
        half = len(outline) // 2
        there, back = outline[:half], outline[half:][::-1]
        t = np.linspace(0, 1, 40)[None, :, None]
        grid = there[:, None] * (1 - t) + back[:, None] * t
        self.patch(name, grid, axis, near, far, 0.002, self.glass)
        self.strip(f"{name} seal", outline, axis, near, far, 0.022, 0.004, self.black, closed=True)
        if trim:
            self.strip(
                f"{name} trim", outline, axis, near, far, 0.010, 0.0065, self.chrome, closed=True
            )

    def add_glass(self) -> None:
        for side in (1, -1):
            line = smooth_curve(SIDE_WINDOW, 240, closed=True)
            outline = np.stack([line[:, 0], 0 * line[:, 0], line[:, 1]], -1)
            # Its halves meet at its ends.
            first, last = np.argmax(line[:, 0]), np.argmin(line[:, 0])
            outline = _from_end_to_end(outline, first, last)
            self.add_pane("Window", outline, 1, 0, side * 1.2, trim=True)
            pillar = smooth_curve([(-0.60, 0.90), (-0.66, 1.0), (-0.76, 1.16)], 30)
            x, z = pillar.T
            z = np.clip(z, BELT, None)
            line = np.stack([x, 0 * x, z], -1)
            self.strip("Pillar", line, 1, 0, side * 1.2, 0.045, 0.0035, self.black)
        for name, corners in (("Windscreen", WINDSCREEN), ("Rear window", REAR_WINDOW)):
            line = _rounded_outline(corners)
            outline = np.stack([*line.T, 0 * line[:, 0]], -1)
            self.add_pane(name, outline, 2, 0.75, 1.5)
        # The scuttle: dark between bonnet and screen, with wipers.
        y = np.linspace(-0.60, 0.60, 80)
        line = np.stack([0.845 - 0.24 * y * y, y, 0 * y], -1)
        self.strip("Scuttle", line, 2, 0.6, 1.5, 0.055, 0.003, self.black)
        for start, end in ((-0.08, 0.42), (-0.52, -0.02)):
            y = np.linspace(start, end, 30)
            x = 0.775 - 0.24 * y * y - 0.05 * (y - start)
            self.strip("Wiper", np.stack([x, y, 0 * y], -1), 2, 0.75, 1.5, 0.014, 0.016, self.black)

    def add_shut_lines(self) -> None:
        def line(
            controls: Sequence[Sequence[float]], axis: int, near: float, far: float,
            width: float = 0.0055, closed: bool = False,
        ) -> None:  # fmt: skip
            a, b = smooth_curve(controls, 200, closed=closed).T
            columns = [[0 * a, a, b], [a, 0 * a, b], [a, b, 0 * a]][axis]
            points = np.stack(columns, -1)
            self.strip("Shut line", points, axis, near, far, width, 0.0003, self.gap, closed=closed)

        for side in (1, -1):
            line(DOOR, 1, 0, side * 1.3)
            line(FUEL_FLAP if side > 0 else FUEL_FLAP[::-1], 1, 0, side * 1.3, 0.003, True)
            line(FRONT_BUMPER, 1, 0, side * 1.3)
            line(REAR_BUMPER, 1, 0, side * 1.3)
            line([(x, side * y) for x, y in BONNET_SIDE], 2, 0.4, 1.5)
            # The handle, flush in its recess.
            x = np.linspace(-0.44, -0.27, 40)
            handle = np.stack([x, 0 * x, 0.785 - 0.02 * x], -1)
            self.strip("Recess", handle, 1, 0, side * 1.3, 0.036, 0.0006, self.gap)
            self.strip("Handle", handle, 1, 0, side * 1.3, 0.020, 0.009, self.chrome)
        line(BONNET_FRONT, 2, 0.3, 1.5)
        line(BOOT, 2, 0.5, 1.5)

    def add_face(self) -> None:
        for side in (1, -1):
            # A dark housing, a ring of light and two lenses under glass.
            s, t = rounded(64, 2.4)
            y, z = _slanted(side, s, t, 1.0)
            self.patch("Head lamp", np.stack([0 * y, y, z], -1), 0, 1.2, 2.4, 0.002, self.lamp)
            angle = np.linspace(0, 2 * np.pi, 160, endpoint=False)
            y, z = _slanted(side, np.cos(angle), np.sin(angle), 1.0)
            ring = np.stack([0 * y, y, z], -1)
            self.strip("Lamp's rim", ring, 0, 1.2, 2.4, 0.010, 0.004, self.black, closed=True)
            bow = np.linspace(0.10, 0.86, 80) * np.pi
            y, z = _slanted(side, np.cos(bow), np.sin(bow), 0.80)
            line = np.stack([0 * y, y, z], -1)
            self.strip("Daytime light", line, 0, 1.2, 2.4, 0.009, 0.005, self.light)
            for s0 in (-0.36, 0.30):
                for size, width, surface in (
                    (0.036, 0.007, self.chrome),
                    (0.014, 0.024, self.lens),
                ):
                    y, z = _slanted(side, s0 + 0 * angle, -0.10 + 0 * angle, 1)
                    y, z = y + size * np.cos(angle), z + size * np.sin(angle)
                    ring = np.stack([0 * y, y, z], -1)
                    self.strip("Lens", ring, 0, 1.2, 2.4, width, 0.004, surface, closed=True)
            # Side intake of the bumper.
            s, t = rounded(48, 3)
            grid = np.stack([0 * s, side * (0.655 + 0.095 * s), 0.325 + 0.055 * t + 0.02 * s], -1)
            self.patch("Intake", grid, 0, 1.2, 2.4, 0.002, self.gap)
        s, t = rounded(80, 4)
        grid = np.stack([0 * s, 0.47 * s, 0.335 + t * (0.085 - 0.02 * s * s)], -1)
        self.patch("Grille", grid, 0, 1.2, 2.4, 0.002, self.gap)
        for dz in (-0.042, 0.0, 0.042):
            y = np.linspace(-0.44, 0.44, 60)
            z = 0.335 + dz * (1 - 0.25 * (y / 0.47) ** 2)
            self.strip("Bar", np.stack([0 * y, y, z], -1), 0, 1.2, 2.4, 0.009, 0.006, self.black)
        angle = np.linspace(0, 2 * np.pi, 240, endpoint=False)
        c, s = (np.sign(v) * np.abs(v) ** 0.5 for v in (np.cos(angle), np.sin(angle)))
        rim = np.stack([0 * c, 0.47 * c, 0.335 + s * (0.085 - 0.02 * c * c)], -1)
        self.strip("Grille's rim", rim, 0, 1.2, 2.4, 0.012, 0.005, self.black, closed=True)
        y = np.linspace(-0.64, 0.64, 80)
        lip = np.stack([0 * y, y, 0.198 + 0.012 * (y / 0.7) ** 2], -1)
        self.strip("Splitter", lip, 0, 1.2, 2.4, 0.045, 0.030, self.black)
        badge = np.stack([0 * angle, 0.030 * np.cos(angle), 0.55 + 0.030 * np.sin(angle)], -1)
        self.strip("Badge", badge, 0, 1.2, 2.4, 0.006, 0.003, self.chrome, closed=True)

    def add_tail(self) -> None:
        y = np.linspace(-0.70, 0.70, 160)
        band = np.stack([0 * y, y, 0.775 - 0.015 * (y / 0.7) ** 2], -1)
        self.strip("Tail lamp", band, 0, -1.2, -2.4, 0.075, 0.008, self.red)
        self.strip("Tail light", band, 0, -1.2, -2.4, 0.014, 0.0115, self.glow)
        s, t = rounded(64, 5)
        plate = np.stack([0 * s, 0.27 * s, 0.56 + 0.065 * t], -1)
        self.patch("Plate", plate, 0, -1.2, -2.4, 0.002, self.black)
        diffuser = np.stack([0 * s, 0.62 * s, 0.265 + 0.075 * t], -1)
        self.patch("Diffuser", diffuser, 0, -1.2, -2.4, 0.002, self.black)
        for side in (1, -1):
            pipe = lathe([(0.030, -0.12), (0.036, -0.12), (0.043, 0.02), (0.040, 0.024),
                          (0.036, 0.018), (0.034, -0.1), (0, -0.1)], 48)  # fmt: skip
            pipe = np.stack([-pipe[..., 1], pipe[..., 0], pipe[..., 2]], -1)
            pipe += np.array((-2.06, side * 0.47, 0.245))
            add_grid(self.scene, "Exhaust", pipe, self.chrome, closed=(False, True))

    def add_trim(self) -> None:
        for side in (1, -1):
            x = np.linspace(-0.86, 0.91, 120)
            sill = np.stack([x, 0 * x, 0.195 + 0 * x], -1)
            self.strip("Sill", sill, 1, 0, side * 1.3, 0.050, 0.016, self.black)
            # The mirror's glass, and the lamp that blinks.
            s, t = rounded(40, 2.6)
            glass = np.stack([0 * s + 0.476, side * (0.905 + 0.080 * s), 0.985 + 0.044 * t], -1)
            add_grid(self.scene, "Mirror", glass[:, ::side], self.chrome)

    # ---- Wheels ----

    def add_wheel(self, axle: float, track: float) -> None:
        side = np.sign(track)

        def add(name: str, grid: Array, surface: bpy.types.Material, closed: bool = True) -> None:
            """In the wheel's own space: y outwards from its middle."""
            grid = grid * (1, side, 1) + np.array((axle, track, WHEEL_RADIUS))
            add_grid(self.scene, name, grid[::-1] if side > 0 else grid, surface,
                     closed=(False, closed))  # fmt: skip

        r, half = WHEEL_RADIUS, 0.118
        tread = [(r - 0.004 * (u / 0.085) ** 4, u) for u in np.linspace(-0.085, 0.085, 9)]
        wall = [(r - 0.013, half - 0.020), (r - 0.030, half - 0.006), (r - 0.050, half),
                (r - 0.070, half - 0.004), (0.254, half - 0.013), (0.247, half - 0.02)]  # fmt: skip
        profile = [*((q, -h) for q, h in wall[::-1]), *tread, *wall]
        add("Tyre", lathe(_smoothed(profile, 90), 128), self.rubber)
        lip = [(0.225, half - 0.045), (0.236, half - 0.030), (0.240, half - 0.014),
               (0.246, half - 0.008), (0.252, half - 0.010), (0.252, half - 0.018)]  # fmt: skip
        add("Rim", lathe(_smoothed(lip, 40), 128), self.alloy)
        add("Barrel", lathe([(0.225, half - 0.045), (0.215, 0.0), (0.22, -0.1)], 96), self.steel)
        disc = [(0.06, 0.012), (0.085, 0.012), (0.09, 0.0), (0.178, 0.0), (0.180, -0.004),
                (0.180, -0.02), (0.09, -0.02)]  # fmt: skip
        add("Brake disc", lathe(disc, 96), self.steel)
        add("Well", lathe([(0.0, -0.03), (0.22, -0.03)], 48), self.gap)
        angle = np.linspace(0.62, 1.25, 14) * np.pi + (0 if axle > 0 else -0.87 * np.pi)
        arc = np.stack([0.150 * np.cos(angle), 0 * angle + 0.006, 0.150 * np.sin(angle)], -1)
        add("Caliper", loft(arc, 14 * [0.062], 14 * [0.058], (0, 1, 0)), self.caliper)

        # Five pairs of spokes, dished, from hub to rim.
        q = np.linspace(0.045, 0.240, 16)
        u = (q - q[0]) / (q[-1] - q[0])
        for k in range(5):
            for turn in (-1, 1):
                angle = 2 * np.pi * k / 5 + turn * (0.13 + 0.085 * u) + 0.5 * np.pi
                y = 0.060 + 0.040 * u**1.6
                along = np.stack([q * np.cos(angle), y, q * np.sin(angle)], -1)
                bar = loft(along, 0.036 - 0.008 * np.sin(np.pi * u), 0.032 - 0.006 * u, (0, 1, 0))
                add("Spoke", bar, self.alloy)
        hub = [(0.075, 0.02), (0.075, 0.055), (0.070, 0.066), (0.055, 0.070), (0.036, 0.071)]
        add("Hub", lathe(_smoothed(hub, 30), 64), self.alloy)
        cap = [(0.036, 0.069), (0.036, 0.076), (0.034, 0.080), (0.026, 0.082), (0.0, 0.0835)]
        add("Hub cap", lathe(cap, 64), self.black)
        add("Hub ring", lathe([(0.0365, 0.07), (0.0365, 0.079), (0.033, 0.081)], 64), self.chrome)
        for k in range(5):
            angle = 2 * np.pi * (k + 0.5) / 5 + 0.5 * np.pi
            bolt = lathe([(0.0085, 0.06), (0.0085, 0.076), (0.006, 0.079), (0, 0.079)], 6)
            place = np.array((0.055 * np.cos(angle), 0, 0.055 * np.sin(angle)))
            add("Bolt", bolt + place, self.chrome)


def _from_end_to_end(outline: Array, first: int, last: int) -> Array:
    """The closed outline anew: as many points from its first end to its last as back."""
    turned = np.roll(outline, -first, 0)
    middle = (last - first) % len(outline)
    n = len(outline) // 2
    parts = (turned[: middle + 1], np.concatenate([turned[middle:], turned[:1]]))
    halves = []
    for part in parts:
        way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(part, axis=0), axis=1))])
        at = np.linspace(0, way[-1], n + 1)
        even = [np.interp(at, way, column) for column in part.T]
        halves.append(np.stack(even, -1)[:-1])
    return np.concatenate(halves)


def _within(outline: Array, x: Array, y: Array) -> Array:
    """Whether points lie in the polygon: a ray from each crosses it an odd number of times."""
    odd = np.zeros(len(x), bool)
    for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, 0), strict=True):
        if y0 != y1:
            odd ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
    return odd


def _rounded_outline(corners: Sequence[tuple[float, float]]) -> Array:
    """The outline (x, y) through the corners of its left half, mirrored, from end to end."""
    left = [*corners, *((x, -y) for x, y in corners[::-1])]
    line = smooth_curve(left, 240, closed=True)
    first, last = np.argmax(line[:, 1]), np.argmin(line[:, 1])
    return _from_end_to_end(line, int(first), int(last))


def _slanted(side: int, s: Array, t: Array, scale: float) -> tuple[Array, Array]:
    """y and z in the head lamp, an ellipse that rises outwards."""
    return side * (0.66 + 0.125 * scale * s), 0.665 + scale * (0.068 * t + 0.035 * s)


def _smoothed(profile: Sequence[tuple[float, float]], count: int) -> list[tuple[float, float]]:
    return [tuple(p) for p in smooth_curve(profile, count)]


# ---- Lines of the body, seen from the side (x, z) and from above (x, y) ----

SIDE_WINDOW = (
    (0.52, 0.928), (0.30, 0.925), (-0.10, 0.930), (-0.50, 0.935), (-0.90, 0.945), (-1.16, 0.955),
    (-1.36, 0.985), (-1.22, 1.05), (-0.95, 1.135), (-0.65, 1.19), (-0.35, 1.213), (-0.10, 1.205),
    (0.12, 1.15), (0.33, 1.055), (0.50, 0.970), (0.64, 0.920),
)  # fmt: skip
WINDSCREEN = (
    (0.80, 0.10), (0.775, 0.30), (0.72, 0.46), (0.66, 0.555), (0.60, 0.575), (0.45, 0.550),
    (0.25, 0.515), (0.03, 0.485), (-0.02, 0.44), (0.03, 0.30), (0.05, 0.10),
)  # fmt: skip
REAR_WINDOW = (
    (-0.82, 0.10), (-0.80, 0.30), (-0.78, 0.43), (-0.84, 0.475), (-1.00, 0.46), (-1.25, 0.42),
    (-1.50, 0.375), (-1.56, 0.32), (-1.58, 0.20), (-1.59, 0.10),
)  # fmt: skip
DOOR = (
    (0.66, 0.925), (0.70, 0.80), (0.74, 0.60), (0.75, 0.42), (0.735, 0.29), (0.66, 0.255),
    (0.50, 0.25), (0.10, 0.25), (-0.30, 0.25), (-0.42, 0.265), (-0.52, 0.35), (-0.60, 0.50),
    (-0.65, 0.65), (-0.66, 0.80), (-0.64, 0.92),
)  # fmt: skip
FUEL_FLAP = tuple(
    (-1.28 + 0.062 * np.cos(a), 0.80 + 0.055 * np.sin(a)) for a in np.arange(12) * np.pi / 6
)
FRONT_BUMPER = ((1.655, 0.42), (1.70, 0.50), (1.78, 0.575), (1.90, 0.60))
REAR_BUMPER = ((-1.60, 0.44), (-1.66, 0.52), (-1.76, 0.60), (-1.95, 0.64))
BONNET_SIDE = ((0.79, 0.70), (1.0, 0.665), (1.3, 0.60), (1.55, 0.55), (1.75, 0.50), (1.85, 0.43))
BONNET_FRONT = (
    (1.75, 0.50), (1.85, 0.43), (1.90, 0.33), (1.93, 0.15), (1.93, 0.0), (1.93, -0.15),
    (1.90, -0.33), (1.85, -0.43), (1.75, -0.50),
)  # fmt: skip
BOOT = (
    (-2.0, 0.56), (-1.85, 0.55), (-1.73, 0.52), (-1.66, 0.42), (-1.64, 0.20), (-1.64, 0.0),
    (-1.64, -0.20), (-1.66, -0.42), (-1.73, -0.52), (-1.85, -0.55), (-2.0, -0.56),
)  # fmt: skip
