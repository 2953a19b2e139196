# SPDX-License-Identifier: Apache-2.0
"""The metallic-paint model over numpy arrays."""

from ._native import __version__

__all__ = ["__version__"]
