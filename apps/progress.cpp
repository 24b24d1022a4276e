// SPDX-License-Identifier: Apache-2.0
#include "apps/progress.h"

#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/output.h"
#include "apps/text_table.h"

namespace apps {
namespace {

constexpr double kSecondsBetweenDraws = 0.1;
constexpr int kBarWidth = 30;

std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  std::array<char, 32> text{};
  if (whole >= 3600)
    std::snprintf(text.data(), text.size(), "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  else
    std::snprintf(text.data(), text.size(), "%lld:%02lld", whole / 60, whole % 60);
  return text.data();
}

void write_error(const std::string& text) { static_cast<void>(std::fwrite(text.data(), 1, text.size(), stderr)); }

}  // namespace

ProgressMeter::ProgressMeter(const Global& global, std::string item, std::int64_t total)
    : global_(global),
      item_(std::move(item)),
      total_(total),
      bar_(global.progress == Progress::automatic && !global.quiet && ::isatty(STDERR_FILENO) == 1) {}

ProgressMeter::~ProgressMeter() { clear(); }

double ProgressMeter::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void ProgressMeter::step(const std::string& name, double ms) {
  ++done_;
  if (global_.progress == Progress::plain)
    complain(std::to_string(done_) + "/" + std::to_string(total_) + " " + one_line(name) + " " + fixed(ms, 1) + " ms");
  if (global_.progress == Progress::json)
    complain(nlohmann::ordered_json{{item_, name}, {"ms", ms}, {"done", done_}, {"total", total_}}.dump(
        -1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  const bool due = std::chrono::duration<double>(Clock::now() - last_draw_).count() >= kSecondsBetweenDraws;
  if (bar_ && (due || done_ == total_)) draw();
}

void ProgressMeter::note(const std::string& text) {
  clear();
  apps::note(global_, text);
}

void ProgressMeter::draw() {
  const double elapsed = seconds(), done = static_cast<double>(done_), total = static_cast<double>(total_);
  const auto filled = static_cast<std::size_t>(kBarWidth * done / total);
  write_error("\r[" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] " + std::to_string(done_) +
              "/" + std::to_string(total_) + " " + item_ + "s  " + fixed(done / elapsed, 1) + "/s  ETA " +
              clock_text(elapsed * (total - done) / done) + "\033[K");
  drawn_ = true;
  last_draw_ = Clock::now();
}

void ProgressMeter::clear() {
  if (drawn_) write_error("\r\033[K");
  drawn_ = false;
}

}  // namespace apps
