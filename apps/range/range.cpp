// SPDX-License-Identifier: Apache-2.0

// `mtf range SENSOR`: how far a sensor detects, recognises and identifies a target.

#include <algorithm>
#include <cmath>
#include <string>

#include "apps/commands.h"
#include "apps/config_command.h"
#include "apps/figures/plot.h"
#include "apps/key_options.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/study/task_ranges.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/components/field.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "mtf/units.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/fields.h"

namespace apps {
namespace {

// How ranges and probabilities against range are shown.

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

/// The ranges, what they hold for, the probabilities.
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

/// A line a range of the probabilities: range_m, then for each task its probability, error and standard deviation.
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
  Json ranges = Json::object(), probability = {{"range_m", found.range_m}};
  for (const TaskRange* task : in_order(found)) {
    Json& one = ranges[task->metric] = {{"value", task->range_m}, {"unit", "m"}, {"error", task->error_m}};
    one["sd"] = found.stated.empty() ? Json(nullptr) : Json(task->sd_m);
    one["cycles_of_half"] = task->half;
    one["at_nyquist"] = task->at_nyquist;
    one["fills_field"] = task->fills_field;
    if (!task->reason.empty()) one["reason"] = task->reason;
    if (task->probability.empty()) continue;
    probability[task->metric] = {{"value", task->probability}, {"error", task->probability_error}};
    if (!found.stated.empty()) probability[task->metric]["sd"] = task->probability_sd;
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

/// Probability against range of all tasks, with bands of two standard deviations where the sensor file states some.
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

/// A target that others know by name.
struct StandardTarget {
  double size_m, contrast_k;
};
/// "nato": STANAG 4347 (1995), 2.3 m x 2.3 m, 2 K above its background.
constexpr std::array kStandardTargets{std::pair{std::string_view("nato"), StandardTarget{2.3, 2.0}}};

struct RangeOptions {
  std::string sensor;
  std::optional<StandardTarget> target{};
  GivenKeys given{};              ///< of [conditions]
  std::vector<double> range_m{};  ///< of the probabilities; empty = steps that show all tasks
  Format format = Format::table;
  std::string plot;  ///< .svg, .pdf or .png
  std::string out;   ///< "" = stdout
};

/// Keys of [conditions] that are about other figures.
bool is_of_ranges(std::string_view key) { return key != "range" && key != "elevation" && key != "signal_contrast"; }

/// "1:10:10 km" or "1,2,5 km", in m.
std::vector<double> lengths(const std::string& option, const std::string& text) {
  const std::size_t end = text.find_last_not_of("abcdefghijklmnopqrstuvwxyz") + 1;
  try {
    std::vector<double> values = frequency_list(option, text.substr(0, text.find_last_not_of(' ', end - 1) + 1));
    const double unit_m = mtf::convert(mtf::parse_quantity("1" + text.substr(end), mtf::Dimension::length), "m");
    for (double& value : values) {
      value *= unit_m;
      if (!(value > 0.0)) throw mtf::UsageError(option + ": ranges are above 0");
    }
    constexpr std::size_t kMost = 10000;
    if (values.size() > kMost)
      throw mtf::UsageError(option + ": more than " + std::to_string(kMost) + " ranges; each takes a millisecond");
    if (!std::is_sorted(values.begin(), values.end())) throw mtf::UsageError(option + ": ranges rise");
    return values;
  } catch (const mtf::UsageError& wrong) {
    const std::string what = wrong.what();
    throw mtf::UsageError((what.starts_with(option) ? "" : option + ": ") + what +
                          "; write START:STOP:COUNT or a list, and a unit, such as '1:10:10 km'");
  }
}

/// Keys of [conditions] in a message, as the options that they are here.
std::string in_options(std::string text) {
  const auto replace = [&](const std::string& key, const std::string& option) {
    const auto goes_on = [&](std::size_t at) {  // within a longer name, as "mrtd.frame_rate"
      return at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) != 0 || text[at - 1] == '.' ||
                        text[at - 1] == '_' || text[at - 1] == '-');
    };
    for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + option.size()))
      if (!goes_on(at)) text.replace(at, key.size(), option);
  };
  const radiometry::Conditions keys;
  radiometry::for_each_field(keys, [&](const radiometry::FieldInfo& info, const auto&) {
    const std::string key(info.name);
    replace("[conditions] " + key, option_of(key));
    if (key.find('_') != std::string::npos) replace(key, option_of(key));
  });
  return text;
}

