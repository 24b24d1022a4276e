// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/frequency_unit.h"

#include <array>

#include "mtf/error.h"
#include "mtf/frame.h"
#include "mtf/units.h"

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

/// The bounds are those of [frame] in a sensor file.
double required(FrequencyUnit unit, const std::optional<double>& value, double most, const char* option) {
  constexpr double kLeast = 1e-6;
  if (value && *value >= kLeast && *value <= most) return *value;
  if (value)
    throw mtf::UsageError("--unit " + std::string(unit_symbol(unit)) + ": " + mtf::format_double(*value) +
                          " is outside [" + mtf::format_double(kLeast) + ", " + mtf::format_double(most) + "] for " +
                          option);
  throw mtf::UsageError("--unit " + std::string(unit_symbol(unit)) + ": needs " + option +
                        "; give it, or leave out --unit to have cycles per pixel");
}

}  // namespace

std::string_view unit_symbol(FrequencyUnit unit) { return kUnitWords[static_cast<std::size_t>(unit)].symbol; }
std::string_view unit_name(FrequencyUnit unit) { return kUnitWords[static_cast<std::size_t>(unit)].name; }

FrequencyScale frequency_scale(FrequencyUnit unit, std::optional<double> pitch_um,
                               std::optional<double> focal_length_mm, std::int64_t rows) {
  constexpr const char* kPitch = "the spacing of the pixels in um: --pitch 4.73um";
  constexpr const char* kFocalLength = "the focal length in mm: --focal-length 50mm";
  const bool per_pixel = unit == FrequencyUnit::cy_px || unit == FrequencyUnit::lw_ph;
  if (per_pixel && (pitch_um || focal_length_mm))
    throw mtf::UsageError(std::string(pitch_um ? "--pitch" : "--focal-length") + ": frequencies in " +
                          std::string(unit_symbol(unit)) +
                          " do not depend on it; add --unit cy/mm, lp/mm or cy/mrad, or leave it out");
  if (unit == FrequencyUnit::cy_px) return {};
  if (unit == FrequencyUnit::lw_ph) return {unit, 2.0 * static_cast<double>(rows)};
  const double pitch = required(unit, pitch_um, 1e6, kPitch);
  const bool angle = unit == FrequencyUnit::cy_mrad;
  const double focal_length = angle ? required(unit, focal_length_mm, 1e7, kFocalLength) : 1.0;
  const mtf::Frame<double> frame{.focal_length_mm = focal_length, .pitch_x_um = pitch, .pitch_y_um = pitch};
  const double cy_mm = frame.cy_mm_from_px(1.0, mtf::Axis::x);
  return {unit, angle ? frame.cy_per_mrad(cy_mm) : cy_mm};
}

}  // namespace apps
