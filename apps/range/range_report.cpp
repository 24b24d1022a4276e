// SPDX-License-Identifier: Apache-2.0
#include "apps/range/range_report.h"

#include <algorithm>
#include <cmath>

#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/units.h"
#include "radiometry/fields.h"

namespace apps {
namespace {

using study::Acquisition;
using study::TaskRange;

std::string length_words(double m, int digits) {
  if (std::isinf(m)) return "not known";
  if (std::isnan(m)) return "-";
  const bool km = m >= 1e3;
  const double value = km ? 1e-3 * m : m;
  return (value >= std::pow(10.0, digits) ? fixed(value, 0) : significant(value, digits)) + (km ? " km" : " m");
}

std::string model_words(const TaskRange& task) { return task.model == "ttp" ? "TTP" : "Johnson"; }

/// V50 of TTP, N50 of Johnson's criteria.
std::string needs_words(const TaskRange& task) {
  return (task.model == "ttp" ? "V50 " : "N50 ") + mtf::format_double(task.half);
}

/// What to know of a range that is there.
std::string remark_of(const TaskRange& task) {
  if (task.range_m == 0.0) return "the task succeeds at no range";
  std::string remark = task.at_nyquist ? "limited by the Nyquist frequency" : "";
  if (task.fills_field)
    remark += std::string(remark.empty() ? "" : "; ") + "the target is wider there than the field of view";
  return remark;
}

/// Each reason once, after the names of its tasks.
std::string reasons(const Acquisition& found) {
  std::vector<std::pair<std::string, std::string>> told;  // reason, names
  for (const TaskRange& task : found.tasks) {
    if (task.reason.empty()) continue;
    const std::string name = model_words(task) + " " + task.task;
    const auto same = std::find_if(told.begin(), told.end(), [&](const auto& one) { return one.first == task.reason; });
    if (same == told.end())
      told.emplace_back(task.reason, name);
    else
      same->second += ", " + name;
  }
  std::string text;
  for (const auto& [reason, names] : told) text += "no range for " + names + ": " + reason + "\n";
  return text;
}

/// What the columns error and sd hold.
std::string uncertainty_words(const Acquisition& found) {
  if (found.stated.empty())
    return "error: numerical; the sensor file states no standard deviation ({ value, stderr }), so there is no sd\n";
  std::string text = "error: numerical; sd: of the standard deviations that the sensor file states, as independent: ";
  for (const study::StatedNumber& one : found.stated) {
    const std::string unit = one.unit.empty() ? "" : " " + one.unit;
    text += (&one == &found.stated.front() ? "" : ", ") + one.path + " " + mtf::format_double(one.value) + " +- " +
            mtf::format_double(one.sd) + unit;
    if (!one.problem.empty()) text += " (cannot be moved: " + one_line(one.problem) + ")";
  }
  return text + "\n";
}

/// Columns in the order of people: TTP, then Johnson.
std::vector<const TaskRange*> in_order(const Acquisition& found) {
  std::vector<const TaskRange*> order;
  for (const char* model : {"ttp", "johnson"})
    for (const TaskRange& task : found.tasks)
      if (task.model == model) order.push_back(&task);
  return order;
}

std::string probability_table(const Acquisition& found) {
  std::vector<const TaskRange*> shown;
  for (const TaskRange* task : in_order(found))
    if (!task->probability.empty()) shown.push_back(task);
  const bool km = !found.range_m.empty() && found.range_m.back() >= 1e3;
  std::vector<std::string> header{std::string("range [") + (km ? "km]" : "m]")};
  for (const TaskRange* task : shown) header.push_back(model_words(*task) + " " + task->task);
  const std::vector<Align> align(header.size(), Align::right);
  TextTable table(header);
  double error = 0.0, sd = 0.0;
  bool sd_known = true;
  for (std::size_t r = 0; r < found.range_m.size(); ++r) {
    std::vector<std::string> row{significant((km ? 1e-3 : 1.0) * found.range_m[r], 6)};
    for (const TaskRange* task : shown) {
      row.push_back(std::isfinite(task->probability[r]) ? fixed(task->probability[r], 3) : "-");
      error = std::fmax(error, std::abs(task->probability_error[r]));
      sd = std::fmax(sd, task->probability_sd[r]);
      sd_known = sd_known && (std::isfinite(task->probability_sd[r]) || std::isnan(task->probability[r]));
    }
    table.add(std::move(row));
  }
  std::string text = table.aligned(align) + "error of the probabilities: up to " + significant(error, 2);
  if (!found.stated.empty()) text += sd_known ? ", sd up to " + significant(sd, 2) : ", sd not known everywhere";
  return text + "\n";
}

Json numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(value);
  return list;
}

}  // namespace

