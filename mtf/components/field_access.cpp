// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/field_access.h"

#include <cmath>

namespace mtf::detail {

bool in_range(const FieldInfo& info, double value) {
  if (!std::isfinite(value)) return false;
  return (info.lo_open ? value > info.lo : value >= info.lo) && (info.hi_open ? value < info.hi : value <= info.hi);
}

std::string range_text(const FieldInfo& info) {
  return (info.lo_open ? "(" : "[") + format_double(info.lo) + ", " + format_double(info.hi) +
         (info.hi_open ? ")" : "]");
}

}  // namespace mtf::detail
