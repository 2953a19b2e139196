// SPDX-License-Identifier: Apache-2.0
//
// A metallic paint as artists and presets state it (parameters.h): its checks, and those of other
// input.
#pragma once

#include <cstddef>
#include <string>

#include "light.h"
#include "parameters.h"
#include "vector.h"

namespace metallic_paint {

// Throws std::invalid_argument with a sentence that names the field, its value and the allowed
// range.
void validate(const Paint& paint);
void validate(const Light<double>& light);

// Likewise, for the arguments of single functions of the model.
void validate_count(double mean, double slots, double uniform);
void validate_probability(double probability);
void validate_cosine(double cos_theta);
void validate_eta(double eta);
void validate_beta(double beta);
void validate_direction(const std::string& field, std::size_t row, Vec3<double> direction);
void validate_int32(const std::string& field, std::size_t row, double value);

}  // namespace metallic_paint
