// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <mutex>

#include "apps/terminal/output.h"

namespace apps {
namespace {

constexpr int kBarWidth = 30;

std::string eta(double elapsed_s, double share) {
  return share > 0.02 ? fixed(elapsed_s * (1.0 - share) / share, 0) + " s left" : "";
}

void show(const std::string& text) { static_cast<void>(std::fwrite(text.data(), 1, text.size(), stderr)); }

}  // namespace

ProgressLine::ProgressLine(const Global& global)
    : way_(global.progress == Progress::plain                                            ? Way::plain
           : global.progress == Progress::json                                           ? Way::json
           : global.progress == Progress::automatic && !global.quiet && ::isatty(2) != 0 ? Way::bar
                                                                                         : Way::none) {}

ProgressLine::~ProgressLine() {
  if (way_ == Way::bar && !step_.empty()) show("\r\033[K");
}

void ProgressLine::update(const std::string& step, double share, const std::string& rate) {
  if (way_ == Way::none) return;
  share = std::clamp(share, 0.0, 1.0);
  const Clock::time_point now = Clock::now();
  const bool fresh = step != step_;
  if (fresh) {
    step_ = step;
    start_ = now;
    tenths_ = -1;
  }
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  if (way_ == Way::bar) {
    if (!fresh && now - shown_ < std::chrono::milliseconds(100)) return;
    shown_ = now;
    const int full = static_cast<int>(share * kBarWidth);
    show("\r" + step + " [" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kBarWidth - full), '.') + "] " + fixed(100.0 * share, 0) + " % " +
         (rate.empty() ? "" : rate + " ") + eta(elapsed_s, share) + "\033[K");
    return;
  }
  const int tenths = static_cast<int>(10.0 * share);
  if (tenths == tenths_) return;
  tenths_ = tenths;
  if (way_ == Way::plain)
    complain(step + " " + fixed(100.0 * share, 0) + " % " + (rate.empty() ? "" : rate + " ") + eta(elapsed_s, share));
  else
    complain("{\"step\":\"" + step + "\",\"share\":" + fixed(share, 3) + ",\"elapsed_s\":" + fixed(elapsed_s, 1) +
             (rate.empty() ? "" : ",\"rate\":\"" + rate + "\"") + "}");
}

void ProgressLine::update_open(const std::string& step, const std::string& done) {
  if (way_ == Way::none) return;
  const Clock::time_point now = Clock::now();
  const bool fresh = step != step_;
  if (fresh) step_ = step, start_ = now;
  if (!fresh && now - shown_ < (way_ == Way::bar ? std::chrono::milliseconds(100) : std::chrono::seconds(10))) return;
  shown_ = now;
  if (way_ == Way::bar)
    show("\r" + step + ": " + done + "\033[K");
  else if (way_ == Way::plain)
    complain(step + ": " + done);
  else
    complain("{\"step\":\"" + step + "\",\"done\":\"" + done +
             "\",\"elapsed_s\":" + fixed(std::chrono::duration<double>(now - start_).count(), 1) + "}");
}

mtf::OtfProgress planning_progress(const Global& global) {
  struct State {
    explicit State(const Global& options) : line(options) {}
    std::mutex lock;
    ProgressLine line;
    std::int64_t values = 0;
    std::chrono::steady_clock::time_point begun = std::chrono::steady_clock::now();
  };
  return [state = std::make_shared<State>(global)](std::int64_t values) {
    const std::lock_guard guard(state->lock);
    state->values += values;
    if (std::chrono::steady_clock::now() - state->begun > std::chrono::milliseconds(500))
      state->line.update_open("planning", std::to_string(state->values) + " values of the OTF");
  };
}

}  // namespace apps
