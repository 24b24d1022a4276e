// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers as they lie in files: whole ones of 8 to 64 bits and floats of 32 and 64, either byte order.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mtf/io/float_rounding.h"

namespace mtf::io {

struct NumberType {
  char kind = 'u';  ///< 'u' and 'i' whole numbers without and with a sign, 'f' floats
  int bytes = 1;
  bool big_endian = false;

  bool is_float() const { return kind == 'f'; }
  std::string name() const;  ///< "uint16", "float", "double"
};

/// numpy's word for it, "<f4", "|u1", ">i2"; nothing for others.
std::optional<NumberType> number_type(std::string_view word);

/// What a stored number n means: gain x n + offset, rounded to float; NaN where n is `no_data`.
struct Meaning {
  double gain = 1.0, offset = 0.0;
  std::optional<double> no_data{};
};

/// Numbers that lie `step` bytes apart, the first at `from`, as many as `values` holds. `rounding` counts those that
/// float may change.
void to_floats(NumberType type, const char* from, std::int64_t step, const Meaning& meaning, std::span<float> values,
               Rounding* rounding = nullptr);

}  // namespace mtf::io
