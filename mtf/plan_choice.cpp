// SPDX-License-Identifier: Apache-2.0
// Which of the drafted ways a plan takes: the cheapest that keeps the tolerance.

#include <algorithm>
#include <cmath>

#include "mtf/measured.h"
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

namespace {

// Leaving out everything may cost the whole tolerance, where other ways spend a small share on it.
std::vector<Draft> identity_drafts(const PlanTask& task) {
  const SampleGrid &in = task.in, &out = task.out;
  const bool same_grid = in.step_x_um == out.step_x_um && in.step_y_um == out.step_y_um;
  // A gain may be dropped for the contrast, not for the mean.
  const bool unit_mean = std::abs(task.sampler.dc() - 1.0) < 1e-12;
  const bool alone = task.options.split.is_whole() && task.options.aperture.kind == SceneAperture::Kind::point;
  Draft draft;
  draft.candidate.method = Method::identity;
  if (!same_grid) draft.candidate.reason = "samples and pixels differ";
  if (!unit_mean) draft.candidate.reason = "the mean does not pass as it is";
  if (!alone) draft.candidate.reason = "the samples' own blur is corrected, or this is a part of a split OTF";
  draft.candidate.detail = "samples as they are";
  draft.candidate.predicted.dropped = task.sampler.identity_error() * task.norm;
  draft.candidate.cost_ms = 1e-6 * 0.5 * static_cast<double>(in.width) * static_cast<double>(in.height);
  if (draft.candidate.reason.empty()) draft.reachable = 1.0001 * draft.candidate.predicted.total();
  std::vector<Draft> drafts;
  drafts.push_back(std::move(draft));
  return drafts;
}

}  // namespace

Family family(std::string_view method_name) {
  if (method_name.starts_with("fft")) return Family::fft;
  return method_name == "identity" ? Family::identity : Family::taps;
}

std::vector<Draft> draft_all(const PlanTask& task, Family wanted) {
  std::vector<Draft> drafts;
  const auto append = [&drafts](std::vector<Draft> more) {
    std::move(more.begin(), more.end(), std::back_inserter(drafts));
  };
  if (wanted == Family::all || wanted == Family::identity) append(identity_drafts(task));
  if (wanted == Family::identity) return drafts;
  std::vector<Draft> fft = fft_drafts(task);
  double fft_ms = std::numeric_limits<double>::infinity();
  for (const Draft& draft : fft) fft_ms = std::min(fft_ms, draft.candidate.cost_ms);
  if (wanted != Family::fft) append(tap_drafts(task, fft_ms));
  if (wanted != Family::taps) append(std::move(fft));
  return drafts;
}

namespace {

// The same work on this machine takes the same time again: the way, both grids, and for the FFT methods whether the OTF
// is complex.
std::string work_of(const Draft& draft, const PlanTask& task) {
  const auto size = [](const SampleGrid& grid) {
    return std::to_string(grid.width) + "x" + std::to_string(grid.height);
  };
  return std::string(name_of(draft.candidate.method)) + " " + size(task.in) + " to " + size(task.out) + ", " +
         draft.candidate.detail + (task.sampler.is_real() ? "" : ", complex") +
         (task.sampler.is_even_x() && task.sampler.is_even_y() ? "" : ", not mirrored");
}

// Times the ways that might be the cheapest. Their predictions are worth a factor of two or so.
void measure_costs(const std::vector<Draft*>& possible, const PlanTask& task) {
  constexpr double kMaybe = 3.0;
  double least = std::numeric_limits<double>::infinity();
  for (const Draft* draft : possible) least = std::min(least, draft->candidate.cost_ms);
  const SampleGrid &in = task.in, &out = task.out;
  Image scene, image;
  for (Draft* draft : possible) {
    if (draft->candidate.cost_ms > kMaybe * least || !draft->make) continue;
    const std::string work = work_of(*draft, task);
    std::optional<double> ms = measured_ms(work);
    if (!ms) {
      if (scene.size() == 0) {
        scene = Image(in.width, in.height);
        image = Image(out.width, out.height);
        // Any samples that are not all alike: times do not depend on them.
        for (std::int64_t i = 0; i < scene.size(); ++i) scene.data()[i] = static_cast<float>(i * 7919 % 1013) - 506.0F;
      }
      const auto engine = draft->make(nullptr);
      const std::vector<Channel> channel{{.in = scene.view(), .out = image.view()}};
      ms = time_ms([&] { engine->run(channel, 1); });
      remember_ms(work, *ms);
    }
    draft->candidate.cost_ms = *ms;
    draft->candidate.measured = true;
  }
}

}  // namespace

