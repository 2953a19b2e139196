# SPDX-License-Identifier: Apache-2.0
"""./paint manual --site: the documents as a site that can be searched."""
