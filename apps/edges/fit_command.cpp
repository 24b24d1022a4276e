// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/fit_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>

#include "apps/arguments.h"
#include "apps/config_command.h"
#include "apps/edges/edge_measure.h"
#include "apps/edges/fit_parameters.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/schedule.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/curve_samples.h"
#include "mtf/io/image_io.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"
#include "mtf/work/stop.h"

namespace apps {
namespace {

using mtf::io::SensorConfig;

/// The sensor of one image after the other; a new one only where a line of the conditions says so.
class Conditions {
 public:
  Conditions(const std::string& file, const SensorConfig& sensor) : systems_{sensor.system} {
    if (file.empty()) return;
    mtf::io::Schedule schedule = mtf::io::read_schedule(file, sensor);
    if (!schedule.settings.empty()) last_ = schedule.settings.back().frame;
    scheduled_.emplace(sensor, std::move(schedule));
  }
  /// Throws UsageError when a line is for an image that there is not.
  void require_within(std::size_t images, const std::string& file) const {
    if (last_ > static_cast<std::int64_t>(images))
      throw mtf::UsageError(one_line(file) + ": has a line for image " + std::to_string(last_) + ", there are " +
                            std::to_string(images) + "; frames count the images of the command line from 1");
  }
  /// Index of the sensor of the next image.
  std::size_t next() {
    if (scheduled_ && scheduled_->advance(++image_)) systems_.push_back(scheduled_->sensor().system);
    return systems_.size() - 1;
  }
  std::vector<mtf::System<double>> take() { return std::move(systems_); }

 private:
  std::vector<mtf::System<double>> systems_;
  std::optional<mtf::io::ScheduledSensor> scheduled_;
  std::int64_t image_ = 0, last_ = 0;
};

/// "jitter.rms" for "presample[1].rms": components by their labels.
std::string readable_name(const mtf::System<double>& system, const std::string& path) {
  for (const mtf::Stage stage : mtf::kStages)
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const std::string owner = std::string(stage_name(stage)) + "[" + std::to_string(i) + "].";
      if (path.starts_with(owner)) return system.list(stage)[i].label + "." + path.substr(owner.size());
    }
  return path;
}

/// "FILE@DEGREES" or "FILE" of --curve.
struct CurveWord {
  std::string file;
  double angle_deg = 0.0;
};
CurveWord curve_word(const std::string& word) {
  const std::size_t at = word.rfind('@');
  if (at == std::string::npos || word.find('/', at) != std::string::npos) return {word, 0.0};
  return {word.substr(0, at), number("--curve " + one_line(word) + ": the angle", word.substr(at + 1))};
}

/// A list of values, such as numbers and null.
bool is_column(const Json& json) {
  return json.is_array() && !json.empty() &&
         std::ranges::none_of(json.elements(), [](const Json& e) { return e.is_array() || e.is_object(); });
}

/// Name of a column of a CSV line, in which a comma between quotes separates nothing.
std::string column_name(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return std::string_view("\"#,;\t\r\n").find(c) != std::string_view::npos; }, ' ');
  return "\"" + name + "\"";
}

/// Curves of a table of JSON. What is wrong is said of it, not of the lines that it is read as: of an element, counted
/// from 0, for line 2 and those below.
std::vector<mtf::io::CurveSamples> json_curves(const std::string& text, const std::string& where) try {
  return mtf::io::parse_curve_samples(text, where);
} catch (const mtf::UsageError& error) {
  std::string_view what = error.what();
  if (!what.starts_with(where + ":")) throw;
  what.remove_prefix(where.size() + 1);
  const auto line = mtf::io::cell_number<std::size_t>(what.substr(0, what.find(':')));
  if (!line) throw;
  what.remove_prefix(what.find(':') + 2);
  if (*line > 1)
    throw mtf::UsageError(where + ", element " + std::to_string(*line - 2) + " of its lists: " + std::string(what));
  throw mtf::UsageError(where + ": " + std::string(what.substr(0, what.find("; write the first line"))) +
                        "; call its lists like this: frequency_cy_px, MTF");
}

