// SPDX-License-Identifier: Apache-2.0
#pragma once

// A study made ready to be evaluated, and its derivatives against differences.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/study/design/evaluator.h"
#include "tests/apps/study/study_files.h"

namespace study_test {

struct Evaluated {
  std::shared_ptr<const study::Study> study;
  std::vector<study::Column> columns;
  std::unique_ptr<study::Evaluator> evaluator;
  std::vector<double> row;

  double operator[](const std::string& name) const {
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (columns[c].name == name) return row[c];
    ADD_FAILURE() << "no column " << name;
    return 0.0;
  }
  void at(std::int64_t design) { evaluator->evaluate(design, row); }
};

inline Evaluated evaluated(const Folder& folder, const std::string& text) {
  folder.write("study.toml", text);
  Evaluated e{study::load_study(folder / "study.toml"), {}, nullptr, {}};
  e.columns = study::columns_of(*e.study);
  e.evaluator = std::make_unique<study::Evaluator>(e.study);
  e.row.resize(e.columns.size());
  return e;
}

inline std::string with_metrics(const std::string& list, const std::string& rest = "") {
  return kHead + rest + kAxis + "[metrics]\nlist = [" + list + "]\n";
}

/// Central differences of fourth order on the whole chain against autodiff; relative to value / parameter where a
/// derivative is far below that, the value being counted as 1e-3 at least: errors of ratios are absolute.
inline void expect_gradient(const Folder& folder, const std::string& text, std::int64_t design, double bar,
                            double reference_tolerance = 1e-11, double step = 1e-3) {
  Evaluated e = evaluated(folder, text);
  std::vector<double> axes(e.study->axes.size());
  study::design_at(*e.study, design, axes);
  const study::Gradient gradient = e.evaluator->gradient_at(axes);
  auto tight = std::make_shared<study::Study>(*e.study);
  tight->tolerance = reference_tolerance;
  study::Evaluator reference(tight);
  const std::size_t width = e.columns.size();
  std::size_t parameter = 0;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (e.study->axes[a].discrete()) continue;
    const double h = step * axes[a];
    const auto at = [&](double steps) {
      std::vector<double> moved = axes, row(width);
      moved[a] += steps * h;
      reference.evaluate_at(moved, row);
      return row;
    };
    const auto p1 = at(1), m1 = at(-1), p2 = at(2), m2 = at(-2);
    for (std::size_t k = 0; k < gradient.columns.size(); ++k) {
      std::size_t c = 0;
      while (e.columns[c].name != gradient.columns[k]) ++c;
      const double difference = (8.0 * (p1[c] - m1[c]) - (p2[c] - m2[c])) / (12.0 * h);
      const double scale = std::max(std::abs(difference), std::max(std::abs(p1[c]), 1e-3) / axes[a]);
      const double automatic = gradient.value[k * gradient.parameters.size() + parameter];
      EXPECT_LE(std::abs(automatic - difference), bar * scale + 1e-300)
          << gradient.columns[k] << " by " << gradient.parameters[parameter] << ": " << automatic << ", " << difference;
    }
    ++parameter;
  }
  EXPECT_EQ(parameter, gradient.parameters.size());
}

}  // namespace study_test
