// SPDX-License-Identifier: Apache-2.0

// Which of the proposed methods a plan takes: the cheapest that keeps the tolerance.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <utility>

#include "mtf/engines/fft/spectral.h"
#include "mtf/error.h"
#include "mtf/plan/measured.h"
#include "mtf/plan/plan_parts.h"
#include "mtf/words.h"
#include "mtf/work/usable_memory.h"

namespace mtf {
namespace {

std::string times_text(double ratio) { return fixed(ratio, ratio < 10.0 ? 1 : 0); }

// Leaving out everything may cost the whole tolerance, where other methods spend a small share of it.
std::vector<MethodCandidate> identity_candidates(const PlanTask& task) {
  const SampleGrid &in = task.in, &out = task.out;
  const bool same_grid = in.step_x_um == out.step_x_um && in.step_y_um == out.step_y_um;
  // A gain may be dropped for the contrast, not for the mean.
  const bool unit_mean = std::abs(task.sampler.dc() - 1.0) < 1e-12;
  const bool alone = task.split.is_whole() && task.options.aperture.kind == SceneAperture::Kind::point;
  MethodCandidate candidate;
  candidate.report.method = Method::identity;
  if (!same_grid) candidate.report.reason = "samples and pixels differ";
  if (!unit_mean) candidate.report.reason = "the mean does not pass as it is";
  if (!alone) candidate.report.reason = "the samples' own blur is corrected, or this is a part of a split OTF";
  candidate.report.detail = "samples as they are";
  candidate.report.predicted.dropped = task.sampler.identity_error() * task.norm;
  candidate.report.cost_ms = 1e-6 * 0.5 * static_cast<double>(in.width) * static_cast<double>(in.height);
  if (candidate.report.reason.empty()) candidate.reachable = 1.0001 * candidate.report.predicted.total();
  std::vector<MethodCandidate> candidates;
  candidates.push_back(std::move(candidate));
  return candidates;
}

// The same work on this machine takes the same time again: the method, both grids, and for the FFT methods whether the
// OTF is complex.
std::string work_of(const MethodCandidate& candidate, const PlanTask& task) {
  const auto size = [](const SampleGrid& grid) { return size_text(grid.width, grid.height); };
  return std::string(name_of(candidate.report)) + " " + size(task.in) + " to " + size(task.out) + ", " +
         candidate.report.detail + (task.sampler.is_real() ? "" : ", complex") +
         (task.sampler.is_even_x() && task.sampler.is_even_y() ? "" : ", not mirrored");
}

// Times the methods that might be the cheapest. Their predictions are worth a factor of two or so.
void measure_costs(const std::vector<MethodCandidate*>& possible, const PlanTask& task) {
  constexpr double kMaybe = 3.0;
  double least = std::numeric_limits<double>::infinity();
  for (const MethodCandidate* candidate : possible) least = std::min(least, candidate->report.cost_ms);
  const SampleGrid &in = task.in, &out = task.out;
  Image scene, image;
  for (MethodCandidate* candidate : possible) {
    if (candidate->report.cost_ms > kMaybe * least || !candidate->make) continue;
    const std::string work = work_of(*candidate, task);
    std::optional<double> ms = measured_ms(work);
    if (!ms) {
      if (scene.size() == 0) {
        scene = Image(in.width, in.height);
        image = Image(out.width, out.height);
        // Any samples that are not all alike: times do not depend on them.
        for (std::int64_t i = 0; i < scene.size(); ++i) scene.data()[i] = static_cast<float>(i * 7919 % 1013) - 506.0F;
      }
      try {
        const auto engine = candidate->make(nullptr);
        const std::vector<Channel> channel{{.in = scene.view(), .out = image.view()}};
        ms = time_ms([&] { engine->run(channel, 1); });
      } catch (const DeviceError&) {  // of no use beside others; where it is the only one, its maker says why
        if (task.options.device.insisted) throw;
        candidate->report.cost_ms = std::numeric_limits<double>::infinity();
        continue;
      }
      remember_ms(work, *ms);
    }
    candidate->report.cost_ms = *ms;
    candidate->report.measured = true;
  }
}

// What was left out, what it costs at most, and the time it saves.
void list_omissions(const MethodCandidate& chosen, const std::vector<MethodCandidate>& candidates, const PlanTask& task,
                    PlanReport& report) {
  if (chosen.report.method == Method::identity) {
    double other = std::numeric_limits<double>::infinity();
    for (const MethodCandidate& candidate : candidates)
      if (candidate.report.possible && &candidate != &chosen) other = std::min(other, candidate.report.cost_ms);
    const double saved = std::isfinite(other) ? other - chosen.report.cost_ms : 0.0;
    report.omitted.push_back({"all components: the samples pass as they are", chosen.report.predicted.dropped, saved});
    return;
  }
  for (const Dropped& d : task.sampler.dropped())
    report.omitted.push_back({d.label, d.bound * task.sampler.gain() * chosen.error_per_otf, d.saved_ms});
  if (const double flat = chosen.report.predicted.flat; flat > 0.0)
    report.omitted.push_back({"transforms of " + std::string(chosen.lines == Lines::rows ? "rows" : "columns") +
                                  " that are of one level, or nearly so when filtered",
                              flat, chosen.lines_saved_ms});
  if (chosen.report.method != Method::fft_cut) return;
  const auto& [x, y] = *chosen.axes;
  for (const MethodCandidate& candidate : candidates)
    if (candidate.report.method == Method::fft_float)
      report.omitted.push_back({"frequencies beyond " + size_text(x.keep, y.keep) + " of " +
                                    size_text(x.frequency.half_count(), y.frequency.half_count()),
                                chosen.report.predicted.cut, candidate.report.cost_ms - chosen.report.cost_ms});
}

double count(std::int64_t n) { return static_cast<double>(n); }

double groups(std::int64_t n, std::int64_t size) { return std::ceil(count(n) / count(size)); }

// Nanoseconds of a transform of kLanes sequences of length n: by its prime factors up to 13, FFTW's beyond.
double transform_ns(std::int64_t n) {
  double weight = 0.0;
  std::int64_t rest = n;
  for (const auto& [p, w] : {std::pair{2, 1.0}, {3, 1.8}, {5, 2.6}, {7, 3.6}, {11, 5.5}, {13, 6.5}})
    for (; rest % p == 0; rest /= p) weight += w;
  return rest == 1 ? 0.88 * count(n) * weight : 25.0 * count(n) * std::log2(count(n));
}

// A chirp goes forwards and backwards.
double inverse_ns(const AxisTransform& job) {
  return transform_ns(inverse_length(job)) * (job.resampling == Resampling::chirp ? 2.0 : 1.0);
}

double whole_vectors(std::int64_t n) { return 16.0 * std::ceil(static_cast<double>(n) / 16.0); }

// Nanoseconds of one pass over the whole scene (its mean), and of fetching the rows of samples that tiles of
// `tile_rows` output rows need: a call a row, samples beyond the edges one by one, and the others, which ratios other
// than 1, 2 and 4 sort into phases with strides.
double load_ns(const TapAxis& x, const TapAxis& y, double tile_rows, double& rows) {
  const double tiles = std::ceil(count(y.outputs) / tile_rows);
  rows = count(y.outputs * y.ratio) + tiles * count(y.count);
  const double sample = x.ratio == 1 ? 0.22 : x.ratio == 2 || x.ratio == 4 ? 0.36 : 0.6;
  const double row = 35.0 * groups(x.outputs, 256) + 5.5 * count(x.count) + sample * count(x.outputs * x.ratio);
  return count(y.samples) * (20.0 + 0.15 * count(x.samples)) + rows * row;
}

constexpr double kSmallestFloat = 0x1p-150;  // half the step of denormal floats

}  // namespace

Family family(std::string_view method_name) {
  if (method_name.starts_with("fft")) return Family::fft;
  return method_name == "identity" ? Family::identity : Family::taps;
}

std::vector<MethodCandidate> all_candidates(const PlanTask& task, Family wanted) {
  std::vector<MethodCandidate> candidates;
  const auto append = [&candidates](std::vector<MethodCandidate> more) {
    std::move(more.begin(), more.end(), std::back_inserter(candidates));
  };
  if (wanted == Family::all || wanted == Family::identity) append(identity_candidates(task));
  if (wanted == Family::identity) return candidates;
  std::vector<MethodCandidate> fft = fft_candidates(task);
  double fft_ms = std::numeric_limits<double>::infinity();
  for (const MethodCandidate& candidate : fft)
    if (candidate.report.reason.empty() &&
        (candidate.report.method != Method::fft_device || keeps_tolerance(candidate, task.options)))
      fft_ms = std::min(fft_ms, candidate.report.cost_ms);
  if (wanted != Family::fft) append(tap_candidates(task, fft_ms));
  if (wanted != Family::taps) append(std::move(fft));
  return candidates;
}

MethodCandidate* choose(std::vector<MethodCandidate>& candidates, const PlanTask& task, bool measure) {
  const PlanOptions& options = task.options;
  std::vector<MethodCandidate*> possible;
  for (MethodCandidate& candidate : candidates) {
    Candidate& report = candidate.report;
    candidate.predicted_ms = report.cost_ms;
    report.possible = report.reason.empty() && keeps_tolerance(candidate, options);
    if (!report.possible && report.reason.empty()) report.reason = "does not keep the tolerance";
    if (report.possible && (!options.method || *options.method == report.method)) possible.push_back(&candidate);
  }
  // Asked for by name, a method that can be done here and on the device is done there.
  const auto is_there = [](const MethodCandidate* candidate) { return candidate->report.on_device; };
  if (options.method && std::ranges::any_of(possible, is_there)) std::erase_if(possible, std::not_fn(is_there));
  if (possible.empty()) return nullptr;
  if (measure && possible.size() > 1) measure_costs(possible, task);
  MethodCandidate* best = possible.front();
  for (MethodCandidate* candidate : possible)
    if (candidate->report.cost_ms < best->report.cost_ms) best = candidate;
  for (MethodCandidate& candidate : candidates) {
    if (&candidate == best || !candidate.report.possible) continue;
    const double ratio = candidate.report.cost_ms / best->report.cost_ms;
    candidate.report.reason = options.method ? "another was asked for" : times_text(ratio) + " x the cost";
  }
  return best;
}

void refuse(const std::vector<MethodCandidate>& candidates, const PlanOptions& options) {
  double reachable = std::numeric_limits<double>::infinity();
  double in_float = reachable;
  const MethodCandidate* wanted = nullptr;
  for (const MethodCandidate& candidate : candidates) {
    if (options.method && *options.method != candidate.report.method) continue;
    wanted = &candidate;
    reachable = std::min(reachable, candidate.reachable);
    if (candidate.axes && candidate.report.method != Method::fft_double)
      in_float = std::min(in_float, candidate.reachable);
  }
  if (options.method == Method::fft_device && wanted == nullptr)
    throw UsageError("method fft_device takes a device that is open; name one (--device, PlanOptions::device)");
  if (options.method && wanted == nullptr)
    throw UsageError("method " + std::string(name_of(*options.method)) +
                     " cannot do this work; `mtf simulate --explain` lists those that can");
  if (options.method && !(reachable < 1.0))
    throw UsageError("method " + std::string(name_of(*options.method)) + ": " + wanted->report.reason);
  throw unreachable_tolerance(options.tolerance, reachable, options.scene, in_float);
}

void describe(const MethodCandidate& chosen, const std::vector<MethodCandidate>& candidates, const Engine* engine,
              const PlanTask& task, PlanReport& report) {
  report.method = name_of(chosen.report);
  report.on_device = chosen.report.on_device;
  report.predicted = chosen.report.predicted;
  report.size = {report.in.width, report.in.height};
  report.axes = {chosen.report.detail, ""};
  list_omissions(chosen, candidates, task, report);
  if (engine == nullptr) return;
  report.otf_bytes = engine->filter_bytes();
  report.run_bytes = engine->run_bytes(1, 1);
  report.largest_gain = chosen.largest_gain;
  if (!chosen.axes) return;
  const auto& [x, y] = *chosen.axes;
  report.size = {x.frequency.length, y.frequency.length};
  report.axes = {axis_text(x), axis_text(y)};
  report.kept = {x.keep, y.keep};
  report.available = {x.frequency.half_count(), y.frequency.half_count()};
  const auto* filter = dynamic_cast<const SpectralFilter*>(engine);
  if (task.sampler.has_gain() && filter != nullptr) report.largest_gain = filter->largest_gain();
}

// Costs are counted in rows of kRow numbers: 5.7 ns each time an axis rearranges one, and 7.3 ns more for each row by
// which image, buffer and OTF together exceed the second-level cache.
double fft_cost_ms(const AxisTransform& x, const AxisTransform& y, const Parities& parities) {
  const std::vector<OtfPart> list = otf_parts(x, y, parities);
  const double parts = count(static_cast<std::int64_t>(list.size()));
  const double planes = list.front().x == list.back().x ? 1.0 : 2.0;  // those even along x come first
  const bool x_cosine = x.frequency.basis == Basis::cosine, y_cosine = y.frequency.basis == Basis::cosine;
  const double blocks = groups(x.keep, x_cosine ? kRow : kLanes), coefficients = blocks * kRow;
  const double terms = count(y_cosine ? y.keep : 2 * y.keep - 1);
  const double x_terms = count(x_cosine ? x.keep : 2 * x.keep - 1);
  const double forward =
      transform_ns(x.frequency.length) + 5.7 * (count(x.samples) + count(x.frequency.length) + coefficients);
  const double backward = inverse_ns(x) + 5.7 * (coefficients + x_terms + count(inverse_length(x) + x.outputs));
  const double product = 0.77 * terms * (parities.is_real() || x_cosine ? 1.0 : 2.0);
  const double column = transform_ns(y.frequency.length) + parts * (inverse_ns(y) + product) +
                        (parts - planes) * 9.0 * count(y.outputs);  // what is added to another part
  const double images = (count(x.samples) * count(y.samples) + count(x.outputs) * count(y.outputs)) / kRow;
  const double rows = blocks * (planes * count(std::max(y.samples, y.outputs)) + parts * terms) + images;
  const double far = std::max(0.0, rows - 12000.0);
  return 1e-6 * (groups(y.samples, kRow) * forward + planes * groups(y.outputs, kRow) * backward + blocks * column +
                 7.3 * far + 700.0);
}

double separable_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t rank) {
  const double tile_rows = std::clamp((384.0 / count(rank) - count(y.count)) / count(y.ratio),
                                      std::max(16.0, count(y.count) / count(y.ratio)), 256.0);
  const double width = whole_vectors(x.outputs);
  double rows = 0.0;
  const double load = load_ns(x, y, tile_rows, rows);
  const double across = rows * count(rank) * (0.18 + 0.030 * count(x.count));
  const double down = count(y.outputs) * (0.2 + 0.025 * count(rank * y.count));
  return 1e-6 * (load + width * (across + down)) + 1e-3;
}

