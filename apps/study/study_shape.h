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

inline constexpr mtf::FieldInfo kTolerance{.name = "tolerance",
                                           .lo = 1e-12,
                                           .hi = 0.1,
                                           .presence = mtf::Presence::optional,
                                           .example = "1e-4",
                                           .doc = "allowed error of every metric, relative"};
inline constexpr mtf::FieldInfo kDraws{.name = "draws", .lo = 1.0, .hi = 1e6, .example = "200"};

/// [conditions].
std::vector<mtf::FieldInfo> condition_fields();

}  // namespace study
