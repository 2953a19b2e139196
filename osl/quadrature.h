// SPDX-License-Identifier: Apache-2.0
//
// Gauss-Legendre quadrature on [0, 1] with 12 points: the float rule of core/quadrature.h.
#pragma once

#define GAUSS_POINTS 12

void gauss_rule(output float node[12], output float weight[12])
{
  float nodes[12] = {0.00921968288, 0.0479413718, 0.115048663, 0.206341023, 0.316084251, 0.437383296,
                     0.562616704, 0.683915749, 0.793658977, 0.884951337, 0.952058628, 0.990780317};
  float weights[12] = {0.0235876682, 0.053469663, 0.0800391643, 0.101583713, 0.116746268, 0.124573523,
                       0.124573523, 0.116746268, 0.101583713, 0.0800391643, 0.053469663, 0.0235876682};
  node = nodes;
  weight = weights;
}