double direct_cost_ms(const TapAxis& x, const TapAxis& y, std::int64_t used, bool mirrored) {
  const double width = whole_vectors(x.outputs), height = count(y.outputs), taps = count(used);
  double rows = 0.0;
  const double load = load_ns(x, y, 64.0, rows), calls = groups(x.outputs, 256) * taps;
  const double added = count(y.count * x.ratio) * (width + 32.0);
  const double row =
      mirrored ? width * (0.5 + 0.0132 * taps) + 0.0085 * added + 2.1 * calls : width * 0.0286 * taps + 6.3 * calls;
  return 1e-6 * (load + height * row) + 1e-3;
}

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

// Rounding inside the transforms is relative to the rms of the canvas (in units of std), which a constant border far
// from the mean raises; that of the result is relative to the values with their mean.
double arithmetic_error(const AxisTransform& x, const AxisTransform& y, double canvas_rms, double gain,
                        const PlanOptions& options) {
  return gain * (kFloatUnit * rounding_units(x, y) * std::max(canvas_rms, 1.0) + storage_error(options));
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

double spectral_bytes(const AxisTransform& x, const AxisTransform& y, const Parities& parities) {
  const auto count = [](std::int64_t n) { return static_cast<double>(n); };
  const double columns = count(x.keep) * (x.frequency.basis == Basis::cosine ? 1.0 : 2.0);
  const double terms = count(std::min(2 * y.keep, y.frequency.length + 1));
  const double parts = count(static_cast<std::int64_t>(otf_parts(x, y, parities).size()));
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
