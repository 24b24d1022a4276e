// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far a long command is, on standard error: a bar with the time left on a terminal, lines for --progress plain and
// json, nothing otherwise.

#include <chrono>
#include <string>

#include "apps/options.h"
#include "mtf/otf/factored_otf.h"

namespace apps {

class ProgressLine {
 public:
  explicit ProgressLine(const Global& global);
  ~ProgressLine();  ///< clears the bar
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// `step` is what is being done, `share` of it in [0, 1] is finished; `rate` is shown next to it ("21000 designs/s").
  /// Cheap to call often: the bar moves at most ten times a second, lines come with a new step or another tenth.
  void update(const std::string& step, double share, const std::string& rate = "");
  /// The same where nobody knows how much is left: `done` says what was finished ("12000 values"). A line every 10 s.
  void update_open(const std::string& step, const std::string& done);

 private:
  using Clock = std::chrono::steady_clock;
  enum class Way { none, bar, plain, json } way_;
  std::string step_;
  Clock::time_point start_{}, shown_{};
  int tenths_ = -1;
};

/// Shows how many values of slow components a plan has made, from half a second on. Safe to call from many threads.
mtf::OtfProgress planning_progress(const Global& global);

}  // namespace apps
