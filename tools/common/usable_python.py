# SPDX-License-Identifier: Apache-2.0
"""Exits 0 if the Python running this is version argv[1] and can make environments and modules."""

import importlib.util
import sys
import sysconfig
from pathlib import Path

header = Path(sysconfig.get_path("include"), "Python.h")
sys.exit(
    "{}.{}".format(*sys.version_info) != sys.argv[1]
    or importlib.util.find_spec("venv") is None
    or importlib.util.find_spec("ensurepip") is None
    or not header.is_file()
)