radiometry::Conditions conditions_of(const RangeOptions& options) {
  radiometry::Conditions conditions;
  if (options.target) {
    conditions.target_size_m = options.target->size_m;
    conditions.contrast_k = options.target->contrast_k;
  }
  set_keys(conditions, options.given);
  if (conditions.contrast_k == 0.0)
    throw mtf::UsageError(
        "--contrast: a target as warm as its background shows nothing, at no range; give the "
        "difference, such as --contrast '2 K'");
  if (conditions.contrast_k && *conditions.contrast_k < 0.0)
    throw mtf::UsageError(
        "--contrast: give the size of the difference, above 0; the models are the same for targets "
        "that are colder than their background");
  try {
    radiometry::require_valid("", conditions);
  } catch (const mtf::UsageError& wrong) {
    std::string text = "\n" + std::string(wrong.what());  // each line begins with "." and its key
    for (std::size_t at = text.find("\n."); at != std::string::npos; at = text.find("\n.", at + 1))
      text.replace(at + 1, 1, "[conditions] ");
    throw mtf::UsageError(in_options(text.substr(1)));
  }
  if (conditions.magnification && (conditions.display_height_m || conditions.viewing_distance_m))
    throw mtf::UsageError("--magnification: given together with a display, from which it follows; remove one of them");
  if (conditions.display_height_m.has_value() != conditions.viewing_distance_m.has_value())
    throw mtf::UsageError(conditions.display_height_m ? "--display-height: needs --viewing-distance beside it"
                                                      : "--viewing-distance: needs --display-height beside it");
  return conditions;
}

/// Throws UsageError with all that ranges of any sensor need and that neither the options nor the file say.
void require_given(const radiometry::Conditions& conditions, const mtf::io::SensorConfig& config) {
  std::vector<std::string> missing;
  const auto need = [&](bool given, const char* text) {
    if (!given) missing.emplace_back(text);
  };
  need(conditions.contrast_k.has_value(), "a contrast of the target (--contrast '2 K', or --target nato)");
  need(conditions.target_size_m.has_value(),
       "a size of the target (--target-size '2.3 m', the square root of its area, or --target nato)");
  const radiometry::SensorSettings settings =
      at_its_place(config, [&] { return radiometry::sensor_settings(config.tables); });
  const mtf::System<double>& system = config.system;
  const bool thermal = settings.thermal.has_value();
  need(thermal || system.frame.integration_time_s > 0.0, "[frame] integration_time = \"10 ms\"");
  need(!thermal || conditions.frame_rate_hz || (settings.frame && settings.frame->frame_time_s),
       "[frame] frame_time = \"33 ms\" (or --frame-rate)");
  need(mtf::f_number_of<double>({}, system.context()) > 0.0, "[optics] f_number = 2.0");
  need(system.band.has_value(), "[band] wavelength = [\"3.4 um\", \"4.8 um\"]");
  need(has_chain(config), "[detector] quantum_efficiency = 0.75 (mtf config kinds detector shows its keys)");
  need(!settings.atmosphere || settings.atmosphere->range_m || settings.atmosphere->zenith_deg,
       "[atmosphere] range = \"2 km\"");
  if (!missing.empty())
    throw mtf::UsageError("ranges need what neither the options nor " + config.file + " say: " + joined(missing, "; "));
}

study::Acquisition acquired(const mtf::io::SensorConfig& config, const radiometry::Conditions& conditions,
                            const std::vector<double>& range_m, int steps) {
  try {
    study::Acquisition found = study::acquisition(config, conditions, range_m, 1e-4, steps);
    for (study::TaskRange& task : found.tasks) task.reason = in_options(task.reason);
    return found;
  } catch (const mtf::UsageError& refused) {
    throw mtf::UsageError(placed(config, in_options(refused.what())));
  }
}

