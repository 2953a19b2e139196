# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising that keeps the sparkles: their light passes by the denoiser, the rest goes through it.

A denoiser takes sparkles for noise. Cycles has no pass of the sparkles alone, but they are in two:
in Glossy Direct, G, beside the noisy mirrored world, and in the light group of the lamps with a
slot, L, beside what these lamps light otherwise. All light of other origin is the picture less L,
and from the same samples; so

    S = max(0, G − (picture − L))

takes the noisy mirrored world away again, exactly. It also takes from each sparkle what the pixel
shows of the world by diffuse and repeated reflection. This little stays in the rest. A world has
one light group for all its light, so the sun of an environment image becomes a lamp for this
(scene/sun_lamp.py). Other things than paint do not sparkle: a matte of the painted materials
(Cryptomatte), m, leaves them to the denoiser. The sum of both is the picture as it was:

    shown = denoised(picture − m S) + m S
"""

from __future__ import annotations

from typing import Literal

import bpy

from .paint import material
from .scene import lights, needs, placed, sun_lamp, wiring

NAME = "Metallic Paint Denoise"
LIGHT_GROUP = "Sparkles"
SET_UP = "Denoise, Keep Sparkles"  # the button

# Of our nodes, trees and lamps, and of the view layer; of the scene: what was before.
_MARK = "metallic_paint_denoise"
_PASSES = ("use_pass_glossy_direct", "use_pass_glossy_color", "use_pass_cryptomatte_material")
_BLENDER_5 = bpy.app.version >= (5, 0)
_GLOSSY = ("Glossy Direct", "Glossy Color") if _BLENDER_5 else ("GlossDir", "GlossCol")
_GUIDES = ("Denoising Albedo", "Denoising Normal")
# What only hands a picture on.
_PLAIN_NODES = {"R_LAYERS", "REROUTE", "VIEWER", "COMPOSITE", "GROUP_OUTPUT", "FRAME"}


class DenoiseError(RuntimeError):
    """Why compositing cannot be set up, in a sentence; nothing was changed."""


def why_not(scene: bpy.types.Scene) -> str:
    """What keeps set_up from it, in a sentence; empty where nothing does."""
    if not scene.is_editable:
        return material.LINKED.format("scene")
    if scene.render.engine != "CYCLES" or not hasattr(scene, "cycles"):
        return "The scene does not render with Cycles"
    if foreign := _foreign_nodes(scene):
        return foreign
    if len(placed.used_layers(scene)) != 1:
        return "One view layer must render: compositing several is the artist's choice"
    if names := [name for name in _painted() if not _in_cryptomatte(name)]:
        listed = ", ".join(f"“{name}”" for name in names)
        return f"Rename {listed}: Cryptomatte takes no comma, nor a space or < at the start"
    return ""


def outdated(scene: bpy.types.Scene) -> str:
    """What keeps the set-up from its purpose since, in a sentence; empty where nothing does.

    Quick enough for a panel: the lamps with a slot are those of the last fit.
    """
    if not is_set_up(scene):
        missing = sun_lamp.is_missing(scene)
        return f"A lamp of another scene shows the world's sun: press “{SET_UP}”" if missing else ""
    was = scene[_MARK]
    layer: bpy.types.ViewLayer | None = scene.view_layers.get(was["layer"])
    switched: list[str] = []
    if layer is None or not layer.use:
        new = ["the view layer that renders"]
    else:
        new = sorted(set(_painted()) - set(was.get("painted", ())))
        groups = set(was.get("groups", ())) & {group.name for group in layer.lightgroups}
        new += [
            lamp.name_full
            for lamp in (*lights.in_slots(), *filter(sun_lamp.is_one, scene.objects))
            if (lamp.is_editable or lamp.lightgroup) and lamp.lightgroup not in groups
        ]
        if not sun_lamp.is_current(scene):
            new.append("the world's sun as it is now")
        if not _is_ours(_tree(scene)):
            new.append("the compositing")
        switched = _switched(scene, layer)
    reasons = [f"Denoising does not know {', '.join(new)}", *switched] if new else switched
    return f"{'; '.join(reasons)}: press “{SET_UP}” again" if reasons else ""


def _switched(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[str]:
    """What of the set-up's switches stands otherwise now, in words."""
    found = []
    if scene.cycles.use_denoising:
        found.append("Cycles' own denoising is on, so sparkles count twice")
    switches = [(layer, name) for name in _PASSES] + [(layer.cycles, "denoising_store_passes")]
    if off := [of.bl_rna.properties[name].name for of, name in switches if not getattr(of, name)]:
        found.append(f"Denoising lacks the passes {', '.join(off)}")
    if not (scene.render.use_compositing and (_BLENDER_5 or scene.use_nodes)):
        found.append("Compositing is off, so nothing is denoised")
    return found


