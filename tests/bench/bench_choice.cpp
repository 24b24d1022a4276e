// SPDX-License-Identifier: Apache-2.0

// Is the method that a plan takes the fastest of those that keep the tolerance? Over the random work of
// tests/mtf/sweep_cases.h every possible candidate is insisted on and timed, all interleaved, on one thread; what
// counts is the time of the chosen one over that of the fastest. Also the measured time over the predicted cost of
// every candidate, by method and by what the cost model may have got wrong: the numbers that mtf/plan/plan_choice.cpp
// is fitted to.
//
//   bench_choice [--cases N] [--seed S] [--largest SIDE] [--csv FILE]

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/engines/fft/fftw.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/version.h"
#include "tests/mtf/sweep_cases.h"

namespace {

using namespace mtf;        // NOLINT: a benchmark program
using namespace mtf::test;  // NOLINT

constexpr double kCountsFromMs = 0.1;  // cases whose fastest candidate takes less are not judged
constexpr double kSuspicious = 1.3;    // timed again before it is believed
constexpr int kRounds = 7, kPatientRounds = 25;
constexpr double kShortMs = 1.0;  // runs of this length and below get more rounds: one of them is soon disturbed

struct Options {
  int cases = 200;
  std::uint64_t seed = 1;
  std::int64_t largest = 1400;
  std::string csv;
};

struct Timed {
  Candidate candidate;
  Plan plan;
  double ms = 0.0;
  bool chosen = false;
};

struct Judged {
  std::string what, chosen, fastest;
  double chosen_ms = 0.0, fastest_ms = 0.0;
  double ratio() const { return chosen_ms / fastest_ms; }
};

std::string_view name_of(Method method) { return kMethodNames[static_cast<std::size_t>(method)]; }

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

// The default plan first, then each other candidate that keeps the tolerance.
std::vector<Timed> compiled(const SweepCase& c) {
  PlanOptions options = c.options();
  if (!options.scene) return {};
  options.spectrum = scene_spectrum(c.scene.view(), c.border, 1);
  const auto once = [&] { return c.compile_with(options); };
  const Plan plan = [&] {
    try {
      return once();
    } catch (const UnreachableTolerance& refusal) {
      if (!(refusal.reachable() < 1.0)) throw;
      options.tolerance = refusal.reachable();
      return once();
    }
  }();
  std::vector<Timed> ways;
  for (const Candidate& candidate : plan.report().candidates) {
    if (!candidate.possible) continue;
    options.method = candidate.method;
    const bool chosen = name_of(candidate.method) == plan.report().method;
    ways.push_back({candidate, chosen ? plan : once(), 0.0, chosen});
  }
  return ways;
}

// Of this thread: on a shared machine the clock on the wall also counts what others do.
double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void time_all(const SweepCase& c, std::vector<Timed>& ways, int rounds) {
  Image out(c.out.width, c.out.height);
  for (int round = 0; round < rounds; ++round)
    for (Timed& way : ways) {
      const double start = processor_ms();
      way.plan.run(c.scene.view(), out.view(), c.border_value, 1);
      const double elapsed = processor_ms() - start;
      way.ms = way.ms == 0.0 ? elapsed : std::min(way.ms, elapsed);
    }
}

Judged judge(const SweepCase& c, const std::vector<Timed>& ways) {
  Judged judged;
  judged.what = c.describe();
  for (const Timed& way : ways) {
    const std::string text = std::string(name_of(way.candidate.method)) + " (" + way.candidate.detail + ")";
    if (way.chosen) judged.chosen_ms = way.ms, judged.chosen = text;
    if (judged.fastest_ms == 0.0 || way.ms < judged.fastest_ms) judged.fastest_ms = way.ms, judged.fastest = text;
  }
  return judged;
}

/// measured / predicted of every candidate, by method and kind of work.
class CostFit {
 public:
  void add(const SweepCase& c, const Timed& way) {
    const double ratio = way.ms / way.candidate.cost_ms;
    const std::string method(name_of(way.candidate.method));
    ratios_[method].push_back(ratio);
    ratios_[method + ", " + size_class(c)].push_back(ratio);
    const std::string& detail = way.candidate.detail;
    if (way.plan.report().kept[0] == 0) return;
    const auto has = [&](const char* word) { return detail.find(word) != std::string::npos; };
    ratios_[method + (has("chirp") ? ", chirp" : has("fold") ? ", fold" : ", as fine")].push_back(ratio);
    ratios_[method + (has("fourier") ? has("cosine") ? ", mixed" : ", fourier" : ", cosine")].push_back(ratio);
    const auto [x, y] = way.plan.report().size;
    ratios_[method + (is_smooth(x) && is_smooth(y) ? ", smooth" : ", rough")].push_back(ratio);
  }
  void print() const {
    std::printf("\n%-36s %6s %8s %8s %8s   measured / predicted\n", "candidates", "plans", "5 %", "median", "95 %");
    for (const auto& [group, ratios] : ratios_)
      std::printf("%-36s %6zu %8.2f %8.2f %8.2f\n", group.c_str(), ratios.size(), quantile(ratios, 0.05),
                  quantile(ratios, 0.5), quantile(ratios, 0.95));
  }

