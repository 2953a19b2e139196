# SPDX-License-Identifier: Apache-2.0
"""./paint accuracy: what each choice of the model costs and errs."""
