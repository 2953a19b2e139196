# SPDX-License-Identifier: Apache-2.0
"""The shader's text reimplements the core's: a header for a header, the same functions in order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SHADER = sorted(path.name for path in (ROOT / "osl").glob("*.h"))

# Functions that only one of the two has, and why.
ONLY_SHADER = {
    "find_own_space": "the renderer's transforms",
    "sparkle_cone": "a closure",
    "mirror": "a closure",
    "mirrored_cone": "a closure",
    "nothing_expected": "C++ has default values",
    "no_flake": "C++ has default values",
    "no_flakes": "C++ has default values",
    "no_such_flakes": "C++ has default values",
    "no_mixture": "C++ has default values",
    "no_part": "C++ has default values",
    "no_returning": "C++ has default values",
    "mixture_rule": "C++ has constant arrays",
    "channels_of": "C++ copies no loop",
    **dict.fromkeys(("flakes_of", "differs", "unlike_in", "become"), "C++ has arrays of species"),
    "add_ring": "OSL folds no loop",
    "normal_place": "C++ has a lambda",
    "inner_product": "dot() of core/vector.h",
    "luminance_of": "luminance(), a name that OSL's own library has taken",
    "is_sound": "a diagnostic",
    "sound": "core/paint.h rejects what a render must take",
    "sound_normal": "likewise",
    "sound_species": "likewise",
    "sound_paint": "likewise",
}
ONLY_CORE = {
    "luminance": "luminance_of()",
    "radiance_variance": "of a draw, for those who judge it",
    **dict.fromkeys(
        ("flake_radiance_variance", "mean_square_sparkle", "capped_area_square"),
        "likewise",
    ),
    **dict.fromkeys(("lookup3_final", "lookup3", "hash_value"), 'OSL\'s noise("hash")'),
    **dict.fromkeys(("power_of_two", "binary_exponent", "significand"), "OSL's exp2 and logb"),
    "flake_blocking": "slant_depth_of() finds it with the areas",
    "among_species": "C++ has arrays of species",
    "make_gauss_rule": "for any number type; the shader has the float rule",
    **dict.fromkeys(("view_below", "under_orange_peel"), "the shader's main fills its surface"),
    **dict.fromkeys(("scattered_by", "coat_shine", "shade"), "closures, which Cycles evaluates"),
    "ramp_at": "a closure",
    "phong_lobe": "a closure",
    **dict.fromkeys(("reflectance", "flake_albedo", "directional_albedo"), "likewise"),
    "each_choice": "words, for error messages",
    "each_flake_parameter": "for checks and bindings",
    "each_paint_parameter": "for checks and bindings",
}
HEADERS_ONLY_SHADER = {
    "sound.h": "core/validation.h rejects what a render must take",
    "diagnostics.h": "the shader's inner values as pictures",
    "footprint.h": "the renderer's transforms and differentials",
    "closures.h": "closures, which Cycles evaluates",
    "mixture_lobes.h": "closures: scattered_by() of whole_paint.h",
}
HEADERS_ONLY_CORE = {
    "batch.h": "many pixels",
    "one_by_one.h": "the paper's sum, which draw.h is held against",
    "paint.h": "checks: the shader makes its inputs sound instead",
    "parallel.h": "many pixels",
    "validation.h": "errors",
    "vector.h": "OSL has vectors",
    "noise.h": "OSL has noise",
    "light_slots.h": "the shader's main, which has its lights as inputs",
    "facet_lobe.h": "a closure of Cycles",
    "flake_brdf.h": "the mean of flake_lobe.h, which a renderer draws",
}


def functions(header: Path) -> list[str]:
    """Names of the functions that a header defines, each once, in order."""
    found: list[str] = []
    for line in header.read_text().splitlines():
        other = r"#|//|\s|\}|template|struct|namespace|using|enum|class|.*\bconstexpr\b"
        match = not re.match(other, line) and re.match(r"[\w:<>,&*\[\] ]+?[ >](\w+)\(", line)
        if match and match[1] not in found:
            found.append(match[1])
    return found


def test_every_header_has_its_twin() -> None:
    core = {path.name for path in (ROOT / "core").glob("*.h")}
    assert set(SHADER) - core == set(HEADERS_ONLY_SHADER)
    assert core - set(SHADER) == set(HEADERS_ONLY_CORE)


@pytest.mark.parametrize("name", [name for name in SHADER if name not in HEADERS_ONLY_SHADER])
def test_the_functions_are_the_same_in_order(name: str) -> None:
    shader, core = functions(ROOT / "osl" / name), functions(ROOT / "core" / name)
    validating = [each for each in core if re.fullmatch("validate(_.*)?", each)]
    both = [each for each in shader if each not in ONLY_SHADER]
    assert both == [each for each in core if each not in {*ONLY_CORE, *validating}]


def test_no_exception_is_stale() -> None:
    shader = {each for name in SHADER for each in functions(ROOT / "osl" / name)}
    core = {each for path in (ROOT / "core").glob("*.h") for each in functions(path)}
    assert set(ONLY_SHADER) <= shader - core
    assert set(ONLY_CORE) <= core - shader
