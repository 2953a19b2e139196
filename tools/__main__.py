# SPDX-License-Identifier: Apache-2.0
"""Runs a module of these packages as a program: python tools MODULE ARGUMENT..."""

import runpy
import sys
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parent.parent / "addon"))
module = sys.argv.pop(1)
runpy.run_module(module, run_name="__main__", alter_sys=True)
