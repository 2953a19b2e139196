// SPDX-License-Identifier: Apache-2.0
#include "module.h"

PYBIND11_MODULE(_native, module) {
  module.attr("__version__") = METALLIC_PAINT_VERSION;
  bind_paint(module);
  bind_light(module);
  bind_evaluate(module);
  bind_shade(module);
  bind_functions(module);
  bind_explicit_flakes(module);
  bind_reference_walk(module);
}
