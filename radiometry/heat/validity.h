// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a closure holds: each states the range of the quantity that it is made for, and what it is off by beyond it
// (convection.h, evaporation.h). Beyond keeps what a run saw outside of such a range.

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace radiometry::heat {

struct Validity {
  std::string_view closure, quantity, unit;
  double lo = 0.0, hi = 0.0;
  std::string_view beyond;  ///< what is wrong there
};

/// Values outside of a range: how many, the first of them, and the one that is farthest out.
struct Beyond {
  std::size_t values = 0;
  double first_s = 0.0, extreme = 0.0;
  std::size_t first_place = 0;

  void see(const Validity& validity, double value, double time_s, std::size_t place = 0) {
    if (value >= validity.lo && value <= validity.hi) return;
    const auto out = [&](double x) { return std::max(validity.lo - x, x - validity.hi); };
    if (values++ == 0) {
      first_s = time_s;
      first_place = place;
      extreme = value;
    }
    if (out(value) > out(extreme)) extreme = value;
  }
};

}  // namespace radiometry::heat