def why_not_remove(scene: bpy.types.Scene) -> str:
    if not scene.is_editable:
        return material.LINKED.format("scene")
    if not hasattr(scene, "cycles"):
        return material.NO_CYCLES
    if not is_set_up(scene):
        return "Denoising that keeps the sparkles is not set up in this scene"
    return _foreign_nodes(scene) if _is_ours(_tree(scene)) else ""


def is_set_up(scene: bpy.types.Scene) -> bool:
    return _MARK in scene


def set_up(scene: bpy.types.Scene) -> list[str]:
    """Sets up passes, light groups and compositing; returns what it changed, in sentences.

    Call it again when lights or painted materials came: it renews what it made. remove() is its
    inverse. Lamps keep their light groups; those without one come into the group "Sparkles". Raises
    DenoiseError, with nothing changed, where why_not has a reason. After any other error nothing is
    set up.
    """
    if reason := why_not(scene):
        raise DenoiseError(f"{reason}.")
    found = needs.fit(scene).lights
    if is_set_up(scene):
        remove(scene)
    layer = _layer(scene)
    was = {
        "layer": layer.name,
        "use_denoising": scene.cycles.use_denoising,
        "use_compositing": scene.render.use_compositing,
        "denoising_store_passes": layer.cycles.denoising_store_passes,
        **{name: getattr(layer, name) for name in _PASSES},
        "made_light_groups": [],
        "painted": _painted(),
    }
    layer[_MARK] = True
    try:
        changed = _change(scene, layer, found, was)
    except BaseException:
        _change_back(scene, was)
        raise
    scene[_MARK] = was
    return changed


def remove(scene: bpy.types.Scene) -> list[str]:
    """Takes back what set_up did and still stands; returns what it changed, in sentences.

    Raises DenoiseError where there is nothing to take back, or other nodes would go with it.
    """
    if reason := why_not_remove(scene):
        raise DenoiseError(f"{reason}.")
    was = dict(scene[_MARK])
    is_gone = not _changed_layers(scene, was)
    _change_back(scene, was)
    del scene[_MARK]
    state = "on" if scene.cycles.use_denoising else "off"
    about = f"Compositing, passes and light groups are as before, Cycles' denoising is {state}."
    gone = f"The view layer “{was['layer']}” is gone, and its passes with it."
    return [about, gone] if is_gone else [about]


