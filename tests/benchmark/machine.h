// SPDX-License-Identifier: Apache-2.0
//
// The limits of this machine: operations of one core, and its way to the memory.
#pragma once

#include <vector>

namespace machine {

// Independent chains of products and sums in the registers, as many at once as the processor can.
double multiply_and_add(int rounds, float factor, float summand);
double operations(int rounds);  // products and sums, each counted

void copy(std::vector<char>& to, const std::vector<char>& from);

}  // namespace machine
