// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf range` takes: the keys of [conditions] that ranges need, as options.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/key_options.h"

namespace apps {

/// A target that others know by name.
struct StandardTarget {
  double size_m, contrast_k;
};
/// "nato": STANAG 4347 (1995), 2.3 m x 2.3 m, 2 K above its background.
inline constexpr std::array kStandardTargets{std::pair{std::string_view("nato"), StandardTarget{2.3, 2.0}}};

struct RangeOptions {
  std::string sensor;
  std::optional<StandardTarget> target{};
  GivenKeys given{};              ///< of [conditions]
  std::vector<double> range_m{};  ///< of the probabilities; empty = steps that show all tasks
  Format format = Format::table;
  std::string plot;  ///< .svg, .pdf or .png
  std::string out;   ///< "" = stdout
};

int run_range(const RangeOptions& options, const Global& global);

}  // namespace apps
