# SPDX-License-Identifier: Apache-2.0
"""Renders a model in one of the paints."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402
from metallic_paint.paint import presets  # noqa: E402

from pictures import render_scene, studio  # noqa: E402
from pictures.render_scene import RenderError, say  # noqa: E402

SMOOTH_BELOW = math.radians(30)  # the angle between faces of a mesh that has no normals
MODELS = (".obj", ".glb", ".ply", ".stl", ".blend")


def main() -> None:
    arguments = parse()
    paint = render_scene.load_paint(arguments.paint)
    check_model(arguments.model, arguments.object, arguments.scale)
    render_scene.check_outputs([arguments.out])
    with render_scene.quiet():
        say(f"Opening {arguments.model}…")
        if arguments.model.suffix.lower() == ".blend":
            scene = open_blend(arguments.model)
        else:
            scene = import_mesh(arguments.model, arguments.scale or 1)
        things = named(scene, arguments.object) if arguments.object else meshes(scene)
        render_scene.paint_objects(things, paint)
        low, high = bounds(things, arguments.model)
        extent = " × ".join(f"{x:.3g}" for x in (high - low) * scene.unit_settings.scale_length)
        say(f"Painting {len(things)} object{'s' if len(things) > 1 else ''}, {extent} m")
        in_studio = not has_camera_and_lights(scene)
        if in_studio:
            render_scene.set_up_studio(scene)
        render_scene.set_up(scene, arguments.samples, arguments.width, arguments.height)
        if in_studio:
            add_studio(scene, low, high)
            render_scene.denoise_all_but_sparkles(scene)
        render_scene.render(scene, [arguments.out], arguments.paint)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="paint render",
        description=f"{__doc__} A mesh stands in the demo's studio; a .blend that has a camera "
        "and lights keeps them, its size and its samples, and is rendered without compositing and "
        "denoising. The flakes have their true size: see --scale for a mesh that is not in metres.",
    )
    parser.add_argument(
        "model", type=Path, metavar="MESH_OR_BLEND", help=f"a file: {' '.join(MODELS)}"
    )
    parser.add_argument(
        "--paint", required=True, metavar="PRESET",
        help=f"a JSON file, or one of {', '.join(presets.names())}",
    )  # fmt: skip
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE",
        help="the picture: .exr (32 bit, linear) or .png (8 bit)",
    )  # fmt: skip
    render_scene.add_arguments(parser)
    parser.add_argument(
        "--height", type=render_scene.whole_number(render_scene.MOST_PIXELS), metavar="H",
        help="in pixels (follows from the width)",
    )  # fmt: skip
    parser.add_argument(
        "--scale", type=positive, metavar="M",
        help="metres in a unit of the mesh, 0.001 for millimetres (1)",
    )  # fmt: skip
    parser.add_argument(
        "--object", nargs="+", default=[], metavar="NAME",
        help="which objects of a .blend to paint (all meshes)",
    )  # fmt: skip
    return parser.parse_args()


def positive(text: str) -> float:
    number = float(text)
    if not 0 < number < math.inf:
        raise ValueError
    return number


positive.__name__ = "number above 0"  # argparse names the type in its message


def check_model(file: Path, names: Sequence[str], scale: float | None) -> None:
    if file.suffix.lower() not in MODELS:
        known = f"{', '.join(MODELS[:-1])} or {MODELS[-1]}"
        raise RenderError(f"{file}: a model's name ends in {known}.")
    if names and file.suffix.lower() != ".blend":
        raise RenderError(f"--object names objects of a .blend, and {file} is none.")
    if scale is not None and file.suffix.lower() == ".blend":
        raise RenderError(f"--scale is for a mesh; {file} has the scale of its scene.")
    try:
        with file.open("rb"):
            pass
    except OSError as error:
        raise RenderError(f"{file} cannot be read: {error.strerror}.") from error


# --- the model -------------------------------------------------------------------------------


def open_blend(file: Path) -> bpy.types.Scene:
    try:
        bpy.ops.wm.open_mainfile(filepath=str(file.resolve()), use_scripts=False, load_ui=False)
    except RuntimeError as error:
        raise RenderError(f"{file} cannot be read: {reason(error)}") from error
    return bpy.context.scene


def import_mesh(file: Path, scale: float = 1) -> bpy.types.Scene:
    """Its meshes in an empty scene, smooth as the file says, a unit of it so many metres long."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    path = str(file.resolve())
    try:
        match file.suffix.lower():
            case ".obj":
                bpy.ops.wm.obj_import(filepath=path)
            case ".ply":
                bpy.ops.wm.ply_import(filepath=path)
            case ".stl":
                bpy.ops.wm.stl_import(filepath=path)
            case ".glb":
                bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
                bpy.ops.import_scene.gltf(filepath=path)
    except RuntimeError as error:
        raise RenderError(f"{file} cannot be read: {reason(error)}") from error
    for thing in list(scene.objects):
        if thing.type in ("CAMERA", "LIGHT"):  # the studio has its own
            bpy.data.objects.remove(thing)
    for mesh in bpy.data.meshes:
        if not mesh.has_custom_normals:
            mesh.shade_smooth()
            mesh.set_sharp_from_angle(angle=SMOOTH_BELOW)
    for thing in scene.objects:
        if thing.parent is None:
            thing.matrix_basis = Matrix.Scale(scale, 4) @ thing.matrix_basis
    return scene


