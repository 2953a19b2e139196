# SPDX-License-Identifier: Apache-2.0
"""./paint verify: renders against the core, pixel by pixel."""
