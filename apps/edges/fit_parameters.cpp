// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/fit_parameters.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "apps/terminal/text_table.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"

namespace apps {
namespace {

using calib::FittedParameter;
using calib::Knowledge;
using calib::RicherModel;
using Correlation = std::vector<std::vector<double>>;

bool has_value(const FittedParameter& p) {
  return p.knowledge != Knowledge::prior_only && p.knowledge != Knowledge::not_determined;
}

std::string interval_text(const std::array<double, 2>& interval) {
  return significant(interval[0], 5) + " to " + significant(interval[1], 5);
}

/// 95 %, an open end in words.
std::string profiled_text(const calib::ProfiledInterval& interval) {
  if (interval.low && interval.high) return interval_text({*interval.low, *interval.high});
  if (interval.low) return "above " + significant(*interval.low, 5);
  return interval.high ? "below " + significant(*interval.high, 5) : "not bounded";
}

/// "0.351 +- 0.0037", or the value with its interval; without the unit.
std::string one_value_text(double value, const std::optional<double>& sd,
                           const std::optional<std::array<double, 2>>& interval95) {
  if (sd) return shown_with_error(value, *sd) + " +- " + significant(*sd, 2);
  if (!interval95) return significant(value, 8);
  return shown_with_error(value, 0.25 * ((*interval95)[1] - (*interval95)[0])) +
         " (95 %: " + interval_text(*interval95) + ")";
}

/// All values of an ambiguous parameter.
std::string values_text(const FittedParameter& p) {
  std::string text = one_value_text(p.value, p.stderr_value, p.interval95);
  for (const calib::OtherValue& other : p.others)
    text += " or " + one_value_text(other.value, other.stderr_value, other.interval95);
  return text;
}

std::string value_text(const FittedParameter& p) {
  const std::string unit = p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
  if (p.knowledge == Knowledge::ambiguous) return values_text(p) + unit;
  if (p.knowledge == Knowledge::interval)
    return shown_with_error(p.value, 0.25 * ((*p.interval95)[1] - (*p.interval95)[0])) + unit +
           " (95 %: " + profiled_text(*p.interval) + unit + ")";
  if (p.knowledge == Knowledge::at_bound)
    return significant(p.value, 6) + unit + " (at its bound" +
           (p.limit95 ? std::string("; 95 %: at ") + (p.limit_is_upper ? "most " : "least ") +
                            significant(*p.limit95, 4) + unit
                      : std::string()) +
           ")";
  if (p.knowledge != Knowledge::determined) return std::string(knowledge_name(p.knowledge));
  return one_value_text(p.value, p.stderr_value, std::nullopt) + unit;
}

/// With a standard deviation that stands for its interval, whatever that is like.
calib::Estimate estimate_of(const FittedParameter& p) {
  if (p.stderr_value) return {p.value, *p.stderr_value};
  if (p.interval95) return {p.value, 0.25 * ((*p.interval95)[1] - (*p.interval95)[0])};
  return {p.value, p.limit95 ? 0.5 * std::abs(*p.limit95 - p.value) : p.linear_sd};
}

/// What a richer model makes of parameter i, where that matters: "defocus" and its words.
std::vector<std::array<std::string, 2>> sensitivities(const FittedParameter& p, std::size_t i,
                                                      std::span<const RicherModel> richer_models) {
  std::vector<std::array<std::string, 2>> all;
  if (!has_value(p)) return all;
  for (const RicherModel& model : richer_models) {
    const FittedParameter& then = model.parameters[i];
    if (!has_value(then) || matters(estimate_of(p), estimate_of(then)))
      all.push_back({model.unknown, value_text(then)});
  }
  return all;
}

std::string correlation_table(std::span<const FittedParameter> parameters, const Correlation& correlation) {
  std::vector<std::string> header{"correlation"};
  for (const FittedParameter& p : parameters) header.push_back(one_line(p.parameter.name));
  std::vector<Align> align(header.size(), Align::right);
  align.front() = Align::left;
  TextTable table(std::move(header));
  for (std::size_t i = 0; i < correlation.size(); ++i) {
    std::vector<std::string> row{one_line(parameters[i].parameter.name)};
    for (const double rho : correlation[i]) row.push_back(std::isfinite(rho) ? fixed(rho, 3) : "not determined");
    table.add(std::move(row));
  }
  return table.aligned(align);
}

Json others_json(const FittedParameter& p) {
  Json all = Json::array();
  for (const calib::OtherValue& other : p.others)
    all.push_back({{"value", other.value},
                   {"stderr", other.stderr_value},
                   {"interval95", other.interval95},
                   {"chi2_rise", other.chi2_rise}});
  return all;
}

}  // namespace

Json parameter_json(const FittedParameter& p) {
  const bool known = has_value(p);
  return {{"name", p.parameter.name},
          {"path", p.parameter.path},
          {"value", known ? Json(p.value) : Json()},
          {"stderr", known ? p.stderr_value : Json()},
          {"unit", p.parameter.unit},
          {"knowledge", knowledge_name(p.knowledge)},
          {"start", p.start},
          {"limit95", p.limit95},
          {"limit_is", p.limit95 ? Json(p.limit_is_upper ? "upper" : "lower") : Json()},
          {"interval68", p.interval68},
          {"interval95", p.interval95},
          {"interval", p.interval ? Json{{"confidence", 0.95},
                                         {"low", p.interval->low},
                                         {"high", p.interval->high},
                                         {"reason", text_or_null(p.interval->reason)}}
                                  : Json()},
          {"other_values", others_json(p)}};
}

std::string shown_with_error(double value, double sd) {
  if (!(sd > 0.0) || !std::isfinite(sd)) return significant(value, 6);
  const int digits = static_cast<int>(std::floor(std::log10(std::max(std::abs(value), sd) / sd))) + 2;
  return significant(value, std::clamp(digits, 2, 12), true);
}

double rounded_to_error(double value, double sd) {
  if (value == 0.0 || !std::isfinite(value)) return value;
  const auto first = [](double number) { return static_cast<int>(std::floor(std::log10(std::abs(number)))); };
  const bool has_error = sd > 0.0 && std::isfinite(sd);
  const int digits = has_error ? first(value) - first(sd) + 3 : 10;
  return digits < 1 ? 0.0 : std::strtod(significant(value, std::min(digits, 17)).c_str(), nullptr);
}

bool matters(const calib::Estimate& plain, const calib::Estimate& richer) {
  return std::abs(richer.value - plain.value) > plain.sd || richer.sd > 1.5 * plain.sd;
}

std::string parameters_table(std::span<const FittedParameter> parameters,
                             std::span<const calib::NullDirection> not_separable, const Correlation& correlation,
                             std::span<const calib::Alternative> alternatives,
                             std::span<const RicherModel> richer_models) {
  std::string text;
  if (!parameters.empty()) {
    TextTable table({"parameter", "value", "start"});
    for (const FittedParameter& p : parameters) {
      const std::string unit = p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
      table.add({one_line(p.parameter.name), value_text(p), significant(p.start, 6) + unit});
    }
    std::istringstream rows(table.aligned());
    std::string row;
    std::getline(rows, row);
    const std::string below_value(row.find("value"), ' ');
    text += "\n" + row + "\n";
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      std::getline(rows, row);
      text += row + "\n";
      for (const auto& [unknown, then] : sensitivities(parameters[i], i, richer_models))
        text += below_value + "with unknown " + unknown + ": " + then + "\n";
    }
  }
  for (const FittedParameter& p : parameters) {
    if (p.interval68) text += one_line(p.parameter.name) + ": 68 % " + interval_text(*p.interval68);
    if (p.interval) text += ", 95 % " + profiled_text(*p.interval);
    if (p.interval68 || p.interval) text += p.parameter.unit.empty() ? "" : " " + p.parameter.unit;
    if (p.interval) text += (p.interval->reason.empty() ? "" : "; " + p.interval->reason) + "\n";
  }
  for (const calib::NullDirection& direction : not_separable) text += "\n" + direction.text + "\n";
  for (const calib::Alternative& alternative : alternatives) text += "\n" + one_line(alternative.text) + "\n";
  if (parameters.size() > 1 && !correlation.empty()) text += "\n" + correlation_table(parameters, correlation);
  return text;
}

