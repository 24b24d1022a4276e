// SPDX-License-Identifier: Apache-2.0
#pragma once

// The chosen designs of a sweep, one by one: curves, noise budget and a simulated image, each computed here
// from chosen/design_N.toml. Where one of them is not possible, a sentence says why; it is no error.

#include <cstdint>
#include <string>
#include <vector>

#include "apps/options.h"
#include "apps/report/report_sweep.h"
#include "mtf/io/config/config.h"
#include "radiometry/performance/sensitivity.h"

namespace apps {

struct ChosenCurve {
  std::string label, stage, doc;
  std::vector<double> mtf;  ///< at ChosenDesign::frequency_cy_mm
  double at_nyquist = 0.0;
};

struct ChosenImage {
  std::string data_uri;  ///< PNG
  std::int64_t width = 0, height = 0;
  double low = 0.0, high = 0.0;  ///< black and white
  std::string unit;
  std::vector<std::string> notes;
};

struct ChosenDesign {
  SweepChosen chosen;
  std::string name, text;  ///< of the sensor file
  std::string problem;     ///< why there is nothing below; "" else
  mtf::io::SensorConfig config;
  double nyquist_cy_mm = 0.0;           ///< along x, as all curves
  std::vector<double> frequency_cy_mm;  ///< 0 to the cutoff or twice Nyquist, the smaller
  std::vector<ChosenCurve> components;
  ChosenCurve system;
  std::vector<radiometry::BudgetRow> budget;
  std::string budget_gap;  ///< why there is none
  std::string saturation;  ///< which of its figures are refused or wrong, and why; "" when all are right
  ChosenImage image;
  std::string image_gap;
};

/// Bytes that an image takes in a page, at most: 160 x 160 grey values that do not compress, in base 64.
inline constexpr std::size_t kMostOfImage = 36'000;

/// Reads every chosen file; curves, and budgets of a surface of the study's temperature.
std::vector<ChosenDesign> load_chosen(const Sweep& sweep);

/// The images of one scene: the file `scene`, or the built-in one when it is empty, which has the same angular size for
/// all designs; `temperature_k`: its mean.
void simulate_chosen(std::vector<ChosenDesign>& designs, const std::string& scene, double temperature_k,
                     const Global& global);

/// A file of the sweep's folder as text. Nothing, and `problem` says why, when it is missing, too large, or not in the
/// folder.
std::string text_of(const Sweep& sweep, const std::string& file, std::string& problem);

}  // namespace apps