def node_group() -> bpy.types.CompositorNodeTree:
    """The file's group that denoises all but the sparkles, made when there is none.

    Inputs: the picture, its passes Glossy Direct and Glossy Color, the sum of the light groups that
    hold the lamps with a slot, the denoiser's guides, and the matte of the paint.
    """
    trees = [t for t in bpy.data.node_groups if isinstance(t, bpy.types.CompositorNodeTree)]
    for group in trees:
        if group.get(_MARK) == "group" and group.library is None:
            return group
    group = bpy.data.node_groups.new(NAME, "CompositorNodeTree")
    group[_MARK] = "group"
    for label in ("Image", "Light Groups", "Glossy Direct", "Glossy Color", "Albedo"):
        group.interface.new_socket(label, in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Normal", in_out="INPUT", socket_type="NodeSocketVector")
    matte = group.interface.new_socket("Paint", in_out="INPUT", socket_type="NodeSocketFloat")
    matte.default_value = 1
    group.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    inside = group.nodes.new("NodeGroupInput")
    out = group.nodes.new("NodeGroupOutput")
    image, lamps, direct, color, albedo, normal, paint = inside.outputs[:7]
    other = _mix(group, "SUBTRACT", image, lamps)
    glossy = _mix(group, "MULTIPLY", direct, color)
    sparkles = _mix(group, "LIGHTEN", _mix(group, "SUBTRACT", glossy, other), None)
    sparkles = _mix(group, "MULTIPLY", sparkles, paint)
    denoise = group.nodes.new("CompositorNodeDenoise")
    links = group.links
    links.new(_mix(group, "SUBTRACT", image, sparkles), denoise.inputs["Image"])
    links.new(albedo, denoise.inputs["Albedo"])
    links.new(normal, denoise.inputs["Normal"])
    links.new(_mix(group, "ADD", denoise.outputs["Image"], sparkles), out.inputs["Image"])
    _lay_out(group)
    return group


# --- there and back ----------------------------------------------------------------------------


def _change(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    found: lights.Report,
    was: dict,
) -> list[str]:
    slots = tuple(dict.fromkeys(found.slots))  # one may be there many times
    changed = []
    _give_sun_back(scene)  # to a world that lacks it, as one from another file may
    if found.sky:
        if reason := sun_lamp.why_not(scene):
            lost = f"Sparkles of {found.sky} are denoised: {reason}"
            changed.append(f"{lost}. A Sun lamp in its place keeps them.")
        else:
            lamp = sun_lamp.make(scene)
            slots += (lamp,)
            changed.append(f"The lamp “{lamp.name}” shines in place of {found.sky}.")
    changed += _set_light_groups(scene, layer, slots, was)
    for name in _PASSES:
        setattr(layer, name, True)
    layer.cycles.denoising_store_passes = True
    changed.append(f"The view layer “{layer.name}” renders the passes that denoising needs.")
    if scene.cycles.use_denoising:
        scene.cycles.use_denoising = False
        changed.append("Cycles' own denoising is off: compositing denoises instead.")
    scene.render.use_compositing = True
    was["groups"] = sorted({lamp.lightgroup for lamp in slots} - {""})
    _compose(scene, layer, was)
    changed.append("Compositing denoises all but the sparkles.")
    return changed


def _give_sun_back(scene: bpy.types.Scene) -> None:
    sun_lamp.remove(scene, [each for each in bpy.data.scenes if each != scene and is_set_up(each)])


def _change_back(scene: bpy.types.Scene, was: dict) -> None:
    """Also of a change that broke off."""
    _take_down(scene, was)
    _give_sun_back(scene)
    of_older_version = [LIGHT_GROUP] if was.get("made_light_group") else []
    made = was.get("made_light_groups", of_older_version)
    for layer in _changed_layers(scene, was):
        for name in _PASSES:
            setattr(layer, name, bool(was[name]))
        layer.cycles.denoising_store_passes = bool(was["denoising_store_passes"])
        for name in {*made} & {*layer.lightgroups.keys()}:
            layer.lightgroups.remove(layer.lightgroups[name])
        layer.pop(_MARK, None)
    for lamp in [thing for thing in bpy.data.objects if _MARK in thing]:
        if lamp.users_scene and scene not in lamp.users_scene:
            continue  # of another scene; one that is shown as instances alone is of none
        if any(is_set_up(other) for other in lamp.users_scene if other != scene):
            continue  # a copy of this scene denoises by it
        if lamp.lightgroup == LIGHT_GROUP:
            lamp.lightgroup = ""
        del lamp[_MARK]
    scene.cycles.use_denoising = bool(was["use_denoising"])
    scene.render.use_compositing = bool(was["use_compositing"])


def _changed_layers(scene: bpy.types.Scene, was: dict) -> list[bpy.types.ViewLayer]:
    """The view layer that set_up changed, whatever it is called now, and copies of it; what an
    older version changed bears no mark."""
    marked = [layer for layer in scene.view_layers if _MARK in layer]
    return marked or [layer for layer in scene.view_layers if layer.name == was["layer"]]


# --- passes and light groups -------------------------------------------------------------------


def _set_light_groups(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    slots: tuple[bpy.types.Object, ...],
    was: dict,
) -> list[str]:
    """Every lamp with a slot comes into a light group of the layer."""
    without = [lamp for lamp in slots if lamp.is_editable and not lamp.lightgroup]
    for lamp in without:
        lamp.lightgroup, lamp[_MARK] = LIGHT_GROUP, True
    lamps = [lamp for lamp in slots if lamp.lightgroup]
    for lamp in lamps:
        if lamp.lightgroup not in layer.lightgroups:
            layer.lightgroups.add(name=lamp.lightgroup)
            was["made_light_groups"].append(lamp.lightgroup)
    changed = []
    if without:
        names = ", ".join(lamp.name for lamp in without)
        changed.append(f"In the light group “{LIGHT_GROUP}”: {names}.")
    if len(lamps) < len(slots):
        linked = ", ".join(lamp.name_full for lamp in slots if lamp not in lamps)
        changed.append(f"Sparkles of {linked} are denoised: linked from another file.")
    groups = {lamp.lightgroup for lamp in lamps}
    others = [thing.name_full for thing in scene.objects
              if thing.lightgroup in groups and thing not in lamps]  # fmt: skip
    if scene.world is not None and scene.world.lightgroup in groups:
        others.append(f"the world {scene.world.name}")
    if others:
        changed.append(f"Reflections of {', '.join(others)} stay noisy: the light group is shared.")
    return changed


# --- compositing -------------------------------------------------------------------------------


def _tree(scene: bpy.types.Scene) -> bpy.types.NodeTree | None:
    return scene.compositing_node_group if _BLENDER_5 else scene.node_tree


def _is_ours(tree: bpy.types.NodeTree | None) -> bool:
    return tree is not None and _MARK in tree


def _layer(scene: bpy.types.Scene) -> bpy.types.ViewLayer:
    """The one that renders."""
    return placed.used_layers(scene)[0]


def _foreign_nodes(scene: bpy.types.Scene) -> str:
    """Names those that do something and are not ours, even if the tree is switched off."""
    tree = _tree(scene)
    nodes = tree.nodes if tree is not None else ()
    names = [
        node.name
        for node in nodes
        if _MARK not in node and (node.type not in _PLAIN_NODES or _shows_another(node, scene))
    ]
    if not names:
        return ""
    return f"The compositing holds the artist's own nodes, which stay: {', '.join(names)}"


def _shows_another(node: bpy.types.Node, scene: bpy.types.Scene) -> bool:
    """Of a Render Layers node: whether it is of another scene."""
    return isinstance(node, bpy.types.CompositorNodeRLayers) and node.scene not in (None, scene)


def _compose(scene: bpy.types.Scene, layer: bpy.types.ViewLayer, was: dict) -> None:
    """The scene's tree: the layer's passes through our group to the output."""
    if _BLENDER_5:
        if scene.compositing_node_group is not None:
            was["tree"] = scene.compositing_node_group
        tree = bpy.data.node_groups.new(NAME, "CompositorNodeTree")
        tree[_MARK] = "scene"
        scene.compositing_node_group = tree
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    else:
        was["use_nodes"] = scene.use_nodes
        scene.use_nodes = True
        tree = scene.node_tree
        tree[_MARK] = "scene"
        tree.nodes.clear()
    passes = tree.nodes.new("CompositorNodeRLayers")
    passes.scene, passes.layer = scene, layer.name
    node = tree.nodes.new("CompositorNodeGroup")
    node.node_tree = node_group()
    node.width = 200
    out = tree.nodes.new("NodeGroupOutput" if _BLENDER_5 else "CompositorNodeComposite")
    links = tree.links
    lamps = None
    for name in was["groups"]:
        light = passes.outputs[f"Combined_{name}"]
        lamps = light if lamps is None else _mix(tree, "ADD", lamps, light)
    names = ("Image", *_GLOSSY, *_GUIDES)
    labels = ("Image", "Glossy Direct", "Glossy Color", "Albedo", "Normal")
    for name, label in zip(names, labels, strict=True):
        links.new(passes.outputs[name], node.inputs[label])
    matte = tree.nodes.new("CompositorNodeCryptomatteV2")
    matte.scene, matte.layer_name = scene, f"{layer.name}.CryptoMaterial"
    matte.matte_id = ",".join(was["painted"])
    links.new(matte.outputs["Matte"], node.inputs["Paint"])
    if lamps is None:
        node.inputs["Light Groups"].default_value = (0, 0, 0, 0)
    else:
        links.new(lamps, node.inputs["Light Groups"])
    links.new(node.outputs["Image"], out.inputs["Image"])
    _lay_out(tree)


def _painted() -> list[str]:
    """Names of the file's materials that hold a paint: instances too may show any of them."""
    used = [each for each in bpy.data.materials if each.users]
    return sorted({each.name for each in used if lights.holds_slots(each.node_tree)})


def _in_cryptomatte(name: str) -> bool:
    """Whether the node's list of mattes can have the name."""
    return "," not in name and not name.startswith((" ", "<"))


def _take_down(scene: bpy.types.Scene, was: dict) -> None:
    tree = _tree(scene)
    if not _is_ours(tree):
        pass  # broke off before it was made, or the artist took another
    elif _BLENDER_5:
        scene.compositing_node_group = was.get("tree")
        if not tree.users:  # a copy of the scene may have it too
            bpy.data.node_groups.remove(tree)
    else:
        del tree[_MARK]
        tree.nodes.clear()
        passes = tree.nodes.new("CompositorNodeRLayers")
        passes.scene = scene
        out = tree.nodes.new("CompositorNodeComposite")
        out.location.x = 300
        tree.links.new(passes.outputs["Image"], out.inputs["Image"])
        scene.use_nodes = bool(was["use_nodes"])
    for group in [g for g in bpy.data.node_groups if g.get(_MARK) == "group" and not g.users]:
        bpy.data.node_groups.remove(group)


def _mix(
    tree: bpy.types.NodeTree,
    blend: Literal["ADD", "LIGHTEN", "MULTIPLY", "SUBTRACT"],
    a: bpy.types.NodeSocket,
    b: bpy.types.NodeSocket | None,
) -> bpy.types.NodeSocket:
    """Both colours blended in full, b black if None. The alpha is that of a."""
    node = tree.nodes.new("ShaderNodeMix")
    node.data_type, node.blend_type = "RGBA", blend
    node.clamp_factor = node.clamp_result = False
    inputs = {socket.identifier: socket for socket in node.inputs}
    inputs["Factor_Float"].default_value = 1
    tree.links.new(a, inputs["A_Color"])
    if b is None:
        inputs["B_Color"].default_value = (0, 0, 0, 1)
    else:
        tree.links.new(b, inputs["B_Color"])
    return next(socket for socket in node.outputs if socket.identifier == "Result_Color")


def _lay_out(tree: bpy.types.NodeTree) -> None:
    """Nodes in columns, and marked as ours."""
    wiring.lay_out(tree)
    for node in tree.nodes:
        node[_MARK] = True
