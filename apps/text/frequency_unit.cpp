// SPDX-License-Identifier: Apache-2.0
#include "apps/text/frequency_unit.h"

#include <array>

#include "mtf/error.h"
#include "mtf/system.h"

namespace apps {
namespace {

struct UnitWords {
  std::string_view symbol, name;
};
constexpr std::array<UnitWords, 5> kUnitWords{{{"cy/px", "cycles/pixel"},
                                               {"cy/mm", "cycles/mm"},
                                               {"lp/mm", "line pairs/mm"},
                                               {"cy/mrad", "cycles/mrad"},
                                               {"lw/ph", "line widths/picture height"}}};

double required(FrequencyUnit unit, const std::optional<double>& value, const char* option) {
  if (value) return *value;
  throw mtf::UsageError("--unit " + std::string(unit_symbol(unit)) + ": needs " + option +
                        "; give it, or leave out --unit to have cycles per pixel");
}

/// The bounds of [frame] in a sensor file hold for the options too.
void require_valid(const mtf::Frame<double>& frame) {
  mtf::System<double> system;
  system.frame = frame;
  for (const auto& finding : system.errors())
    throw mtf::UsageError((finding.where == "frame.focal_length" ? "--focal-length: " : "--pitch: ") +
                          finding.problem.text);
}

}  // namespace

std::string_view unit_symbol(FrequencyUnit unit) { return kUnitWords[static_cast<std::size_t>(unit)].symbol; }
std::string_view unit_name(FrequencyUnit unit) { return kUnitWords[static_cast<std::size_t>(unit)].name; }

FrequencyScale frequency_scale(FrequencyUnit unit, std::optional<double> pitch_um,
                               std::optional<double> focal_length_mm, std::int64_t rows) {
  constexpr const char* kPitch = "the spacing of the pixels: --pitch 4.73um";
  constexpr const char* kFocalLength = "the focal length: --focal-length 50mm";
  const bool per_pixel = unit == FrequencyUnit::cy_px || unit == FrequencyUnit::lw_ph;
  if (per_pixel && (pitch_um || focal_length_mm))
    throw mtf::UsageError(std::string(pitch_um ? "--pitch" : "--focal-length") + ": frequencies in " +
                          std::string(unit_symbol(unit)) +
                          " do not depend on it; add --unit cy/mm, lp/mm or cy/mrad, or leave it out");
  if (unit == FrequencyUnit::cy_px) return {};
  if (unit == FrequencyUnit::lw_ph) return {unit, 2.0 * static_cast<double>(rows)};
  const double pitch = required(unit, pitch_um, kPitch);
  const bool angle = unit == FrequencyUnit::cy_mrad;
  const double focal_length = angle ? required(unit, focal_length_mm, kFocalLength) : 1.0;
  const mtf::Frame<double> frame{.focal_length_mm = focal_length, .pitch_x_um = pitch, .pitch_y_um = pitch};
  require_valid(frame);
  const double cy_mm = frame.cy_mm_from_px(1.0, mtf::Axis::x);
  return {unit, angle ? frame.cy_per_mrad(cy_mm) : cy_mm};
}

}  // namespace apps
