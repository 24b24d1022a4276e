// SPDX-License-Identifier: Apache-2.0
#pragma once

// The keys of a study file, table by table: what the reader knows and what `mtf config schema study` tells editors.

#include <array>
#include <string_view>
#include <vector>

#include "mtf/component.h"

namespace study {

inline constexpr std::array<std::string_view, 14> kTopKeys{"schema",      "name",       "sensor",  "tolerance", "seed",
                                                           "constraints", "objectives", "axis",    "sampling",  "links",
                                                           "as_built",    "yield",      "metrics", "conditions"};
inline constexpr std::array<std::string_view, 7> kAxisKeys{"parameter", "name",  "values", "from",
                                                           "to",        "count", "scale"};
inline constexpr std::array<std::string_view, 2> kScales{"linear", "log"};
inline constexpr std::array<std::string_view, 2> kSamplingKeys{"method", "points"};
inline constexpr std::array<std::string_view, 3> kMethods{"grid", "latin_hypercube", "sobol"};
inline constexpr std::array<std::string_view, 3> kAsBuiltKeys{"parameter", "sd", "plus_minus"};
inline constexpr std::array<std::string_view, 1> kYieldKeys{"draws"};
inline constexpr std::array<std::string_view, 1> kMetricsKeys{"list"};

inline constexpr mtf::FieldInfo kTolerance =
    mtf::optional_row("tolerance", 1e-12, 0.1, "1e-4", "allowed error of every metric, relative");
inline constexpr mtf::FieldInfo kDraws = mtf::required_row("draws", 1.0, 1e6, "200", "");

/// [conditions].
std::vector<mtf::FieldInfo> condition_fields();

}  // namespace study
