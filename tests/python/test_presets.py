# SPDX-License-Identifier: Apache-2.0
"""Paints, and their files."""

from __future__ import annotations

import dataclasses
import json
import math
import shutil
import subprocess
import sys
from pathlib import Path

import parameters
import pytest
from metallic_paint.paint import PARAMETERS, presets, table, value_of
from metallic_paint.paint.presets import Flakes, Paint, PaintError, PresetError

OWN = {name: p for name, p in PARAMETERS.items() if "." not in name}  # not of further species
NUMBERS = [
    name for name, parameter in OWN.items()
    if not parameter.choices and not isinstance(getattr(Paint(), name), tuple)
]  # fmt: skip
COLORS = [name for name in OWN if isinstance(getattr(Paint(), name), tuple)]


def text(paint: dict[str, object], **more: object) -> str:
    return json.dumps({"schema_version": 1, "paint": paint, **more})


def in_use(paint: Paint) -> list[Flakes]:
    return [flakes for flakes in paint.species if flakes.flakes_per_mm2 > 0]


@pytest.mark.parametrize("name", presets.names())
def test_a_shipped_preset_is_a_plausible_paint(name: str) -> None:
    paint = presets.load(name)
    assert in_use(paint)[0] is paint
    # A base coat hides what is under it; pearls over a coloured ground and sparse glass need not.
    assert 0.1 <= sum(flakes.flake_coverage for flakes in in_use(paint)) <= 3
    for flakes in in_use(paint):
        assert 5 <= flakes.flake_diameter_um <= 400
        assert 0.1 <= flakes.flake_area_spread <= 0.6
        assert 0.05 <= flakes.tilt <= 0.3
        assert 0.005 <= flakes.flake_spread <= 0.03
    glitter = max(flakes.flake_diameter_um for flakes in in_use(paint)) >= 100
    assert 10 <= paint.layer_thickness_um <= (500 if glitter else 40)
    assert paint.binder_ior == 1.5


@pytest.mark.parametrize("name", presets.names())
def test_a_shipped_preset_sets_nothing_that_its_coating_does_not_use(name: str) -> None:
    for flakes in in_use(presets.load(name)):
        if "-on-" not in flakes.coating:
            assert flakes.coating_nm == Flakes().coating_nm
        if flakes.coating != "colors":
            for field in ("flake_color", "flake_edge_color", "flake_transmission"):
                assert getattr(flakes, field) == getattr(Flakes(), field)


def test_the_promised_presets_ship() -> None:
    assert set(presets.names()) >= {
        "silver-fine", "silver-medium", "silver-coarse", "champagne", "gunmetal", "graphite-matt",
        "candy-red", "deep-blue", "petrol", "racing-green", "wine-red", "gold", "copper", "bronze",
        "white-pearl", "green-purple", "blue-violet", "gold-green", "sunset", "lime",
        "glass-flake-black", "hammer-look", "bass-boat", "nail-polish",
    }  # fmt: skip


