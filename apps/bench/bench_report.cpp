// SPDX-License-Identifier: Apache-2.0
#include "apps/bench/bench_report.h"

#include <algorithm>
#include <map>

#include "apps/bench/bench_rivals.h"
#include "apps/bench/machine.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/units.h"
#include "mtf/version.h"

namespace apps {
namespace {

std::string digits(const std::optional<double>& value, int count) { return value ? significant(*value, count) : ""; }

std::string size_text(const std::array<std::int64_t, 2>& size) {
  return std::to_string(size[0]) + "x" + std::to_string(size[1]);
}

std::string speed_text(const BenchRow& row) {
  if (!row.time || !row.floor_image_ms || *row.floor_image_ms <= 0.0) return "";
  return fixed(row.time->min_ms / *row.floor_image_ms, 2);
}

std::optional<double> min_ms(const BenchRow& row) {
  return row.time ? std::optional<double>(row.time->min_ms) : std::nullopt;
}
std::optional<double> median_ms(const BenchRow& row) {
  return row.time ? std::optional<double>(row.time->median_ms) : std::nullopt;
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json row_json(const BenchRow& row) {
  return {{"tolerance", row.tolerance},
          {"method", row.method},
          {"chosen", row.chosen},
          {"promised", number_or_null(row.promised)},
          {"rms_error", number_or_null(row.rms_error)},
          {"max_error", number_or_null(row.max_error)},
          {"time_ms_min", number_or_null(min_ms(row))},
          {"time_ms_median", number_or_null(median_ms(row))},
          {"plan_ms", number_or_null(row.plan_ms)},
          {"memory_mib", number_or_null(row.memory_mib)},
          {"floor_ms", number_or_null(row.floor_ms)},
          {"floor_image_ms", number_or_null(row.floor_image_ms)},
          {"detail", row.detail},
          {"runs", row.time ? Json(row.time->runs) : Json(nullptr)}};
}

// The least error that can be had within a time: a staircase over the rows that no other beats in both error and time.
Series pareto_front(const std::vector<BenchRow>& rows) {
  std::vector<std::pair<double, double>> points;
  for (const BenchRow& row : rows)
    if (row.time && row.rms_error && *row.rms_error > 0.0) points.emplace_back(row.time->min_ms, *row.rms_error);
  std::sort(points.begin(), points.end());
  Series front{"Pareto front", {}, {}, true};
  for (const auto& [time, error] : points)
    if (front.y.empty() || error < front.y.back()) {
      if (!front.y.empty()) {
        front.x.push_back(time);
        front.y.push_back(front.y.back());
      }
      front.x.push_back(time);
      front.y.push_back(error);
    }
  return front;
}

}  // namespace

std::string bench_table(const BenchReport& report) {
  TextTable table({"tolerance", "", "method", "promised", "rms error", "max error", "ms min", "median", "plan ms",
                   "MiB", "x FFTW", "detail"});
  double last = 0.0;
  for (const BenchRow& row : report.rows) {
    table.add({row.tolerance == last ? "" : significant(row.tolerance, 2), row.chosen ? ">" : "", row.method,
               digits(row.promised, 2), digits(row.rms_error, 2), digits(row.max_error, 2),
               row.time ? fixed(row.time->min_ms, 3) : "", row.time ? fixed(row.time->median_ms, 3) : "",
               row.plan_ms ? fixed(*row.plan_ms, 1) : "", row.memory_mib ? fixed(*row.memory_mib, 1) : "",
               speed_text(row), row.detail});
    last = row.tolerance;
  }
  constexpr Align l = Align::left, r = Align::right;
  std::string text = table.aligned({r, l, l, r, r, r, r, r, r, r, r, l});
  text +=
      "> is what the plan chooses; errors are relative to the scene's std; x FFTW compares with bare FFTW of the "
      "image's size\n";
  for (const Floor& floor : report.floors)
    text += "bare FFTW " + size_text(floor.size) + ", forward and back, " + (floor.in_place ? "in" : "out of") +
            " place: " + fixed(floor.time.min_ms, 3) + " ms (median " + fixed(floor.time.median_ms, 3) + ")\n";
  return text;
}

std::string bench_csv(const BenchReport& report) {
  TextTable table({"tolerance", "method", "chosen", "promised", "rms_error", "max_error", "time_ms_min",
                   "time_ms_median", "plan_ms", "memory_mib", "floor_ms", "floor_image_ms", "detail", "runs"});
  for (const BenchRow& row : report.rows)
    table.add({mtf::format_double(row.tolerance), row.method, row.chosen ? "1" : "0", digits(row.promised, 17),
               digits(row.rms_error, 17), digits(row.max_error, 17), digits(min_ms(row), 17),
               digits(median_ms(row), 17), digits(row.plan_ms, 17), digits(row.memory_mib, 17),
               digits(row.floor_ms, 17), digits(row.floor_image_ms, 17), row.detail,
               row.time ? std::to_string(row.time->runs) : ""});
  return table.csv();
}

std::string bench_json(const BenchReport& report) {
  const BenchJob& job = *report.job;
  const Machine machine = this_machine();
  Json json;
  json["version"] = mtf::version;
  json["git_commit"] = mtf::git_commit;
  json["fft"] = mtf::fft::version();
  json["machine"] = {{"cpu", machine.cpu}, {"cores", machine.cores}, {"memory_bytes", machine.memory_bytes}};
  json["command"] = report.command;
  json["sensor"] = report.sensor;
  json["sensor_name"] = report.sensor_name;
  json["config_sha256"] = report.config_sha256;
  json["scene"] = report.scene_path;
  json["channel"] = report.channel;
  json["scene_size"] = {job.in.width, job.in.height};
  json["out_size"] = {job.out.width, job.out.height};
  json["border"] = mtf::kBorderNames[static_cast<std::size_t>(job.options.border)];
  json["scene_std"] = job.flat ? 0.0 : job.scale;
  json["threads"] = report.threads;
  json["rigor"] = job.options.rigor == mtf::Rigor::measure ? "measure" : "estimate";
  json["rounds"] = report.rounds;
  json["floors"] = Json::array();
  for (const Floor& floor : report.floors)
    json["floors"].push_back({{"size", floor.size},
                              {"in_place", floor.in_place},
                              {"time_ms_min", floor.time.min_ms},
                              {"time_ms_median", floor.time.median_ms},
                              {"runs", floor.time.runs}});
  json["rows"] = Json::array();
  for (const BenchRow& row : report.rows) json["rows"].push_back(row_json(row));
  json["warnings"] = report.notes;
  // Names of files may hold any bytes; the report stays valid UTF-8.
  return json_document(json);
}

std::optional<Figure> bench_figure(const BenchReport& report) {
  Figure figure;
  figure.title = "error against run time: " + (report.sensor_name.empty() ? report.sensor : report.sensor_name) + ", " +
                 size_text({report.job->in.width, report.job->in.height}) + " samples to " +
                 size_text({report.job->out.width, report.job->out.height}) + " pixels";
  figure.x_label = "time of one image [ms], minimum of interleaved runs";
  figure.y_label = "realised rms error [std of the scene]";
  figure.log_x = figure.log_y = true;
  figure.series.push_back(pareto_front(report.rows));
  if (figure.series.front().x.empty()) return std::nullopt;
  Series chosen{"chosen by the plan", {}, {}, true, Mark::large_points};
  // All methods in one order, present or not, so that each has the same symbol in every chart.
  std::vector<std::string_view> methods(mtf::kMethodNames.begin(), mtf::kMethodNames.end());
  methods.insert(methods.end(), kRivalNames.begin(), kRivalNames.end());
  for (std::size_t i = 0; i < methods.size(); ++i) {
    Series series{.name = std::string(methods[i]), .x = {}, .y = {}, .mark = Mark::points, .style = i};
    for (const BenchRow& row : report.rows) {
      if (row.method != methods[i] || !row.time) continue;
      series.x.push_back(row.time->min_ms);
      series.y.push_back(*row.rms_error);
      if (!row.chosen) continue;
      chosen.x.push_back(row.time->min_ms);
      chosen.y.push_back(*row.rms_error);
    }
    if (!series.x.empty()) figure.series.push_back(std::move(series));
  }
  figure.series.push_back(std::move(chosen));
  double low = figure.series.front().x.front(), high = low;
  for (const Series& series : figure.series)
    for (const double x : series.x) low = std::min(low, x), high = std::max(high, x);
  for (const Floor& floor : report.floors) {
    figure.vertical_lines.push_back({floor.time.min_ms, "FFTW " + size_text(floor.size)});
    low = std::min(low, floor.time.min_ms), high = std::max(high, floor.time.min_ms);
  }
  std::sort(figure.vertical_lines.begin(), figure.vertical_lines.end(),
            [](const VerticalLine& a, const VerticalLine& b) { return a.x < b.x; });
  figure.x_range = std::array{0.8 * low, 1.25 * high};
  return figure;
}

}  // namespace apps
