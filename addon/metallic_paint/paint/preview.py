# SPDX-License-Identifier: GPL-3.0-or-later
"""What the paint shows where no shader runs: in EEVEE, Material Preview, and Cycles without OSL.

The shader's output Rendered is 1 where it runs and 0 where none does. It mixes the shader with a
preview of ordinary nodes, in the same group and of the same sockets. That is the paint's mean by
the angle of view: the coat's highlight, a rough reflection of the flakes, and what leaves the paint
after several turns as a matt ground. Of the sparkles there is a hint: the flakes' reflection is
brighter or darker from cell to cell of the surface, around the same mean.

Where the shader runs, Cycles drops the preview before it compiles anything.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy

from ..scene import lights
from . import coatings
from .parameters import PARAMETERS

RENDERED = "Rendered"  # the shader's output
LABEL = "Preview without Open Shading Language"

_SPECIES = ("", "second.", "third.")
_RAYLEIGH = 16.7551608  # core/layer.h

# Fitted to the core's albedo of the presets and of random paints: how the mirrored directions of
# tilted flakes lie about the critical angle, how far the ways there and back lie apart, and what
# the long tail of GGX adds to the square of a slope.
_OUTWARDS, _FLANK, _APART, _GGX_TAIL = 0.9, 1.3, 1.5, 2.0

# Where a mirror is sampled, Cycles gives it a density of 1e6 and adds what other lobes have there:
# a lobe as dense, of another colour, would be counted twice. Of this roughness, alpha 0.0056, its
# density is 1e4, 1/(pi alpha^2): an error of 1 % at most.
_SHARPEST = 0.075

# Of the glitter. Nodes do not know how wide a pixel is: that of a lens of 50 mm and 1920 pixels.
_PIXEL = 36 / 50 / 1920
_LAMP = 1e-5  # square of half the angle, within the binder, at which a usual lamp is seen
_MOST_VARIANCE = 0.7  # of a cell's brightness, whose mean is 1: more looks like noise
_PEAKED = 8.0  # k, of how few cells are bright: one in nine
_TURNS = 20.0  # a cell flashes anew when the view turns by so many parts of a radian


class Value:
    """A number or a vector within a node tree; arithmetic with it makes nodes.

    Vectors are colours, directions, or one number for each of the three species. A number beside a
    vector counts for each of its parts. What is divided by 0 is 0. What was asked for before has
    its node already: Blender looks through all of a tree for each new one.
    """

    def __init__(self, socket: bpy.types.NodeSocket) -> None:
        self.socket = socket
        self.is_vector = socket.type in ("VECTOR", "RGBA")

    def __add__(self, other: Value | float) -> Value:
        return _arithmetic("ADD", self, other)

    def __radd__(self, other: float) -> Value:
        return _arithmetic("ADD", other, self)

    def __sub__(self, other: Value | float) -> Value:
        return _arithmetic("SUBTRACT", self, other)

    def __rsub__(self, other: float) -> Value:
        return _arithmetic("SUBTRACT", other, self)

    def __mul__(self, other: Value | float) -> Value:
        return _arithmetic("MULTIPLY", self, other)

    def __rmul__(self, other: float) -> Value:
        return _arithmetic("MULTIPLY", self, other)

    def __truediv__(self, other: Value | float) -> Value:
        return _arithmetic("DIVIDE", self, other)

    def __rtruediv__(self, other: float) -> Value:
        return _arithmetic("DIVIDE", other, self)

    def __abs__(self) -> Value:
        return _arithmetic("ABSOLUTE", self)

    def least(self, other: Value | float) -> Value:
        return _arithmetic("MINIMUM", self, other)

    def most(self, other: Value | float) -> Value:
        return _arithmetic("MAXIMUM", self, other)

    def cut(self) -> Value:
        """Within 0 and 1."""
        if self.is_vector:
            return self.most(0.0).least(1.0)
        return _made(self.socket.id_data, "ShaderNodeClamp", "", (self,))

    def power(self, exponent: float) -> Value:
        """Of no negative number."""
        return _arithmetic("POWER", self, exponent)

    def root(self) -> Value:
        """0 of a negative number."""
        return self.most(0.0).power(0.5) if self.is_vector else self.function("SQRT")

    def decay(self) -> Value:
        """exp(-x)."""
        return _arithmetic("POWER", 0.36787944, self)

    def function(self, operation: str) -> Value:
        """Of a Math node."""
        return _arithmetic(operation, self)

    def above(self, number: int) -> Value:
        """Of whole numbers: 1 where they are greater, else 0."""
        return (self - float(number)).cut()

    def equal(self, number: int) -> Value:
        """Of whole numbers likewise."""
        if self.is_vector:
            return (1.0 - abs(self - float(number))).most(0.0)
        return _arithmetic("COMPARE", self, float(number), 0.5)

    def dot(self, other: Value | float) -> Value:
        return _arithmetic("DOT_PRODUCT", self, other)

    def unit(self) -> Value:
        return _arithmetic("NORMALIZE", self)

    def parts(self) -> list[Value]:
        first = _made(self.socket.id_data, "ShaderNodeSeparateXYZ", "", (self,))
        return [Value(each) for each in first.socket.node.outputs]


def vector(*parts: Value | float) -> Value:
    [tree, *_] = (each.socket.id_data for each in parts if isinstance(each, Value))
    return _made(tree, "ShaderNodeCombineXYZ", "", parts)


def _arithmetic(operation: str, *operands: Value | float) -> Value:
    [tree, *_] = (each.socket.id_data for each in operands if isinstance(each, Value))
    vectors = [each for each in operands if isinstance(each, Value) and each.is_vector]
    kind = "ShaderNodeVectorMath" if vectors else "ShaderNodeMath"
    if operation == "MULTIPLY" and len(vectors) == 1:
        [number] = (each for each in operands if each is not vectors[0])
        operation, operands = "SCALE", (vectors[0], number)
    return _made(tree, kind, operation, operands)


_known: dict[tuple[object, ...], Value] = {}  # of the tree that is being made


def _made(
    tree: bpy.types.NodeTree, kind: str, operation: str, operands: tuple[Value | float, ...]
) -> Value:
    """The first output of a node of that kind, new or made before for the same operands."""
    asked = tuple(
        each.socket.as_pointer() if isinstance(each, Value) else float(each) for each in operands
    )
    key = (kind, operation, *asked)
    if key not in _known:
        node: Any = tree.nodes.new(kind)  # of a kind that no type knows before
        node.hide = True
        if operation and node.operation != operation:
            node.operation = operation
        inputs = (each for each in node.inputs if each.enabled)
        for socket, operand in zip(inputs, operands, strict=False):
            _fill(socket, operand)
        _known[key] = Value(next(each for each in node.outputs if each.enabled))
    return _known[key]


def _fill(socket: bpy.types.NodeSocket, operand: Value | float) -> None:
    if isinstance(operand, Value):
        socket.id_data.links.new(operand.socket, socket)
    else:
        socket.default_value = (operand,) * 3 if socket.type == "VECTOR" else operand


def mix_with(
    group: bpy.types.ShaderNodeTree,
    inside: bpy.types.Node,
    script: bpy.types.ShaderNodeScript,
    output: str,
) -> bpy.types.NodeSocket:
    """The shader where it runs, elsewhere the preview, whose nodes this adds to the group."""
    _known.clear()
    there = list(group.nodes)
    [scale] = script.inputs[lights.METERS_PER_UNIT].links
    previewed = _preview(_Sockets(inside), Value(scale.from_socket))
    frame = group.nodes.new("NodeFrame")
    frame.label = LABEL
    places: list[float] = []  # all at once: Blender looks through the tree for each
    for number, node in enumerate(group.nodes):
        if node in there or node == frame:
            places.extend(node.location)
            continue
        node.parent = frame
        places.extend((number // 30 * 180, -1200 - number % 30 * 45))
    group.nodes.foreach_set("location", places)
    _known.clear()
    known, runs = group.nodes.new("ShaderNodeMixShader"), group.nodes.new("ShaderNodeMixShader")
    for mix, factor, otherwise in (
        (known, _known_to_run(group, script), previewed),
        (runs, script.outputs[RENDERED], known.outputs[0]),
    ):
        mix.inputs[0].default_value = 0  # Cycles without OSL leaves the shader out, with its link
        for source, target in zip(
            (factor, otherwise, script.outputs[output]), mix.inputs, strict=True
        ):
            group.links.new(source, target)
    known.location, runs.location = (200, 0), (400, 0)
    return runs.outputs[0]


def _known_to_run(
    group: bpy.types.ShaderNodeTree, script: bpy.types.ShaderNodeScript
) -> bpy.types.NodeSocket:
    """1 where Cycles knows, before it compiles anything, that the shader runs; else 0.

    So Cycles drops the preview, whose 200 nodes OSL would compile before it finds them unused.

    Cycles takes what is subtracted from itself for 0 without knowing it. Where the shader does not
    run, Cycles leaves its links out, and the sockets that they end at differ by 1. In EEVEE the
    shader's outputs are 0, and only there a stroke's place is linked: where 1 stands for Cycles, it
    has 0.
    """
    nothing = group.nodes.new("ShaderNodeMix")
    nothing.data_type, nothing.blend_type = "RGBA", "SUBTRACT"
    factor, *values = (each for each in nothing.inputs if each.enabled)
    factor.default_value = 1
    for value, default in zip(values, (1.0, 0.0), strict=True):
        value.default_value = (default, default, default, 1)
        group.links.new(script.outputs[RENDERED], value)
    stroke = group.nodes.new("ShaderNodeUVAlongStroke")
    less = group.nodes.new("ShaderNodeVectorMath")
    less.operation = "SUBTRACT"
    less.inputs[0].default_value = (1, 1, 1)
    group.links.new(stroke.outputs[0], less.inputs[0])
    group.links.new(next(each for each in nothing.outputs if each.enabled), less.inputs[1])
    part = group.nodes.new("ShaderNodeSeparateXYZ")
    group.links.new(less.outputs[0], part.inputs[0])
    for number, node in enumerate((nothing, stroke, less, part)):
        node.hide, node.location = True, (number * 180, 300)
    return part.outputs[0]


class _Sockets:
    """The paint's values as the group's sockets give them."""

    def __init__(self, inside: bpy.types.Node) -> None:
        self.inside = inside

    def __getitem__(self, field: str) -> Value:
        return Value(self.inside.outputs[PARAMETERS[field].label])

    def of_species(self, field: str) -> Value:
        """A number of each species."""
        return vector(*(self[prefix + field] for prefix in _SPECIES))

    def direction(self, label: str, otherwise: Value) -> Value:
        """An unconnected socket is (0, 0, 0)."""
        given = Value(self.inside.outputs[label])
        is_given = given.dot(given).function("SIGN")
        return (given + otherwise * (1.0 - is_given)).unit()


def _preview(sockets: _Sockets, meters_per_unit: Value) -> bpy.types.NodeSocket:
    """The shader of flakes, ground and coat."""
    geometry = sockets.inside.id_data.nodes.new("ShaderNodeNewGeometry")
    normal = sockets.direction("Normal", Value(geometry.outputs["Normal"]))
    coat_normal = sockets.direction("Coat Normal", normal)
    cos_view = abs(normal.dot(Value(geometry.outputs["Incoming"]))).cut()
    eta = sockets["binder_ior"].most(0.1)
    # Snell's law: the cosine within the binder.
    cos_in = (1.0 - (1.0 - cos_view * cos_view) / (eta * eta)).most(1e-4).root()

    flakes = _flakes(sockets, eta)
    layer = _layer(sockets, flakes, cos_in)
    glossy, matt = _scattered(layer, _surface(eta, cos_in, flakes.slope2), sockets)
    glossy = glossy.cut()
    matt = matt.least(1.0 - glossy)  # each is a fit: together they leave no more than came

    roughness = sockets["coat_roughness"].cut()
    reflected = _coat_reflectance(cos_view, roughness, eta)
    entered = 1.0 - reflected
    # A facet of the surface must turn eta times as far as a flake below it. Blender's roughness is
    # the root of alpha.
    wide = (eta * eta * (flakes.slope2 + flakes.blur2)).power(0.25).least(1.0).most(_SHARPEST)
    glitter = _glitter(sockets, flakes, Value(geometry.outputs["Incoming"]), meters_per_unit)
    return _add(
        _glossy(glossy * entered, normal, wide, cos_view, glitter),
        _lobe("ShaderNodeBsdfDiffuse", (matt * entered).cut(), normal),
        _glossy(reflected, coat_normal, roughness, cos_view),
    )


def _glossy(
    albedo: Value, normal: Value, roughness: Value, cos_view: Value,
    brightness: Value | float = 1.0,
) -> bpy.types.NodeSocket:  # fmt: skip
    # Of light that meets facets once, so that it is in proportion to the colour. The share of it
    # that leaves GGX is 1/(1 + lost), fitted to its integral: within 7 %, face on 3 %.
    alpha = roughness * roughness
    aslant = 1.077 * (1.0 - cos_view)
    lost = alpha * (aslant + alpha * (3.256 * cos_view - 1.713 + 0.803 * alpha))
    color = albedo * (1.0 + lost) * brightness
    lobe = _lobe("ShaderNodeBsdfGlossy", color, normal, roughness)
    lobe.node.distribution = "GGX"
    return lobe


def _lobe(
    kind: str, color: Value, normal: Value, roughness: Value | None = None
) -> bpy.types.NodeSocket:
    node = color.socket.id_data.nodes.new(kind)
    _fill(node.inputs["Color"], color)
    _fill(node.inputs["Normal"], normal)
    if roughness is not None:
        _fill(node.inputs["Roughness"], roughness)
    return node.outputs[0]


def _add(*shaders: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    total, *more = shaders
    for each in more:
        node = each.id_data.nodes.new("ShaderNodeAddShader")
        each.id_data.links.new(total, node.inputs[0])
        each.id_data.links.new(each, node.inputs[1])
        total = node.outputs[0]
    return total


# --- flakes ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Flakes:
    """Of all species, as vectors over them where there is one for each; means by coverage."""

    met: Value  # by light that crosses the layer
    cosine: Value  # at which light meets a flake, per cosine of the light
    slope2: Value  # mean square of the tilts
    blur2: Value  # the same of what else widens the reflection
    diameter: Value


def _flakes(sockets: _Sockets, eta: Value) -> _Flakes:
    diameter = sockets.of_species("flake_diameter_um").most(1e-3)
    spread = sockets.of_species("flake_area_spread")
    # E[max(0, 1 + s w)] of a normal w is near the hyperbola that has its asymptote (4 %).
    mean_area = 0.5 + 0.5 * (1.0 + 0.63661977 * spread * spread).root()
    coverage = sockets.of_species("flakes_per_mm2").most(0.0) * (
        0.785398163e-6 * diameter * diameter * mean_area
    )
    tilt = sockets.of_species("tilt").most(1e-6)
    orientation = sockets.of_species("orientation")
    gaussian, ggx = orientation.equal(0), orientation.equal(2)
    slope2 = tilt * tilt * (1.0 + gaussian)
    # core/orientation.h has the mean cosine exactly.
    mean_cos = 1.0 / (1.0 + 0.5 * slope2 * (1.0 - ggx) + tilt.power(1.65) * ggx)
    # Waves and the edge spread the light of a flake: half as far turns a mirror.
    wave = sockets.of_species("flake_spread")
    edge = sockets["diffraction"] * 0.350140875 / eta / diameter
    covered = coverage.dot(1.0).most(1e-6)
    return _Flakes(
        met=coverage * mean_cos,
        cosine=(1.0 - 0.5 * slope2).most(0.0),
        slope2=coverage.dot(slope2 * (1.0 + (_GGX_TAIL - 1.0) * ggx)) / covered,
        blur2=coverage.dot(0.25 * (wave * wave + edge * edge)) / covered,
        diameter=coverage.dot(diameter) / covered,
    )


# --- glitter ---------------------------------------------------------------------------------


def _glitter(sockets: _Sockets, flakes: _Flakes, incoming: Value, meters_per_unit: Value) -> Value:
    """What the flakes' reflection is multiplied by in a cell of the surface: 1 in the mean.

    Cells are as wide as flakes lie apart, or twice, four times... as wide: at least two pixels. Of
    the n flakes in a cell, n q mirror a lamp, so its light varies by 1/(n q) about its mean.
    """
    nodes = sockets.inside.id_data.nodes
    place = Value(nodes.new("ShaderNodeTexCoord").outputs["Object"])
    turned = nodes.new("ShaderNodeVectorTransform")
    turned.vector_type, turned.convert_from, turned.convert_to = "VECTOR", "OBJECT", "WORLD"
    turned.inputs[0].default_value = (0.57735027,) * 3
    size = Value(turned.outputs[0])  # of the object: how long a unit of it is
    meters = size.dot(size).root() * meters_per_unit
    distance = Value(nodes.new("ShaderNodeCameraData").outputs["View Distance"]) * meters_per_unit
    apart = 1e-3 / sockets.of_species("flakes_per_mm2").dot(1.0).most(1e-6).root()
    pixels = (2 * _PIXEL * distance / apart).most(1.0)
    wide = _arithmetic("POWER", 2.0, _arithmetic("LOGARITHM", pixels, 2.0).function("CEIL"))

    cells = nodes.new("ShaderNodeTexVoronoi")
    cells.inputs["Scale"].default_value = 1
    _fill(cells.inputs["Vector"], place * (meters / (apart * wide)))
    cell = Value(cells.outputs["Color"])
    noise = nodes.new("ShaderNodeTexWhiteNoise")
    _fill(noise.inputs["Vector"], cell + _arithmetic("FLOOR", cell + _TURNS * incoming))
    u = Value(noise.outputs["Value"])

    # (1 + k) u^k has the mean 1 and the variance k^2/(1 + 2 k): few bright cells in a dark ground.
    # A share of it on an even one has the share's square of that variance, and no dark specks.
    mirrored = wide * wide * (flakes.blur2 + _LAMP) / flakes.slope2.most(1e-9)
    contrast = sockets["sparkle_contrast"].cut()
    variance = contrast * contrast * (1.0 / mirrored).least(_MOST_VARIANCE)
    share = variance.root() * (math.sqrt(1 + 2 * _PEAKED) / _PEAKED)
    return 1.0 - share + share * ((1 + _PEAKED) * u.power(_PEAKED))


def _coatings(sockets: _Sockets, cos_alpha: Value) -> Iterator[tuple[Value, Value]]:
    """Reflectance and transmittance of each species' flakes: core/coating.h."""
    kind = sockets.of_species("coating")
    is_pearl = kind.above(coatings.FIRST_PEARL - 1)
    is_iron = kind.above(coatings.FIRST_IRON - 1) * (1.0 - kind.above(coatings.LAST_IRON))
    is_titania = is_pearl * (1.0 - kind.above(coatings.FIRST_IRON - 1))
    nm = sockets.of_species("coating_nm") * (1 / coatings.NM_PER_ROW)
    further = nm.most(0.0).least(coatings.ROWS - 1.0)
    row = kind - 1.0 + is_pearl * (
        (coatings.ROWS - 1.0) * (kind - float(coatings.FIRST_PEARL)) + further
    )  # fmt: skip
    node = (6.0 * cos_alpha).most(24.0 * cos_alpha - 12.0)
    schlick = (1.0 - cos_alpha).power(5.0)
    each_species = zip(
        _SPECIES,
        *(each.parts() for each in (kind.equal(0), is_iron, is_titania, row, node, schlick)),
        strict=True,
    )
    for prefix, own, iron, titania, at_row, at_node, at_edge in each_species:
        through = sockets[prefix + "flake_transmission"].cut()
        face = sockets[prefix + "flake_color"].least(1.0 - through)
        edge = sockets[prefix + "flake_edge_color"].least(1.0 - through)
        measured = _in_table(at_node, at_row)
        passed = _in_table(at_node, at_row + float(coatings.TRANSMITTANCES))
        yield (
            (face + (edge - face) * at_edge) * own + measured * (1.0 - own),
            through * own + passed * iron + (1.0 - measured) * titania,
        )


