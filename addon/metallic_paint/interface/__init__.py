# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist sees: operators, menus, panels and preferences."""
