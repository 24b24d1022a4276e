// SPDX-License-Identifier: Apache-2.0
#pragma once

// The figures of merit of a measured edge, in one order and one unit for every output.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/edges/measure_report.h"
#include "calib/measure/measure.h"

namespace apps {

/// Names of the figures: "mtf50", ..., then those of the contrasts that were asked for.
std::vector<std::string> merit_names(std::span<const double> contrasts);

/// Their values in the same order, frequencies in the unit of the edge.
std::vector<std::optional<calib::Estimate>> merits_of(const MeasuredEdge& edge);

/// The frequency of one contrast in the unit of the edge, be it a figure of every edge or one of `further`.
std::optional<calib::Estimate> at_contrast(const MeasuredEdge& edge, double contrast, std::span<const double> further);

/// "35" for 0.35.
std::string percent_text(double contrast);

/// A frequency in the unit of the edge.
std::optional<calib::Estimate> in_unit(const std::optional<calib::Estimate>& cy_px, const FrequencyScale& scale);
std::vector<double> in_unit(std::vector<double> cy_px, const FrequencyScale& scale);

/// Finds the frequencies of these contrasts in the measured curve. `absent` names those to which it does not fall.
void add_contrasts(MeasuredEdge& edge, std::span<const double> contrasts);

/// The contrasts without repetitions, and those of them that are no figures of every edge.
std::vector<double> without_repetitions(const std::vector<double>& asked);
std::vector<double> further_contrasts(const std::vector<double>& asked);

}  // namespace apps
