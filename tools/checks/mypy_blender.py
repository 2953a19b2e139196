# SPDX-License-Identifier: Apache-2.0
"""A plugin of mypy: what Blender's Python has and the stubs of fake-bpy-module lack.

With the stubs alone mypy finds 388 errors in 24 of the add-on's 37 files, none of them a mistake:
they type a node, a socket or a light by its base class, which lacks what every use asks for.
Every name is listed, so that a wrong one is still an error.
"""

from __future__ import annotations

from collections.abc import Callable

from mypy.errorcodes import ATTR_DEFINED
from mypy.mro import calculate_mro
from mypy.nodes import ARG_POS, Argument, TypeInfo, Var
from mypy.plugin import AttributeContext, ClassDefContext, FunctionContext, MethodContext, Plugin
from mypy.plugins.common import add_attribute_to_class, add_method_to_class
from mypy.types import AnyType, Instance, LiteralType, Type, TypeOfAny, get_proper_type

ANY = AnyType(TypeOfAny.explicit)

# What Blender's subclasses have where its functions and collections are typed with the base: the
# code has asked a node, a socket or a light for its type by then.
OF_SUBCLASSES = {
    "ActionStrip": ("channelbag",),
    "AddonPreferences": ("compute_device_type",),
    "Light": ("energy", "shadow_soft_size"),
    "Node": ("attribute_name", "distribution", "node_tree", "script"),
    "NodeSocket": ("default_value",),
    "NodeTreeInterfaceItem": ("default_value", "max_value", "min_value", "subtype"),
    "Space": (
        "cursor_location", "cursor_location_from_region", "edit_tree", "shader_type", "shading",
        "tree_type",
    ),
}  # fmt: skip
OF_BLENDER_5 = {"Scene": ("compositing_node_group",)}
NAMES = {f"bpy.types.{name}": each for name, each in (OF_SUBCLASSES | OF_BLENDER_5).items()}

# Functions that the stubs have return nothing.
RETURNING = {
    "bpy.app.is_job_running",
    "bpy.props.EnumProperty",
    "bpy.utils.register_classes_factory",
}

VECTORS = {"mathutils.Color", "mathutils.Vector"}  # sequences of numbers
# What depends on the scene or on Blender's add-ons, and is typed as if it did not.
VARYING = {
    "bpy.types.CompositorNodeCryptomatteV2.layer_name",
    "bpy.types.CompositorNodeRLayers.layer",
    "bpy.types.Image.pixels",
    "bpy.types.Object.data",
    "bpy.types.RenderSettings.engine",
    "bpy.types.bpy_struct.id_data",
}

# Methods that return an object of the class that one of their arguments names.
FACTORIES = {"bpy.types.Nodes.new": 0, "bpy.types.BlendDataNodeTrees.new": 1}


class BlenderPlugin(Plugin):
    def get_customize_class_mro_hook(
        self, fullname: str
    ) -> Callable[[ClassDefContext], None] | None:
        if fullname in NAMES:
            return _add_names
        if fullname in VECTORS:
            return _make_sequence
        return _add_contains if fullname == "bpy.types.bpy_struct" else None

    def get_attribute_hook(self, fullname: str) -> Callable[[AttributeContext], Type] | None:
        return _any if fullname in VARYING else None

    def get_function_hook(self, fullname: str) -> Callable[[FunctionContext], Type] | None:
        return _any if fullname in RETURNING else None

    def get_method_hook(self, fullname: str) -> Callable[[MethodContext], Type] | None:
        if fullname not in FACTORIES:
            return None
        return lambda context: self._made(context, FACTORIES[fullname])

    def _made(self, context: MethodContext, argument: int) -> Type:
        """The class whose name is given; the stubs' base class where the name is computed."""
        given = get_proper_type(context.arg_types[argument][0])
        literal = given.last_known_value if isinstance(given, Instance) else given
        if not isinstance(literal, LiteralType):
            return context.default_return_type
        found = self.lookup_fully_qualified(f"bpy.types.{literal.value}")
        if found is None or not isinstance(found.node, TypeInfo):
            context.api.fail(f"Blender has no {literal.value}", context.context, code=ATTR_DEFINED)
            return context.default_return_type
        return Instance(found.node, [])


def _any(_context: AttributeContext | FunctionContext) -> Type:
    return ANY


def _add_names(context: ClassDefContext) -> None:
    for name in NAMES[context.cls.fullname]:
        add_attribute_to_class(context.api, context.cls, name, ANY)


def _add_contains(context: ClassDefContext) -> None:
    """`in` asks for a custom property."""
    key = Argument(Var("key"), context.api.named_type("builtins.str"), None, ARG_POS)
    boolean = context.api.named_type("builtins.bool")
    add_method_to_class(context.api, context.cls, "__contains__", [key], boolean)


def _make_sequence(context: ClassDefContext) -> None:
    number = context.api.named_type("builtins.float")
    info = context.cls.info
    info.bases, info.mro = [context.api.named_type("typing.Sequence", [number])], []
    calculate_mro(info)


def plugin(_version: str) -> type[Plugin]:
    return BlenderPlugin