 private:
  static std::string size_class(const SweepCase& c) {
    const double side = std::sqrt(static_cast<double>(c.scene.size()));
    return side < 128.0 ? "to 128" : side < 400.0 ? "to 400" : "larger";
  }
  std::map<std::string, std::vector<double>> ratios_;
};

class Csv {
 public:
  explicit Csv(const std::string& path) {
    if (path.empty()) return;
    file_.reset(std::fopen(path.c_str(), "w"));
    if (!file_) std::exit((std::fprintf(stderr, "cannot write %s\n", path.c_str()), 1));
    std::fputs("seed,width,height,out_width,out_height,border,tolerance,scene,real,method,chosen,cost_ms,ms,detail\n",
               file_.get());
  }
  void add(const SweepCase& c, const std::vector<Timed>& ways) {
    if (!file_) return;
    bool real = true;
    for (const Stage stage : c.stages)
      for (const Entry<double>& entry : c.system.list(stage))
        real = real && entry.component.traits(c.system.context()).real;
    for (const Timed& way : ways)
      std::fprintf(file_.get(), "%llu,%lld,%lld,%lld,%lld,%s,%.3g,%s,%d,%s,%d,%.6g,%.6g,\"%s\"\n",
                   static_cast<unsigned long long>(c.seed), static_cast<long long>(c.in.width),
                   static_cast<long long>(c.in.height), static_cast<long long>(c.out.width),
                   static_cast<long long>(c.out.height), kBorderNames[static_cast<std::size_t>(c.border)].data(),
                   c.tolerance, c.scene_kind.c_str(), real ? 1 : 0, name_of(way.candidate.method).data(),
                   way.chosen ? 1 : 0, way.candidate.cost_ms, way.ms, way.candidate.detail.c_str());
    std::fflush(file_.get());
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

void print(std::vector<Judged>& cases) {
  std::vector<double> ratios;
  for (const Judged& judged : cases) ratios.push_back(judged.ratio());
  const auto within = std::count_if(ratios.begin(), ratios.end(), [](double r) { return r <= 1.5; });
  std::printf(
      "%zu cases whose fastest way takes %g ms or more: chosen / fastest median %.3f, 98 %% %.2f, largest %.2f; "
      "%.1f %% within 1.5\n",
      cases.size(), kCountsFromMs, quantile(ratios, 0.5), quantile(ratios, 0.98), quantile(ratios, 1.0),
      100.0 * static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(cases.size(), 1)));
  std::sort(cases.begin(), cases.end(), [](const Judged& a, const Judged& b) { return a.ratio() > b.ratio(); });
  for (std::size_t i = 0; i < std::min<std::size_t>(cases.size(), 15) && cases[i].ratio() > 1.1; ++i)
    std::printf("%6.2f  %s\n        chosen  %8.3f ms %s\n        fastest %8.3f ms %s\n", cases[i].ratio(),
                cases[i].what.c_str(), cases[i].chosen_ms, cases[i].chosen.c_str(), cases[i].fastest_ms,
                cases[i].fastest.c_str());
}

Options parsed(int count, char** arguments) {
  Options options;
  for (int i = 1; i < count; i += 2) {
    const std::string_view name = arguments[i];
    const char* value = i + 1 < count ? arguments[i + 1] : nullptr;
    if (value != nullptr && name == "--cases")
      options.cases = std::atoi(value);
    else if (value != nullptr && name == "--seed")
      options.seed = std::strtoull(value, nullptr, 10);
    else if (value != nullptr && name == "--largest")
      options.largest = std::max(16LL, std::atoll(value));
    else if (value != nullptr && name == "--csv")
      options.csv = value;
    else
      std::exit((std::fprintf(stderr, "bench_choice [--cases N] [--seed S] [--largest SIDE] [--csv FILE]\n"), 2));
  }
  return options;
}

}  // namespace

int main(int count, char** arguments) {
  const Options options = parsed(count, arguments);
  std::printf("mtfkit %s (%s), %s; one thread, minima of %d interleaved rounds\n", std::string(mtf::version).c_str(),
              std::string(mtf::git_commit).c_str(), fft::version().c_str(), kRounds);
  const std::vector<Photograph> images = photographs();
  Csv csv(options.csv);
  CostFit fit;
  std::vector<Judged> judged;
  int failed = 0, single = 0;
  for (std::uint64_t seed = options.seed; seed < options.seed + static_cast<std::uint64_t>(options.cases); ++seed) {
    const SweepCase c =
        sweep_case(seed, {32, options.largest}, std::span(images).first(seed % 2 == 0 ? images.size() : 0));
    try {
      std::vector<Timed> ways = compiled(c);
      if (ways.empty()) continue;
      time_all(c, ways, 1);
      const bool brief = std::all_of(ways.begin(), ways.end(), [](const Timed& w) { return w.ms < kShortMs; });
      time_all(c, ways, brief ? kPatientRounds : kRounds);
      if (judge(c, ways).ratio() > kSuspicious) time_all(c, ways, kPatientRounds);
      csv.add(c, ways);
      for (const Timed& way : ways) fit.add(c, way);
      const Judged result = judge(c, ways);
      if (result.fastest_ms >= kCountsFromMs) judged.push_back(result);
      if (result.fastest_ms >= kCountsFromMs && ways.size() == 1) ++single;
    } catch (const UnreachableTolerance&) {  // no tolerance below 1: nothing to choose from
    } catch (const std::exception& e) {
      ++failed;
      std::printf("%s: %s\n", c.describe().c_str(), e.what());
    }
  }
  print(judged);
  std::printf("(%d of them have one way only)\n", single);
  fit.print();
  return failed == 0 ? 0 : 1;
}