/// Curves in the JSON of other programs, such as Imatest: lists of one length that stand in one object, wherever it is,
/// are the columns of a table by their names, "Cy/Pxl": [...], "MTF_Y": [...]. A unit may stand beside them,
/// "frequency_units": "cy/px", else it is `unit`. Tables without a frequency and an MTF are passed by.
void add_json_curves(const Json& json, const std::string& where, std::string unit,
                     std::vector<mtf::io::CurveSamples>& curves) {
  if (json.is_array())
    for (std::size_t i = 0; i < json.size(); ++i)
      add_json_curves(json[i], where + "[" + std::to_string(i) + "]", unit, curves);
  if (!json.is_object()) return;
  std::map<std::size_t, std::vector<std::pair<std::string, const Json*>>> tables;  // by the length of their columns
  for (const auto& [name, value] : json.items()) {
    add_json_curves(value, where + "." + mtf::printable(name, 40), unit, curves);
    if (is_column(value)) tables[value.size()].emplace_back(name, &value);
  }
  for (const auto& [name, value] : json.items())
    if (mtf::lower_case(name).starts_with("freq") && value.is_string()) unit = value.get<std::string>();
  for (const auto& [length, columns] : tables) {
    std::string text;
    for (const auto& [name, list] : columns) {
      const std::string word = mtf::lower_case(name);
      const bool is_bare = !unit.empty() && (word == "frequency" || word == "freq");
      mtf::io::append_word(text, column_name(name + (is_bare ? " (" + unit + ")" : "")), ',');
    }
    if (!mtf::io::is_curve_header(text)) continue;
    for (std::size_t row = 0; row < length; ++row) {
      std::string line;
      for (const auto& [name, list] : columns) {
        const Json& cell = (*list)[row];
        mtf::io::append_word(line, cell.is_number() ? mtf::format_double(cell.get<double>()) : "null", ',');
      }
      text += "\n" + line;
    }
    for (mtf::io::CurveSamples& curve : json_curves(text, where)) {
      curve.name = where.substr(where.find(": ") + 2) + " " + curve.name;
      curves.push_back(std::move(curve));
    }
  }
}

/// Of a text that is no JSON the place is said.
Json json_of(const std::string& text, const std::string& name) try {
  return parse_json(text);
} catch (const mtf::UsageError& error) {
  throw mtf::UsageError(name + ": is no JSON: " + mtf::printable(error.what()) + "; export it anew");
}

/// True where data of that file and place in it were added before, by whatever name.
bool is_again(LoadedData& loaded, const std::string& file, const std::string& place) {
  std::error_code failed;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(file, failed);
  return !loaded.seen.insert((failed ? file : whole.string()) + "\n" + place).second;
}
void warn_of_again(LoadedData& loaded, const std::string& name) {
  loaded.warnings.push_back(name + " is given twice: its noise counts as independent; leave one of them out");
}

/// All curves of a file; `sd` for those that do not say it themselves.
void add_curves(LoadedData& loaded, const std::string& word, double sd, const std::string& unit) {
  const CurveWord parts = curve_word(word);
  const std::string text = mtf::io::read_table_text(parts.file), name = one_line(parts.file);
  if (is_again(loaded, parts.file, "curves")) warn_of_again(loaded, name);
  std::vector<mtf::io::CurveSamples> curves;
  if (!mtf::lower_case(name).ends_with(".json"))
    curves = mtf::io::parse_curve_samples(text, parts.file, mtf::find_unit(unit));
  else
    add_json_curves(json_of(text, name), name + ": $", unit, curves);
  if (curves.empty())
    throw mtf::UsageError(name + ": no JSON with lists of a frequency (frequency_cy_px, Cy/Pxl) and of an MTF (MTF, " +
                          "SFR, MTF_Y) in one object; rename them, or export a CSV");
  for (const mtf::io::CurveSamples& samples : curves) {
    calib::CurveData data;
    data.name = one_line(parts.file) + (samples.name.empty() ? "" : " " + samples.name);
    data.angle_deg = parts.angle_deg;
    data.unit = samples.unit;
    data.frequency = samples.frequency;
    data.mtf = samples.mtf;
    data.sd = samples.sd.empty() ? std::vector{sd} : samples.sd;
    loaded.data.curves.push_back(std::move(data));
  }
  loaded.files.push_back(parts.file);
}

