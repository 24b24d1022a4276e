// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far a long run is, on standard error: a bar with the time left on a terminal, or a line an item for those who
// ask.

#include <chrono>
#include <cstdint>
#include <string>

#include "apps/options.h"

namespace apps {

/// Used by one thread at a time.
class ProgressMeter {
 public:
  /// `item` is what is counted: "frame".
  ProgressMeter(const Global& global, std::string item, std::int64_t total);
  ~ProgressMeter();
  ProgressMeter(const ProgressMeter&) = delete;
  ProgressMeter& operator=(const ProgressMeter&) = delete;

  /// One more is done; `name` says which, `ms` how long it took.
  void step(const std::string& name, double ms);
  /// A line on standard error that does not mix with the bar, unless --quiet.
  void note(const std::string& text);
  double seconds() const;

 private:
  using Clock = std::chrono::steady_clock;
  void draw();
  void clear();

  const Global& global_;
  std::string item_;
  std::int64_t total_ = 0, done_ = 0;
  bool bar_ = false, drawn_ = false;
  Clock::time_point start_ = Clock::now(), last_draw_;
};

}  // namespace apps
