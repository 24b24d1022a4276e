// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/fit_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/io/sha256.h"
#include "mtf/units.h"
#include "mtf/version.h"

namespace apps {
namespace {

using calib::FitResult;
using calib::FittedParameter;
using calib::Knowledge;
using Json = nlohmann::ordered_json;

bool has_value(const FittedParameter& p) {
  return p.knowledge == Knowledge::determined || p.knowledge == Knowledge::at_bound ||
         p.knowledge == Knowledge::interval;
}

/// As many digits as the standard error has, two more than its first.
std::string shown(double value, double sd) {
  if (!(sd > 0.0) || !std::isfinite(sd)) return significant(value, 6);
  const int digits = static_cast<int>(std::floor(std::log10(std::max(std::abs(value), sd) / sd))) + 2;
  return significant(value, std::clamp(digits, 2, 12), true);
}

std::string shown(const calib::Estimate& e) { return shown(e.value, e.sd) + " +- " + significant(e.sd, 2); }

std::string interval_text(const std::array<double, 2>& interval) {
  return significant(interval[0], 5) + " to " + significant(interval[1], 5);
}

/// 95 %, an open end in words.
std::string profiled_text(const calib::ProfiledInterval& interval) {
  if (interval.low && interval.high) return interval_text({*interval.low, *interval.high});
  if (interval.low) return "above " + significant(*interval.low, 5);
  return interval.high ? "below " + significant(*interval.high, 5) : "not bounded";
}

std::string value_text(const FittedParameter& p) {
  const std::string unit = p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
  if (p.knowledge == Knowledge::interval)
    return shown(p.value, 0.25 * ((*p.interval95)[1] - (*p.interval95)[0])) + unit +
           " (95 %: " + profiled_text(*p.interval) + unit + ")";
  if (p.knowledge == Knowledge::at_bound)
    return significant(p.value, 6) + unit + " (at its bound" +
           (p.limit95 ? std::string("; 95 %: at ") + (p.limit_is_upper ? "most " : "least ") +
                            significant(*p.limit95, 4) + unit
                      : std::string()) +
           ")";
  if (p.knowledge != Knowledge::determined) return std::string(knowledge_name(p.knowledge));
  return (p.stderr_value ? shown({p.value, *p.stderr_value}) : significant(p.value, 8)) + unit;
}

std::string correlation_table(const FitResult& result) {
  std::vector<std::string> header{"correlation"};
  for (const FittedParameter& p : result.parameters) header.push_back(one_line(p.parameter.name));
  const std::vector<Align> align = [&] {
    std::vector<Align> columns(header.size(), Align::right);
    columns.front() = Align::left;
    return columns;
  }();
  TextTable table(std::move(header));
  for (std::size_t i = 0; i < result.correlation.size(); ++i) {
    std::vector<std::string> row{one_line(result.parameters[i].parameter.name)};
    for (const double rho : result.correlation[i]) row.push_back(std::isfinite(rho) ? fixed(rho, 3) : "not determined");
    table.add(std::move(row));
  }
  return table.aligned(align);
}

Json optional_json(const std::optional<double>& value) { return value ? Json(*value) : Json(); }
Json optional_json(const std::optional<std::array<double, 2>>& value) { return value ? Json(*value) : Json(); }
Json optional_json(const std::optional<calib::Estimate>& value) {
  return value ? Json{{"value", value->value}, {"sd", value->sd}} : Json();
}

Json parameter_json(const FittedParameter& p) {
  const bool known = has_value(p);
  return {{"name", p.parameter.name},
          {"path", p.parameter.path},
          {"value", known ? Json(p.value) : Json()},
          {"stderr", known ? optional_json(p.stderr_value) : Json()},
          {"unit", p.parameter.unit},
          {"knowledge", knowledge_name(p.knowledge)},
          {"start", p.start},
          {"limit95", optional_json(p.limit95)},
          {"limit_is", p.limit95 ? Json(p.limit_is_upper ? "upper" : "lower") : Json()},
          {"interval68", optional_json(p.interval68)},
          {"interval95", optional_json(p.interval95)},
          {"interval", p.interval ? Json{{"confidence", 0.95},
                                         {"low", optional_json(p.interval->low)},
                                         {"high", optional_json(p.interval->high)},
                                         {"reason", p.interval->reason.empty() ? Json() : Json(p.interval->reason)}}
                                  : Json()}};
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

/// Without the lines that an earlier fit has put above, up to the empty one.
std::string without_head(const std::string& text) {
  const std::size_t line = text.find('\n');
  if (!text.starts_with("# ") || text.substr(0, line).find(") fitted by mtf ") == std::string::npos) return text;
  const std::size_t end = text.find("\n\n");
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace

std::string fit_table(const FitResult& result) {
  std::string text =
      std::string(status_name(result.status)) + (result.reason.empty() ? "" : ": " + result.reason) + "\n";
  if (!result.parameters.empty()) {
    TextTable table({"parameter", "value", "start"});
    for (const FittedParameter& p : result.parameters) {
      const std::string unit = p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
      table.add({one_line(p.parameter.name), value_text(p), significant(p.start, 6) + unit});
    }
    text += "\n" + table.aligned();
  }
  for (const FittedParameter& p : result.parameters) {
    if (p.interval68) text += one_line(p.parameter.name) + ": 68 % " + interval_text(*p.interval68);
    if (p.interval) text += ", 95 % " + profiled_text(*p.interval);
    if (p.interval68 || p.interval) text += p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
    if (p.interval) text += (p.interval->reason.empty() ? "" : "; " + p.interval->reason) + "\n";
  }
  for (const calib::NullDirection& direction : result.not_separable) text += "\n" + direction.text + "\n";
  if (result.parameters.size() > 1 && !result.correlation.empty()) text += "\n" + correlation_table(result);
  text += "\n";
  if (result.mtf50)
    text += "MTF50                " + shown(*result.mtf50) + " cy/px along " + direction_of(result) + "\n";
  if (result.equivalent_variance_px2)
    text += "equivalent variance  " + shown(*result.equivalent_variance_px2) + " px^2\n";
  text += "chi2 per dof         " + significant(result.chi2_per_dof, 4) + "\n";
  text += "structure left       p = " + significant(result.whiteness_p, 2) + "\n";
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
  json["reason"] = result.reason.empty() ? Json() : Json(result.reason);
  json["warnings"] = result.warnings;
  json["parameters"] = Json::array();
  for (const FittedParameter& p : result.parameters) json["parameters"].push_back(parameter_json(p));
  json["correlation"] = result.correlation;
  json["not_separable"] = Json::array();
  for (const calib::NullDirection& direction : result.not_separable) {
    Json names = Json::array();
    for (const std::size_t i : direction.parameters) names.push_back(result.parameters[i].parameter.name);
    json["not_separable"].push_back({{"parameters", names}, {"weight", direction.weight}, {"text", direction.text}});
  }
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
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
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
    Series series{.name = name, .x = edge.frequency_cy_px, .y = {}};
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
  std::string head = "# " + one_line(sensor.file) + " (sha256 " + sensor.sha256.substr(0, 16) + ") fitted by mtf " +
                     mtf::version + ": " + std::string(status_name(result.status)) + ", chi2 per dof " +
                     significant(result.chi2_per_dof, 4) + "\n";
  for (const std::string& input : inputs)
    head += "# to " + one_line(input) + " (sha256 " + mtf::io::sha256_file(input).substr(0, 16) + ")\n";
  for (const calib::NullDirection& direction : result.not_separable) head += "# " + one_line(direction.text) + "\n";
  std::vector<std::optional<double>> values(fitted.fits.size());
  for (const FittedParameter& p : result.parameters) {
    calib::set_parameter(fitted.system, p.parameter.path, p.value);
    const auto spec = std::find_if(fitted.fits.begin(), fitted.fits.end(),
                                   [&](const mtf::io::FitSpec& fit) { return fit.path == p.parameter.path; });
    if (spec == fitted.fits.end()) continue;
    values[static_cast<std::size_t>(spec - fitted.fits.begin())] = p.value;
    spec->stderr_value = p.knowledge == Knowledge::determined ? p.stderr_value : std::nullopt;
    if (p.knowledge != Knowledge::determined)
      head += "# " + one_line(p.parameter.name) + ": " + std::string(knowledge_name(p.knowledge)) +
              (p.interval ? ", 95 % " + profiled_text(*p.interval) +
                                (p.parameter.unit.empty() ? "" : " " + one_line(p.parameter.unit))
                          : "") +
              "\n";
  }
  // The user's own text with the new numbers, where that says the same; curve files are named relative to it.
  const std::string whole = write_config(fitted, destination);
  const std::string own = without_head(splice_fits(fitted, values));
  const mtf::io::ConfigResult read = mtf::io::parse_config(own, destination.empty() ? sensor.file : destination);
  return head + "\n" + (read.ok() && write_config(read.config, destination) == whole ? own : whole);
}

}  // namespace apps
