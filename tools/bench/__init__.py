# SPDX-License-Identifier: Apache-2.0
"""./paint bench: waits, time per sample, time to equal error, growth and the core's speed."""
