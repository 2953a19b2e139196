# SPDX-License-Identifier: GPL-3.0-or-later
"""Metallic paint with sparkling flakes for Cycles.

paint.py     what a paint is: fields, units, ranges
presets.py   paints as files
shader.py    the OSL text, and its compilation into a script node
material.py  the node group and the material around the shader
lights.py    the lights that sparkle, fed to every paint of the file by drivers
needs.py     what a scene requires of its paints; the rest is left out

Nothing is registered yet: the interface comes with the extension.
"""