void add_parameters(Json& json, std::span<const FittedParameter> parameters,
                    std::span<const calib::NullDirection> not_separable, const Correlation& correlation) {
  json["parameters"] = Json::array(parameters, parameter_json);
  json["correlation"] = correlation;
  json["not_separable"] = Json::array();
  for (const calib::NullDirection& direction : not_separable) {
    Json names = Json::array();
    for (const std::size_t i : direction.parameters) names.push_back(parameters[i].parameter.name);
    json["not_separable"].push_back({{"parameters", names}, {"weight", direction.weight}, {"text", direction.text}});
  }
}

std::string fit_head(const FitOrigin& origin, const std::vector<std::string>& inputs,
                     std::span<const FittedParameter> parameters, std::span<const calib::NullDirection> not_separable,
                     std::span<const RicherModel> richer_models) {
  std::string head = "# " + one_line(origin.file) + " (sha256 " + origin.sha256.substr(0, 16) + ") fitted by mtf " +
                     mtf::version + ": " + origin.outcome + "\n";
  for (const std::string& input : inputs)
    head += "# to " + one_line(input) + " (sha256 " + mtf::io::sha256_file(input).substr(0, 16) + ")\n";
  for (const calib::NullDirection& direction : not_separable) head += "# " + one_line(direction.text) + "\n";
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const FittedParameter& p = parameters[i];
    const std::string name = "# " + one_line(p.parameter.name) + ": ";
    const std::string unit = p.parameter.unit.empty() ? "" : " " + one_line(p.parameter.unit);
    if (p.knowledge != Knowledge::determined)
      head += name + std::string(knowledge_name(p.knowledge)) +
              (p.knowledge == Knowledge::ambiguous ? ", " + values_text(p) + unit
               : p.interval                        ? ", 95 % " + profiled_text(*p.interval) + unit
                                                   : "") +
              "\n";
    for (const auto& [unknown, then] : sensitivities(p, i, richer_models))
      head += "# " + one_line(p.parameter.name) + " with unknown " + unknown + ": " + one_line(then) + "\n";
  }
  return head + "\n";
}

std::string without_fit_head(const std::string& text) {
  const std::size_t line = text.find('\n');
  if (!text.starts_with("# ") || text.substr(0, line).find(") fitted by mtf ") == std::string::npos) return text;
  const std::size_t end = text.find("\n\n");
  return end == std::string::npos ? text : text.substr(end + 2);
}

}  // namespace apps
