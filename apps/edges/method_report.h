// SPDX-License-Identifier: Apache-2.0
#pragma once

// The response of ISO 12233 beside the MTF of the same edges, and why they differ.

#include <string>

#include "apps/edges/measure_report.h"
#include "apps/text/json.h"

namespace apps {

/// A table that leads from the MTF to the response of ISO 12233 for every edge that both methods measured, and why the
/// others were not; "" where only one method was asked for.
std::string comparison_table(const MeasureReport& report);

/// The columns of CSV: what ISO 12233 gives for MTF50 and at Nyquist; "" where only one method was asked for.
std::string comparison_header(const MeasureReport& report);
std::string comparison_columns(const MeasuredEdge& edge);

/// Figures of ISO 12233, the reasons of the difference with their sizes, and what is left; null without a comparison.
Json comparison_json(const MeasuredEdge& edge);

}  // namespace apps
