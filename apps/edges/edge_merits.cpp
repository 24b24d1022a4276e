// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/edge_merits.h"

#include <algorithm>
#include <array>

#include "apps/terminal/text_table.h"

namespace apps {
namespace {

using calib::EdgeMeasurement;
using calib::Estimate;

struct Merit {
  const char* name;
  std::optional<Estimate> EdgeMeasurement::*value;
  bool frequency = false;
};
constexpr std::array kMerits{Merit{"mtf50", &EdgeMeasurement::mtf50, true},
                             Merit{"mtf30", &EdgeMeasurement::mtf30, true},
                             Merit{"mtf20", &EdgeMeasurement::mtf20, true},
                             Merit{"mtf10", &EdgeMeasurement::mtf10, true},
                             Merit{"mtf50p", &EdgeMeasurement::mtf50p, true},
                             Merit{"nyquist", &EdgeMeasurement::nyquist},
                             Merit{"rer", &EdgeMeasurement::rer},
                             Merit{"overshoot", &EdgeMeasurement::overshoot},
                             Merit{"fwhm_px", &EdgeMeasurement::fwhm_px},
                             Merit{"mtfa", &EdgeMeasurement::mtfa},
                             Merit{"sampling_efficiency", &EdgeMeasurement::sampling_efficiency}};

std::string merit_name(double contrast) { return "mtf" + percent_text(contrast); }

/// The contrasts whose names are neither known nor those of earlier ones.
std::vector<double> unknown_of(std::vector<double> contrasts, std::vector<std::string> known) {
  std::erase_if(contrasts, [&](double contrast) {
    const std::string name = merit_name(contrast);
    if (std::find(known.begin(), known.end(), name) != known.end()) return true;
    known.push_back(name);
    return false;
  });
  return contrasts;
}

}  // namespace

/// Few enough digits for 0.29 to be 29.
std::string percent_text(double contrast) { return significant(100.0 * contrast, 12); }

std::vector<std::string> merit_names(std::span<const double> contrasts) {
  std::vector<std::string> names;
  for (const Merit& merit : kMerits) names.emplace_back(merit.name);
  for (const double contrast : contrasts) names.push_back(merit_name(contrast));
  return names;
}

std::vector<std::optional<Estimate>> merits_of(const MeasuredEdge& edge) {
  std::vector<std::optional<Estimate>> values;
  for (const Merit& merit : kMerits) {
    const std::optional<Estimate>& value = edge.edge.*merit.value;
    values.push_back(merit.frequency ? in_unit(value, edge.scale) : value);
  }
  for (const std::optional<Estimate>& frequency : edge.at_contrasts) values.push_back(in_unit(frequency, edge.scale));
  return values;
}

std::optional<Estimate> at_contrast(const MeasuredEdge& edge, double contrast, std::span<const double> further) {
  const std::vector<std::string> names = merit_names(further);
  const auto name = std::find(names.begin(), names.end(), merit_name(contrast));
  if (name == names.end()) return std::nullopt;
  return merits_of(edge)[static_cast<std::size_t>(name - names.begin())];
}

std::optional<Estimate> in_unit(const std::optional<Estimate>& cy_px, const FrequencyScale& scale) {
  if (!cy_px) return std::nullopt;
  return Estimate{cy_px->value * scale.per_cy_px, cy_px->sd * scale.per_cy_px};
}

std::vector<double> in_unit(std::vector<double> cy_px, const FrequencyScale& scale) {
  for (double& frequency : cy_px) frequency *= scale.per_cy_px;
  return cy_px;
}

void add_contrasts(MeasuredEdge& edge, std::span<const double> contrasts) {
  const std::vector<double>& frequencies = edge.edge.frequency_cy_px;
  for (const double contrast : contrasts) {
    edge.at_contrasts.push_back(calib::frequency_at(edge.edge, contrast));
    if (edge.at_contrasts.back() || frequencies.empty()) continue;
    edge.edge.absent.emplace_back(merit_name(contrast), "the MTF stays above " + percent_text(contrast) + " % up to " +
                                                            significant(frequencies.back() * edge.scale.per_cy_px, 4) +
                                                            " " + std::string(unit_name(edge.scale.unit)));
  }
}

std::vector<double> without_repetitions(const std::vector<double>& asked) { return unknown_of(asked, {}); }

std::vector<double> further_contrasts(const std::vector<double>& asked) { return unknown_of(asked, merit_names({})); }

}  // namespace apps
