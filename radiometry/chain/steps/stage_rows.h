// SPDX-License-Identifier: Apache-2.0
#pragma once

// The rows of the stages of the chain. A file beside this one holds the rows of one part of the camera in their order:
// a row says all that a stage is, in words and on a frame (StageRow in chain_impl.h). Steps take the frame in the
// quantity that the step before left: radiance to the end of the optics, electrons (volts of a thermal detector) from
// `collect` to the converter, counts after it.

#include <span>
#include <string>

#include "mtf/words.h"
#include "radiometry/chain/chain_impl.h"

namespace radiometry {

/// In this order they are the table of the stages.
std::span<const StageRow> optics_rows();
std::span<const StageRow> light_rows();
std::span<const StageRow> charge_rows();
std::span<const StageRow> count_rows();

using System = mtf::System<double>;

constexpr const char* kNotThermal = "a thermal detector has none";

/// The words of a stage that is on where it has something to say: numbers above 0, which the text lists.
inline StageWords said(std::string what, const std::string& otherwise) {
  if (what.empty()) return {false, otherwise};
  return {true, std::move(what)};
}

inline std::string rounded(double value) { return mtf::significant(value, 6); }

inline const char* rms_unit(const Sensor& sensor) { return sensor.settings.thermal ? "V rms" : "e- rms"; }

/// The values above 0 with their names, "" where there are none.
inline std::string terms(std::initializer_list<std::pair<const char*, double>> list, const char* unit) {
  std::string text;
  for (const auto& [name, value] : list)
    if (value > 0.0) text += (text.empty() ? "" : ", ") + std::string(name) + " " + rounded(value) + " " + unit;
  return text;
}

/// A map from a file has its name; one that a program made has none.
inline std::string map_words(const std::string& file) { return file.empty() ? "a map" : file; }

inline StageWords filters(const System& system, mtf::Stage stage) {
  std::string labels;
  for (const auto& entry : system.list(stage)) labels += (labels.empty() ? "" : " x ") + entry.label;
  return said(labels, "no [[" + std::string(mtf::stage_name(stage)) + "]]");
}
template <mtf::Stage stage>
StageWords filters(const System& system, const Sensor&) {
  return filters(system, stage);
}

/// Runs the plan of a filter on the frame and on the value beyond its border.
inline void filter(const mtf::Plan& plan, FrameRun& run, mtf::Image& image) {
  std::vector<mtf::Image> planes;
  planes.push_back(std::move(image));
  image = std::move(mtf::run_in_place(plan, std::move(planes), run.border, run.threads).front());
  run.border *= plan.dc();
}

}  // namespace radiometry
