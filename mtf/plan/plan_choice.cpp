// SPDX-License-Identifier: Apache-2.0
// Which of the proposed methods a plan takes: the cheapest that keeps the tolerance.

#include <algorithm>
#include <cmath>

#include "mtf/plan/measured.h"
#include "mtf/plan/plan_parts.h"
#include "mtf/plan/plan_spectral.h"
#include "mtf/words.h"

namespace mtf {
namespace {

std::string_view name_of(Method method) { return kMethodNames[static_cast<std::size_t>(method)]; }

std::string times_text(double ratio) { return fixed(ratio, ratio < 10.0 ? 1 : 0); }

}  // namespace

namespace {

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
  for (const MethodCandidate& candidate : fft) fft_ms = std::min(fft_ms, candidate.report.cost_ms);
  if (wanted != Family::fft) append(tap_candidates(task, fft_ms));
  if (wanted != Family::taps) append(std::move(fft));
  return candidates;
}

namespace {

// The same work on this machine takes the same time again: the method, both grids, and for the FFT methods whether the
// OTF is complex.
std::string work_of(const MethodCandidate& candidate, const PlanTask& task) {
  const auto size = [](const SampleGrid& grid) {
    return std::to_string(grid.width) + "x" + std::to_string(grid.height);
  };
  return std::string(name_of(candidate.report.method)) + " " + size(task.in) + " to " + size(task.out) + ", " +
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
      const auto engine = candidate->make(nullptr);
      const std::vector<Channel> channel{{.in = scene.view(), .out = image.view()}};
      ms = time_ms([&] { engine->run(channel, 1); });
      remember_ms(work, *ms);
    }
    candidate->report.cost_ms = *ms;
    candidate->report.measured = true;
  }
}

}  // namespace

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
  if (options.method && wanted == nullptr)
    throw UsageError("method " + std::string(name_of(*options.method)) +
                     " cannot do this work; `mtf simulate --explain` lists those that can");
  if (options.method && !(reachable < 1.0))
    throw UsageError("method " + std::string(name_of(*options.method)) + ": " + wanted->report.reason);
  throw unreachable_tolerance(options.tolerance, reachable, options.scene, in_float);
}

namespace {

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
      report.omitted.push_back({"frequencies beyond " + std::to_string(x.keep) + "x" + std::to_string(y.keep) + " of " +
                                    std::to_string(x.frequency.half_count()) + "x" +
                                    std::to_string(y.frequency.half_count()),
                                chosen.report.predicted.cut, candidate.report.cost_ms - chosen.report.cost_ms});
}

}  // namespace

void describe(const MethodCandidate& chosen, const std::vector<MethodCandidate>& candidates, const Engine* engine,
              const PlanTask& task, PlanReport& report) {
  report.method = name_of(chosen.report.method);
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

}  // namespace mtf
