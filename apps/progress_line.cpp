// SPDX-License-Identifier: Apache-2.0
#include "apps/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "apps/output.h"
#include "apps/text_table.h"

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

}  // namespace apps
