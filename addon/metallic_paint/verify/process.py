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
    """What it cannot check it says; an error of ours ends it, with the traceback in its log."""
    for name, file in job["modules"].items():
        load(name, Path(file))
    check = importlib.import_module("metallic_paint.verify.check")
    with said.open("a", encoding="utf-8") as lines:

        def say(**what: object) -> None:
            lines.write(json.dumps(what) + "\n")
            lines.flush()

        bpy.ops.wm.open_mainfile(filepath=job["blend"], use_scripts=False)
        try:
            found = check.check(
                find("scenes", job["scene"]), find("objects", job["object"]),
                find("materials", job["material"]), job["size"], Path(job["folder"]),
                lambda share, what: say(progress=share, what=what),
            )  # fmt: skip
        except check.VerifyError as error:
            say(error=str(error))
        else:
            say(found=found)


if __name__ == "__main__":
    path = Path(sys.argv[-1])
    code = 1
    try:
        main(json.loads(path.read_text(encoding="utf-8")), path.with_name("said.jsonl"))
        code = 0
    except Exception:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # an ordinary exit can hang in bpy 4.5
