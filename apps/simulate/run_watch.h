// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a run tells its caller, from whatever thread: one event at a time, and the run ends where the caller says so.

#include <chrono>
#include <functional>
#include <mutex>
#include <string>

#include "apps/simulate/run_report.h"
#include "apps/simulate/simulate_options.h"
#include "mtf/otf/factored_otf.h"

namespace apps {

class RunWatch {
 public:
  /// Both live longer than the watch. Warnings and notes go to the report too.
  RunWatch(const SimulateOptions& options, RunReport& report) : options_(options), report_(report) {}

  /// So much of a step is done. All of these throw Cancelled where the caller ends the run.
  void share(std::string_view step, double share) { tell({SimulateEvent::Kind::share, step, share}); }
  void note(const std::string& text);
  void warn(const std::string& text);
  /// A warning that is in the report already.
  void tell_warning(const std::string& text) { tell({SimulateEvent::Kind::warning, text, 0.0}); }
  /// Time since the last lap goes to the report; `tell_stage` does that and tells it.
  void lap(const char* stage);
  void tell_stage(const char* stage);
  /// For PlanOptions::progress; nothing where nobody watches.
  mtf::OtfProgress planning();

 private:
  using Clock = std::chrono::steady_clock;
  void tell(const SimulateEvent& event);

  const SimulateOptions& options_;
  RunReport& report_;
  std::mutex lock_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace apps
