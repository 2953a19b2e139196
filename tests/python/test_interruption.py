# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while the core works: the call ends at once, with no thread left and no result."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.long

# A process that another one sends the signal of Ctrl-C while the call is under way: a thread
# of the same process would have to wait for the interpreter's lock.
PROGRAM = """
import json, os, signal, sys, time
import metallic_paint_core as core
import numpy as np

n = 500_000
paint = core.Paint(flakes_per_mm2=2000, tilt=0.2)
clear = core.Paint(flakes_per_mm2=0, rayleigh_per_mm=1e6, layer_thickness_um=1e6)
wavy = core.Paint(flakes_per_mm2=1e5, tilt=0.2, flake_spread=0.3)
suns = [core.Light(core.LightKind.parallel, (0.3, 0.1 * i, 0.9), 0.005) for i in range(8)]
up = np.tile([0.0, 0.0, 1.0], (n, 1))
pixel = np.zeros((n, 2))
footprint = np.full(n, 1e-7)
cosines = np.linspace(0.1, 1, 10**7)
detectors = np.tile([0.0, 0.0, 1.0], (4096, 1))
view, light = (0.28, 0.0, 0.96), (-0.28, 0.0, 0.96)
calls = {
    "many photons": lambda: core.random_walk(paint, light, photons=10**9),
    "one long walk": lambda: core.random_walk(clear, light, photons=2, detectors=detectors),
    "many flakes": lambda: core.explicit_flakes(paint, view, light, 0.05, 1e-5, 10**6),
    "many points": lambda: core.explicit_flakes(
        wavy, view, light, 0.05, 1e-9, 10, points=65536
    ),
    "many pixels": lambda: core.evaluate(
        paint, suns, position=pixel @ np.zeros((2, 3)), normal=up, view=up, footprint=footprint,
        pixel=pixel,
    ),
    "many cosines": lambda: core.mixture(paint, (0.8, 0.8, 0.8), cosines),
}
call = calls[sys.argv[1]]
outcome = "returned"
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever our starter ignores
print("ready", flush=True)
try:
    call()
except KeyboardInterrupt:
    outcome = "interrupted"
ended = time.monotonic()
threads = len(os.listdir("/proc/self/task")) if os.path.isdir("/proc/self/task") else 1
print(json.dumps([outcome, ended, threads]))
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send")
@pytest.mark.parametrize(
    "call",
    ["many photons", "one long walk", "many flakes", "many points", "many pixels", "many cosines"],
)
def test_ctrl_c_ends_the_call_at_once(call: str) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, call],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},  # numpy's own threads stay
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        assert process.poll() is None
        sent = time.monotonic()  # the same clock in all processes
        process.send_signal(signal.SIGINT)
        try:
            output, _ = process.communicate(timeout=60)
        finally:
            process.kill()
    outcome, ended, threads = json.loads(output)
    assert outcome == "interrupted"
    assert ended - sent < 5  # s: on a busy machine; the calls themselves take minutes
    assert threads == 1
