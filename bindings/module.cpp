// SPDX-License-Identifier: Apache-2.0
#include <pybind11/pybind11.h>

PYBIND11_MODULE(_native, module) { module.attr("__version__") = METALLIC_PAINT_VERSION; }
