# SPDX-License-Identifier: Apache-2.0
"""A render machine: Blender alone, without the add-on, scripts switched off.

Usage: python open_and_render.py FILE.blend OUT FRAME... writes OUT-FRAME.exr.
"""

import importlib.util
import os
import sys
from pathlib import Path

import bpy

blend, out, *frames = sys.argv[1:]
assert importlib.util.find_spec("metallic_paint") is None
assert importlib.util.find_spec("oslquery") is None  # without it no script node compiles
bpy.ops.wm.open_mainfile(filepath=blend, use_scripts=False)
assert not bpy.app.autoexec_fail, bpy.app.autoexec_fail_message
for text in list(bpy.data.texts):
    bpy.data.texts.remove(text)
scene = bpy.context.scene
for frame in frames:
    scene.frame_set(int(frame))
    scene.render.filepath = str(Path(f"{out}-{frame}.exr"))
    bpy.ops.render.render(write_still=True)
sys.stdout.flush()
os._exit(0)  # an ordinary exit can hang in bpy 4.5
