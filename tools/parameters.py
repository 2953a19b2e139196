# SPDX-License-Identifier: Apache-2.0
"""Makes of parameters.toml what describes a paint's parameters elsewhere, in each language.

The made files are committed: a reader sees the real struct and the shader's real inputs, the core
builds with CMake alone, the shader's text is whole without Python, and a commit shows what a
change of the table does. tests/python/test_parameters.py holds them to the table.
"""

from __future__ import annotations

import re
import textwrap
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TABLE = "parameters.toml"
MADE = f"Made by tools/parameters.py from {TABLE}: do not edit."
WIDTH = 100

INT_RANGE = [-(2**31), 2**31 - 1]


class TableError(ValueError):
    """What is wrong with the table."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """One of several words. The columns are explained in the table."""

    name: str
    tooltip: str
    choices: Sequence[str] = ()
    enum: str = ""

    @property
    def choice(self) -> str:
        """The name of the choice in C++."""
        return self.enum or camel(self.name)


@dataclass(frozen=True, kw_only=True)
class Parameter(Choice):
    """A row of the table, of a paint."""

    type: str
    default: Any
    label: str
    panel: str
    usual: str
    manual: str
    acts_on: str | list[str]
    range: Sequence[float] = ()
    useful: Sequence[float] = ()
    unit: str = ""
    subtype: str = "NONE"
    default_of_further: float | None = None
    as_roughness: dict[str, Any] | None = None
    input: str = ""
    former: Sequence[dict[str, Any]] = ()

    @property
    def shader(self) -> str:
        return self.input or camel(self.name)

    @property
    def is_triple(self) -> bool:
        return self.type in ("color", "rgb")

    @property
    def number(self) -> int | float | list[float]:
        """The default as the shader has it."""
        return self.choices.index(self.default) if self.choices else self.default

    @property
    def ends(self) -> Sequence[float]:
        return [0, len(self.choices) - 1] if self.choices else self.range

    @property
    def functions(self) -> list[str]:
        return [self.acts_on] if isinstance(self.acts_on, str) else self.acts_on


@dataclass(frozen=True)
class Table:
    version_of_defaults: int
    most_of_a_sum: float
    flakes: list[Parameter]
    paint: list[Parameter]
    lights: list[Choice]

    @property
    def all(self) -> list[Parameter]:
        return [*self.flakes, *self.paint]

    @property
    def choices(self) -> list[Choice]:
        return [*(each for each in self.all if each.choices), *self.lights]


def camel(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def read(file: Path = ROOT / TABLE) -> Table:
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    for key in ("flakes", "paint"):
        content[key] = [_row(name, columns) for name, columns in content[key].items()]
    content["lights"] = [Choice(name=name, **of) for name, of in content["lights"].items()]
    return Table(**content)


def _row(name: str, columns: dict[str, Any]) -> Parameter:
    try:
        row = Parameter(name=name, **columns)
    except TypeError as error:
        raise TableError(f"{TABLE}: {name}: {error}.") from error
    if row.tooltip.endswith("{choices}"):
        numbered = ", ".join(f"{i} {word}" for i, word in enumerate(row.choices) if i)
        columns = columns | {"tooltip": row.tooltip.replace("{choices}", numbered)}
        row = Parameter(name=name, **columns)
    return row


# ---- Texts that several languages share ----


def plain(number: float) -> str:
    """0.001, 1e-06, 1e+09: as C++ and Python both write it in messages."""
    return f"{number:.9g}"


def literal(number: float) -> str:
    """A number of C++ or Python source: 20, 0.3, 1e-6, 1e9."""
    text = f"{number:g}" if float(f"{number:g}") == number else repr(number)
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m[1].replace("+", "") + m[2], text)


def real(number: float) -> str:
    """The same where only a point makes it a real number: 20.0."""
    text = literal(number)
    return text if re.search(r"[.e]", text) else text + ".0"


def explained(row: Parameter) -> str:
    """The comment on a field: what the tooltip begins with, range and unit."""
    text = row.tooltip.partition(". ")[0]
    if row.range and row.range != INT_RANGE:
        text += f"; {literal(row.range[0])} to {literal(row.range[1])} {row.unit}".rstrip()
    if row.as_roughness:
        least, most = row.as_roughness["range"]
        text += f", {literal(least)} to {literal(most)} {row.as_roughness['unit']}"
    return text


def comment(text: str, mark: str, indent: int) -> list[str]:
    start = " " * indent + mark + " "
    return textwrap.wrap(
        text, WIDTH, initial_indent=start, subsequent_indent=start, break_on_hyphens=False
    )


def packed(items: list[str], start: str, end: str, width: int = WIDTH) -> list[str]:
    """start, the items with commas between them, end: in as many lines as it takes."""
    lines = [start]
    for number, item in enumerate(items):
        text = item + (end if number == len(items) - 1 else ",")
        if lines[-1] == start or lines[-1].isspace():
            lines[-1] += text
        elif len(lines[-1]) + 1 + len(text) <= width:
            lines[-1] += " " + text
        else:
            lines.append(" " * len(start) + text)
    return lines


# ---- C++ ----


def cpp_choices(table: Table) -> Iterator[str]:
    yield from (
        "// SPDX-License-Identifier: Apache-2.0",
        f"// {MADE}",
        "//",
        "// What a paint can choose from, and the words by which people do; kinds of light.",
        "#pragma once",
        "",
        "#include <array>",
        "",
        "namespace metallic_paint {",
    )
    for row in table.choices:
        yield ""
        yield from comment(row.tooltip.partition(". ")[0], "//", 0)
        members = [f"{word.replace('-', '_')} = {i}" for i, word in enumerate(row.choices)]
        line = f"enum class {row.choice} {{ {', '.join(members)} }};"
        if len(line) <= WIDTH:
            yield line
        else:
            yield f"enum class {row.choice} {{"
            yield from (f"  {member}," for member in members[:-1])
            yield f"  {members[-1]}"
            yield "};"
        yield from _cpp_words(row)
    yield from ("", "// Calls visit(name, Choice{}, words, explanation) for each of them.",
                "template <class Visit>", "void each_choice(const Visit& visit) {")  # fmt: skip
    for row in table.choices:
        first = f'  visit("{row.choice}", {row.choice}{{}}, k{row.choice}Words,'
        yield first
        lines = textwrap.wrap(row.tooltip, WIDTH - 12, break_on_hyphens=False)
        spaced = [f'        "{line} "' for line in lines[:-1]]
        yield from (*spaced, f'        "{lines[-1]}");')
    yield from ("}", "", "}  // namespace metallic_paint")


def _cpp_words(row: Choice) -> Iterator[str]:
    start = f"inline constexpr std::array k{row.choice}Words{{"
    words = [f'"{word}"' for word in row.choices]
    lines = packed(words, start, "};")
    if len(lines) == 1:
        yield from lines
    else:  # clang-format would set a table
        yield from ("// clang-format off", *packed(words, start, "};"), "// clang-format on")


def cpp_parameters(table: Table) -> Iterator[str]:
    yield from (
        "// SPDX-License-Identifier: Apache-2.0",
        f"// {MADE}",
        "//",
        "// A metallic paint as artists and presets state it: real units in the names, the ranges",
        "// that validate() holds them to (paint.h).",
        "#pragma once",
        "",
        "#include <array>",
        "#include <cstddef>",
        "",
        '#include "choices.h"',
        '#include "vector.h"',
        "",
        "namespace metallic_paint {",
        "",
        "inline constexpr int kSpecies = 3;  // of flakes, in a paint",
        "",
        "// One species of flakes.",
        "struct FlakeSpecies {",
    )
    for row in table.flakes:
        yield from _cpp_field(row)
    equality = "  bool operator==(const {}&) const = default;"
    further = ", ".join(
        f".{row.name} = {literal(row.default_of_further)}"
        for row in table.flakes
        if row.default_of_further is not None
    )
    yield from (
        "",
        equality.format("FlakeSpecies"),
        "};",
        "",
        "// The first species is the paint's own; most paints have no other.",
        "struct Paint : FlakeSpecies {",
        f"  std::array<FlakeSpecies, kSpecies - 1> more{{FlakeSpecies{{{further}}},",
        f"                                              FlakeSpecies{{{further}}}}};",
    )
    for row in table.paint:
        yield from _cpp_field(row)
    yield from (
        "  // Another number, another draw of the same flakes. The scene's, not the paint's.",
        "  int frame = 0;",
        "",
        "  const FlakeSpecies& species(int i) const {",
        "    return i == 0 ? *this : more[static_cast<std::size_t>(i - 1)];",
        "  }",
        equality.format("Paint"),
        "};",
        "",
        "struct Range {",
        "  double least, most;",
        '  const char* unit = "";  // as it stands behind the range',
        "};",
        "",
    )
    for row in table.flakes:
        if row.as_roughness:
            ends = _cpp_range(row.as_roughness)
            yield f"inline constexpr Range k{camel(row.name)}AsRoughness{ends};"
    yield from (
        "// Of two colours; 1 but for the rounding of floats.",
        f"inline constexpr double kMostOfASum = {literal(table.most_of_a_sum)};",
        "",
        "// Calls visit(name, member, range) for each parameter; for a choice, range is its words.",
        "template <class Visit>",
        "void each_flake_parameter(const Visit& visit) {",
        *(_cpp_visit("FlakeSpecies", row) for row in table.flakes),
        "}",
        "",
        "template <class Visit>",
        "void each_paint_parameter(const Visit& visit) {",
        *(_cpp_visit("Paint", row) for row in table.paint),
        "}",
        "",
        "}  // namespace metallic_paint",
    )


def _cpp_field(row: Parameter) -> Iterator[str]:
    yield from comment(explained(row), "//", 2)
    if row.choices:
        yield f"  {row.choice} {row.name} = {row.choice}::{row.default.replace('-', '_')};"
    elif row.is_triple:
        yield f"  Rgb<double> {row.name}{{{', '.join(map(literal, row.default))}}};"
    else:
        kind = {"float": "double", "int": "int"}[row.type]
        yield f"  {kind} {row.name} = {literal(row.default)};"


def _cpp_range(of: dict[str, Any]) -> str:
    parts = [literal(end) for end in of["range"]] + ([f'" {of["unit"]}"'] if of["unit"] else [])
    return "{" + ", ".join(parts) + "}"


def _cpp_visit(struct: str, row: Parameter) -> str:
    ends = f"k{row.choice}Words"
    if not row.choices:
        ends = "Range" + _cpp_range({"range": row.range, "unit": row.unit})
    return f'  visit("{row.name}", &{struct}::{row.name}, {ends});'


# ---- The bindings' types ----


def stubs(table: Table) -> Iterator[str]:
    yield from (
        "# SPDX-License-Identifier: Apache-2.0",
        f"# {MADE}",
        '"""Types of the paint in the native module."""',
        "",
        "from collections.abc import Sequence",
        "from enum import IntEnum",
        "from typing import ClassVar",
        "",
    )
    for row in table.choices:
        yield f"class {row.choice}(IntEnum):"
        yield from (f"    {word.replace('-', '_')} = {i}" for i, word in enumerate(row.choices))
        yield ""
    yield "Colour = tuple[float, float, float]"
    yield ""
    yield "class FlakeSpecies:"
    for row in table.flakes:
        yield from _stub_field(row)
    yield from ("", "    def __init__(self, **fields: object) -> None: ...",
                "    def __eq__(self, other: object, /) -> bool: ...",
                "    __hash__: ClassVar[None]", "",
                "class Paint(FlakeSpecies):",
                "    more: Sequence[FlakeSpecies]  # the second and the third species")  # fmt: skip
    for row in table.paint:
        yield from _stub_field(row)
    yield from (
        "    frame: int",
        "",
        "    def __init__(self, **fields: object) -> None: ...",
        "    def validate(self) -> None: ...",
    )


def _stub_field(row: Parameter) -> Iterator[str]:
    kind = row.choice if row.choices else "Colour" if row.is_triple else row.type
    yield from comment(explained(row), "#", 4)
    yield f"    {row.name}: {kind}"


# ---- OSL ----

OSL_HEAD = ("// SPDX-License-Identifier: Apache-2.0", f"// {MADE}", "//")
OSL_WIDTH = 125


def osl_choices(table: Table) -> Iterator[str]:
    yield from (*OSL_HEAD, "// What a paint can choose from; the kinds of light.", "#pragma once")
    for row in table.choices:
        yield ""
        for i, word in enumerate(row.choices):
            yield f"#define {row.name.upper()}_{word.upper().replace('-', '_')} {i}"


def osl_inputs(table: Table) -> Iterator[str]:
    yield from (*OSL_HEAD, "// The paint's inputs, for the list of parameters of the shader.")
    for number, species in enumerate(("", "Second", "Third"), start=1):
        for row in table.flakes:
            yield from _osl_input(row, species, number)
    for row in table.paint:
        yield from _osl_input(row)


def _ascii(text: str) -> str:
    """Blender writes the shader's text in the system's encoding, which need not be UTF-8."""
    plain = text.translate({ord("²"): "2", ord("µ"): "u", ord("°"): " degrees"})
    if not plain.isascii():
        raise TableError(f"{text!r} holds a sign that has no plain form for the shader's text.")
    return plain


def _osl_input(row: Parameter, species: str = "", number: int = 1) -> Iterator[str]:
    kind = {"choice": "int", "rgb": "color"}.get(row.type, row.type)
    default = row.number
    if species and row.default_of_further is not None:
        default = row.default_of_further
    label = f"{row.label} {number}" if species else row.label
    says = [f'string label = "{_ascii(label)}"', f'string help = "{_ascii(row.tooltip)}"']
    if row.choices:
        words = "|".join(f"{word}:{i}" for i, word in enumerate(row.choices))
        says += ['string widget = "mapper"', f'string options = "{words}"']
    elif row.range != INT_RANGE:
        says += [f"float min = {real(row.range[0])}", f"float max = {real(row.range[1])}"]
        if row.useful:
            says += [f"float slidermin = {real(row.useful[0])}",
                     f"float slidermax = {real(row.useful[1])}"]  # fmt: skip
    yield f"  {kind} {species}{row.shader} = {_osl_value(row, default)}"
    yield f"    [[ {says[0]},"
    yield f"       {says[1]}" + ("," if says[2:] else " ]],")
    if says[2:]:
        yield f"       {', '.join(says[2:])} ]],"


def _osl_value(row: Parameter, value: float | list[float]) -> str:
    if isinstance(value, list):
        return f"color({', '.join(map(real, value))})"
    return real(value) if row.type == "float" else str(value)


def osl_parameters(table: Table) -> Iterator[str]:
    yield from (
        *OSL_HEAD,
        "// A paint as core/parameters.h has it, of the shader's inputs: each within its range; "
        "what is no number becomes the default.",
        "#pragma once",
        "",
        '#include "choices.h"',
        '#include "sound.h"',
        "",
        "struct FlakeSpecies {",
        *(f"  {_osl_type(row)} {row.name};" for row in table.flakes),
        "};",
        "",
        "struct Paint {",
        *(f"  {_osl_type(row)} {row.name};" for row in table.paint),
        "};",
        "",
    )
    yield from _osl_sound("FlakeSpecies", "sound_species", table.flakes)
    yield ""
    yield from _osl_sound("Paint", "sound_paint", table.paint)
    yield ""
    yield "// The calls, inside the shader."
    for name, species in (("FIRST", ""), ("SECOND", "Second"), ("THIRD", "Third")):
        arguments = []
        for row in table.flakes:
            arguments.append(species + row.shader)
            if row.default_of_further is not None:
                arguments.append(real(row.default_of_further if species else row.default))
        yield from _osl_macro(f"SOUND_{name}_SPECIES", "sound_species", arguments)
    yield from _osl_macro("SOUND_PAINT", "sound_paint", [row.shader for row in table.paint])


def _osl_type(row: Parameter) -> str:
    return {"choice": "int", "rgb": "color"}.get(row.type, row.type)


def _osl_sound(struct: str, function: str, rows: list[Parameter]) -> Iterator[str]:
    arguments = []
    for row in rows:
        arguments.append(f"{_osl_type(row)} {row.name}")
        if row.default_of_further is not None:
            arguments.append(f"float default_{row.name}")
    yield from packed(arguments, f"{struct} {function}(", ")", OSL_WIDTH)
    yield "{"
    yield f"  {struct} given;"
    for row in rows:
        given, default = f"given.{row.name}", _osl_value(row, row.number)
        if row.default_of_further is not None:
            default = f"default_{row.name}"
        if row.choices:
            yield f"  {given} = clamp({row.name}, 0, {len(row.choices) - 1});"
        elif row.type == "int":
            yield f"  {given} = {row.name};"
        else:
            sound = f"  {given} = sound({row.name}, {{}}, {default});"
            ends = ", ".join(map(real, row.range))
            if row.as_roughness:
                ends_of_other = ", ".join(map(real, row.as_roughness["range"]))
                yield "  if (given.orientation == ORIENTATION_GAUSSIAN)"
                yield "  " + sound.format(ends)
                yield "  else"
                yield "  " + sound.format(ends_of_other)
            else:
                yield sound.format(ends)
    yield "  return given;"
    yield "}"


def _osl_macro(name: str, function: str, arguments: list[str]) -> Iterator[str]:
    yield f"#define {name} \\"
    lines = packed(arguments, f"  {function}(", ")", OSL_WIDTH - 2)
    yield from (f"{line} \\" for line in lines[:-1])
    yield lines[-1]


# ---- The add-on ----


def addon(table: Table) -> Iterator[str]:
    yield from (
        "# SPDX-License-Identifier: GPL-3.0-or-later",
        f"# {MADE}",
        '"""The fields of a paint with their defaults, and what is to be known of each."""',
        "",
        "from __future__ import annotations",
        "",
        "from dataclasses import dataclass",
        "",
        "from .parameter import Color, Parameter",
        "",
        "# fmt: off",
        f"VERSION_OF_DEFAULTS = {table.version_of_defaults}",
        "# By field: a default that was, and the last version of the defaults that had it.",
        "FORMER_DEFAULTS: dict[str, tuple[tuple[int, float | str | Color], ...]] = {",
    )
    for row in table.all:
        if row.former:
            former = [
                f"({each['through']}, {_python(row, each['default'])})" for each in row.former
            ]
            yield f'    "{row.name}": ({", ".join(former)},),'
    yield from ("}", "", "# Of two colours; 1 but for the rounding of floats.",
                f"MOST_OF_A_SUM = {literal(table.most_of_a_sum)}")  # fmt: skip
    for kinds in table.lights:
        names = ", ".join(word.upper() for word in kinds.choices)
        yield from ("", *comment(kinds.tooltip, "#", 0),
                    f"{names} = range({len(kinds.choices)})")  # fmt: skip
    for name, rows in (("Flake", table.flakes), ("Paint", table.paint)):
        yield from ("", "", "@dataclass(frozen=True)", f"class {name}Fields:")
        for row in rows:
            kind = {"choice": "str", "color": "Color", "rgb": "Color"}.get(row.type, row.type)
            yield f"    {row.name}: {kind} = {_python(row, row.default)}"
    for name, rows in (("FLAKE", table.flakes), ("PAINT", table.paint)):
        yield from ("", "", f"{name}_PARAMETERS = {{")
        for row in rows:
            yield f'    "{row.name}": Parameter('
            yield from (f"        {line}" for line in _parameter(row))
            yield "    ),"
        yield "}"
    yield ""
    for row in table.flakes:
        if row.as_roughness:
            yield f"{row.name.upper()}_AS_ROUGHNESS = Parameter("
            yield from (f"    {line}" for line in _parameter(row, row.as_roughness))
            yield ")"


def _python(row: Parameter, value: float | str | list[float]) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return f"({', '.join(map(real, value))})"
    return real(value) if row.type == "float" else str(value)


def _parameter(row: Parameter, changes: dict[str, Any] = {}) -> Iterator[str]:  # noqa: B006
    """The arguments of the add-on's Parameter, in lines."""
    ends = changes.get("range", row.ends)
    yield f'"{row.shader}", "{row.label}", "{row.panel}", {literal(ends[0])}, {literal(ends[1])},'
    lines = textwrap.wrap(row.tooltip, WIDTH - 12, break_on_hyphens=False)
    yield from (f'"{line} "' for line in lines[:-1])
    yield f'"{lines[-1]}",'
    if row.choices:
        yield from packed([f'"{word}"' for word in row.choices], "choices=(", "),", WIDTH - 8)
    more = []
    if unit := changes.get("unit", row.unit):
        more.append(f'unit="{unit}"')
    if row.subtype != "NONE":
        more.append(f'subtype="{row.subtype}"')
    if row.type == "color":
        more.append("is_color=True")
    if row.useful:
        more.append(f"useful=({literal(row.useful[0])}, {literal(row.useful[1])})")
    if more:
        yield ", ".join(more) + ","


