// SPDX-License-Identifier: Apache-2.0
//
// The Gauss rules: weights and nodes against what they integrate exactly.
#include "quadrature.h"

#include <cmath>

#include "support.h"

namespace {

using namespace metallic_paint;
using core_tests::relative_error;
using core_tests::Worst;

// Integral of x^power over [0, 1] is 1/(power + 1).
template <class T>
void expect_exact_to_degree(int degree, double limit) {
  Worst worst;
  const GaussRule<T>& rule = gauss_rule<T>();
  for (int power = 0; power <= degree; ++power) {
    long double sum = 0;
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      sum += static_cast<long double>(rule.weight[i]) *
             std::pow(static_cast<long double>(rule.node[i]), power);
    }
    worst.see(relative_error(sum, 1.0L / (power + 1)), "power", power);
  }
  worst.expect_at_most(limit);
}

TEST(Quadrature, DoubleRuleOf64PointsIsExactToDegree127) {
  ASSERT_EQ(kGaussPoints<double>, 64);
  expect_exact_to_degree<double>(127, 2e-14);
}

TEST(Quadrature, FloatRuleOf12PointsIsExactToDegree23) {
  ASSERT_EQ(kGaussPoints<float>, 12);
  expect_exact_to_degree<float>(23, 1e-6);
}

TEST(Quadrature, NodesAscendAndMirror) {
  const GaussRule<double>& rule = gauss_rule<double>();
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    if (i > 0) {
      EXPECT_GT(rule.node[i], rule.node[i - 1]);
    }
    EXPECT_NEAR(rule.node[i] + rule.node[rule.node.size() - 1 - i], 1, 1e-15);
    EXPECT_GT(rule.weight[i], 0);
  }
}

}  // namespace
