// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/tolerance_runs.h"

#include <algorithm>
#include <memory>
#include <set>

#include "apps/bench/bench_rivals.h"
#include "apps/bench/machine.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

class Climber {
 public:
  Climber(const BenchJob& job, mtf::ImageView<float> out, double slowest_ms)
      : job_(job), out_(out), slowest_ms_(slowest_ms), memory_(this_machine().memory_bytes / 4) {}

  void plans(double tolerance) {
    mtf::PlanOptions options = job_.options;
    options.tolerance = tolerance;
    const mtf::Stopwatch watch;
    std::optional<mtf::SensorPlan> chosen;
    try {
      chosen = mtf::compile_sensor(job_.system, job_.in, options);
    } catch (const mtf::UnreachableTolerance& refusal) {
      ToleranceRun run;
      run.tolerance = tolerance;
      run.reachable = refusal.reachable();
      results.runs.push_back(run);
      return;
    }
    add(tolerance, *chosen, watch.ms(), true);
    const mtf::PlanReport& report = chosen->presample.report();
    std::set<mtf::Method> seen;
    for (const mtf::Candidate& candidate : report.candidates) {
      const std::string_view name = mtf::kMethodNames[static_cast<std::size_t>(candidate.method)];
      if (!candidate.possible || name == report.method || !seen.insert(candidate.method).second) continue;
      if (candidate.cost_ms > slowest_ms_) {
        leave_out(std::string(name), "a run takes about " + fixed(1e-3 * candidate.cost_ms, 1) + " s; see --seconds");
        continue;
      }
      if (bytes_ + candidate.bytes > memory_) {
        leave_out(std::string(name), "all filters together would take more than a quarter of the memory");
        continue;
      }
      try {
        another_way(tolerance, *chosen, candidate.method, options);
      } catch (const mtf::UsageError& refusal) {
        leave_out(std::string(name), refusal.what());
      }
    }
  }

  void rivals(double tolerance) {
    if (!rivals_) return;
    for (Contender& rival : rivals_->at(tolerance)) {
      ToleranceRun run;
      run.tolerance = tolerance;
      run.contender = enlist(std::move(rival));
      results.runs.push_back(run);
    }
  }

  void invite_rivals() {
    if (job_.flat) return;
    std::string obstacle = Rivals::obstacle(job_);
    if (obstacle.empty()) try {
        rivals_ = std::make_unique<Rivals>(job_, out_, slowest_ms_);
      } catch (const mtf::RuntimeError& error) {
        obstacle = error.what();
      }
    if (!obstacle.empty()) results.notes.push_back("no rows for OpenCV: " + obstacle);
  }

  /// Which rows are left out, and why.
  void finish() {
    if (rivals_)
      for (const std::string& what : rivals_->too_slow()) leave_out(what, "a run takes too long; see --seconds");
    const auto refused = std::ranges::find_if(results.runs, [](const ToleranceRun& run) { return !run.contender; });
    if (refused == results.runs.end()) return;
    results.notes.push_back("no plan keeps " + significant(refused->tolerance, 2) + " and less; " +
                            (refused->reachable < 1.0 ? significant(refused->reachable, 2) + " can be kept"
                                                      : "no tolerance can be kept for this scene"));
  }

  ToleranceRuns results;

 private:
  // The chosen plan with its presample step done by another method; the tolerance of that step stays.
  void another_way(double tolerance, const mtf::SensorPlan& chosen, mtf::Method method, mtf::PlanOptions options) {
    options.tolerance = chosen.presample.report().tolerance;
    options.method = method;
    const mtf::Stopwatch watch;
    mtf::SensorPlan plan = chosen;
    plan.presample = mtf::compile(job_.system, job_.in, job_.out, options);
    const double ms = watch.ms();
    double predicted = plan.presample.report().predicted.total();
    if (chosen.post) {
      const mtf::PlanReport& post = chosen.post->report();
      predicted = predicted * std::max(1.0, post.largest_gain) + post.predicted.total();
    }
    plan.predicted_error = predicted;
    add(tolerance, plan, ms, false);
  }

  void add(double tolerance, const mtf::SensorPlan& plan, double plan_ms, bool chosen) {
    const mtf::PlanReport& report = plan.presample.report();
    Contender contender;
    contender.method = report.method;
    for (const mtf::Candidate& candidate : report.candidates)
      if (candidate.reason.empty() && mtf::kMethodNames[static_cast<std::size_t>(candidate.method)] == contender.method)
        contender.detail = candidate.detail;
    if (plan.post) contender.detail += "; then " + plan.post->report().method;
    contender.size = report.size;
    contender.bytes = report.otf_bytes + report.run_bytes;
    std::int64_t filters = report.otf_bytes;
    if (plan.post) {
      contender.bytes += plan.post->report().otf_bytes + 4 * job_.out.width * job_.out.height;
      filters += plan.post->report().otf_bytes;
    }
    contender.run = runner(plan);
    contender.run();
    contender.error = realised_error(job_, out_);
    const std::size_t count = results.contenders.size();
    ToleranceRun run;
    run.tolerance = tolerance;
    run.contender = enlist(std::move(contender));
    run.chosen = chosen;
    run.promised = plan.predicted_error;
    run.plan_ms = plan_ms;
    if (results.contenders.size() > count) bytes_ += filters;
    results.runs.push_back(run);
  }

  std::function<void()> runner(const mtf::SensorPlan& plan) const {
    const auto scene = job_.scene.view();
    const double level = job_.border_value;
    const int threads = job_.options.threads;
    const mtf::ImageView<float> out = out_;
    if (!plan.post) return [=] { plan.presample.run(scene, out, level, threads); };
    const auto sampled = std::make_shared<mtf::Image>(out.width, out.height);
    return [=] {
      plan.presample.run(scene, sampled->view(), level, threads);
      plan.post->run(sampled->view(), out, plan.presample.dc() * level, threads);
    };
  }

  // Plans of one shape and one result to the last digit are one plan.
  std::size_t enlist(Contender contender) {
    const auto same = [&](const Contender& other) {
      return other.method == contender.method && other.detail == contender.detail && other.size == contender.size &&
             other.bytes == contender.bytes && other.error.rms == contender.error.rms &&
             other.error.largest == contender.error.largest;
    };
    const auto known = std::find_if(results.contenders.begin(), results.contenders.end(), same);
    if (known != results.contenders.end()) return static_cast<std::size_t>(known - results.contenders.begin());
    results.contenders.push_back(std::move(contender));
    return results.contenders.size() - 1;
  }

  void leave_out(const std::string& method, const std::string& reason) {
    const std::string text = "no rows for " + method + " at some tolerances: " + reason;
    if (std::ranges::find(results.notes, text) == results.notes.end()) results.notes.push_back(text);
  }

  const BenchJob& job_;
  mtf::ImageView<float> out_;
  double slowest_ms_;
  std::int64_t memory_, bytes_ = 0;
  std::unique_ptr<Rivals> rivals_;
};

}  // namespace

ToleranceRuns run_tolerances(const BenchJob& job, mtf::ImageView<float> out, double slowest_ms,
                             ProgressLine& progress) {
  Climber climber(job, out, slowest_ms);
  climber.invite_rivals();
  for (std::size_t i = 0; i < kTolerances.size(); ++i) {
    progress.update("plans", static_cast<double>(i) / static_cast<double>(kTolerances.size()));
    climber.plans(kTolerances[i]);
    climber.rivals(kTolerances[i]);
  }
  climber.finish();
  return std::move(climber.results);
}

}  // namespace apps