/// Every so many of the ranges, the first one among them.
void keep_every(std::size_t steps, study::Acquisition& found) {
  const auto thin_out = [&](std::vector<double>& values) {
    for (std::size_t r = 0; r * steps < values.size(); ++r) values[r] = values[r * steps];
    values.resize((values.size() + steps - 1) / steps);
  };
  thin_out(found.range_m);
  for (study::TaskRange& task : found.tasks)
    for (auto* values : {&task.probability, &task.probability_error, &task.probability_sd}) thin_out(*values);
}

int run_range(const RangeOptions& options, const Global& global) {
  const radiometry::Conditions conditions = conditions_of(options);
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  require_given(conditions, config);
  std::vector<std::string> files{options.out};
  for (std::string& file : figure_files(options.plot)) files.push_back(std::move(file));
  OutputSet outputs({.files = files, .inputs = files_of(config)});
  // For each range of the table, so that curves look like curves.
  constexpr int kSteps = 5;
  const int steps = options.plot.empty() || !options.range_m.empty() ? 1 : kSteps;
  study::Acquisition found = acquired(config, conditions, options.range_m, steps);
  if (!options.range_m.empty() && found.range_m.empty())
    throw mtf::UsageError(
        "--ranges: " + (found.cautions.empty() ? std::string("none can be") : found.cautions.front()) +
        "; ask for others");
  if (!options.plot.empty()) {
    const std::string title = config.system.name.empty() ? config.file : config.system.name;
    const bool drawn = write_figure(outputs.at(options.plot), range_figure(found, one_line(title)));
    note(global, figure_note(options.plot, drawn));
    keep_every(static_cast<std::size_t>(steps), found);
  }
  if (options.format != Format::table)
    for (const std::string& caution : found.cautions) note(global, "caution: " + one_line(caution));
  if (options.format == Format::csv)
    for (const std::string& line : found.lines) note(global, "note: " + one_line(line));
  outputs.commit(options.out, options.format == Format::csv    ? range_csv(found)
                              : options.format == Format::json ? range_json(found, conditions, config)
                                                               : range_table(found, conditions));
  return 0;
}

}  // namespace

Command range_command() {
  Command app{
      "range", "how far a sensor detects, recognises and identifies a target",
      "Ranges and probability against range by TTP (NVThermIP) and by Johnson's criteria (MRTD of FLIR92), each with\n"
      "its error. Target and contrast have to be given; TTP needs what the observer looks at too: --display-height "
      "and\n"
      "--viewing-distance, or --magnification. The air is that of the sensor file ([atmosphere], or path.table), up "
      "to\n"
      "each range, or --extinction. Numbers that the sensor file states as { value, stderr } give each range a\n"
      "standard deviation. --target nato is the target of STANAG 4347: 2.3 m x 2.3 m, 2 K.",
      "  mtf range sensor.toml --target nato --magnification 5\n"
      "  mtf range sensor.toml --contrast '1 K' --target-size '3 m' --extinction 0.2 --format csv -o range.csv"};
  auto& options = options_of<RangeOptions>(app, run_range);
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_choice(app, "--target", "NAME", "standard target, whose size and contrast other options replace: nato",
             kStandardTargets, options.target);
  add_keys(app, radiometry::Conditions{}, options.given, is_of_ranges);
  add_value(app, "--ranges", "LIST",
            "of the probabilities, such as '1:10:10 km' (START:STOP:COUNT) or '1,2,5 km'; default: round lengths "
            "that show all tasks",
            options.range_m, lengths);
  add_text(app, "--plot", "FILE", "figure of probability against range: a .svg, .pdf or .png file", options.plot);
  add_format(app, "table (default), csv (probabilities) or json (all)", options.format);
  add_text(app, "-o,--out", "FILE", "write the result here instead of standard output", options.out);
  return app;
}

}  // namespace apps
