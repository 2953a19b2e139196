# SPDX-License-Identifier: GPL-3.0-or-later
"""The other process of job.py: a script, not a part of the add-on.

Its last argument is a file with the job. It runs in a Blender that need not have the add-on: what
it imports, it finds in the files that the job names.
"""

import importlib.util
import json
import os
import sys
import traceback
from pathlib import Path
from types import ModuleType

import bpy


def load(name: str, file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        name, file, submodule_search_locations=[str(file.parent)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def find(kind: str, name_full: str) -> bpy.types.ID:
    """By the name with the library, which tells it from one of the same name."""
    return next(each for each in getattr(bpy.data, kind) if each.name_full == name_full)


def main(job: dict, said: Path) -> None:
    with said.open("a", encoding="utf-8") as lines:

        def say(**what: object) -> None:
            lines.write(json.dumps(what) + "\n")
            lines.flush()

        try:
            for name, file in job["modules"].items():
                load(name, Path(file))
            check = importlib.import_module("metallic_paint.verify.check").check
            bpy.ops.wm.open_mainfile(filepath=job["blend"], use_scripts=False)
            found = check(
                find("scenes", job["scene"]), find("objects", job["object"]),
                find("materials", job["material"]), job["size"], Path(job["folder"]),
                lambda share, what: say(progress=share, what=what),
            )  # fmt: skip
            say(found=found)
        except Exception as error:
            traceback.print_exc()
            say(error=str(error) or type(error).__name__)


if __name__ == "__main__":
    path = Path(sys.argv[-1])
    main(json.loads(path.read_text(encoding="utf-8")), path.with_name("said.jsonl"))
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)  # an ordinary exit can hang in bpy 4.5
