// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "mtf/engines/fft/spectral.h"
#include "mtf/error.h"
#include "mtf/plan/plan_parts.h"
#include "mtf/work/usable_memory.h"

namespace mtf {
namespace {

constexpr double kFloatUnit = 5.9604644775390625e-8;  // 2^-24
constexpr double kSmallestFloat = 0x1p-150;           // half the step of denormal floats

}  // namespace

double aliases(const AxisTransform& job) {
  const double detector_band = job.frequency.period_um() / job.pitch_um;
  const std::int64_t all = job.frequency.basis == Basis::cosine ? 2 * job.frequency.length : job.frequency.length;
  const auto kept = static_cast<double>(std::min(2 * job.keep - 1, all));
  return std::max(1.0, std::ceil(kept / std::max(detector_band, 1.0) - kWholeEpsilon));
}

double dropped_error(const FactoredOtf& sampler) {
  double sum = 0.0;
  for (const Dropped& d : sampler.dropped()) sum += d.bound;
  return sum * sampler.gain();
}

double storage_error(const PlanOptions& options) {
  if (!options.scene) return kFloatUnit;
  const SceneSummary& scene = *options.scene;
  return (std::max(scene.largest * kFloatUnit, kSmallestFloat) + scene.error) / scene.std;
}

// rms rounding of float32: a transform pair errs by about 0.4 units per doubling of its length (measured in tests), the
// chirp passes through twice as many; then OTF rounding. Rounding inside the transforms is relative to the rms of the
// canvas (in units of std), which a constant border far from the mean raises; that of the result is relative to the
// values with their mean.
double arithmetic_error(const AxisTransform& x, const AxisTransform& y, double canvas_rms, double gain,
                        const PlanOptions& options) {
  double units = 2.0;
  for (const AxisTransform* job : {&x, &y}) {
    const double stages = std::log2(1.0 + static_cast<double>(job->frequency.length));
    const bool chirps = job->resampling == Resampling::chirp;
    const bool small = in_small_steps(job->frequency.length) && in_small_steps(inverse_length(*job));
    units += 0.5 * stages * (chirps ? 4.0 : small ? 1.0 : 3.0);
  }
  return gain * (kFloatUnit * units * std::max(canvas_rms, 1.0) + storage_error(options));
}

bool keeps_tolerance(const MethodCandidate& candidate, const PlanOptions& options) {
  const PredictedError& predicted = candidate.report.predicted;
  if (predicted.total() <= options.tolerance) return true;
  // The parts of an FFT method are shares of the tolerance but for rounding and tables.
  return !options.scene && candidate.axes && predicted.table == 0.0 && predicted.arithmetic <= options.tolerance;
}

// The other parts scale with the tolerance, or are none where radial factors are exact and nothing is cut; arithmetic
// is fixed.
double reachable_tolerance(double arithmetic, double band, double wrap_share) {
  const double shares = kDropShare + wrap_share;
  double least = 1.001 * (arithmetic + band) / (1.0 - shares);
  if (band > 0.0) least = std::max(least, 1.001 * arithmetic / (1.0 - shares - kBandShare));
  if (!(least > 0.0) || !std::isfinite(least)) return least;
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.2e", least * (1.0 + 5e-3));  // to the nearest of what is half a digit more
  return std::strtod(text.data(), nullptr);
}

UnreachableTolerance unreachable_tolerance(double asked, double reachable, const std::optional<SceneSummary>& scene,
                                           double in_float) {
  if (reachable < 1.0) {
    const bool both = in_float > reachable && in_float < 1.0;
    const bool made = scene && scene->error > scene->largest * kFloatUnit;
    return {
        "tolerance " + format_double(asked) + " is below what can be kept here (" +
            (made ? "the values of the scene, made with a table, err by up to " + format_double(scene->error)
                  : std::string("samples are float32")) +
            (both ? "; transforms in float reach " + format_double(in_float) + ", in double " + format_double(reachable)
                  : std::string()) +
            "); use " + format_double(reachable) + " or more",
        reachable};
  }
  const SceneSummary s = scene.value_or(SceneSummary{});
  return {"no tolerance below 1 can be kept: float32 rounds values of " + format_double(s.largest) +
              " by more than this scene's contrast (std " + format_double(s.std) +
              "); take off its offset, bring the border value nearer, or lower the gain of the filter",
          std::numeric_limits<double>::infinity()};
}

double spectral_bytes(const AxisTransform& x, const AxisTransform& y, bool real_otf) {
  const auto count = [](std::int64_t n) { return static_cast<double>(n); };
  const double columns = count(x.keep) * (x.frequency.basis == Basis::cosine ? 1.0 : 2.0);
  const double terms = count(std::min(2 * y.keep, y.frequency.length + 1));
  const double parts = count(static_cast<std::int64_t>(otf_parts(x, y, real_otf).size()));
  const double otf = parts * columns * (y.frequency.basis == Basis::cosine ? count(y.keep) : terms);
  const double buffer = (x.odd ? 2.0 : 1.0) * columns * count(std::max(y.samples, y.outputs));
  // Per frequency of an axis: up to five work areas of a row of lanes each, and tables.
  double axes = 0.0;
  for (const AxisTransform* job : {&x, &y})
    axes += (20.0 * kRow + 200.0) * count(std::max(job->frequency.length, inverse_length(*job)));
  return 4.0 * (otf + buffer) + axes;
}

void require_memory(double bytes, const SampleGrid& out) {
  bytes += 4.0 * static_cast<double>(out.width) * static_cast<double>(out.height);
  const UsableMemory memory = usable_memory();
  if (bytes <= memory.bytes) return;
  throw UsageError(
      "the plan would need " + format_double(bytes) + " bytes, " + memory.whose + " " + format_double(memory.bytes) +
      "; check scene.sample and frame.pitch, set frame.format, choose border = \"periodic\", or cut the scene");
}

}  // namespace mtf
