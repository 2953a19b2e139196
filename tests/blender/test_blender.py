# SPDX-License-Identifier: Apache-2.0
"""The ground that every render test stands on."""

from pathlib import Path
from types import ModuleType

import bpy
import OpenImageIO
import oslquery
import pytest


@pytest.mark.parametrize("package", [OpenImageIO, oslquery])
def test_image_and_shader_libraries_are_blenders_own(package: ModuleType) -> None:
    assert Path(bpy.utils.resource_path("LOCAL")) in Path(package.__file__).parents


def test_user_settings_are_a_scratch_folder() -> None:
    assert "metallic-paint-" in bpy.utils.resource_path("USER")


def test_a_shader_compiles() -> None:
    bpy.context.scene.render.engine = "CYCLES"
    text = bpy.data.texts.new("probe.osl")
    text.write("shader probe(float Gain = 1, output color Result = 0) { Result = Gain; }")
    node = bpy.data.node_groups.new("Probe", "ShaderNodeTree").nodes.new("ShaderNodeScript")
    node.script = text
    assert node.bytecode
    assert [socket.name for socket in node.outputs] == ["Result"]
