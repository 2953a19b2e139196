# SPDX-License-Identifier: Apache-2.0
"""The core against flakes traced one by one by code that shares nothing with the project."""

from __future__ import annotations

import json
import os
from pathlib import Path

import metallic_paint_core as core
import numpy as np
import pytest

pytestmark = pytest.mark.long

# Another file of the same form can be judged by setting METALLIC_PAINT_REFERENCE_VALUES.
FILE = os.environ.get(
    "METALLIC_PAINT_REFERENCE_VALUES", Path(__file__).with_name("reference-values.json")
)
ROWS = json.loads(Path(FILE).read_text())["rows"]


def predict(row: dict) -> core.Pixels:
    paint = core.Paint(
        diffraction=core.Diffraction.none,  # the flakes traced have no spread
        flakes_per_mm2=row["D"] * row["H"] * 1e-6,
        flake_diameter_um=np.sqrt(4 * row["S"] / np.pi) * 1e6,
        flake_area_spread=row["sigS"] / row["S"],
        tilt=row["sigma"],
        flake_spread=0,
        flake_color=[row["r"]] * 3,
        flake_edge_color=[row["r"]] * 3,
        binder_ior=row["eta"],
        layer_thickness_um=row["H"] * 1e6,
    )

    def cos_inside(direction: list[float]) -> float:
        return np.sqrt(1 - (1 - direction[2] ** 2) / row["eta"] ** 2)

    slant = row["H"] * (
        row["tau_v"] / cos_inside(row["view"]) + row["tau_l"] / cos_inside(row["light"])
    )
    light = core.Light(core.LightKind.parallel, row["light"], np.sin(row["delta_out"]))
    return core.evaluate(
        paint,
        [light],
        position=[[0, 0, 0]],
        normal=[[0, 0, 1]],
        view=[row["view"]],
        footprint=[row["area"]],
        pixel=[[0, 0]],
        slant_depth=np.full((1, 1, 3), slant),
    )


@pytest.mark.parametrize("row", ROWS)
def test_count_and_radiance_are_those_of_traced_flakes(row: dict) -> None:
    result = predict(row)
    assert abs(result["mean_count"][0, 0] - row["count"]) < 3 * row["count_se"]
    assert abs(result["mean_radiance"][0, 0, 0] - row["mean_T"]) < 3 * row["mean_T_se"]
