# SPDX-License-Identifier: Apache-2.0
"""Form and types of the sources."""
