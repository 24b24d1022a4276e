// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/heat_fit_report.h"

#include <cmath>

#include "apps/edges/fit_parameters.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

/// What the standard errors rest on.
std::string errors_text(const HeatFit& fit) {
  const calib::SeriesFit& s = fit.series;
  std::string text = "standard errors: residuals of " + significant(s.sd, 3) + " K";
  if (s.phi > 0.0)
    text += " that stay correlated for " + significant(fit.correlation_time_s / 60.0, 2) + " min, so that " +
            std::to_string(s.count) + " values count as " + significant(s.independent_values, 3);
  return text + ";\nwhat the model does wrong on every day alike is not in them\n";
}

}  // namespace

std::string heat_fit_table(const HeatFit& fit) {
  const calib::SeriesFit& s = fit.series;
  std::string text = std::string(calib::status_name(s.status)) + (s.reason.empty() ? "" : ": " + s.reason) + "\n";
  text += parameters_table(s.parameters, s.not_separable, s.correlation) + "\n";
  TextTable table({"surface temperature", "rms [K]", "largest [K]"});
  table.add({"with the numbers of the file", fixed(s.before.rms, 3), fixed(s.before.worst, 2)});
  if (s.fitted()) table.add({"fitted", fixed(s.after.rms, 3), fixed(s.after.worst, 2)});
  text += table.aligned({Align::left, Align::right, Align::right});
  text += std::to_string(s.count) + " values of " + one_line(fit.measured.source) +
          (fit.measured.from_longwave ? ", from the long wave of the ground" : "") + "\n";
  if (s.fitted()) text += errors_text(fit);
  return text;
}

std::string heat_fit_json(const SceneFile& scene, const HeatFit& fit) {
  const calib::SeriesFit& s = fit.series;
  Json json{{"version", mtf::version}, {"status", calib::status_name(s.status)}};
  json["reason"] = text_or_null(s.reason);
  json["warnings"] = fit.warnings;
  add_parameters(json, s.parameters, s.not_separable, s.correlation);
  json["count"] = s.count;
  json["before"] = {{"rms_K", s.before.rms}, {"largest_K", s.before.worst}};
  json["after"] = s.fitted() ? Json{{"rms_K", s.after.rms}, {"largest_K", s.after.worst}} : Json();
  json["chi2_per_dof"] = scene.measured && scene.measured->sd_k ? Json(s.chi2_per_dof) : Json();
  json["residuals"] = {{"model", "first-order autoregressive"},
                       {"sd_K", s.sd},
                       {"correlation_of_neighbours", s.phi},
                       {"correlation_time_s", fit.correlation_time_s},
                       {"independent_values", s.independent_values}};
  json["temperature"] = {{"start", radiometry::heat::instant_text(scene.time.start_s)},
                         {"time_s", fit.measured.time_s},
                         {"measured_K", fit.measured.kelvin},
                         {"before_K", s.before.model},
                         {"after_K", s.fitted() ? Json(s.after.model) : Json()}};
  json["iterations"] = s.iterations;
  json["provenance"] = {
      {"scene", scene.file},
      {"config_sha256", scene.sha256},
      {"data", {{{"file", fit.measured.source}, {"sha256", mtf::io::sha256_file(fit.measured.source)}}}}};
  return json_document(json, -1);
}

std::vector<Figure> heat_fit_figures(const SceneFile& scene, const HeatFit& fit) {
  Figure kelvin, difference;
  kelvin.title = "temperature of the ground, fitted to " + fixed(fit.series.after.rms, 2) + " K rms";
  kelvin.x_label = difference.x_label = "hours since " + radiometry::heat::instant_text(scene.time.start_s);
  kelvin.y_label = "temperature [K]";
  difference.y_label = "solved - measured [K]";
  Series measured{.name = "measured", .x = {}, .y = {}},
      before{.name = "with the numbers of the file", .x = {}, .y = {}},
      after{.name = "fitted", .x = {}, .y = {}, .emphasised = true}, residual{.name = "fitted", .x = {}, .y = {}};
  for (std::size_t i = 0; i < fit.measured.time_s.size(); ++i) {
    if (!std::isfinite(fit.measured.kelvin[i])) continue;
    const double hours = fit.measured.time_s[i] / 3600.0;
    for (Series* series : {&measured, &before, &after, &residual}) series->x.push_back(hours);
    measured.y.push_back(fit.measured.kelvin[i]);
    before.y.push_back(fit.series.before.model[i]);
    after.y.push_back(fit.series.after.model[i]);
    residual.y.push_back(fit.series.after.model[i] - fit.measured.kelvin[i]);
  }
  kelvin.series = {measured, before, after};
  difference.series = {residual};
  return {kelvin, difference};
}

}  // namespace apps::scene
