# SPDX-License-Identifier: Apache-2.0
"""./paint test --all leaves out what has passed on these sources, and keeps what passes."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import pytest
from common.kept import Kept


def pytest_configure(config: pytest.Config) -> None:
    if file := os.environ.get("METALLIC_PAINT_KEPT"):
        config.pluginmanager.register(Keeper(config, Kept(Path(file))))


class Keeper:
    def __init__(self, config: pytest.Config, kept: Kept) -> None:
        self.kept = kept
        # A worker of pytest-xdist must find what the others found, also if it starts later.
        self.worker = getattr(config, "workerinput", None)
        self.before = list(self.worker["kept"] if self.worker else kept)
        self.failed: set[str] = set()  # or skipped
        self.seconds: Counter[str] = Counter()

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: object) -> None:
        node.workerinput["kept"] = self.before

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        config.hook.pytest_deselected(items=[each for each in items if each.nodeid in self.before])
        items[:] = [each for each in items if each.nodeid not in self.before]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if self.worker is not None:
            return
        self.seconds[report.nodeid] += report.duration
        if not report.passed:
            self.failed.add(report.nodeid)
        elif report.when == "teardown" and report.nodeid not in self.failed:
            self.kept.add(report.nodeid, self.seconds[report.nodeid])
