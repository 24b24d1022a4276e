// SPDX-License-Identifier: Apache-2.0

// `mtf heat --fit`: numbers of the ground's material from its measured temperature; a fitted scene file.

#include "apps/edges/fit_parameters.h"
#include "apps/figures/plot.h"
#include "apps/options.h"
#include "apps/scene/fit/heat_fit.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"
#include "radiometry/weather/instant.h"

namespace apps {
namespace {

using namespace scene;

/// What the standard errors rest on.
std::string errors_text(const HeatFit& fit) {
  const calib::SeriesFit& s = fit.series;
  std::string text = "standard errors: residuals of " + significant(s.sd, 3) + " K";
  if (s.phi > 0.0)
    text += " that stay correlated for " + significant(fit.correlation_time_s / 60.0, 2) + " min, so that " +
            std::to_string(s.count) + " values count as " + significant(s.independent_values, 3);
  return text + ";\nwhat the model does wrong on every day alike is not in them\n";
}

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

/// As that of `mtf fit`, with temperatures in place of the MTF.
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

/// Measured, solved with the numbers of the file, and fitted; the residuals.
std::vector<Figure> heat_fit_figures(const SceneFile& scene, const HeatFit& fit) {
  Figure kelvin, difference;
  kelvin.title = "temperature of the ground, fitted to " + fixed(fit.series.after.rms, 2) + " K rms";
  kelvin.x_label = difference.x_label = "hours since " + radiometry::heat::instant_text(scene.time.start_s);
  kelvin.y_label = "temperature [K]";
  difference.y_label = "solved - measured [K]";
  Series measured{.name = "measured"}, before{.name = "with the numbers of the file"},
      after{.name = "fitted", .emphasised = true}, residual{.name = "fitted"};
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

std::string outcome_of(const HeatFit& fit) {
  return std::string(calib::status_name(fit.series.status)) + ", " + fixed(fit.series.after.rms, 3) + " K rms, " +
         fixed(fit.series.before.rms, 3) + " K before";
}

}  // namespace

int run_heat_fit(const HeatCommandOptions& options, const Global& global) {
  if (options.ply || options.vtk || options.sensitivity || options.every_facet || options.seen)
    throw mtf::UsageError(
        "--fit solves the ground alone: --ply, --vtk, --sensitivity, --every-facet and --seen do not go with it");
  std::vector<mtf::io::Diagnostic> findings;
  const SceneFile file = load_scene(options.scene, &findings);
  std::vector<std::string> outputs{options.out, options.fit_report};
  for (std::string& output : figure_files(options.fit_plot)) outputs.push_back(std::move(output));
  std::erase(outputs, "");
  OutputSet files({.files = outputs, .inputs = files_of(file)});
  for (const mtf::io::Diagnostic& finding : findings) note(global, mtf::io::format_diagnostic(finding, file.file));
  HeatFit fit;
  {
    ProgressLine progress(global);
    progress.update("fitting", 0.0);
    fit = fit_heat(file, {.tolerance_k = options.tolerance_k.value_or(HeatFitOptions{}.tolerance_k),
                          .threads = global.threads,
                          .progress = [&](int solutions) {
                            progress.update("fitting, " + std::to_string(solutions) + " solutions", 0.5);
                          }});
  }
  for (const std::string& warning : fit.warnings) note(global, "warning: " + warning);
  const std::string json = heat_fit_json(file, fit);
  if (!options.fit_report.empty()) emit(files.at(options.fit_report), json);
  if (fit.series.fitted()) {
    if (!options.fit_plot.empty() && !write_figures(files.at(options.fit_plot), heat_fit_figures(file, fit)))
      note(global, figure_note(options.fit_plot, false));
    emit(files.at(options.out), fit_head({file.file, file.sha256, outcome_of(fit)}, {fit.measured.source},
                                         fit.series.parameters, fit.series.not_separable) +
                                    without_fit_head(fitted_scene_text(file, fit)));
  } else {
    note(global, "mtf: note: not fitted: " + one_line(options.out) + " is not written");
  }
  files.commit();
  print(options.format == Format::json ? json : heat_fit_table(fit));
  if (!fit.series.fitted()) return 1;
  if (fit.series.status == calib::FitStatus::converged || options.allow_misfit) return 0;
  note(global,
       "mtf: note: the heat balance does not describe the data: exit code 3; all outputs are written (--allow-misfit: "
       "exit code 0)");
  return 3;
}

}  // namespace apps
