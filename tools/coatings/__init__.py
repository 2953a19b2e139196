# SPDX-License-Identifier: Apache-2.0
"""Colours of coated flakes by thin-film interference: the library of coatings."""
