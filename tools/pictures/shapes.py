# SPDX-License-Identifier: Apache-2.0
"""Meshes from curves, and the plain materials of what is not painted."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


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


def smooth_curve(controls: Sequence[Sequence[float]], count: int, *, closed: bool = False) -> Array:
    """The cubic B-spline of these controls, (count, d); closed, or from the first to the last."""
    c = np.asarray(controls, float)
    if closed:
        c = np.concatenate([c, c[:3]])
        u = np.linspace(1, len(c) - 2, count + 1)[:-1]
        return np.stack([spline(u, 0, len(c) - 1, column) for column in c.T], -1)
    u = np.linspace(0, 1, count)
    return np.stack([spline(u, 0, 1, column) for column in c.T], -1)


# ---- Meshes ----


def add_mesh(
    scene: bpy.types.Scene,
    name: str,
    points: Array,
    faces: Array,
    surface: bpy.types.Material | None,
) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    mesh.update()
    if surface:
        mesh.materials.append(surface)
    item = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(item)
    return item


def grid_faces(rows: int, columns: int, *, closed: tuple[bool, bool] = (False, False)) -> Array:
    """The quads of a grid of points (rows, columns), closed along either way."""
    i = np.arange(rows * columns).reshape(rows, columns)
    for axis in (0, 1):
        if closed[axis]:
            i = np.concatenate([i, i.take([0], axis)], axis)
    return np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], -1).reshape(-1, 4)


def add_grid(
    scene: bpy.types.Scene,
    name: str,
    grid: Array,
    surface: bpy.types.Material,
    *,
    closed: tuple[bool, bool] = (False, False),
) -> bpy.types.Object:
    """A surface through a grid of points (n, m, 3)."""
    n, m = grid.shape[:2]
    return add_mesh(scene, name, grid.reshape(-1, 3), grid_faces(n, m, closed=closed), surface)


def lathe(profile: Sequence[tuple[float, float]], segments: int = 96) -> Array:
    """A grid of the profile's points (radius, height) turned about the y axis."""
    r, h = np.asarray(profile, float).T[:, :, None]
    angle = np.arange(segments) * 2 * np.pi / segments
    return np.stack([r * np.cos(angle), h + 0 * angle, r * np.sin(angle)], -1)


def loft(
    along: Sequence[Sequence[float]], widths: Sequence[float], heights: Sequence[float],
    side: Sequence[float], *, power: float = 4, count: int = 20,
) -> Array:  # fmt: skip
    """A rounded bar along points (n, 3): super-elliptic sections, `side` about the widths' way."""
    middle = np.asarray(along, float)
    forward = unit(np.gradient(middle, axis=0))
    up = unit(np.cross(forward, side))
    across = np.cross(up, forward)
    angle = np.arange(count) * 2 * np.pi / count
    c, s = (np.sign(f) * np.abs(f) ** (2 / power) for f in (np.cos(angle), np.sin(angle)))
    w, h = (np.asarray(v, float)[:, None, None] / 2 for v in (widths, heights))
    bar = middle[:, None] + w * across[:, None] * c[:, None] + h * up[:, None] * s[:, None]
    # Its ends are closed by sections without extent.
    return np.concatenate([0 * bar[:1] + middle[0], bar, 0 * bar[:1] + middle[-1]])