void add_remarks(LoadedData& loaded, const EdgePlane& plane) {
  if (!plane.warning.empty()) loaded.warnings.push_back(plane.warning);
  loaded.warnings.insert(loaded.warnings.end(), plane.notes.begin(), plane.notes.end());
}

/// A single set of data that cannot be read is an error; of several it is left out with a warning.
template <class Load>
void load_or_leave_out(LoadedData& loaded, std::size_t sets, const Load& load) {
  try {
    load();
  } catch (const mtf::Stopped&) {
    throw;
  } catch (const mtf::Error& error) {
    if (sets == 1) throw;
    loaded.warnings.push_back(std::string(error.what()) + " (left out)");
    ++loaded.left_out;
  }
}

/// Loads and measures. One of several that cannot be read is left out with a warning. Throws as load_edge_planes.
LoadedData load_fit_data(const FitOptions& options, const SensorConfig& sensor, int threads) {
  LoadedData loaded;
  Conditions conditions(options.conditions, sensor);
  const std::size_t images = options.input.images.size() + options.spots.size();
  const std::size_t sets = images + options.curves.size();
  conditions.require_within(images, options.conditions);
  for (const std::string& image : options.input.images) {
    const std::size_t condition = conditions.next();
    load_or_leave_out(loaded, sets, [&] {
      for (EdgePlane& plane : load_edge_planes(image, options.input))
        add_edges(loaded, std::move(plane), condition, threads);
      loaded.files.push_back(image);
    });
  }
  for (const std::string& image : options.spots) {
    const std::size_t condition = conditions.next();
    load_or_leave_out(loaded, sets, [&] {
      for (EdgePlane& plane : load_edge_planes(image, options.input, Regions::none))
        add_spot(loaded, std::move(plane), condition);
      loaded.files.push_back(image);
    });
  }
  for (const std::string& word : options.curves)
    load_or_leave_out(loaded, sets, [&] { add_curves(loaded, word, options.curve_sd, options.curve_unit); });
  loaded.data.conditions = conditions.take();
  return loaded;
}

// The results.

using calib::FitResult;
using calib::FittedParameter;
using calib::Knowledge;

std::string shown(const calib::Estimate& e) { return shown_with_error(e.value, e.sd) + " +- " + significant(e.sd, 2); }

Json optional_json(const std::optional<calib::Estimate>& value) {
  return value ? Json{{"value", value->value}, {"sd", value->sd}} : Json();
}

/// The direction of FitResult::mtf.
double direction_deg(const FitResult& result) {
  for (const calib::FitResiduals& data : result.data)
    if (data.contrast.value != 0.0) return std::remainder(data.curve.angle_rad * 180.0 / std::numbers::pi, 180.0);
  return 0.0;
}
std::string direction_of(const FitResult& result) {
  const bool edge = std::any_of(result.data.begin(), result.data.end(),
                                [](const calib::FitResiduals& data) { return data.contrast.value != 0.0; });
  return edge ? "the first edge's normal (" + fixed(direction_deg(result), 2) + " deg)" : "x";
}

Json provenance(const mtf::io::SensorConfig& sensor, const std::vector<std::string>& inputs) {
  Json json{{"sensor", sensor.file}, {"config_sha256", sensor.sha256}, {"data", Json::array()}};
  for (const std::string& input : inputs)
    json["data"].push_back({{"file", input}, {"sha256", mtf::io::sha256_file(input)}});
  return json;
}