# ---- The manual ----


def manual(table: Table, text: str) -> str:
    """The manual, with the rows of the table under the heading of each panel.

    What else stands in a table, such as Frame, stays where it is, behind them.
    """
    labels = {row.label for row in table.all}
    for panel in dict.fromkeys(row.panel for row in table.all):
        rows = [f"| {row.label} | {row.usual} | {row.manual} |"
                for row in table.all if row.panel == panel]  # fmt: skip
        head = re.compile(
            rf"(^## {panel}\n\n\|[^\n]*\n\| ---[^\n]*\n)((?:\|[^\n]*\n)*)", re.MULTILINE
        )
        if not (found := head.search(text)):
            raise TableError(f"{MANUAL} has no table under ## {panel}.")
        others = [
            line for line in found[2].splitlines() if line.split("|")[1].strip() not in labels
        ]
        made = "".join(line + "\n" for line in (*rows, *others))
        text = text[: found.start()] + found[1] + made + text[found.end() :]
    return text


# ---- All of them ----

_FILES: dict[str, Callable[[Table], Iterator[str]]] = {
    "core/choices.h": cpp_choices,
    "core/parameters.h": cpp_parameters,
    "osl/choices.h": osl_choices,
    "osl/parameters.h": osl_parameters,
    "osl/parameters.inc": osl_inputs,
    "bindings/metallic_paint_core/_paint.pyi": stubs,
    "addon/metallic_paint/paint/table.py": addon,
}
MANUAL = "docs/manual/parameters.md"


def made(table: Table) -> dict[str, str]:
    """The text of every made file, by its path."""
    texts = {path: "\n".join(lines(table)) + "\n" for path, lines in _FILES.items()}
    texts[MANUAL] = manual(table, (ROOT / MANUAL).read_text(encoding="utf-8"))
    return texts


def main() -> None:
    for path, text in made(read()).items():
        file = ROOT / path
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
            print(path)


if __name__ == "__main__":
    main()
