// SPDX-License-Identifier: Apache-2.0
// Which of the drafted ways a plan takes: the cheapest that keeps the tolerance.

#include <algorithm>
#include <cmath>

#include "mtf/plan_parts.h"
#include "mtf/plan_spectral.h"

namespace mtf {
namespace {

std::string_view name_of(Method method) { return kMethodNames[static_cast<std::size_t>(method)]; }

std::string times_text(double ratio) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), ratio < 10.0 ? "%.1f" : "%.0f", ratio);
  return text.data();
}

}  // namespace

std::vector<Draft> identity_drafts(const PlanTask& task) {
  const SampleGrid &in = task.in, &out = task.out;
  const bool same_grid = in.step_x_um == out.step_x_um && in.step_y_um == out.step_y_um;
  // A gain may be dropped for the contrast, not for the mean.
  const bool unit_mean = std::abs(task.sampler.dc() - 1.0) < 1e-12;
  if (!task.sampler.is_identity() || !same_grid || !unit_mean) return {};
  Draft draft;
  draft.candidate.method = Method::identity;
  draft.candidate.detail = "samples as they are";
  draft.candidate.predicted.dropped = task.sampler.error() * task.norm;
  draft.candidate.cost_ms = 1e-6 * 0.1 * static_cast<double>(in.width) * static_cast<double>(in.height);
  draft.reachable = 0.0;
  std::vector<Draft> drafts;
  drafts.push_back(std::move(draft));
  return drafts;
}

std::vector<Draft> draft_all(const PlanTask& task) {
  std::vector<Draft> drafts = identity_drafts(task);
  const auto append = [&drafts](std::vector<Draft> more) {
    std::move(more.begin(), more.end(), std::back_inserter(drafts));
  };
  std::vector<Draft> fft = fft_drafts(task);
  double fft_ms = std::numeric_limits<double>::infinity();
  for (const Draft& draft : fft) fft_ms = std::min(fft_ms, draft.candidate.cost_ms);
  append(tap_drafts(task, fft_ms));
  append(std::move(fft));
  return drafts;
}

Draft* choose(std::vector<Draft>& drafts, const PlanOptions& options) {
  Draft* best = nullptr;
  for (Draft& draft : drafts) {
    Candidate& candidate = draft.candidate;
    candidate.possible = candidate.reason.empty() && keeps_tolerance(candidate.predicted, options);
    if (!candidate.possible) {
      if (candidate.reason.empty()) candidate.reason = "does not keep the tolerance";
      continue;
    }
    if (options.method && *options.method != candidate.method) continue;
    if (best == nullptr || candidate.cost_ms < best->candidate.cost_ms) best = &draft;
  }
  if (best == nullptr) return nullptr;
  for (Draft& draft : drafts) {
    if (&draft == best || !draft.candidate.possible) continue;
    const double ratio = draft.candidate.cost_ms / best->candidate.cost_ms;
    draft.candidate.reason = options.method ? "another was asked for" : times_text(ratio) + " x the cost";
  }
  return best;
}

void refuse(const std::vector<Draft>& drafts, const PlanOptions& options) {
  double reachable = std::numeric_limits<double>::infinity();
  const Draft* wanted = nullptr;
  for (const Draft& draft : drafts) {
    if (options.method && *options.method != draft.candidate.method) continue;
    wanted = &draft;
    reachable = std::min(reachable, draft.reachable);
  }
  if (options.method && wanted == nullptr)
    throw UsageError("method " + std::string(name_of(*options.method)) +
                     " cannot do this work; `mtf simulate --explain` lists those that can");
  if (options.method && !wanted->candidate.reason.empty() && !std::isfinite(reachable))
    throw UsageError("method " + std::string(name_of(*options.method)) + ": " + wanted->candidate.reason);
  throw unreachable_tolerance(options.tolerance, reachable, options.scene);
}

void describe(const Draft& chosen, const Engine* engine, const OtfSampler& sampler, int threads, PlanReport& report) {
  report.method = name_of(chosen.candidate.method);
  report.predicted = chosen.candidate.predicted;
  report.size = {report.in.width, report.in.height};
  report.axes = {"as it is", "as it is"};
  if (engine == nullptr) return;
  report.otf_bytes = engine->filter_bytes();
  report.run_bytes = engine->run_bytes(1, threads);
  report.largest_gain = chosen.largest_gain;
  if (!chosen.axes) {
    report.axes = {chosen.candidate.detail, ""};
    return;
  }
  const auto& [x, y] = *chosen.axes;
  report.size = {x.frequency.length, y.frequency.length};
  report.axes = {axis_text(x), axis_text(y)};
  report.kept = {x.keep, y.keep};
  report.available = {x.frequency.half_count(), y.frequency.half_count()};
  const auto* filter = dynamic_cast<const SpectralFilter*>(engine);
  if (sampler.has_gain() && filter != nullptr) report.largest_gain = filter->largest_gain();
}

}  // namespace mtf