/// What every richer model makes of parameter i, whether it matters or not.
Json sensitivity_json(const FitResult& result, std::size_t i) {
  Json all = Json::array();
  const Json now = parameter_json(result.parameters[i]);
  for (const calib::RicherModel& model : result.richer_models) {
    const Json then = parameter_json(model.parameters[i]);
    Json one{{"unknown", model.unknown}};
    for (const char* const field : {"value", "stderr", "knowledge", "interval95"}) one[field] = then[field];
    const bool known = !now["value"].is_null() && !then["value"].is_null();
    one["moves_by"] = known ? Json(model.parameters[i].value - result.parameters[i].value) : Json();
    all.push_back(std::move(one));
  }
  return all;
}

/// MTF of the fitted system with its band beside the measured ones, and their difference.
std::vector<Figure> fit_figures(const FitResult& result, const std::vector<MeasuredEdge>& measured) {
  constexpr std::size_t kMost = 5;  // more lines would hide each other
  constexpr double kSameDirection_deg = 5.0;
  Figure mtf, difference;
  mtf.title = "fitted MTF" + (result.mtf50 ? ", MTF50 " + fixed(result.mtf50->value, 4) + " cy/px" : std::string());
  mtf.x_label = difference.x_label = "spatial frequency [cycles/pixel]";
  mtf.y_label = "MTF along the first edge's normal";
  difference.y_label = "measured - fitted, with 2 sd";
  mtf.series.push_back(with_band("fitted, 2 sd", result.frequency_cy_px, result.mtf, result.mtf_sd));
  mtf.y_low = 0.0;
  mtf.vertical_lines.push_back({0.5, "Nyquist"});
  for (std::size_t i = 0; i < measured.size() && mtf.series.size() <= kMost; ++i) {
    const calib::EdgeMeasurement& edge = measured[i].edge;
    if (edge.trouble != calib::Trouble::none || edge.mtf.size() != result.mtf.size()) continue;
    // The fitted curve is of the first edge's direction: others differ from it by right.
    if (std::abs(std::remainder(edge.angle_deg.value - direction_deg(result), 180.0)) > kSameDirection_deg) continue;
    const std::string name = "edge " + std::to_string(i + 1);
    mtf.series.push_back({.name = name, .x = edge.frequency_cy_px, .y = edge.mtf});
    if (!difference.series.empty()) continue;
    std::vector<double> less(edge.mtf.size());
    std::ranges::transform(edge.mtf, result.mtf, less.begin(), std::minus<>());
    difference.series.push_back(with_band(name, edge.frequency_cy_px, less, edge.mtf_sd));
    difference.series.back().emphasised = false;
  }
  std::vector<Figure> figures{std::move(mtf)};
  if (!difference.series.empty()) figures.push_back(std::move(difference));
  return figures;
}

// The command.

std::vector<std::string> outputs_of(const FitOptions& options) {
  std::vector<std::string> outputs{options.out, options.report};
  for (std::string& file : figure_files(options.plot)) outputs.push_back(std::move(file));
  std::erase(outputs, "");
  return outputs;
}

std::vector<std::string> inputs_of(const FitOptions& options, const mtf::io::SensorConfig& sensor) {
  std::vector<std::string> inputs = files_of(sensor);
  for (const std::string& file : files_of(options.input)) inputs.push_back(file);
  inputs.insert(inputs.end(), options.spots.begin(), options.spots.end());
  if (!options.conditions.empty()) inputs.push_back(options.conditions);
  for (const std::string& curve : options.curves) inputs.push_back(curve_word(curve).file);
  return inputs;
}

