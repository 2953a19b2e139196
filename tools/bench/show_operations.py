# SPDX-License-Identifier: Apache-2.0
"""Renders a variant of the shader, named by absent_parts.py, for OSL's statistics of it."""

from __future__ import annotations

import sys

from common import blender_env

blender_env.prepare()

from bench.absent_parts import show  # noqa: E402


def main() -> int:
    show(sys.argv[1])
    return 0


if __name__ == "__main__":
    blender_env.run(main)