std::string range_table(const Acquisition& found, const radiometry::Conditions& conditions) {
  std::vector<std::string> header{"task", "model", "needs", "range", "error"};
  if (!found.stated.empty()) header.emplace_back("sd");
  header.emplace_back("remark");
  TextTable table(header);
  for (const TaskRange* task : in_order(found)) {
    std::vector<std::string> row{task->task, model_words(*task), needs_words(*task), length_words(task->range_m, 5),
                                 length_words(task->error_m, 2)};
    if (!found.stated.empty()) row.push_back(length_words(task->sd_m, 2));
    row.push_back(task->reason.empty() ? remark_of(*task) : "see below");
    table.add(std::move(row));
  }
  std::string text = "ranges at which tasks succeed with a probability of " +
                     mtf::format_double(conditions.probability) + "\n" +
                     table.aligned({Align::left, Align::left, Align::left, Align::right, Align::right,
                                    found.stated.empty() ? Align::left : Align::right}) +
                     reasons(found) + uncertainty_words(found);
  for (const std::string& line : found.lines) text += one_line(line) + "\n";
  for (const std::string& caution : found.cautions) text += "caution: " + one_line(caution) + "\n";
  return found.range_m.empty() ? text : text + "\nprobability against range\n" + probability_table(found);
}

std::string range_csv(const Acquisition& found) {
  std::string text = "range_m";
  const std::vector<const TaskRange*> order = in_order(found);
  for (const TaskRange* task : order) {
    const std::string name = task->model + "_" + task->task;
    text += "," + name + "," + name + "_error," + name + "_sd";
  }
  text += "\n";
  const auto cell = [](const std::vector<double>& values, std::size_t r) {
    return "," + (r < values.size() ? csv_number(values[r]) : std::string());
  };
  for (std::size_t r = 0; r < found.range_m.size(); ++r) {
    text += csv_number(found.range_m[r]);
    for (const TaskRange* task : order)
      text += cell(task->probability, r) + cell(task->probability_error, r) +
              (found.stated.empty() ? "," : cell(task->probability_sd, r));
    text += "\n";
  }
  return text;
}

std::string range_json(const Acquisition& found, const radiometry::Conditions& conditions,
                       const mtf::io::SensorConfig& sensor) {
  Json given = Json::object();
  radiometry::for_each_field(conditions, [&](const radiometry::FieldInfo& info, const auto& member) {
    const std::optional<double> value = radiometry::detail::bounded(member);
    if (value) given[info.name] = {{"value", *value}, {"unit", std::string(info.unit)}};
  });
  given["lines"] = found.lines;
  Json ranges = Json::object(), probability = {{"range_m", numbers(found.range_m)}};
  for (const TaskRange* task : in_order(found)) {
    Json& one = ranges[task->metric] = {{"value", task->range_m}, {"unit", "m"}, {"error", task->error_m}};
    one["sd"] = found.stated.empty() ? Json(nullptr) : Json(task->sd_m);
    one["cycles_of_half"] = task->half;
    one["at_nyquist"] = task->at_nyquist;
    one["fills_field"] = task->fills_field;
    if (!task->reason.empty()) one["reason"] = task->reason;
    if (task->probability.empty()) continue;
    probability[task->metric] = {{"value", numbers(task->probability)}, {"error", numbers(task->probability_error)}};
    if (!found.stated.empty()) probability[task->metric]["sd"] = numbers(task->probability_sd);
  }
  Json stated = Json::array();
  for (const study::StatedNumber& number : found.stated) {
    stated.push_back({{"parameter", number.path}, {"unit", number.unit}, {"value", number.value}, {"sd", number.sd}});
    Json& moves = stated.back()["moves_m"] = Json::object();
    for (std::size_t i = 0; i < study::kRangeTasks; ++i) moves[found.tasks[i].metric] = number.moves_m[i];
    if (!number.problem.empty()) stated.back()["reason"] = number.problem;
  }
  return json_document({{"sensor", sensor.file},
                        {"name", sensor.system.name},
                        {"config_sha256", sensor.sha256},
                        {"conditions", given},
                        {"ranges", ranges},
                        {"probability", probability},
                        {"standard_deviations", stated},
                        {"cautions", found.cautions}});
}

Figure range_figure(const Acquisition& found, const std::string& title) {
  Figure figure;
  figure.title = title;
  figure.x_label = "range [km]";
  figure.y_label = "probability";
  for (const TaskRange* task : in_order(found)) {
    if (task->probability.empty()) continue;
    Series series{.name = model_words(*task) + " " + task->task, .y = task->probability};
    for (const double range : found.range_m) series.x.push_back(1e-3 * range);
    if (!found.stated.empty())
      for (std::size_t r = 0; r < series.y.size(); ++r) {
        const double by = 2.0 * task->probability_sd[r];  // NaN stays NaN: no band
        series.low.push_back(std::clamp(series.y[r] - by, 0.0, 1.0));
        series.high.push_back(std::clamp(series.y[r] + by, 0.0, 1.0));
      }
    figure.series.push_back(std::move(series));
  }
  figure.log_x = true;
  figure.y_low = 0.0;
  figure.y_high = 1.0;
  return figure;
}

}  // namespace apps