/// One file an edge or spot, in standard deviations of a pixel.
void write_residuals(OutputSet& outputs, const calib::FitResult& result) {
  int number = 0;
  for (const calib::FitResiduals& data : result.data) {
    if (data.residual.size() == 0) continue;
    mtf::io::Metadata metadata;
    metadata.text["mtf:quantity"] = "residual / sd";
    metadata.history = {"mtf fit: " + one_line(data.name)};
    mtf::io::write_exr(outputs.in("residual-" + std::to_string(++number) + ".exr"), {{"Y", data.residual.view()}},
                       metadata);
  }
}

}  // namespace

void add_edges(LoadedData& loaded, EdgePlane made, std::size_t condition, int threads) {
  const EdgePlane& plane = loaded.planes.emplace_back(std::move(made));
  add_remarks(loaded, plane);
  std::vector<MeasuredEdge> measured = measure_plane(plane, {}, threads);
  std::vector<std::string> again;
  for (MeasuredEdge& edge : measured) {
    const calib::Roi& roi = edge.edge.roi;
    loaded.data.edges.push_back({.name = one_line(plane.image) + (plane.channel.empty() ? "" : " " + plane.channel) +
                                         " " + std::to_string(roi.x) + "," + std::to_string(roi.y) + "," +
                                         std::to_string(roi.width) + "," + std::to_string(roi.height),
                                 .image = plane.plane.view(),
                                 .roi = roi,
                                 .condition = condition,
                                 .start = edge.edge,
                                 .quantum = plane.options.quantum,
                                 .saturation = plane.options.saturation,
                                 .floor = plane.options.floor});
    const std::string& name = loaded.data.edges.back().name;
    if (is_again(loaded, plane.image, name.substr(one_line(plane.image).size()))) again.push_back(name);
    loaded.measured.push_back(std::move(edge));
  }
  if (!again.empty())
    warn_of_again(loaded,
                  again.front() + (again.size() > 1 ? ", with " + std::to_string(again.size() - 1) + " more," : ""));
}

void add_spot(LoadedData& loaded, EdgePlane made, std::size_t condition) {
  const EdgePlane& plane = loaded.planes.emplace_back(std::move(made));
  add_remarks(loaded, plane);
  if (is_again(loaded, plane.image, "spot " + plane.channel)) warn_of_again(loaded, one_line(plane.image));
  loaded.data.spots.push_back({.name = one_line(plane.image),
                               .image = plane.plane.view(),
                               .roi = {0, 0, plane.plane.width(), plane.plane.height()},
                               .condition = condition,
                               .saturation = plane.options.saturation,
                               .floor = plane.options.floor});
}

std::vector<calib::FitParameter> fit_parameters(const SensorConfig& sensor) {
  std::vector<calib::FitParameter> parameters;
  for (const mtf::io::FitSpec& spec : sensor.fits)
    if (spec.fit)
      parameters.push_back({.path = spec.path,
                            .name = readable_name(sensor.system, spec.path),
                            .unit = spec.unit,
                            .min = spec.min,
                            .max = spec.max,
                            .prior = spec.prior});
  if (parameters.empty())
    throw mtf::UsageError(one_line(sensor.file) +
                          ": nothing to fit: write a number of a component as a table, such as\n"
                          "  rms = { value = \"8 urad\", fit = true, min = \"0 urad\", max = \"50 urad\" }");
  return parameters;
}

std::string fit_table(const FitResult& result) {
  std::string text =
      std::string(status_name(result.status)) + (result.reason.empty() ? "" : ": " + result.reason) + "\n";
  text += parameters_table(result.parameters, result.not_separable, result.correlation, result.alternatives,
                           result.richer_models);
  text += "\n";
  if (result.mtf50) {
    text += "MTF50                " + shown(*result.mtf50) + " cy/px along " + direction_of(result) + "\n";
    for (const calib::RicherModel& model : result.richer_models)
      if (model.mtf50 && matters(*result.mtf50, *model.mtf50))
        text += "                     " + shown(*model.mtf50) + " cy/px with unknown " + model.unknown + "\n";
  }
  if (result.equivalent_variance_px2)
    text += "equivalent variance  " + shown(*result.equivalent_variance_px2) + " px^2\n";
  if (result.status != calib::FitStatus::no_data)
    text += "chi2 per dof         " + significant(result.chi2_per_dof, 4) +
            "\nresiduals as noise   p = " + significant(result.whiteness_p, 2) + "\n";
  for (const calib::FitResiduals& data : result.data)
    text += "  " + one_line(data.name) + ": " + std::to_string(data.count) + " values, chi2 per dof " +
            significant(data.chi2_per_dof, 4) + ", p = " + significant(data.whiteness_p, 2) +
            (data.outlier_share > 0.0 ? ", outliers " + significant(100.0 * data.outlier_share, 2) + " %" : "") + "\n";
  for (const std::string& warning : result.warnings) text += "warning: " + warning + "\n";
  return text;
}