def _in_table(node: Value, row: Value) -> Value:
    """core/coating.h's library, which an image holds and interpolates."""
    image = coatings.table()
    width, height = image.size
    place = vector((node + 0.5) * (1 / width), (row + 0.5) * (1 / height), 0.0)
    texture = node.socket.id_data.nodes.new("ShaderNodeTexImage")
    texture.image, texture.hide = image, True
    texture.interpolation, texture.extension = "Linear", "EXTEND"
    _fill(texture.inputs["Vector"], place)
    return Value(texture.outputs["Color"])


# --- the layer -------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Layer:
    """What light meets that crosses the layer on the way of the view, as optical depths."""

    mirror: Value  # reflected by flakes
    loss: Value  # absorbed by them
    blocking: Value  # all that they stop
    absorption: Value  # of the binder
    rayleigh: Value
    apart: Value  # how far the ways there and back lie apart, in diameters of a flake


def _layer(sockets: _Sockets, flakes: _Flakes, cos_in: Value) -> _Layer:
    mirror, loss, blocking = [], [], []
    cos_alpha = flakes.cosine * cos_in
    for met, (reflectance, transmittance) in zip(
        flakes.met.parts(), _coatings(sockets, cos_alpha), strict=True
    ):
        stopped = 1.0 - transmittance
        mirror.append(reflectance * met)
        loss.append((stopped - reflectance).most(0.0) * met)
        blocking.append(stopped * met)
    thickness_mm = 1e-3 * sockets["layer_thickness_um"]
    along = thickness_mm / cos_in
    tangent2 = 1.0 / (cos_in * cos_in) - 1.0
    delta = 2.0 * (tangent2 + _APART * flakes.slope2).root()  # core/hot_spot.h
    return _Layer(
        mirror=mirror[0] + mirror[1] + mirror[2],
        loss=loss[0] + loss[1] + loss[2],
        blocking=blocking[0] + blocking[1] + blocking[2],
        absorption=sockets["binder_absorption_per_mm"].most(0.0) * along,
        rayleigh=_RAYLEIGH * sockets["rayleigh_per_mm"] * along,
        apart=delta * thickness_mm * 1e3 / flakes.diameter,
    )


