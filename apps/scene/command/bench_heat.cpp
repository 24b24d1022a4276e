// SPDX-License-Identifier: Apache-2.0

// `mtf bench scene.toml -o DIR`: what each tolerance of the temperatures costs: promised and realised error, and time.

#include <algorithm>

#include "apps/bench/machine.h"
#include "apps/figures/plot.h"
#include "apps/options.h"
#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/version.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

using namespace scene;

struct Rung {
  double tolerance_k = 0.0;
  HeatReport report;       ///< of the run that is verified
  std::vector<double> ms;  ///< of each round: weather and meshes read, rays, heat
  double least_ms() const { return *std::min_element(ms.begin(), ms.end()); }
  double median_ms() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
  bool kept() const { return report.verified->as_units.largest_k <= report.promised.total_k(); }
};

Rung rung_of(const SceneFile& file, double tolerance_k, int rounds, const Global& global, ProgressLine& progress) {
  Rung rung{tolerance_k, {}, {}};
  const std::string name = significant(tolerance_k, 2) + " K: ";
  const auto say = [&](const std::string& step, double share) { progress.update(name + step, share); };
  HeatOptions options{.tolerance_k = tolerance_k, .threads = global.threads};
  for (int round = 0; round < rounds; ++round) {
    const mtf::Stopwatch watch;
    const HeatScene scene = prepare_heat(file, options);
    run_heat(
        scene, options, [](const HeatOutput&) {}, say);
    rung.ms.push_back(watch.ms());
  }
  options.verify = true;
  const HeatScene scene = prepare_heat(file, options);
  rung.report = run_heat(
      scene, options, [](const HeatOutput&) {}, say);
  return rung;
}

constexpr const char* kColumns[] = {"tolerance_K", "promised_K",    "realised_K",       "facets_rms_K",
                                    "facets_95_K", "facets_99_9_K", "facets_largest_K", "classes",
                                    "time_ms_min", "time_ms_median"};

std::vector<double> numbers_of(const Rung& rung) {
  const RealisedError &ours = rung.report.verified->as_units, &facets = rung.report.verified->by_itself;
  return {rung.tolerance_k,       rung.report.promised.total_k(),
          ours.largest_k,         facets.rms_k,
          facets.percentile_95_k, facets.percentile_999_k,
          facets.largest_k,       static_cast<double>(rung.report.units),
          rung.least_ms(),        rung.median_ms()};
}

std::string csv_of(const std::vector<Rung>& ladder) {
  TextTable table(std::vector<std::string>(std::begin(kColumns), std::end(kColumns)));
  for (const Rung& rung : ladder) {
    std::vector<std::string> row;
    for (const double number : numbers_of(rung)) row.push_back(csv_number(number));
    table.add(std::move(row));
  }
  return table.csv();
}

std::string json_of(const SceneFile& file, const std::vector<Rung>& ladder, const Global& global, int rounds) {
  const Machine machine = this_machine();
  Json rows = Json::array();
  for (const Rung& rung : ladder) {
    Json row = Json::object();
    const std::vector<double> numbers = numbers_of(rung);
    for (std::size_t i = 0; i < numbers.size(); ++i) row[kColumns[i]] = numbers[i];
    row["kept"] = rung.kept();
    rows.push_back(row);
  }
  const Json json = {
      {"version", mtf::version},
      {"git_commit", mtf::git_commit},
      {"machine", {{"cpu", machine.cpu}, {"cores", machine.cores}, {"memory_bytes", machine.memory_bytes}}},
      {"scene", file.file},
      {"scene_sha256", file.sha256},
      {"facets", ladder.front().report.facets},
      {"threads", global.threads > 0 ? global.threads : machine.cores},
      {"rounds", rounds},
      {"rows", rows}};
  return json_document(json);
}