Json fit_report(const FitResult& result, const mtf::io::SensorConfig& sensor, const std::vector<std::string>& inputs) {
  Json json{{"version", mtf::version}, {"status", status_name(result.status)}};
  json["reason"] = text_or_null(result.reason);
  json["warnings"] = result.warnings;
  add_parameters(json, result.parameters, result.not_separable, result.correlation);
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    json["parameters"][i]["model_sensitivity"] = sensitivity_json(result, i);
  json["alternatives"] = Json::array();
  for (const calib::Alternative& one : result.alternatives) {
    Json names = Json::array();
    for (const std::size_t i : one.parameters) names.push_back(result.parameters[i].parameter.name);
    json["alternatives"].push_back(
        {{"parameters", names}, {"values", one.values}, {"chi2_rise", one.chi2_rise}, {"text", one.text}});
  }
  json["richer_models"] = Json::array();
  for (const calib::RicherModel& model : result.richer_models)
    json["richer_models"].push_back({{"unknown", model.unknown},
                                     {"chi2_gain", model.chi2_gain},
                                     {"p", model.p},
                                     {"parameter", parameter_json(model.parameters.back())},
                                     {"mtf50", optional_json(model.mtf50)}});
  json["equivalent_variance_px2"] = optional_json(result.equivalent_variance_px2);
  json["chi2_per_dof"] = result.chi2_per_dof;
  json["whiteness_p"] = result.whiteness_p;
  json["unit"] = "cycles/pixel";
  json["angle_deg"] = direction_deg(result);
  json["mtf"] = {{"frequency", result.frequency_cy_px}, {"value", result.mtf}, {"sd", result.mtf_sd}};
  json["mtf50"] = optional_json(result.mtf50);
  json["residual_otf"] = result.residual_otf.empty()
                             ? Json()
                             : Json{{"frequency", result.frequency_cy_px}, {"value", result.residual_otf}};
  json["data"] = Json::array();
  for (const calib::FitResiduals& data : result.data)
    json["data"].push_back({{"name", data.name},
                            {"count", data.count},
                            {"chi2_per_dof", data.chi2_per_dof},
                            {"whiteness_p", data.whiteness_p},
                            {"outlier_share", data.outlier_share},
                            {"contrast", {{"value", data.contrast.value}, {"sd", data.contrast.sd}}}});
  json["iterations"] = result.iterations;
  json["starts_agreeing"] = result.starts_agreeing;
  json["provenance"] = provenance(sensor, inputs);
  return json;
}

