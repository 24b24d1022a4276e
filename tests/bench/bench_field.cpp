// SPDX-License-Identifier: Apache-2.0

// Images with an OTF that changes over the field, 1280 x 1024 pixels, one thread: time of planning, modes, and the run
// beside a bare FFTW pair of the image's size and beside the plan of the optical axis, interleaved. Scenes have edges
// and a power that falls with the square of the frequency, and a little noise; their spectrum is known to the plan.
// Output: a table, of each method that keeps the tolerance, the chosen one first; times are minimum and median in ms.
// Usage: bench_field [NAME [RATIO [TOLERANCE]]], of one system, ratio of pitch to sample, tolerance alone.

#include <cstdio>
#include <cstdlib>
#include <random>
#include <string_view>

#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/version.h"
#include "mtf/work/stopwatch.h"
#include "tests/bench/bare_pair.h"
#include "tests/bench/interleave.h"
#include "tests/mtf/field_systems.h"

namespace {

using namespace mtf;  // NOLINT: a benchmark program

/// Dead leaves: discs of random size and grey that hide one another.
Image leaves(std::int64_t width, std::int64_t height) {
  std::mt19937 generator(1);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); };
  Image image(width, height);
  std::fill_n(image.data(), image.size(), 0.5F);
  for (int n = 0; n < 6000; ++n) {
    const double r = 2.0 / std::sqrt(uniform(1.0 / (300.0 * 300.0), 1.0)), grey = uniform(0.0, 1.0);
    const double cx = uniform(0.0, static_cast<double>(width)), cy = uniform(0.0, static_cast<double>(height));
    for (auto y = std::max<std::int64_t>(0, std::llround(cy - r));
         y < std::min<std::int64_t>(height, std::llround(cy + r)); ++y)
      for (auto x = std::max<std::int64_t>(0, std::llround(cx - r));
           x < std::min<std::int64_t>(width, std::llround(cx + r)); ++x)
        if (std::hypot(static_cast<double>(x) - cx, static_cast<double>(y) - cy) < r)
          image.at(x, y) = static_cast<float>(grey);
  }
  std::normal_distribution<double> noise(0.0, 0.01);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] += static_cast<float>(noise(generator));
  return image;
}

System<double> lens(System<double> system, double cutoff_cy_px) {
  system.frame = {100.0, 15.0, 15.0, 0.01, 1280, 1024};
  system.optics.wavelength_um = 15.0 / (2.0 * cutoff_cy_px);  // F/2
  system.add(Stage::presample, test::footprint(15.0));
  return system;
}

struct Only {
  std::string_view name;
  std::int64_t ratio = 0;
  double tolerance = 0.0;
};

void measure(const Only& only, const char* what, const System<double>& system, std::int64_t ratio) {
  if ((!only.name.empty() && only.name != what) || (only.ratio > 0 && only.ratio != ratio)) return;
  const Image scene = leaves(1280 * ratio, 1024 * ratio);
  const double step = 15.0 / static_cast<double>(ratio);
  const SampleGrid in{scene.width(), scene.height(), step, step}, out = detector_grid(system, in);
  PlanOptions options = test::options_for(scene, Border::reflect, 1e-2);
  options.spectrum = scene_spectrum(scene.view(), Border::reflect, 1);
  Image image(out.width, out.height);
  const bench::BarePair apart(1280, 1024, false), in_place(1280, 1024, true);
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    if (only.tolerance > 0.0 && std::abs(tolerance / only.tolerance - 1.0) > 1e-9) continue;
    options.tolerance = tolerance;
    options.method.reset();
    const Plan axis = compile(system.at({}), in, out, options);
    std::vector<std::optional<Method>> methods{std::nullopt};
    for (std::size_t i = 0; i < methods.size(); ++i) {
      options.method = methods[i];
      const Stopwatch watch;
      std::optional<Plan> made;
      try {
        made = compile(system, in, out, options);
      } catch (const UnreachableTolerance& refused) {
        std::printf("%-14s %lld a pitch %7.0e  refused: %.1e can be kept, after %.1f s\n", what,
                    static_cast<long long>(ratio), tolerance, refused.reachable(), watch.seconds());
        continue;
      }
      const Plan& plan = *made;
      const PlanReport& r = plan.report();
      const double planning = watch.seconds();
      const auto t = bench::interleave(
          {[&] { plan.run(scene.view(), image.view(), 0.0, 1); }, [&] { axis.run(scene.view(), image.view(), 0.0, 1); },
           [&] { apart.both(); }, [&] { in_place.both(); }},
          7);
      const apps::Timing& floor = t[2].min_ms < t[3].min_ms ? t[2] : t[3];
      std::printf(
          "%-11s %lld a pitch %5.0e  %-11s planning %5.1f s  %3zu modes %3zu tiles %3zu places  promised %.1e  one OTF "
          "%.1e  run %7.1f %7.1f  axis %6.1f %6.1f  FFTW %5.1f %5.1f  run/FFTW %5.1f %5.1f  run/axis %5.1f %5.1f\n",
          what, static_cast<long long>(ratio), tolerance, r.method.c_str(), planning, r.field.modes, r.field.tiles,
          r.field.points, r.predicted.total(), r.field.one_otf_error, t[0].min_ms, t[0].median_ms, t[1].min_ms,
          t[1].median_ms, floor.min_ms, floor.median_ms, t[0].min_ms / floor.min_ms, t[0].median_ms / floor.median_ms,
          t[0].min_ms / t[1].min_ms, t[0].median_ms / t[1].median_ms);
      for (const Candidate& way : r.candidates) {
        if (way.method != Method::field_modes && way.method != Method::field_tiles) continue;
        std::printf("    %s predicted %.1f ms: %s %s\n",
                    std::string(kMethodNames[static_cast<std::size_t>(way.method)]).c_str(), way.cost_ms,
                    way.detail.c_str(), way.reason.c_str());
        if (i == 0 && !way.reason.empty()) methods.push_back(way.method);
      }
      std::fflush(stdout);
    }
  }
}

}  // namespace

int main(int count, char** words) {
  const Only only{.name = count > 1 ? words[1] : "",
                  .ratio = count > 2 ? std::atoll(words[2]) : 0,
                  .tolerance = count > 3 ? std::atof(words[3]) : 0.0};
  std::printf("mtfkit %s %s, one thread\n", std::string(version).c_str(), std::string(git_commit).c_str());
  for (const std::int64_t ratio : {1, 2}) {
    measure(only, "no matter", lens(test::seidel(0.05, 1e-6, 1e-6, 0.0, 0.0), 1.57), ratio);
    measure(only, "good lens", lens(test::seidel(0.05, 0.05, 0.1, 0.05, 0.0), 1.57), ratio);
    measure(only, "triplet", lens(test::seidel(0.25, 0.7, 1.0, 0.5, -0.3), 1.57), ratio);
    measure(only, "roll jitter", lens(test::rolling(1.5, 0.0, 1280, 1024), 1.57), ratio);
  }
  return 0;
}
