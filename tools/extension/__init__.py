# SPDX-License-Identifier: Apache-2.0
"""./paint extension: the add-on as a zip that Blender installs."""