std::string fitted_config(const FitResult& result, const mtf::io::SensorConfig& sensor,
                          const std::vector<std::string>& inputs, const std::string& destination) {
  mtf::io::SensorConfig fitted = sensor;
  const std::string head =
      fit_head({sensor.file, sensor.sha256,
                std::string(status_name(result.status)) + ", chi2 per dof " + significant(result.chi2_per_dof, 4)},
               inputs, result.parameters, result.not_separable, result.richer_models);
  std::vector<std::optional<double>> values(fitted.fits.size());
  for (const FittedParameter& p : result.parameters) {
    const auto sd = p.knowledge == Knowledge::determined ? p.stderr_value : std::nullopt;
    const double value = p.knowledge == Knowledge::at_bound ? p.value
                                                            : std::clamp(rounded_to_error(p.value, sd.value_or(0.0)),
                                                                         p.parameter.min.value_or(-mtf::kInfinity),
                                                                         p.parameter.max.value_or(mtf::kInfinity));
    calib::set_parameter(fitted.system, p.parameter.path, value);
    for (mtf::SettingsTable& table : fitted.tables)  // the optical axis
      for (mtf::GivenSetting& setting : table.settings)
        if (p.parameter.path == std::string(table.name) + "." + std::string(setting.name)) setting.value = value;
    const auto spec = std::find_if(fitted.fits.begin(), fitted.fits.end(),
                                   [&](const mtf::io::FitSpec& fit) { return fit.path == p.parameter.path; });
    if (spec == fitted.fits.end()) continue;
    values[static_cast<std::size_t>(spec - fitted.fits.begin())] = value;
    spec->stderr_value = sd ? std::optional(rounded_to_error(*sd, *sd)) : std::nullopt;
  }
  // The user's own text with the new numbers, where that says the same; curve files are named relative to it.
  const std::string whole = write_config(fitted, destination);
  const std::string own = without_fit_head(splice_fits(fitted, values));
  const mtf::io::ConfigResult read =
      mtf::io::parse_config(own, destination.empty() ? sensor.file : destination, sensor.schema);
  return head + (read.ok() && write_config(read.config, destination) == whole ? own : whole);
}

int run_fit(const FitOptions& options, const Global& global) {
  const mtf::io::SensorConfig sensor = load_sensor(options.sensor, global);
  OutputSet outputs({.folder = options.residuals,
                     .force = options.force,
                     .files = outputs_of(options),
                     .inputs = inputs_of(options, sensor)});
  if (options.input.images.empty() && options.curves.empty() && options.spots.empty())
    throw mtf::UsageError("fit: no data; name images of edges, or give --curve or --spot");
  const std::vector<calib::FitParameter> parameters = fit_parameters(sensor);

  calib::FitResult result;
  LoadedData loaded;
  {
    ProgressLine progress(global);
    progress.update("measuring", 0.0);
    loaded = load_fit_data(options, sensor, global.threads);
    const calib::FitOptions how{.robust = options.robust,
                                .starts = options.starts,
                                .profile = options.profile,
                                .residual_otf = options.residual_otf,
                                .richer_models = true,
                                .threads = global.threads,
                                .progress = [&](double share) {
                                  progress.update("fitting", share);
                                  return true;
                                }};
    result = calib::fit(loaded.data, parameters, how);
  }
  result.warnings.insert(result.warnings.begin(), loaded.warnings.begin(), loaded.warnings.end());

  const bool fitted =
      result.status == calib::FitStatus::converged || result.status == calib::FitStatus::converged_model_wrong;
  const std::string json = json_document(fit_report(result, sensor, loaded.files), -1);
  if (!options.report.empty()) emit(outputs.at(options.report), json);
  if (fitted) {
    if (!options.plot.empty()) {
      const bool drawn = write_figures(outputs.at(options.plot), fit_figures(result, loaded.measured));
      note(global, figure_note(options.plot, drawn));
    }
    if (!options.residuals.empty()) write_residuals(outputs, result);
    if (!options.out.empty()) emit(outputs.at(options.out), fitted_config(result, sensor, loaded.files, options.out));
  } else if (!options.out.empty()) {
    note(global, "mtf: note: not fitted: " + one_line(options.out) + " is not written");
  }
  outputs.commit();
  print(options.format == Format::json ? json : fit_table(result));
  if (!fitted || loaded.left_out > 0) return 1;
  if (result.status == calib::FitStatus::converged || options.allow_misfit) return 0;
  note(global,
       "mtf: note: the sensor does not describe the data: exit code 3; all outputs are written "
       "(--allow-misfit: exit code 0)");
  return 3;
}

}  // namespace apps
