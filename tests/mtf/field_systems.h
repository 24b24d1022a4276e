// SPDX-License-Identifier: Apache-2.0
#pragma once

// Systems whose OTF changes over the field, for tests and benchmarks.

#include <string_view>
#include <utility>

#include "mtf/components/jitter.h"
#include "mtf/components/wavefront.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {

inline void let_vary(System<double>& system, std::size_t entry, std::string_view field, std::string_view term,
                     double value) {
  const auto fields = std::as_const(system.list(Stage::presample).at(entry).component).fields();
  std::size_t row = 0, at = 0;
  while (fields.at(row).info->name != field) ++row;
  while (kFieldTerms.at(at) != term) ++at;
  for (FieldNumber<double>& number : system.field.numbers)
    if (number.entry == entry && number.field == row) {
      number.coefficient[at] = value;
      return;
    }
  system.field.numbers.push_back({entry, row, 0, {}});
  system.field.numbers.back().coefficient[at] = value;
}

inline void turn_with_field(System<double>& system, std::size_t entry, std::string_view field) {
  const auto fields = std::as_const(system.list(Stage::presample).at(entry).component).fields();
  std::size_t row = 0;
  while (fields.at(row).info->name != field) ++row;
  system.field.angles.push_back({entry, row});
}

/// Seidel aberrations in waves at |q| = 1: w131 r, w222 r^2, field curvature w220 r^2.
inline System<double> seidel(double w040, double w131, double w222, double w220, double w020) {
  System<double> s = bare(15.0, 15.0);
  Wavefront<double> w;
  w.w020 = w020, w.w040 = w040, w.w131 = 0.0, w.w222 = 0.0;
  s.add(Stage::presample, w);
  let_vary(s, 0, "w131", "r", w131);
  let_vary(s, 0, "w222", "r2", w222);
  let_vary(s, 0, "w020", "r2", w220);
  turn_with_field(s, 0, "orientation");
  return s;
}

inline System<double> rolling(double sigma_px, double sigma0_px, int columns, int rows) {
  System<double> s = bare(15.0, 15.0);
  s.frame.columns = columns, s.frame.rows = rows;
  Jitter<double> jitter;
  jitter.rms = pixels(sigma0_px);
  jitter.roll_urad = microradians(1e6 * sigma_px * 15.0 / s.field_radius_um());
  s.add(Stage::presample, jitter);
  return s;
}

}  // namespace mtf::test
