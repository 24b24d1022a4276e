// SPDX-License-Identifier: Apache-2.0
#include "apps/report/report_chosen.h"
#include "apps/sensor/sensor_air.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/arguments.h"
#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/terminal/output.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"

namespace apps {
namespace {

constexpr int kPoints = 97;
constexpr std::size_t kMostText = 256 << 10;

double modulus(const mtf::Complex<double>& value) { return std::hypot(value.re, value.im); }

ChosenCurve curve_of(const OtfColumn& column) {
  ChosenCurve curve{column.label, column.stage, column.doc, {}, 0.0};
  // The last frequency is Nyquist's own.
  for (std::size_t i = 0; i + 1 < column.otf.size(); ++i) curve.mtf.push_back(modulus(column.otf[i]));
  curve.at_nyquist = modulus(column.otf.back());
  return curve;
}

void add_curves(ChosenDesign& design, const mtf::System<double>& system) {
  const KeyFigures figures = key_figures(system, {});
  design.nyquist_cy_mm = figures.nyquist;
  std::vector<double> frequency = evenly_spaced(0.0, figures.last_frequency(), kPoints);
  design.frequency_cy_mm = frequency;
  frequency.push_back(figures.nyquist);
  const OtfCurves values = otf_curves(system, std::move(frequency));
  for (const OtfColumn& column : values.components) design.components.push_back(curve_of(column));
  design.system = curve_of(values.system);
}

void add_budget(ChosenDesign& design, double temperature_k) {
  try {
    const LoadedSensor loaded = load_chain(design.config);
    const radiometry::Budget<double> budget = budget_of(design.config.system, loaded.sensor, temperature_k);
    design.budget = budget_rows(design.config.system, loaded.sensor, budget);
    design.saturation = words(budget.saturation);
  } catch (const std::exception& error) {
    design.budget_gap = one_line(error.what());
  }
}

void load(const Sweep& sweep, ChosenDesign& design) {
  std::string problem;
  design.text = text_of(sweep, design.chosen.file, problem);
  if (!problem.empty()) throw mtf::RuntimeError(problem);
  const std::string path = (sweep.folder / design.chosen.file).string();
  mtf::io::ConfigResult parsed = mtf::io::parse_config(design.text, path, sensor_schema());
  for (const mtf::io::Diagnostic& diagnostic : parsed.diagnostics)
    if (diagnostic.error) throw mtf::UsageError(mtf::io::format_diagnostic(diagnostic, design.chosen.file));
  design.config = std::move(parsed.config);
  design.name = design.config.system.name;
  const bool chain = has_chain(design.config);
  const mtf::System<double>& system = design.config.system;
  add_curves(design, chain && system.band ? with_electron_rate(system, load_chain(design.config)) : system);
  if (chain)
    add_budget(design, sweep.temperature_k);
  else
    design.budget_gap = "its sensor file has no [detector], without which there is neither light nor noise";
}

}  // namespace

std::string text_of(const Sweep& sweep, const std::string& file, std::string& problem) {
  const std::filesystem::path path = file;
  const bool inside = !file.empty() && path.is_relative() &&
                      std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
  if (!inside) {
    problem = one_line(file) + ": is not a file of the sweep's folder";
    return {};
  }
  try {
    return mtf::io::read_table_text((sweep.folder / path).string(), kMostText);
  } catch (const std::exception& error) {
    problem = one_line(error.what());
    return {};
  }
}

std::vector<ChosenDesign> load_chosen(const Sweep& sweep) {
  constexpr std::size_t kMost = 16;  // a sweep chooses about ten
  std::vector<ChosenDesign> designs;
  for (const SweepChosen& chosen : sweep.chosen) {
    if (designs.size() == kMost) break;
    ChosenDesign& design = designs.emplace_back();
    design.chosen = chosen;
    try {
      load(sweep, design);
    } catch (const std::exception& error) {
      design.problem = one_line(error.what());
      design.budget_gap = design.image_gap = design.problem;
    }
  }
  return designs;
}

}  // namespace apps
