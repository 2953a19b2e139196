# SPDX-License-Identifier: Apache-2.0
"""These tests need Python and the core's bindings: no Blender, which they could not import."""

import sys

sys.modules["bpy"] = None
