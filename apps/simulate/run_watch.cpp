// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/run_watch.h"

#include "apps/simulate/simulate.h"

namespace apps {

void RunWatch::Caller::tell(const SimulateEvent& event) {
  const std::scoped_lock guard(lock_);
  if (watch_ && !watch_(event)) throw Cancelled("the run was cancelled by its caller");
}

void RunWatch::Caller::leave() {
  const std::scoped_lock guard(lock_);
  watch_ = nullptr;
}

void RunWatch::note(const std::string& text) {
  report_.notes.push_back(text);
  tell({SimulateEvent::Kind::note, text, 0.0});
}

void RunWatch::warn(const std::string& text) {
  report_.warnings.push_back(text);
  tell_warning(text);
}

void RunWatch::lap(const char* stage) {
  const Clock::time_point now = Clock::now();
  report_.timing_ms.emplace_back(stage, std::chrono::duration<double, std::milli>(now - last_).count());
  last_ = now;
}

void RunWatch::tell_stage(const char* stage) {
  lap(stage);
  tell({SimulateEvent::Kind::stage, stage, report_.timing_ms.back().second});
}

mtf::OtfProgress RunWatch::planning() {
  if (!caller_->watches()) return {};
  return [caller = caller_](std::int64_t values) {
    caller->tell({SimulateEvent::Kind::planning, "planning", static_cast<double>(values)});
  };
}

}  // namespace apps