std::string table_of(const std::vector<Rung>& ladder) {
  TextTable table(
      {"tolerance", "promised", "realised", "facets rms", "95 %", "largest [K]", "classes", "s min", "median"});
  for (const Rung& rung : ladder) {
    const RealisedError &ours = rung.report.verified->as_units, &facets = rung.report.verified->by_itself;
    table.add({significant(rung.tolerance_k, 2), significant(rung.report.promised.total_k(), 2),
               significant(ours.largest_k, 2), significant(facets.rms_k, 2), significant(facets.percentile_95_k, 2),
               significant(facets.largest_k, 2), std::to_string(rung.report.units), fixed(1e-3 * rung.least_ms(), 2),
               fixed(1e-3 * rung.median_ms(), 2)});
  }
  using enum Align;
  return table.aligned({right, right, right, right, right, right, right, right, right}) +
         "realised: the worst facet and output against a tenth of the tolerance, with the same classes; facets: "
         "against\n"
         "every facet solved by itself, with what those of a class see differently, which the promise leaves out\n";
}

Figure figure_of(const SceneFile& file, const std::vector<Rung>& ladder) {
  Figure figure;
  figure.title = "error against run time: " + file.file;
  figure.x_label = "time [s], minimum of the rounds";
  figure.y_label = "error [K]";
  figure.log_x = figure.log_y = true;
  Series promised{.name = "promised", .x = {}, .y = {}, .mark = Mark::large_points};
  Series realised{.name = "realised, worst facet and output", .x = {}, .y = {}, .mark = Mark::points};
  Series rms{.name = "every facet by itself, rms", .x = {}, .y = {}, .mark = Mark::points};
  for (const Rung& rung : ladder) {
    for (Series* series : {&promised, &realised, &rms}) series->x.push_back(1e-3 * rung.least_ms());
    promised.y.push_back(rung.report.promised.total_k());
    realised.y.push_back(rung.report.verified->as_units.largest_k);
    rms.y.push_back(rung.report.verified->by_itself.rms_k);
  }
  figure.series = {promised, realised, rms};
  return figure;
}

}  // namespace

int run_bench_heat(const BenchOptions& options, const Global& global) {
  if (options.out.empty()) throw mtf::UsageError("-o, --out is missing: name the folder for the results");
  const SceneFile file = load_scene(options.sensor);
  OutputSet outputs({.folder = options.out,
                     .force = options.force,
                     .names = {"heat_bench.csv", "heat_bench.json", "heat_bench.svg"},
                     .inputs = files_of(file)});
  std::vector<double> tolerances = options.tolerances_k;
  if (tolerances.empty()) tolerances = {1.0, 0.3, 0.1};
  const int rounds = options.rounds.value_or(1);
  std::vector<Rung> ladder;
  {
    ProgressLine progress(global);
    for (const double tolerance_k : tolerances) ladder.push_back(rung_of(file, tolerance_k, rounds, global, progress));
  }
  emit(outputs.in("heat_bench.csv"), csv_of(ladder));
  emit(outputs.in("heat_bench.json"), json_of(file, ladder, global, rounds));
  if (!draw_figure(outputs.in("heat_bench.svg"), figure_of(file, ladder)))
    note(global, "note: gnuplot is not installed; heat_bench.csv has the numbers, heat_bench.svg is left out");
  outputs.commit();
  print(options.format == Format::json  ? json_of(file, ladder, global, rounds)
        : options.format == Format::csv ? csv_of(ladder)
                                        : table_of(ladder) + "written to " + one_line(options.out) + "/\n");
  bool kept = true;
  for (const Rung& rung : ladder)
    if (!rung.kept()) {
      kept = false;
      complain("mtf: PROMISE BROKEN: tolerance " + significant(rung.tolerance_k, 2) + " K: promised " +
               significant(rung.report.promised.total_k(), 3) + " K, realised " +
               significant(rung.report.verified->as_units.largest_k, 3) + " K");
    }
  return kept ? 0 : 3;
}

}  // namespace apps