def rounded(n: int, power: float) -> tuple[Array, Array]:
    """A grid over the super-ellipse |s|^p + |t|^p <= 1, denser where its outline is steep."""
    s = np.sin(np.linspace(-1, 1, n) * np.pi / 2)
    s, t = np.meshgrid(s, np.linspace(-1, 1, n // 2), indexing="ij")
    return s, t * (1 - np.abs(s) ** power) ** (1 / power)


# ---- Materials ----


def plain_material(
    name: str, colour: Sequence[float], roughness: float, metallic: float = 0, glow: float = 0,
    *, mirrors: bool = True,
) -> bpy.types.Material:  # fmt: skip
    """A Principled BSDF; `glow` is the radiance of its own light, of the same colour."""
    surface = bpy.data.materials.new(name)
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    shader = surface.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    shader.inputs["Specular IOR Level"].default_value = 0.5 * mirrors
    shader.inputs["Emission Color"].default_value = (*colour, 1)
    shader.inputs["Emission Strength"].default_value = glow
    surface.cycles.emission_sampling = "NONE"  # small lights of the picture, no lamps of the scene
    return surface


def asphalt_material(name: str, grey: float) -> bpy.types.Material:
    """Stones of a few millimetres, smooth where it is worn."""
    surface = plain_material(name, (grey, grey, 1.03 * grey), roughness=0.5)
    tree = surface.node_tree
    shader = tree.nodes["Principled BSDF"]
    place, stones, wear, shades, gloss, bump = (
        tree.nodes.new(f"ShaderNode{kind}")
        for kind in ("NewGeometry", "TexNoise", "TexNoise", "MapRange", "MapRange", "Bump")
    )
    stones.inputs["Scale"].default_value, wear.inputs["Scale"].default_value = 120, 0.7
    for texture in (stones, wear):
        tree.links.new(place.outputs["Position"], texture.inputs["Vector"])
    shades.inputs["From Min"].default_value, shades.inputs["From Max"].default_value = 0.3, 0.7
    shades.inputs["To Min"].default_value, shades.inputs["To Max"].default_value = 0.4, 1.6
    gloss.inputs["To Min"].default_value, gloss.inputs["To Max"].default_value = 0.45, 0.62
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.3, 0.003
    tint = tree.nodes.new("ShaderNodeVectorMath")
    tint.operation = "SCALE"
    tint.inputs[0].default_value = (grey, grey, 1.03 * grey)
    fac = next(out for out in stones.outputs if out.type == "VALUE")
    tree.links.new(fac, shades.inputs["Value"])
    tree.links.new(fac, bump.inputs["Height"])
    worn = next(out for out in wear.outputs if out.type == "VALUE")
    tree.links.new(worn, gloss.inputs["Value"])
    tree.links.new(shades.outputs["Result"], tint.inputs["Scale"])
    tree.links.new(tint.outputs["Vector"], shader.inputs["Base Color"])
    tree.links.new(gloss.outputs["Result"], shader.inputs["Roughness"])
    tree.links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    return surface


def glass_material(name: str, tint: Sequence[float]) -> bpy.types.Material:
    """A thin pane: what is behind it in the tint, and a mirror image by Schlick's formula."""
    surface = bpy.data.materials.new(name)
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    tree = surface.node_tree
    tree.nodes.clear()
    facing, power, share, through, mirror, mix, out = (
        tree.nodes.new(f"ShaderNode{kind}")
        for kind in ("LayerWeight", "Math", "Math", "BsdfTransparent", "BsdfGlossy", "MixShader",
                     "OutputMaterial")
    )  # fmt: skip
    power.operation, power.inputs[1].default_value = "POWER", 5
    share.operation = "MULTIPLY_ADD"
    share.inputs[1].default_value, share.inputs[2].default_value = 0.93, 0.07  # of both faces
    through.inputs["Color"].default_value = (*tint, 1)
    mirror.inputs["Roughness"].default_value = 0
    tree.links.new(facing.outputs["Facing"], power.inputs[0])
    tree.links.new(power.outputs[0], share.inputs[0])
    tree.links.new(share.outputs[0], mix.inputs["Fac"])
    tree.links.new(through.outputs[0], mix.inputs[1])
    tree.links.new(mirror.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], out.inputs["Surface"])
    return surface


def glowing_material(name: str, radiance: float, fall: str) -> bpy.types.Material:
    """White light on its front alone, times an attribute; no shadow ray seeks it."""
    surface = bpy.data.materials.new(name)
    if surface.node_tree is None:
        surface.use_nodes = True  # Blender 4.5
    surface.cycles.emission_sampling = "NONE"
    tree = surface.node_tree
    tree.nodes.clear()
    factor, times, side, glow, nothing, mix, out = (
        tree.nodes.new(f"ShaderNode{kind}")
        for kind in ("Attribute", "Math", "NewGeometry", "Emission", "BsdfTransparent",
                     "MixShader", "OutputMaterial")
    )  # fmt: skip
    factor.attribute_name = fall
    times.operation, times.inputs[1].default_value = "MULTIPLY", radiance
    tree.links.new(factor.outputs["Fac"], times.inputs[0])
    tree.links.new(times.outputs[0], glow.inputs["Strength"])
    tree.links.new(side.outputs["Backfacing"], mix.inputs["Fac"])
    tree.links.new(glow.outputs[0], mix.inputs[1])
    tree.links.new(nothing.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], out.inputs["Surface"])
    return surface
