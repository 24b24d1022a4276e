// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/saturation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/math/special.h"
#include "mtf/words.h"

namespace radiometry {
namespace {

constexpr double kFarAway = 3.2e-5;  // Q(4)

/// Share of values that lie `distance` or more above their mean.
double share_beyond(double distance, double sigma) {
  if (!(sigma > 0.0)) return distance <= 0.0 ? 1.0 : 0.0;
  return 0.5 * std::erfc(distance / (std::sqrt(2.0) * sigma));
}

std::string percent(double share) { return mtf::three_digits(100.0 * share) + " %"; }

std::string shorter(const Saturation& s) {
  return s.end_e > 0.0 && s.mean_e >= s.end_e
             ? "shorten frame.integration_time to less than " + at_most(s.end_e / s.mean_e) + " of what it is"
             : std::string("shorten frame.integration_time");
}

}  // namespace

std::string_view range_end_name(RangeEnd end) {
  constexpr std::array<std::string_view, 4> names{"", "full_well", "most_count", "least_count"};
  return names[static_cast<std::size_t>(end)];
}

HeldScatter held_scatter(double x) {
  const double beyond = share_beyond(x, 1.0), density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * mtf::kPi);
  const double mean = x * beyond - density;  // of min(value, x)
  return {1.0 - beyond, std::sqrt(1.0 - beyond + x * mean - mean * mean)};
}

Saturation saturation_of(const PixelScatter& pixel, const PixelRange& range, double full_well_e) {
  const bool well = full_well_e <= range.most_e;
  const double most_e = well ? full_well_e : range.most_e;
  const double above = share_beyond(most_e - pixel.mean_e, well ? pixel.well_e : pixel.converter_e);
  // A pixel without light at count 0 is not held: a little more light changes its value.
  const double below = pixel.converter_e > 0.0 || pixel.mean_e < range.least_e
                           ? share_beyond(pixel.mean_e - range.least_e, pixel.converter_e)
                           : 0.0;
  if (!(above + below > 0.0)) return {.mean_e = pixel.mean_e};
  const bool high = above >= below;
  return {.end = !high  ? RangeEnd::least_count
                 : well ? RangeEnd::full_well
                        : RangeEnd::most_count,
          .mean_e = pixel.mean_e,
          .end_e = high ? most_e : range.least_e,
          .sigmas = high ? (most_e - pixel.mean_e) / (well ? pixel.well_e : pixel.converter_e)
                         : (pixel.mean_e - range.least_e) / pixel.converter_e,
          .held = std::min(above + below, 1.0)};
}

std::string at_most(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return mtf::significant(std::floor(value / unit) * unit, 2);
}

std::string words(const Saturation& s) {
  if (!(s.held >= kFarAway)) return {};
  std::string text = s.saturated() ? "saturated: " : "near saturation: about ";
  text += percent(s.held) + " of the values are held at ";
  const std::string unit = s.volts ? " V" : " e-", mean = " for a mean of " + mtf::three_digits(s.mean_e) + unit;
  if (s.end == RangeEnd::full_well)
    text += "the full well of " + mtf::three_digits(s.end_e) + " e-" + mean + "; " + shorter(s) +
            ", or raise detector.full_well";
  else if (s.end == RangeEnd::most_count)
    text += "the largest count of [adc], which stands for " + mtf::three_digits(s.end_e) + unit + "," + mean +
            "; raise " +
            (s.volts ? "adc.volts_per_count or adc.bits, or lower adc.offset"
                     : "adc.electrons_per_count or adc.bits, lower adc.offset, or " + shorter(s));
  else
    text +=
        "count 0 of [adc], which stands for " + mtf::three_digits(s.end_e) + unit + "," + mean + "; raise adc.offset";
  if (s.saturated()) return text;
  const HeldScatter left = held_scatter(s.sigmas);
  return text + "; slope, noise and NETD are " + mtf::three_digits(left.slope) + ", " + mtf::three_digits(left.sd) +
         " and " + mtf::three_digits(left.sd / left.slope) + " of the figures, at worst";
}

double HeldPixels::share() const {
  if (pixels == 0) return 0.0;
  return static_cast<double>(std::max({full_well, most_count, least_count})) / static_cast<double>(pixels);
}

HeldPixels& HeldPixels::operator+=(const HeldPixels& other) {
  pixels += other.pixels;
  full_well += other.full_well;
  most_count += other.most_count;
  least_count += other.least_count;
  volts = volts || other.volts;
  return *this;
}

std::string where_held(const HeldPixels& held) {
  std::string text;
  const auto add = [&](std::int64_t count, const char* where) {
    if (count == 0) return;
    const double share = static_cast<double>(count) / static_cast<double>(held.pixels);
    text += (text.empty() ? "" : ", ") + percent(share) +
            (text.empty() ? " of the pixels (" + std::to_string(count) + " of " + std::to_string(held.pixels) + ")"
                          : " (" + std::to_string(count) + ")") +
            " at " + where;
  };
  add(held.full_well, "the full well");
  add(held.most_count, "the converter's largest count");
  add(held.least_count, "the converter's count 0");
  return text;
}

std::string words(const HeldPixels& held) {
  if (!held.any()) return {};
  // A converter whose range is the well clips values that read noise lifts above a full well; the well is the cause.
  const bool converter = held.most_count > held.full_well;
  std::string change = held.full_well > 0 ? "shorten frame.integration_time or raise detector.full_well" : "";
  if (converter)
    change += std::string(held.volts       ? ""
                          : change.empty() ? "shorten frame.integration_time, "
                                           : "; ") +
              (held.volts ? "raise adc.volts_per_count or adc.bits, or lower adc.offset"
                          : "raise adc.electrons_per_count or adc.bits, or lower adc.offset");
  if (held.least_count > 0) change += std::string(change.empty() ? "" : "; ") + "raise adc.offset";
  return "saturated: " + where_held(held) + ", where values no longer follow the scene; " + change;
}

}  // namespace radiometry
