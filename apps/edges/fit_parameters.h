// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fitted numbers as a table, as JSON and as lines above a fitted file: what all fits of the command have in common.

#include <span>
#include <string>
#include <vector>

#include "apps/text/json.h"
#include "calib/fit/fit.h"

namespace apps {

/// As many digits as the standard error has, two more than its first.
std::string shown_with_error(double value, double sd);
/// As files have it: to two digits beyond the first one of its standard error, which moves it by at most 0.01 of that;
/// without an error (0) to ten digits.
double rounded_to_error(double value, double sd);

/// Whether one more unknown of the sensor changes what is known of a number: it moves by more than its standard
/// deviation, or that grows by half.
bool matters(const calib::Estimate& plain, const calib::Estimate& richer);

/// Values, beside each what a richer model makes of it where that matters, intervals, what is not separable,
/// correlation.
std::string parameters_table(std::span<const calib::FittedParameter> parameters,
                             std::span<const calib::NullDirection> not_separable,
                             const std::vector<std::vector<double>>& correlation,
                             std::span<const calib::Alternative> alternatives = {},
                             std::span<const calib::RicherModel> richer_models = {});

/// "parameters", "correlation", "not_separable".
void add_parameters(Json& json, std::span<const calib::FittedParameter> parameters,
                    std::span<const calib::NullDirection> not_separable,
                    const std::vector<std::vector<double>>& correlation);
/// One of "parameters".
Json parameter_json(const calib::FittedParameter& parameter);

/// The file whose numbers were fitted.
struct FitOrigin {
  std::string file, sha256;
  std::string outcome;  ///< "converged, chi2 per dof 1.02"
};
/// Comments at the top of a fitted file, up to an empty line: where it comes from, and what has no standard error.
std::string fit_head(const FitOrigin& origin, const std::vector<std::string>& inputs,
                     std::span<const calib::FittedParameter> parameters,
                     std::span<const calib::NullDirection> not_separable,
                     std::span<const calib::RicherModel> richer_models = {});

/// A fitted file without the lines that an earlier fit has put above, up to the empty one.
std::string without_fit_head(const std::string& text);

}  // namespace apps