def reason(error: RuntimeError) -> str:
    """What an operator reported, as the end of a sentence."""
    text = str(error).strip().splitlines()[-1].removeprefix("Error: ")
    return text if text.endswith(".") else f"{text}."


def named(scene: bpy.types.Scene, names: Sequence[str]) -> list[bpy.types.Object]:
    for name in names:
        if name not in scene.objects:
            raise RenderError(
                f"The scene has no object {name!r}; its meshes are "
                f"{', '.join(repr(thing.name) for thing in meshes(scene)) or 'none'}."
            )
    return [scene.objects[name] for name in dict.fromkeys(names)]


def meshes(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    return [thing for thing in render_scene.rendered(scene) if thing.type == "MESH"]


def bounds(things: Sequence[bpy.types.Object], file: Path) -> tuple[Vector, Vector]:
    """The corners of the objects' box in the world."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = [thing.evaluated_get(depsgraph) for thing in things]
    if not any(thing.type != "MESH" or thing.data.polygons for thing in evaluated):
        raise RenderError(f"{file} holds no faces to paint.")
    for thing in evaluated:
        if thing.type == "MESH" and not np.isfinite(coordinates(thing.data)).all():
            raise RenderError(f"{file}: {thing.name!r} has coordinates that are no finite numbers.")
    corners = [thing.matrix_world @ Vector(c) for thing in evaluated for c in thing.bound_box]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    extent = np.linalg.norm(high - low)
    if not 0 < extent < np.inf:
        finite = "" if extent == 0 else "finite "
        raise RenderError(f"{file}: what is to be painted has no {finite}extent.")
    return Vector(low), Vector(high)


def coordinates(mesh: bpy.types.Mesh) -> np.ndarray:
    values = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", values)
    return values


# --- where it stands -------------------------------------------------------------------------


def has_camera_and_lights(scene: bpy.types.Scene) -> bool:
    return scene.camera is not None and any(
        thing.type == "LIGHT" for thing in render_scene.rendered(scene)
    )


def add_studio(scene: bpy.types.Scene, low: Vector, high: Vector) -> None:
    """The demo's camera, lights, floor and backdrop, around the box.

    The ground lies a little lower than the box: a flat model would lie in it.
    """
    low = low - Vector((0, 0, 1e-3 * (high - low).length))
    mesh = bpy.data.meshes.new("Box")
    mesh.from_pydata([low, high], [], [])
    box = bpy.data.objects.new("Box", mesh)
    scene.collection.objects.link(box)
    bpy.context.view_layer.update()
    studio.build(scene, box)
    bpy.data.objects.remove(box)


if __name__ == "__main__":
    render_scene.run(main)
