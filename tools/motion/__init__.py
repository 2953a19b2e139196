# SPDX-License-Identifier: Apache-2.0
"""./paint motion: what sparkles do while camera, object and light move."""
