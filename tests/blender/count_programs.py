# SPDX-License-Identifier: Apache-2.0
"""How many programs of paints Blender compiles for each picture of a file, without the add-on.

Usage: python count_programs.py FILE.blend OUT, in an empty folder of its own and with
OSL_OPTIONS=llvm_output_bitcode=1, by which OSL writes each program that it compiles into the
folder. Renders the file as it is, after the lamp Lamp moved and grew and the empty Instancer, which
shows another, moved, at the next frame, and after a step of the paint's slider; prints the number
of programs of each, and writes OUT-moved.exr, OUT-next.exr and so on, and beside them the files as
they were then.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

blend, out = sys.argv[1:]
bpy.ops.wm.open_mainfile(filepath=blend, use_scripts=False)
scene = bpy.context.scene
scene.render.use_persistent_data = True


def programs() -> int:
    """Of one picture: those with an input of the paint, whether or not OSL optimised them already.

    A lamp whose data changes compiles the lamp's own, which is a hundredth as long.
    """
    bpy.ops.render.render(write_still=True)
    written = {file: file.read_text() for file in Path().glob("*.ll")}
    for file in written:
        file.unlink()
    return sum("Light1Vector" in text for text in written.values())


scene.render.filepath = f"{out}-first.exr"
counts = [programs()]
lamp = bpy.data.objects["Lamp"]
lamp.location.x += 0.1
lamp.data.shadow_soft_size *= 2
bpy.data.objects["Instancer"].location.x += 0.1
scene.render.filepath = f"{out}-moved.exr"
counts.append(programs())
bpy.ops.wm.save_as_mainfile(filepath=f"{out}-moved.blend", copy=True)
scene.frame_set(scene.frame_current + 1)
scene.render.filepath = f"{out}-next.exr"
counts.append(programs())
bpy.ops.wm.save_as_mainfile(filepath=f"{out}-next.blend", copy=True)
scene.render.filepath = f"{out}-slider.exr"
tree = bpy.data.materials["Painted"].node_tree
tree.nodes["Metallic Paint"].inputs["Tilt"].default_value *= 1.1
counts.append(programs())
print("Programs:", *counts, flush=True)
os._exit(0)  # an ordinary exit can hang in bpy 4.5