REFERENCE = json.loads((Path(__file__).parent / "preset-values.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", presets.names())
def test_a_shipped_preset_is_the_paint_that_it_was(name: str) -> None:
    """Whatever has become of the defaults since: the values are those of 0.1.0, as it stated all.

    A field that came later is at its neutral value and stands in no preset. But the sparkles of
    what ships ride on the surface, and its layers are correlated.
    """
    paint = presets.load(name)
    assert (paint.anchor, paint.depth_model) == ("surface", "correlated")
    for field, value in zip(REFERENCE["fields"], REFERENCE[name], strict=True):
        if field == "depth_model":
            continue
        wanted = tuple(value) if isinstance(value, list) else value
        assert value_of(paint, field) == wanted, field


@pytest.mark.parametrize("name", presets.names())
def test_a_shipped_preset_names_what_differs_from_its_defaults(name: str) -> None:
    file = presets.FOLDER / f"{name}.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    assert content["description"]
    assert content["schema_version"] == presets.SCHEMA_VERSION
    if content["defaults"] == table.VERSION_OF_DEFAULTS:
        for kind, values in ((Paint, content["paint"]), (Flakes, content["paint"].get("second"))):
            for field, value in (values or {}).items():
                assert not isinstance(value, dict) or field in ("second", "third")
                default = getattr(kind, field)
                assert (tuple(value) if isinstance(value, list) else value) != default, field


def test_coverage_is_flake_area_per_area_of_paint() -> None:
    paint = Paint(flakes_per_mm2=1000, flake_diameter_um=20, flake_area_spread=0)
    assert paint.flake_coverage == pytest.approx(1000e6 * math.pi / 4 * 20e-6**2)
    # E[max(0, 1 + w)] of a standard normal w is 1.0833.
    wide = dataclasses.replace(paint, flake_area_spread=1)
    assert wide.flake_coverage / paint.flake_coverage == pytest.approx(1.08332, abs=1e-5)


# --- a paint checks itself ----------------------------------------------------------------------


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("end", ["minimum", "maximum"])
def test_a_paint_takes_the_ends_of_a_range_and_nothing_beyond(name: str, end: str) -> None:
    parameter = PARAMETERS[name]
    bound = getattr(parameter, end)
    assert getattr(Paint(**{name: bound}), name) == bound
    beyond = bound + math.copysign(max(1e-9, abs(bound) * 1e-9), -1 if end == "minimum" else 1)
    if name == "seed":
        beyond = bound + (-1 if end == "minimum" else 1)
    with pytest.raises(PaintError) as error:
        Paint(**{name: beyond})
    ends = f"{parameter.minimum:.9g} to {parameter.maximum:.9g} {parameter.unit}".rstrip()
    if name == "seed":
        ends = "-2^31 to 2^31 - 1"
    assert str(error.value).startswith(f"{name} is ")
    assert str(error.value).endswith(f" from {ends}.")


@pytest.mark.parametrize("name", NUMBERS + COLORS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_paint_has_only_finite_numbers(name: str, value: float) -> None:
    with pytest.raises(PaintError, match=f"^{name}.* is -?(nan|inf), but must "):
        Paint(**{name: (value, 0, 0) if name in COLORS else value})


@pytest.mark.parametrize("name", COLORS)
@pytest.mark.parametrize("value", [0.5, "red", (0.1, 0.2), (0, 0, 0, 1), None])
def test_a_color_is_three_numbers(name: str, value: object) -> None:
    with pytest.raises(PaintError, match=f"^{name} is .*, but must be three numbers from"):
        Paint(**{name: value})


def test_a_bad_channel_is_named() -> None:
    with pytest.raises(PaintError, match=r"^flake_color\.g is 1.5, but must be from 0 to 1\.$"):
        Paint(flake_color=(0, 1.5, 0))


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [True, "3", None, [1]])
def test_a_number_is_a_number(name: str, value: object) -> None:
    with pytest.raises(PaintError, match=f"^{name} is .*, but must be a (whole )?number from"):
        Paint(**{name: value})


def test_a_seed_is_whole() -> None:
    with pytest.raises(
        PaintError, match=r"^seed is 1\.5, but must be a whole number from -2\^31 to .*\.$"
    ):
        Paint(seed=1.5)


@pytest.mark.parametrize("name", [name for name, p in OWN.items() if p.choices])
@pytest.mark.parametrize("value", ["phong", "", 0, None, ["gaussian"]])
def test_a_choice_is_one_of_its_words(name: str, value: object) -> None:
    with pytest.raises(PaintError) as error:
        Paint(**{name: value})
    *others, last = PARAMETERS[name].choices
    assert str(error.value) == f"{name} is {value!r}, but must be {', '.join(others)} or {last}."


@pytest.mark.parametrize("orientation", ["beckmann", "ggx"])
def test_a_roughness_is_at_most_one(orientation: str) -> None:
    assert Paint(orientation=orientation, tilt=1).tilt == 1
    assert Paint(orientation="gaussian", tilt=1.01).tilt == 1.01
    with pytest.raises(
        PaintError, match=r"^tilt is 1\.01, but must be from 1e-06 to 1 \(roughness"
    ):
        Paint(orientation=orientation, tilt=1.01)


@pytest.mark.parametrize("edge", ["", "edge_"])
def test_a_flake_gives_back_no_more_light_than_it_receives(edge: str) -> None:
    reflectance = f"flake_{edge}color"
    paint = {"flake_color": (0.5, 0.5, 0.5), "flake_edge_color": (0.5, 0.5, 0.5)}
    paint |= {reflectance: (0.9, 0.9, 0.9)}
    Paint(**paint, flake_transmission=(0.1, 0.1, 0.1))
    with pytest.raises(PaintError) as error:
        Paint(**paint, flake_transmission=(0.1, 0.1, 0.11))
    assert str(error.value) == (
        f"{reflectance} + flake_transmission is 1.01, but must be at most 1 in every channel."
    )


def test_a_paint_does_not_change() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Paint().tilt = 0.2


# --- files ----------------------------------------------------------------------------------------


def test_a_saved_paint_is_read_back(tmp_path: Path) -> None:
    paint = Paint(
        flakes_per_mm2=1234.5, orientation="ggx", tilt=0.21, flake_color=(0.1, 0.2, 1 / 3),
        depth_model="thinned", radiometry="published", sparkle_contrast=0.3, seed=-7,
    )  # fmt: skip
    presets.save(paint, tmp_path / "mine.json", "Käferblau")
    assert presets.load(tmp_path / "mine.json") == paint
    assert presets.load(str(tmp_path / "mine.json")) == paint
    assert [path.name for path in tmp_path.iterdir()] == ["mine.json"]


def test_a_failed_save_leaves_the_earlier_file_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "mine.json"
    presets.save(Paint(seed=1), file)

    def fail(*_: object, **__: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(OSError, match="No space"):
        presets.save(Paint(seed=2), file)
    assert presets.load(file) == Paint(seed=1)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.json"]


def test_a_description_that_would_not_be_read_back_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "long.json"
    with pytest.raises(PresetError, match=r"description has 70000 characters.*65536 bytes"):
        presets.save(Paint(), path, "a" * 70_000)
    assert not any(tmp_path.iterdir())


def test_a_symbolic_link_stays_one(tmp_path: Path) -> None:
    file, link = tmp_path / "shared.json", tmp_path / "link.json"
    file.write_text(text({}))
    link.symlink_to(file)
    presets.save(Paint(tilt=0.2), link)
    assert link.is_symlink()
    assert presets.load(file).tilt == 0.2


def test_a_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    path = tmp_path / "marked.json"
    path.write_text(text({"tilt": 0.2}), encoding="utf-8-sig")
    assert presets.load(path).tilt == 0.2


def test_a_field_left_out_has_its_default(tmp_path: Path) -> None:
    head = f'"schema_version": 2, "defaults": {table.VERSION_OF_DEFAULTS}'
    (tmp_path / "mine.json").write_text(f'{{{head}, "paint": {{"tilt": 0.3}}}}')
    assert presets.load(tmp_path / "mine.json") == Paint(tilt=0.3)


def test_a_saved_paint_names_only_what_differs(tmp_path: Path) -> None:
    file = tmp_path / "mine.json"
    more = Flakes(flakes_per_mm2=0, tilt=0.3)
    for paint, fields in [
        (Paint(), {}),
        (Paint(seed=3, flake_color=(0.5, 0.5, 0.5)), {"flake_color": [0.5, 0.5, 0.5], "seed": 3}),
        (Paint(second=more), {"second": {"flakes_per_mm2": 0.0, "tilt": 0.3}}),
        (Paint(third=Flakes()), {"third": {}}),
    ]:
        presets.save(paint, file)
        assert json.loads(file.read_text())["paint"] == fields
        assert presets.load(file) == paint


# What the add-on's files of another day read, without Blender.
OTHER_DAY = """
import json, sys
sys.path.insert(0, sys.argv[1])
from metallic_paint.paint import Paint, presets
paints = map(presets.load, sys.argv[2:])
found = [[getattr(paint, name) for name in ("tilt", "seed", "glitter")] for paint in paints]
print(json.dumps(found + [presets.load(name).tilt for name in ("gold", "lime")]))
"""


def test_presets_keep_their_look_when_a_default_changes_and_a_parameter_comes(
    tmp_path: Path,
) -> None:
    """Another table: in a new version tilt starts at 0.2, and there is Glitter, 1 but 0 before."""
    was, new = table.VERSION_OF_DEFAULTS, table.VERSION_OF_DEFAULTS + 1
    text = (parameters.ROOT / parameters.TABLE).read_text(encoding="utf-8")
    text = text.replace(f"version_of_defaults = {was}\n", f"version_of_defaults = {new}\n")
    text = text.replace(
        '[flakes.tilt]\ntype = "float"\ndefault = 0.15\n',
        '[flakes.tilt]\ntype = "float"\ndefault = 0.2\n'
        f"former = [{{ through = {was}, default = 0.15 }}]\n",
    )
    seed = text[text.index("[paint.seed]") : text.index("[paint.substrate_color]")]
    glitter = seed.replace("seed", "glitter").replace("Seed", "Glitter")
    glitter = glitter.replace(
        "default = 0\n", f"default = 1\nformer = [{{ through = {was}, default = 0 }}]\n"
    )
    (tmp_path / "parameters.toml").write_text(text + glitter, encoding="utf-8")
    made = parameters.made(parameters.read(tmp_path / "parameters.toml"))
    addon = tmp_path / "addon" / "metallic_paint"
    shutil.copytree(Path(presets.__file__).parent.parent, addon)
    (addon / "paint" / "table.py").write_text(
        made["addon/metallic_paint/paint/table.py"], encoding="utf-8"
    )
    files = {
        '{"schema_version": 1, "paint": {"seed": 4}}': [0.15, 4, 0],
        f'{{"schema_version": 2, "defaults": {was}, "paint": {{"seed": 5}}}}': [0.15, 5, 0],
        f'{{"schema_version": 2, "defaults": {new}, "paint": {{"seed": 6}}}}': [0.2, 6, 1],
        f'{{"schema_version": 2, "defaults": {was}, "paint": {{"tilt": 0.2, "seed": 7}}}}': [
            0.2,
            7,
            0,
        ],
    }
    for number, content in enumerate(files):
        (tmp_path / f"{number}.json").write_text(content)
    names = [str(tmp_path / f"{number}.json") for number in range(len(files))]
    done = subprocess.run(
        [sys.executable, "-c", OTHER_DAY, str(addon.parent), *names],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    shipped = [presets.load(name).tilt for name in ("gold", "lime")]
    assert json.loads(done.stdout) == [*files.values(), *shipped]


@pytest.mark.parametrize(
    ("head", "anchor", "depth_model"),
    [
        ('"schema_version": 1', "pixel", "attenuated"),
        ('"schema_version": 2, "defaults": 1', "pixel", "attenuated"),
        ('"schema_version": 2, "defaults": 2', "surface", "attenuated"),
        ('"schema_version": 2, "defaults": 3', "surface", "correlated"),
    ],
)
def test_own_presets_of_before_keep_their_defaults(
    tmp_path: Path, head: str, anchor: str, depth_model: str
) -> None:
    file = tmp_path / "mine.json"
    file.write_text(f'{{{head}, "paint": {{"seed": 4}}}}')
    paint = Paint(seed=4, anchor=anchor, depth_model=depth_model)
    assert presets.load(file) == paint
    presets.save(presets.load(file), file)
    assert presets.load(file) == paint


def test_an_unknown_name_is_told_the_known_ones() -> None:
    with pytest.raises(PresetError, match=r"'silber' is neither a file nor a preset.*candy-red"):
        presets.load("silber")


def test_a_folder_is_no_preset(tmp_path: Path) -> None:
    with pytest.raises(PresetError, match="is neither a file nor a preset"):
        presets.load(tmp_path)


@pytest.mark.parametrize("name", ["x" * 300, "x/" * 3000])
def test_a_name_too_long_is_refused(name: str) -> None:
    with pytest.raises(PresetError, match=r"^'x.* cannot be read: File name too long\.$"):
        presets.load(name)


@pytest.mark.parametrize("name", ["", "a\0b", "\ud800"])
def test_a_name_that_no_file_has_is_unknown(name: str) -> None:
    with pytest.raises(PresetError, match="is neither a file nor a preset"):
        presets.load(name)


BAD_FILES = {
    "nan": (text({"tilt": math.nan}), "paint.tilt is nan, but must be from 1e-06 to 100"),
    "infinity": (text({"tilt": math.inf}), "paint.tilt is inf, but must be from 1e-06 to 100"),
    "minus infinity": (text({"second": {"tilt": -math.inf}}), "paint.second.tilt is -inf, but"),
    "version that is no number": (text({}, schema_version=math.nan), "schema_version is nan, but"),
    "overflow": ('{"schema_version": 1, "paint": {"tilt": 1e999}}',
                 "paint.tilt is inf, but must be from 1e-06 to 100"),
    "huge integer": ('{"schema_version": 1, "paint": {"tilt": 1' + 400 * "0" + "}}",
                     "paint.tilt is 1000000000"),
    "endless integer": ('{"schema_version": 1, "paint": {"tilt": 1' + 5000 * "0" + "}}",
                        "paint.tilt is inf, but must be from 1e-06 to 100"),
    "endless seed": ('{"schema_version": 1, "paint": {"seed": -1' + 5000 * "0" + "}}",
                     "paint.seed is -inf, but must be a whole number"),
    "duplicate key": ('{"schema_version": 1, "paint": {"tilt": 0.1, "tilt": 0.2}}',
                      "the key 'tilt' stands there twice"),
    "duplicate paint": ('{"schema_version": 1, "paint": {}, "paint": {}}',
                        "the key 'paint' stands there twice"),
    "unknown key": (text({}, author="me"), "'author' is no key of a preset; the keys are schema_"),
    "unknown field": (text({"colour": 1}), "'paint.colour' is no key of a preset; the keys are fl"),
    "flood of a key": (text({"k" * 60000: 1}), "kkk' is no key of a preset"),
    "flood of a version": ('{"schema_version": [' + 20000 * "0, " + '0], "paint": {}}',
                           "schema_version is [0, 0, 0, 0, 0, 0, ...], but must be 1 or 2"),
    "a key for the console": (text({"\x1b[2J": 1}), r"'paint.\x1b[2J' is no key of a preset"),
    "no version": ('{"paint": {}}', "schema_version is None, but must be 1 or 2"),
    "other version": ('{"schema_version": 3, "paint": {}}',
                      "schema_version is 3, but must be 1 or 2"),
    "no defaults": ('{"schema_version": 2, "paint": {}}', "defaults is None, but must be from 1"),
    "defaults of the first schema": (text({}, defaults=1), "'defaults' is no key of a preset"),
    "defaults to come": ('{"schema_version": 2, "defaults": 99, "paint": {}}',
                         "defaults is 99, but must be from 1"),
    "true defaults": ('{"schema_version": 2, "defaults": true, "paint": {}}',
                      "defaults is True, but must be from 1"),
    "true version": ('{"schema_version": true, "paint": {}}',
                     "schema_version is True, but must be 1 or 2"),
    "float version": ('{"schema_version": 1.0, "paint": {}}',
                      "schema_version is 1.0, but must be 1 or 2"),
    "no paint": ('{"schema_version": 1}', "paint is missing or no object"),
    "flakes a list": (text({"second": []}), "paint.second is [], but must be an object {...}"),
    "paint a list": ('{"schema_version": 1, "paint": []}', "paint is missing or no object"),
    "description": (text({}, description=3), "description must be a text"),
    "boolean": (text({"tilt": True}), "paint.tilt is True, but must be a number"),
    "string": (text({"tilt": "0.1"}), "paint.tilt is '0.1', but must be a number"),
    "fractional seed": (text({"seed": 1.5}), "paint.seed is 1.5, but must be a whole number"),
    "color": (text({"flake_color": [1, 1]}), "paint.flake_color is [1, 1], but must be three num"),
    "color of booleans": (text({"flake_color": [True, 0, 0]}),
                          "paint.flake_color is [True, 0, 0], but must be three numbers"),
    "range": (text({"binder_ior": 0}), "paint.binder_ior is 0, but must be from 0.1 to 10"),
    "energy": (text({"flake_transmission": [0.5, 0, 0]}),
               "paint.flake_color + flake_transmission is 1.41, but must be at most 1"),
    "not an object": ("[1]", "the file must hold an object {...}"),
    "not JSON": ("paint: silver", "is no JSON"),
    "empty": ("", "is no JSON"),
    "trailing": (text({}) + "x", "is no JSON"),
    "deep": ("[" * 60000, "is no JSON"),
    "large": (text({}) + " " * presets.MAX_BYTES, "is larger than 65536 bytes"),
}  # fmt: skip


@pytest.mark.parametrize(("content", "message"), BAD_FILES.values(), ids=list(BAD_FILES))
def test_a_bad_file_is_refused_with_its_name_and_the_reason(
    tmp_path: Path, content: str, message: str
) -> None:
    file = tmp_path / "bad.json"
    file.write_text(content, encoding="utf-8")
    with pytest.raises(PresetError) as error:
        presets.load(file)
    said = str(error.value)
    assert said.startswith(str(file))
    assert message in said
    assert said.endswith(".")
    assert len(said) < len(str(file)) + 1000


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "bad.json"
    file.write_bytes(b'{"schema_version": 1, "description": "\xff", "paint": {}}')
    with pytest.raises(PresetError, match="is no JSON: 'utf-8' codec"):
        presets.load(file)


def test_presets_need_no_blender() -> None:
    code = (
        "import sys, metallic_paint.paint.presets as presets; presets.load('gold');"
        "assert 'bpy' not in sys.modules"
    )
    addon = Path(presets.__file__).parents[2]
    subprocess.run([sys.executable, "-c", code], cwd=addon, check=True, timeout=60)
