// SPDX-License-Identifier: Apache-2.0
#include "validation.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "coating.h"

namespace metallic_paint {

std::string text(double value, int digits) {
  std::ostringstream stream;
  stream.precision(digits);
  stream << value;
  return stream.str();
}

std::string at_row(const std::string& field, std::size_t row) {
  return field + "[" + std::to_string(row) + "]";
}

void reject(const std::string& field, const std::string& value, const std::string& range) {
  throw std::invalid_argument(field + " is " + value + ", but must be " + range + ".");
}

void reject(const std::string& field, double value, const std::string& range) {
  reject(field, text(value), range);
}

void require_range(const std::string& field, double value, double least, double most,
                   const std::string& unit) {
  if (value >= least && value <= most) return;  // false for NaN
  std::string shown = text(value);
  // All digits where these are those of the limit that the value misses.
  if (shown == text(least) || shown == text(most)) shown += " (" + text(value, 17) + ")";
  reject(field, shown, "from " + text(least) + " to " + text(most) + unit);
}

void require_colour(const std::string& field, Rgb<double> value, double most,
                    const std::string& unit) {
  require_range(field + ".r", value.x, 0, most, unit);
  require_range(field + ".g", value.y, 0, most, unit);
  require_range(field + ".b", value.z, 0, most, unit);
}

void require_library_coating(const std::string& field, int kind, double nm) {
  if (kind < 1 || kind >= kCoatingKinds) {
    reject(field, kind,
           "from 1 (" + std::string(kCoatingKindWords[1]) + ") to " +
               std::to_string(kCoatingKinds - 1) + " (" + kCoatingKindWords.back() + ")");
  }
  require_range(field + "_nm", nm, 0, kMostCoatingNm, " nm");
}

void require_unit(const std::string& field, Vec3<double> direction) {
  const double square = dot(direction, direction);
  if (!is_unit(square)) reject("length of " + field, std::sqrt(square), "1 to a thousandth");
}

}  // namespace metallic_paint
