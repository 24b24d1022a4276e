// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/measured.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <mutex>
#include <string_view>

#include "mtf/engines/fft/fftw.h"
#include "mtf/math/word_hash.h"
#include "mtf/work/stopwatch.h"

namespace mtf {
namespace {

constexpr std::string_view kHeader = "mtfkit measured 2 ", kWisdom = "wisdom\n";

struct Book {
  std::mutex lock;
  std::map<std::string, double> ms;
};

Book& book() {
  static Book all;
  return all;
}

/// The first line: what it is, and a checksum of all that follows.
std::string header_of(std::string_view text) {
  std::uint64_t hash = kWordHashStart;
  for (const char c : text) hash = mixed(hash, static_cast<unsigned char>(c));
  return std::string(kHeader) + std::to_string(hash) + "\n";
}

}  // namespace

std::optional<double> measured_ms(const std::string& work) {
  const std::scoped_lock lock(book().lock);
  const auto found = book().ms.find(work);
  return found == book().ms.end() ? std::nullopt : std::optional(found->second);
}

void remember_ms(const std::string& work, double ms) {
  const std::scoped_lock lock(book().lock);
  book().ms[work] = ms;
}

double time_ms(const std::function<void()>& run) {
  constexpr double kEnough = 30.0;
  constexpr int kMostRuns = 7;
  double best = 0.0, spent = 0.0;
  run();
  for (int i = 0; i < kMostRuns && (i == 0 || spent < kEnough); ++i) {
    const Stopwatch watch;
    run();
    const double ms = watch.ms();
    best = i == 0 ? ms : std::min(best, ms);
    spent += ms;
  }
  return best;
}

std::string export_measured() {
  std::string text;
  {
    const std::scoped_lock lock(book().lock);
    for (const auto& [work, ms] : book().ms) text += format_double(ms) + " " + work + "\n";
  }
  text += std::string(kWisdom) + fft::export_wisdom();
  return header_of(text) + text;
}

bool import_measured(const std::string& text) {
  std::string_view rest = text;
  const std::size_t line = rest.find('\n');
  if (line == std::string_view::npos || header_of(rest.substr(line + 1)) != rest.substr(0, line + 1)) return false;
  rest.remove_prefix(line + 1);
  std::map<std::string, double> learnt;
  while (!rest.starts_with(kWisdom)) {
    const auto end = rest.find('\n'), gap = rest.find(' ');
    double ms = 0.0;
    if (end == std::string_view::npos || gap >= end) return false;
    const auto [stop, error] = std::from_chars(rest.data(), rest.data() + gap, ms);
    if (error != std::errc{} || stop != rest.data() + gap || !(ms > 0.0)) return false;
    learnt[std::string(rest.substr(gap + 1, end - gap - 1))] = ms;
    rest.remove_prefix(end + 1);
  }
  rest.remove_prefix(kWisdom.size());
  if (!fft::import_wisdom(std::string(rest))) return false;
  const std::scoped_lock lock(book().lock);
  book().ms.merge(learnt);
  return true;
}

}  // namespace mtf
