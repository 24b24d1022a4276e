// SPDX-License-Identifier: Apache-2.0

// Whether the noise of a pixel is its own: that of its neighbours, and of other frames. All other numbers take the
// frames as independent: noise that lasts from one to the next (1/f, lag, blinking, averages over frames) is missing in
// the temporal noise of a short stack, and stands in its fixed pattern.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/characterize/characterize.h"
#include "calib/characterize/defect_pixels.h"
#include "calib/fit/fit_report.h"
#include "mtf/words.h"

namespace calib {
namespace {

constexpr double kSure_sd = 5.0, kLeast = 0.01;  // a correlation below changes no number by its error

}  // namespace

void warn_of_neighbours(const Stack& dark, std::vector<std::string>& warnings) {
  const double v = dark.sums.squares.value[radiometry::kTvh];
  const auto covariance = pixel_covariance(dark.sums);
  for (std::size_t k = 0; k < 2; ++k) {
    const double r = covariance[k].value / v, sd = covariance[k].sd / v;
    if (std::abs(r) > 0.02 + 5.0 * sd)
      warnings.push_back(
          dark.name + ": the noise of neighbours in " + (k == 0 ? "rows" : "columns") + " correlates (" +
          mtf::significant(r, 2) +
          "), as 1/f noise of the readout, a filter or a denoiser makes it: behind a filter gain and noise are "
          "wrong; give raw frames");
  }
}

SlowNoise slow_noise_of(const Stack& dark) {
  const StackSummary& s = dark.sums;
  if (s.noise.empty()) return {};
  const auto square_of = [&](radiometry::CubePart part) {
    const double variance = std::max(0.0, s.squares.variance(part));
    return variance * variance;
  };
  return estimate_slow_noise(s.noise,
                             square_of(radiometry::kTv) * static_cast<double>(s.noise.rows_apart) / s.squares.rows +
                                 square_of(radiometry::kTh) / s.squares.columns);
}

void add_slow_noise(const SlowNoise& slow, int dark, const Estimate& gain, Characterization& camera) {
  const auto undetermined = [&](const std::string& why) {
    camera.findings.push_back({.name = "flicker_octave", .unit = "e-", .verdict = Verdict::not_determined, .why = why});
  };
  const Estimate& K = slow.strength;
  if (!(K.sd > 0.0))
    return undetermined("it takes a dark stack of " + std::to_string(kSlowFrames) +
                        " frames or more, whose noise rounding does not hide");
  const std::string from = camera.stacks[static_cast<std::size_t>(dark)].name + ", noise over 1 to " +
                           std::to_string(slow.frames / 2) + " frames";
  if (K.value > 3.0 * K.sd && !slow.found)
    return undetermined("the noise of pixels lasts from frame to frame, but not as 1/f noise (p = " +
                        mtf::significant(slow.p, 2) + ")");
  const auto octave = [&](double strength) {
    return std::sqrt(std::max(0.0, strength) * std::numbers::ln2) / gain.value;
  };
  const double value = slow.found ? octave(K.value) : 0.0;
  camera.flicker_lowest = slow.lowest;
  camera.findings.push_back({.name = "flicker_octave",
                             .unit = "e-",
                             .verdict = slow.found ? Verdict::determined : Verdict::upper_limit,
                             .value = value,
                             .sd = slow.found ? value * std::hypot(0.5 * K.sd / K.value, gain.sd / gain.value) : 0.0,
                             .low95 = slow.found ? octave(K.value - k95_sd * K.sd) : 0.0,
                             .high95 = octave(std::max(0.0, K.value) + k95_sd * K.sd),
                             .from = from});
  if (slow.found)
    camera.findings.push_back(finding_of("flicker_corner", "cycles per frame", slow.corner,
                                         from + ", where it equals a pixel's white noise"));
}

void add_noise_in_time(const std::vector<Stack>& stacks, std::vector<Finding>& findings,
                       std::vector<std::string>& warnings, bool known, double explained) {
  const Stack *least = nullptr, *clearest = nullptr;
  const auto clear = [](const Stack& one) {
    const Estimate& e = one.sums.frame_correlation;
    return e.sd > 0.0 ? std::abs(e.value) / e.sd : 0.0;
  };
  for (const Stack& one : stacks) {
    if (!one.is_usable() || is_hidden_by_rounding(one)) continue;
    if (least == nullptr) least = &one;
    if (clearest == nullptr || clear(one) > clear(*clearest)) clearest = &one;
  }
  if (least == nullptr) return;
  if (const Estimate& e = least->sums.frame_correlation; e.sd > 0.0)
    findings.push_back(finding_of("frame_correlation", "", e, least->name + ", a pixel's noise in successive frames"));
  if (const Estimate& e = clearest->sums.frame_correlation;
      !known && std::abs(e.value) > std::max(kLeast, kSure_sd * e.sd))
    warnings.push_back(
        clearest->name + ": the noise of a pixel is correlated from frame to frame (" + mtf::significant(e.value, 2) +
        " +- " + mtf::significant(e.sd, 2) +
        "), as 1/f noise, lag, blinking or a filter over frames make it: read noise and patterns are those of this "
        "number of frames, and behind a filter gain and noise are wrong; give raw frames");
  // Light makes the variances of pixels differ, and so does rounding below 0.4 counts, of which 1e-4 is fixed.
  const bool is_dark = least->light == 0.0 || least->light_per_k > 0.0;
  if (!is_dark || rounding_of(*least) > 1e-4) return;
  const auto count = static_cast<double>(noisy_places(least->sums).size()),
             of = static_cast<double>(least->sums.variances.size());
  findings.push_back(
      share_finding("noisy_pixels", count, of, least->name + ", temporal variance above that of the others"));
  if (poisson_tail(count, kNoisy_p * of + explained) < 1e-3)
    warnings.push_back(least->name +
                       ": pixels that are noisier than the noise of the others makes any, as those that blink: " +
                       mtf::significant(count, 9) + " of " + mtf::significant(of, 9) +
                       (explained > 0.0 ? ", where hot and blinking ones are about " + mtf::significant(explained, 3)
                                        : "; the twin's pixels are all alike, with the same mean variance"));
}

}  // namespace calib
