// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/fit_outputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/edges/fit_parameters.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"

namespace apps {
namespace {

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

}  // namespace

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

std::string fit_json(const FitResult& result, const mtf::io::SensorConfig& sensor,
                     const std::vector<std::string>& inputs) {
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
  return json_document(json, -1);
}

std::vector<Figure> fit_figures(const FitResult& result, const std::vector<MeasuredEdge>& measured) {
  constexpr std::size_t kMost = 5;  // more lines would hide each other
  constexpr double kSameDirection_deg = 5.0;
  Figure mtf, difference;
  mtf.title = "fitted MTF" + (result.mtf50 ? ", MTF50 " + fixed(result.mtf50->value, 4) + " cy/px" : std::string());
  mtf.x_label = difference.x_label = "spatial frequency [cycles/pixel]";
  mtf.y_label = "MTF along the first edge's normal";
  difference.y_label = "measured - fitted, with 2 sd";
  Series fitted{.name = "fitted, 2 sd", .x = result.frequency_cy_px, .y = result.mtf, .emphasised = true};
  for (std::size_t i = 0; i < result.mtf_sd.size(); ++i) {
    fitted.low.push_back(result.mtf[i] - 2.0 * result.mtf_sd[i]);
    fitted.high.push_back(result.mtf[i] + 2.0 * result.mtf_sd[i]);
  }
  mtf.series.push_back(std::move(fitted));
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
    Series series{.name = name, .x = edge.frequency_cy_px};
    for (std::size_t k = 0; k < edge.mtf.size(); ++k) {
      series.y.push_back(edge.mtf[k] - result.mtf[k]);
      series.low.push_back(series.y[k] - 2.0 * edge.mtf_sd[k]);
      series.high.push_back(series.y[k] + 2.0 * edge.mtf_sd[k]);
    }
    difference.series.push_back(std::move(series));
  }
  std::vector<Figure> figures{std::move(mtf)};
  if (!difference.series.empty()) figures.push_back(std::move(difference));
  return figures;
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
    calib::set_parameter(fitted.system, p.parameter.path, p.value);
    const auto spec = std::find_if(fitted.fits.begin(), fitted.fits.end(),
                                   [&](const mtf::io::FitSpec& fit) { return fit.path == p.parameter.path; });
    if (spec == fitted.fits.end()) continue;
    values[static_cast<std::size_t>(spec - fitted.fits.begin())] = p.value;
    spec->stderr_value = p.knowledge == Knowledge::determined ? p.stderr_value : std::nullopt;
  }
  // The user's own text with the new numbers, where that says the same; curve files are named relative to it.
  const std::string whole = write_config(fitted, destination);
  const std::string own = without_fit_head(splice_fits(fitted, values));
  const mtf::io::ConfigResult read = mtf::io::parse_config(own, destination.empty() ? sensor.file : destination);
  return head + (read.ok() && write_config(read.config, destination) == whole ? own : whole);
}

}  // namespace apps
