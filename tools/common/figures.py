# SPDX-License-Identifier: Apache-2.0
"""How the figures of the reports look, and how they are written."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from PIL import Image

mpl.use("Agg")
import matplotlib.pyplot as plt

COLOUR, GREY, DARK = "#0b6fb8", "#a0a0a0", "#303030"
STYLE = {
    "font.size": 9, "axes.titlesize": 10, "axes.grid": True, "grid.color": "#e4e4e4",
    "axes.axisbelow": True, "savefig.facecolor": "white", "legend.frameon": False,
}  # fmt: skip


def save(figure: plt.Figure, file: Path) -> None:
    figure.savefig(file, dpi=110)
    plt.close(figure)
    with Image.open(file) as image:  # a palette holds these colours in a third of the bytes
        image.convert("RGB").quantize(256).save(file, optimize=True)
