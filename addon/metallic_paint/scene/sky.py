# SPDX-License-Identifier: GPL-3.0-or-later
"""The sun of a world: of Blender's sky, or the brightest spot of an environment image.

Cycles lights, colours and shadows it as part of the world. The shader needs its direction, and the
disc that has as many sparkles. Directions were measured in renders, in Blender 4.5 and 5.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TypeGuard

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector

from . import placed

REACH = 0.02  # rad, of the cone about the sun that sparkles: kSkyReach of the core
# Of all the image's light, what that cone must have to hold a sun. It fills 1e-4 of the sphere: so
# it is five hundred times as bright as the mean. A lamp in a room is wider, or dimmer.
LEAST_SHARE = 0.05
_MOST_PIXELS = 2**25  # 8192 x 4096
_BRIGHTEST = 1000  # pixels, among which the sun is looked for
_FINER = 4  # steps in a pixel: Cycles interpolates between pixels
MARK = "metallic_paint_sun"  # of a group that keeps the sun out of a world (sun_lamp.py)


@dataclass(frozen=True)
class Sun:
    name: str
    direction: tuple[float, float, float]  # towards it
    sine: float  # of its angular radius
    irradiance: float = 0.0  # of a surface that faces it, at Strength 1; 0: not known, as of a sky


@dataclass(frozen=True)
class _Spot:
    direction: tuple[float, float, float]  # in the texture's space
    sine: float
    irradiance: float = 0.0


_found: dict[tuple[object, ...], _Spot | None] = {}  # of images, which are searched once


def forget() -> None:
    """Images are searched anew: one that is painted does not tell that its pixels changed."""
    _found.clear()


def find(scene: bpy.types.Scene) -> Sun | None:
    """None where there is none, or where what lies between it and the world is not known."""
    world = world_of(scene)
    if (parts := shown(world)) is None or not world.cycles_visibility.glossy:
        return None
    background, texture = parts
    strength = background.inputs["Strength"]
    if not (strength.is_linked or strength.default_value > 0):
        return None
    if isinstance(texture, bpy.types.ShaderNodeTexSky):
        spot, turned = _of_sky(texture), Matrix.Identity(3)
    elif isinstance(texture, bpy.types.ShaderNodeTexEnvironment):
        spot, turned = _of_image(texture), _turned(texture.inputs["Vector"])
    else:
        return None
    if spot is None or turned is None:
        return None
    x, y, z = (turned @ Vector(spot.direction)).normalized()
    return Sun(f"the sun of {world.name_full}", (x, y, z), spot.sine, spot.irradiance)


def worlds(scene: bpy.types.Scene) -> set[bpy.types.World | None]:
    """Of the view layers in use, each of which may have its own, or none."""
    return {
        (getattr(layer, "world_override", None) or scene.world) if layer.use_sky else None
        for layer in placed.used_layers(scene)
    }


def world_of(scene: bpy.types.Scene) -> bpy.types.World | None:
    """That of all view layers in use; None where they differ."""
    found = worlds(scene)
    return found.pop() if len(found) == 1 else None


def shown(world: bpy.types.World | None) -> tuple[bpy.types.Node, bpy.types.Node] | None:
    """The Background node that shines, and the node that has its colour, where these are all."""
    tree = world.node_tree if world else None
    if tree is None or (bpy.app.version < (5, 0) and not world.use_nodes):
        return None
    out = tree.get_output_node("CYCLES")
    background = source(out.inputs["Surface"]) if out else None
    if background is None or background.type != "BACKGROUND" or background.mute:
        return None
    texture = source(background.inputs["Color"])
    if texture is not None and keeps_sun_out(texture):
        texture = source(texture.inputs[0]) if texture.inputs else None
    return None if texture is None or texture.mute else (background, texture)


def keeps_sun_out(node: bpy.types.Node) -> TypeGuard[bpy.types.ShaderNodeGroup]:
    """Whether it is the group that sun_lamp.py puts into a world."""
    return node.type == "GROUP" and node.node_tree is not None and MARK in node.node_tree


def source(socket: bpy.types.NodeSocket) -> bpy.types.Node | None:
    return socket.links[0].from_node if socket.is_linked else None


def _of_sky(node: bpy.types.ShaderNodeTexSky) -> _Spot | None:
    """Skies with a sun take no direction from outside: their Vector is not used."""
    if node.sky_type in ("PREETHAM", "HOSEK_WILKIE") or not node.sun_disc:
        return None
    if node.sun_intensity <= 0:
        return None
    up, turn = node.sun_elevation, node.sun_rotation
    across = math.cos(up)
    direction = (math.sin(turn) * across, math.cos(turn) * across, math.sin(up))
    return _Spot(direction, math.sin(node.sun_size / 2))


def _turned(socket: bpy.types.NodeSocket) -> Matrix | None:
    """From the texture's space into the world's; None where it is not known."""
    node = source(socket)
    if node is None or _is_generated(socket):
        return Matrix.Identity(3)
    if not isinstance(node, bpy.types.ShaderNodeMapping) or node.mute:
        return None
    location, rotation, scale = (node.inputs[each] for each in ("Location", "Rotation", "Scale"))
    if location.is_linked or rotation.is_linked or scale.is_linked:
        return None
    moved, turned, scaled = (np.array(each.default_value) for each in (location, rotation, scale))
    if moved.any() or (scaled != 1).any():
        return None
    if not _is_generated(node.inputs["Vector"]):
        return None
    matrix = Euler(turned.tolist()).to_matrix()
    return matrix if node.vector_type == "TEXTURE" else matrix.inverted_safe()


def _is_generated(socket: bpy.types.NodeSocket) -> bool:
    """Whether it takes the direction itself, from a Texture Coordinate node."""
    return socket.is_linked and (
        socket.links[0].from_node.type == "TEX_COORD"
        and socket.links[0].from_socket.name == "Generated"
    )


def _of_image(node: bpy.types.ShaderNodeTexEnvironment) -> _Spot | None:
    image = node.image
    if image is None or node.projection != "EQUIRECTANGULAR":
        return None
    if image.source not in ("FILE", "GENERATED"):
        return None
    is_known = image.has_data  # not after a reload, and asking for its size loads it
    stamp = _stamp(image)
    if image.source == "FILE" and not (is_known or stamp or image.packed_file):
        return None  # its file is missing, and would be missed again each time
    # Names come again in the next file; this number does not in a session.
    key = (
        image.session_uid, image.filepath, stamp, tuple(image.size),
        image.colorspace_settings.name,
    )  # fmt: skip
    if not is_known or key not in _found:
        _found[key] = _search(image)
    return _found[key]


def _stamp(image: bpy.types.Image) -> tuple[int, int] | None:
    """What tells that its file was written again; None where there is none."""
    if not image.filepath:
        return None
    try:
        found = Path(image.filepath_from_user()).stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def _search(image: bpy.types.Image) -> _Spot | None:
    width, height = image.size
    if not 64 <= width * height <= _MOST_PIXELS or image.channels < 3:
        return None
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    colours = pixels.reshape(height, width, image.channels)[:, :, :3]
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        colours = np.where(
            colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** np.float32(2.4)
        )
    light = np.maximum(np.nan_to_num(colours.mean(axis=2), posinf=0), 0)
    return spot_of(light)


def spot_of(light: np.ndarray) -> _Spot | None:
    """Of an equirectangular image's brightness, its lowest row first."""
    height, width = light.shape
    polar = math.pi * ((np.arange(height) + 0.5) / height - 0.5)
    pixel = 2 * math.pi / width * math.pi / height
    total = float((light.sum(axis=1) * np.cos(polar)).sum() * pixel)
    row, column = _brightest(light, polar)
    # Within the cone about that pixel, and about the spot's own centre.
    off = math.ceil(2 * REACH / (math.pi / height)) + 2
    rows = np.arange(max(row - off, 0), min(row + off, height - 1) + 1)
    aside = math.ceil(off / max(math.cos(polar[row]), 1e-3))
    columns = column + np.arange(-min(aside, width // 2), min(aside, width // 2) + 1)
    patch = light[np.ix_(rows, columns % width)]
    finer_rows = np.linspace(rows[0], rows[-1], _FINER * (len(rows) - 1) + 1)
    finer_columns = np.linspace(columns[0], columns[-1], _FINER * (len(columns) - 1) + 1)
    patch = np.array([np.interp(finer_rows, rows, each) for each in patch.T]).T
    patch = np.array([np.interp(finer_columns, columns, each) for each in patch])
    up = math.pi * ((finer_rows + 0.5) / height - 0.5)[:, None]
    turn = _turn(finer_columns, width)[None, :]
    directions = _directions(up, turn)
    solid_angle = pixel / _FINER**2 * np.cos(up) + 0 * turn
    centre = _directions(polar[row], _turn(column, width))
    for _ in range(3):
        held = ((directions - centre) ** 2).sum(axis=-1) <= REACH**2
        power = patch * solid_angle * held
        if not power.sum() > 0:
            return None
        centre = (directions * power[..., None]).sum(axis=(0, 1))
        centre = centre / np.linalg.norm(centre)
    flux = float(power.sum())
    if not flux >= LEAST_SHARE * total:
        return None
    # The disc with as many sparkles: uneven light L counts as (integral of L)^2/integral of L^2.
    even = flux**2 / float((patch * power).sum())
    h = min(even / (4 * math.pi), 0.5)
    x, y, z = centre.tolist()
    return _Spot((x, y, z), 2 * math.sqrt(h * (1 - h)), flux)


def _brightest(light: np.ndarray, polar: np.ndarray) -> tuple[int, int]:
    """Row and column of the pixel with most light about it, of the brightest ones: a single pixel
    may be brighter than the sun."""
    number = min(_BRIGHTEST, light.size)
    rows, columns = np.unravel_index(np.argpartition(light, -number, None)[-number:], light.shape)
    directions = _directions(polar[rows], _turn(columns, light.shape[1]))
    near = directions @ directions.T >= 1 - REACH**2 / 2
    best = int((near @ (light[rows, columns] * np.cos(polar[rows]))).argmax())
    return int(rows[best]), int(columns[best])


def _turn(column: np.ndarray | int, width: int) -> np.ndarray:
    return -2 * math.pi * (np.asarray(column + 0.5) / width - 0.5)


def _directions(up: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(..., 3)."""
    return np.stack(
        [np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up) + 0 * turn], axis=-1
    )
