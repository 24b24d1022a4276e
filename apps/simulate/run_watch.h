// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a run tells its caller, from whatever thread: one event at a time, and the run ends where the caller says so.

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "apps/simulate/run_report.h"
#include "apps/simulate/simulate_options.h"
#include "mtf/otf/factored_otf.h"

namespace apps {

class RunWatch {
 public:
  /// The report lives longer than the watch. Warnings and notes go to it too.
  RunWatch(const SimulateOptions& options, RunReport& report)
      : report_(report), caller_(std::make_shared<Caller>(options.watch)) {}
  ~RunWatch() { caller_->leave(); }
  RunWatch(const RunWatch&) = delete;
  RunWatch& operator=(const RunWatch&) = delete;

  /// So much of a step is done. All of these throw Cancelled where the caller ends the run.
  void share(std::string_view step, double share) { tell({SimulateEvent::Kind::share, step, share}); }
  void note(const std::string& text);
  void warn(const std::string& text);
  /// A warning that is in the report already.
  void tell_warning(const std::string& text) { tell({SimulateEvent::Kind::warning, text, 0.0}); }
  /// Time since the last lap goes to the report; `tell_stage` does that and tells it.
  void lap(const char* stage);
  void tell_stage(const char* stage);
  /// For PlanOptions::progress; nothing where nobody watches. Plans keep it: it is silent once the run is over.
  mtf::OtfProgress planning();

 private:
  using Clock = std::chrono::steady_clock;

  class Caller {
   public:
    explicit Caller(std::function<bool(const SimulateEvent&)> watch) : watch_(std::move(watch)) {}
    bool watches() const { return watch_ != nullptr; }
    void tell(const SimulateEvent& event);
    void leave();

   private:
    std::mutex lock_;
    std::function<bool(const SimulateEvent&)> watch_;
  };

  void tell(const SimulateEvent& event) { caller_->tell(event); }

  RunReport& report_;
  std::shared_ptr<Caller> caller_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace apps
