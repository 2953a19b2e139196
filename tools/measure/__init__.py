# SPDX-License-Identifier: Apache-2.0
"""./paint measure: virtual instruments of the paint industry."""