@dataclass(frozen=True)
class _Surface:
    """What the binder's surface does to the light within."""

    leaving: Value  # share of what the flakes mirror that gets out
    turned: Value  # share of the rest that gets out by the next flakes
    escaping: Value  # share of diffuse light that gets out


def _surface(eta: Value, cos_in: Value, slope2: Value) -> _Surface:
    # Mirrored directions lie normally about that of a level mirror. Of a normal distribution the
    # share below the critical angle is near a logistic function.
    width = (2.0 * slope2).root() + 1e-3
    angle = cos_in.function("ARCCOSINE")
    critical = (1.0 / eta).least(1.0).function("ARCSINE")
    beyond = ((angle * angle + _OUTWARDS * width * width).root() - critical) / width
    odds = (1.702 / _FLANK * beyond).most(-30.0).decay()
    # Diffuse light meets the surface from within: a fit of Egan and Hilgeman, 1973.
    index = eta.most(1.0).least(2.5)
    escaping = 1.4399 / (index * index) - 0.7099 / index + 0.3319 - 0.0636 * index
    return _Surface(
        leaving=odds / (1.0 + odds),
        turned=2.0 * escaping * slope2.root() / (1.0 + 2.0 * slope2),  # core/mixture.h
        escaping=escaping,
    )


def _scattered(layer: _Layer, surface: _Surface, sockets: _Sockets) -> tuple[Value, Value]:
    """What leaves the paint, of the light that enters: mirrored by flakes, and diffuse."""
    # Light down and up in the layer (Kubelka and Munk), whose substrate is black:
    # R = s sinh x / d, T = x / d, d = (s + k) sinh x + x cosh x; here times 2 exp(-x).
    s = layer.mirror + 0.5 * layer.rayleigh
    k = layer.loss + layer.absorption
    x = (k * (k + 2.0 * s)).root() + 1e-3
    once = x.decay()
    sinh, cosh = 1.0 - once * once, 1.0 + once * once
    d = (s + k) * sinh + x * cosh
    r, t = s * sinh / d, 2.0 * once * x / d

    # Depth Model correlated, core/hot_spot.h: what hides a flake from the observer often hides it
    # from the light as well. More is reflected at once, and less is left.
    depth = 2.0 * (layer.blocking + layer.absorption + layer.rayleigh)
    y = layer.apart / (1.0 + 0.0971 * depth)
    share = (1.0 + 1.6392 * y) / (1.0 + y * (2.0389 + 1.8717 * y / (1.0 + 0.1464 * depth)))
    common = share * layer.blocking.least(0.5 * depth) * sockets["depth_model"].equal(2)
    apart = s * _mean_transmittance(depth)
    single = s * _mean_transmittance(depth - common)
    kept = 1.0 - k * _mean_transmittance(s + k)
    less = ((kept - single) / (kept - apart).most(1e-6)).cut()
    near = single + (r - apart).most(0.0) * less

    trapped = near * (1.0 - surface.leaving)
    again = 1.0 - r * (1.0 - surface.turned)
    down = t * less + trapped * t / again
    # What the substrate scatters leaves, or comes back from the flakes and from the surface.
    inwards = 1.0 - surface.escaping
    between = t / (1.0 - inwards * r)
    substrate = sockets["substrate_color"].cut()
    back = (1.0 - substrate * (r + inwards * t * between)).most(1e-3)
    ground = down * substrate * between * surface.escaping / back
    return near * surface.leaving, trapped * r * surface.turned / again + ground


def _mean_transmittance(x: Value) -> Value:
    """(1 - exp(-x))/x."""
    x = x.most(1e-3)
    return (1.0 - x.decay()) / x


# --- the coat --------------------------------------------------------------------------------


def _coat_reflectance(cos_view: Value, roughness: Value, eta: Value) -> Value:
    """core/composition.h: what the facets of a rough surface reflect in all."""
    q = roughness.power(2.5)
    k = 0.55 * q / (1.0 + 0.56 * q)
    square = cos_view * cos_view
    facets = _fresnel((square + k * (1.0 - 0.6 * square)).root(), eta)
    return facets * (1.0 - roughness * roughness * (0.43 + 0.26 * cos_view))


def _fresnel(cosine: Value, eta: Value) -> Value:
    """Reflectance of a surface for unpolarised light; 1 where nothing passes."""
    eta2 = eta * eta
    g = (eta2 - 1.0 + cosine * cosine).root()
    across = (cosine - g) / (cosine + g)
    along = (eta2 * cosine - g) / (eta2 * cosine + g)
    return (0.5 * (across * across + along * along)).cut()