Draft* choose(std::vector<Draft>& drafts, const PlanTask& task, bool measure) {
  const PlanOptions& options = task.options;
  std::vector<Draft*> possible;
  for (Draft& draft : drafts) {
    Candidate& candidate = draft.candidate;
    draft.predicted_ms = candidate.cost_ms;
    candidate.possible = candidate.reason.empty() && keeps_tolerance(draft, options);
    if (!candidate.possible && candidate.reason.empty()) candidate.reason = "does not keep the tolerance";
    if (candidate.possible && (!options.method || *options.method == candidate.method)) possible.push_back(&draft);
  }
  if (possible.empty()) return nullptr;
  if (measure && possible.size() > 1) measure_costs(possible, task);
  Draft* best = possible.front();
  for (Draft* draft : possible)
    if (draft->candidate.cost_ms < best->candidate.cost_ms) best = draft;
  for (Draft& draft : drafts) {
    if (&draft == best || !draft.candidate.possible) continue;
    const double ratio = draft.candidate.cost_ms / best->candidate.cost_ms;
    draft.candidate.reason = options.method ? "another was asked for" : times_text(ratio) + " x the cost";
  }
  return best;
}

void refuse(const std::vector<Draft>& drafts, const PlanOptions& options) {
  double reachable = std::numeric_limits<double>::infinity();
  double in_float = reachable;
  const Draft* wanted = nullptr;
  for (const Draft& draft : drafts) {
    if (options.method && *options.method != draft.candidate.method) continue;
    wanted = &draft;
    reachable = std::min(reachable, draft.reachable);
    if (draft.axes && draft.candidate.method != Method::fft_double) in_float = std::min(in_float, draft.reachable);
  }
  if (options.method && wanted == nullptr)
    throw UsageError("method " + std::string(name_of(*options.method)) +
                     " cannot do this work; `mtf simulate --explain` lists those that can");
  if (options.method && !(reachable < 1.0))
    throw UsageError("method " + std::string(name_of(*options.method)) + ": " + wanted->candidate.reason);
  throw unreachable_tolerance(options.tolerance, reachable, options.scene, in_float);
}

namespace {

// What was left out, what it costs at most, and the time it saves.
void list_omissions(const Draft& chosen, const std::vector<Draft>& drafts, const PlanTask& task, PlanReport& report) {
  if (chosen.candidate.method == Method::identity) {
    double other = std::numeric_limits<double>::infinity();
    for (const Draft& draft : drafts)
      if (draft.candidate.possible && &draft != &chosen) other = std::min(other, draft.candidate.cost_ms);
    const double saved = std::isfinite(other) ? other - chosen.candidate.cost_ms : 0.0;
    report.omitted.push_back(
        {"all components: the samples pass as they are", chosen.candidate.predicted.dropped, saved});
    return;
  }
  for (const Dropped& d : task.sampler.dropped())
    report.omitted.push_back({d.label, d.bound * task.sampler.gain() * chosen.error_per_otf, d.saved_ms});
  if (const double flat = chosen.candidate.predicted.flat; flat > 0.0)
    report.omitted.push_back({"transforms of " + std::string(chosen.lines == Lines::rows ? "rows" : "columns") +
                                  " that are of one level, or nearly so when filtered",
                              flat, chosen.lines_saved_ms});
  if (chosen.candidate.method != Method::fft_cut) return;
  const auto& [x, y] = *chosen.axes;
  for (const Draft& draft : drafts)
    if (draft.candidate.method == Method::fft_float)
      report.omitted.push_back({"frequencies beyond " + std::to_string(x.keep) + "x" + std::to_string(y.keep) + " of " +
                                    std::to_string(x.frequency.half_count()) + "x" +
                                    std::to_string(y.frequency.half_count()),
                                chosen.candidate.predicted.cut, draft.candidate.cost_ms - chosen.candidate.cost_ms});
}

}  // namespace

void describe(const Draft& chosen, const std::vector<Draft>& drafts, const Engine* engine, const PlanTask& task,
              PlanReport& report) {
  report.method = name_of(chosen.candidate.method);
  report.predicted = chosen.candidate.predicted;
  report.size = {report.in.width, report.in.height};
  report.axes = {chosen.candidate.detail, ""};
  list_omissions(chosen, drafts, task, report);
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
