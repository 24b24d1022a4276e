// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/plan_parts.h"

namespace mtf {
namespace {

constexpr double kFloatUnit = 5.9604644775390625e-8;  // 2^-24
constexpr double kSmallestFloat = 0x1p-150;           // half the step of denormal floats
constexpr double kWholeEpsilon = 1e-9;                // a count of pitches is whole within this

}  // namespace

double aliases(const AxisJob& job) {
  const double detector_band = job.frequency.period_um() / job.pitch_um;
  const std::int64_t all = job.frequency.basis == Basis::cosine ? 2 * job.frequency.length : job.frequency.length;
  const auto kept = static_cast<double>(std::min(2 * job.keep - 1, all));
  return std::max(1.0, std::ceil(kept / std::max(detector_band, 1.0) - kWholeEpsilon));
}

// rms rounding of float32: a transform pair errs by about 0.4 units per doubling of its length (measured in tests), the
// chirp passes through twice as many; then OTF rounding. Rounding inside the transforms is relative to the rms of the
// canvas (in units of std), which a far border level raises; that of the result to the values with their mean.
double arithmetic_error(const AxisJob& x, const AxisJob& y, double canvas_rms, double gain,
                        const PlanOptions& options) {
  double units = 2.0;
  for (const AxisJob* job : {&x, &y}) {
    const double stages = std::log2(1.0 + static_cast<double>(job->frequency.length));
    units += 0.5 * stages * (job->resampling == Resampling::chirp ? 4.0 : 1.0);
  }
  const double storage =
      options.scene ? std::max(options.scene->largest * kFloatUnit, kSmallestFloat) / options.scene->std : kFloatUnit;
  return gain * (kFloatUnit * units * std::max(canvas_rms, 1.0) + storage);
}

void refuse_unreachable(const PredictedError& predicted, double arithmetic, double tolerance,
                        const PlanOptions& options) {
  if (predicted.total() <= tolerance) return;
  if (!options.scene && predicted.arithmetic <= tolerance) return;
  // The other parts scale with the tolerance; arithmetic and the table's resolution are fixed.
  const double reachable =
      1.01 * (arithmetic + predicted.table) / (1.0 - kDropShare - 2.0 * kTableShare - kCutShare - kWrapShare);
  if (!(reachable < 1.0))
    throw UsageError("no tolerance below 1 can be kept: float32 rounds values of " +
                     format_double(options.scene ? options.scene->largest : 1.0) +
                     " by more than this scene's contrast (std " +
                     format_double(options.scene ? options.scene->std : 1.0) +
                     "); take off its offset, bring the border level nearer, or lower the gain of the filter");
  throw UsageError("tolerance " + format_double(tolerance) + " is below what float32 reaches for this scene; use " +
                   format_double(reachable) + " or more");
}

}  // namespace mtf
