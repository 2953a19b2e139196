# SPDX-License-Identifier: Apache-2.0
"""What the programs share: environments, processes, Blender, reports, bars."""
