# SPDX-License-Identifier: Apache-2.0
"""A pytest session with Blender in its process: what the conftest.py of such a room takes."""

from __future__ import annotations

import pytest
from common import blender_env

blender_env.prepare()

import bpy  # noqa: E402

__all__ = ["empty_scene", "pytest_sessionfinish", "pytest_unconfigure"]

INTERRUPTED = 3  # the exit code if pytest never came to the end of its session

exit_code = pytest.StashKey[int]()


@pytest.fixture(autouse=True)
def empty_scene() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[exit_code] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config: pytest.Config) -> None:
    blender_env.finish(config.stash.get(exit_code, INTERRUPTED))
