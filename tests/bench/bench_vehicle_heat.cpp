// SPDX-License-Identifier: Apache-2.0

// Surface temperatures of the example scene of `mtf scene demo` (177,736 facets of a tracked vehicle, 8,100 of terrain;
// 48 h in outputs of 10 minutes, 72 directions to the sun, views and exchange between surfaces included) at several
// tolerances: time of all threads by the processor and by the clock, stage by stage, and the promise. Arguments: the
// tolerances in K, 1, 0.3 and 0.1 without any. With `verify` among them the realised error too, as `mtf heat --verify`
// has it, which is in the times then; with `seen` only what the camera of the scene sees, as with `mtf heat --seen`.
// The bar: 6 s by the clock on two cores at 0.1 K.

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/outputs/mesh_files.h"
#include "apps/scene/scene_file/demo_scene_text.h"
#include "apps/scene/vehicle/vehicle.h"
#include "mtf/version.h"
#include "mtf/work/stopwatch.h"

namespace {

using namespace apps::scene;  // NOLINT: a benchmark program
namespace fs = std::filesystem;

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

fs::path demo_scene() {
  const fs::path folder = fs::temp_directory_path() / "mtfkit_bench_vehicle_heat";
  fs::create_directories(folder);
  std::ofstream(folder / "scene.toml") << demo_scene_text();
  std::ofstream(folder / "weather.csv") << demo_weather_text();
  std::ofstream(folder / "engine.csv") << demo_engine_text();
  write_obj((folder / "vehicle.obj").string(), make_vehicle());
  write_obj((folder / "terrain.obj").string(), make_terrain());
  return folder / "scene.toml";
}

void print(const char* name, const RealisedError& error) {
  std::printf(
      "  realised, %s: %.4f K rms, %.4f K for 95 %%, %.4f K for 99.9 %% of facets, %.4f K at most, against a run "
      "that promises %.4f K\n",
      name, error.rms_k, error.percentile_95_k, error.percentile_999_k, error.largest_k, error.promised_k);
}

void run(const SceneFile& file, double tolerance_k, bool verify, bool seen) {
  const mtf::Stopwatch clock;
  const double begin_s = processor_s();
  const HeatOptions options{.tolerance_k = tolerance_k, .seen = seen, .verify = verify};
  const HeatScene scene = prepare_heat(file, options);
  const HeatReport report = run_heat(
      scene, options, [](const HeatOutput&) {}, [](const std::string&, double) {});
  std::printf("%6.2f K: %6.2f s by the clock, %6.2f s of processors; promised %.3f K, %zu units, %zu patches\n",
              tolerance_k, 1e-3 * clock.ms(), processor_s() - begin_s, report.promised.total_k(), report.units,
              report.patches);
  for (const auto& [name, ms] : report.timing_ms) std::printf("  %s %.2f", name.c_str(), 1e-3 * ms);
  const HeatPromise& p = report.promised;
  std::printf("\n  promise: %.2f x (%.3f solver + %.3f ground + %.3f units + %.3f exchange), %d passes\n", p.feedback,
              p.solver.total_k(), p.ground_k, p.units_k, p.exchange_k, report.iterations);
  if (report.left_out)
    std::printf(
        "  left out: %zu facets of %zu, %zu units: %.3f K rms, %.3f K for 95 %%, %.3f K at most (standard errors)\n",
        report.left_out->facets, report.facets, report.left_out->units, report.left_out->error_k.rms,
        report.left_out->error_k.percentile_95, report.left_out->largest_k);
  for (const MaterialRun& m : report.materials)
    std::printf("  %-16s %6zu units %3zu nodes %11lld steps of facets, %7lld refused, %.4f K\n", m.name.c_str(),
                m.units, m.nodes, static_cast<long long>(m.steps.facet_steps), static_cast<long long>(m.steps.refused),
                m.promised.total_k());
  std::printf(
      "  views of facets against those of units %.3f K rms, %.3f K for 95 %%, %.2f K at most; shadows %.3f rms\n",
      report.view_spread.error_k.rms, report.view_spread.error_k.percentile_95, report.view_spread.largest_k,
      report.sun_error.of_directions.rms);
  if (report.verified) {
    print("classes as they are", report.verified->as_units);
    print("each facet by itself", report.verified->by_itself);
  }
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  std::printf("mtfkit %s\n", std::string(mtf::version).c_str());
  const SceneFile file = load_scene(demo_scene().string());
  bool verify = false, seen = false;
  std::vector<double> tolerances_k;
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    verify = verify || argument == "verify";
    seen = seen || argument == "seen";
    if (argument != "verify" && argument != "seen") tolerances_k.push_back(std::strtod(arguments[i], nullptr));
  }
  if (tolerances_k.empty()) tolerances_k = {1.0, 0.3, 0.1};
  for (const double tolerance_k : tolerances_k) run(file, tolerance_k, verify, seen);
  return 0;
}
