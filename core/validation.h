// SPDX-License-Identifier: Apache-2.0
//
// How values are rejected, once: std::invalid_argument with a sentence that names the field, its
// value and the allowed range.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "vector.h"

namespace metallic_paint {

std::string text(double value, int digits = 9);
std::string at_row(const std::string& field, std::size_t row);  // field[row]

[[noreturn]] void reject(const std::string& field, const std::string& value,
                         const std::string& range);
[[noreturn]] void reject(const std::string& field, double value, const std::string& range);

void require_range(const std::string& field, double value, double least, double most,
                   const std::string& unit = "");
void require_colour(const std::string& field, Rgb<double> value, double most,
                    const std::string& unit = "");

// A kind of the library, any CoatingKind but colors, in `field` and its thickness in `field`_nm.
void require_library_coating(const std::string& field, int kind, double nm);

// Vectors come as floats: unit length to a thousandth.
inline bool is_unit(double square) { return std::abs(square - 1) < 2e-3; }
void require_unit(const std::string& field, Vec3<double> direction);

}  // namespace metallic_paint
