# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene gives to its paints, and what it asks of them."""
