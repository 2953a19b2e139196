# SPDX-License-Identifier: Apache-2.0
"""Pictures of paints: ./paint demo, render, gallery and manual, and the scenes they show."""
