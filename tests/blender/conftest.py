# SPDX-License-Identifier: Apache-2.0
"""Every test file runs in a process of its own and starts each test with a clean Blender."""

from blender_session import *  # noqa: F403
from shader_library import *  # noqa: F403
