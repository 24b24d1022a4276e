// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cases of performance.csv: arguments in the order that its generator says, value and slope to 25 and 15 digits.

#include <cstdlib>
#include <sstream>

#include "radiometry/performance/contrast_threshold.h"
#include "tests/mtf/reference_table.h"

namespace radiometry::test {

struct PerformanceCase {
  std::vector<double> x;
  double value, slope;
  std::string where;
};

inline std::vector<PerformanceCase> performance_cases(std::string_view quantity) {
  std::vector<PerformanceCase> cases;
  for (const mtf::test::Row& row : mtf::test::reference_table("performance.csv")) {
    if (row.at("quantity") != quantity) continue;
    PerformanceCase one{{}, mtf::test::number(row, "value"), 0.0, row.where};
    std::istringstream arguments{std::string(row.at("arguments_hex"))};
    for (std::string text; std::getline(arguments, text, '|');) one.x.push_back(std::strtod(text.c_str(), nullptr));
    if (!row.at("slope").empty()) one.slope = mtf::test::number(row, "slope");
    cases.push_back(one);
  }
  if (cases.empty()) throw std::runtime_error("performance.csv has no " + std::string(quantity));
  return cases;
}

/// exp(-(f/a)^2).
template <class S>
S gaussian_mtf(double f, const S& a) {
  using std::exp;
  const S x = S(f) / a;
  return exp(-x * x);
}

/// The observer in the first five numbers of a case.
template <class S, class Numbers>
Observer<S> observer_of(const Numbers& x) {
  return {.model = static_cast<ContrastModel>(static_cast<int>(mtf::value_of(x[0]))),
          .luminance_cd_m2 = S(x[1]),
          .field_deg = S(x[2]),
          .magnification = S(x[3]),
          .display_contrast = S(x[4])};
}

/// 1/CTF of the system in the first seven: that observer, noise factor, width of the Gaussian MTF.
template <class S, class Numbers>
auto sensitivity_of(const Numbers& x) {
  const Observer<S> observer = observer_of<S>(x);
  const S factor(x[5]), a(x[6]);
  return [=](double f) { return system_sensitivity(observer, f, gaussian_mtf(f, a), factor); };
}

}  // namespace radiometry::test
