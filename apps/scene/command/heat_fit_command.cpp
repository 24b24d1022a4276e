// SPDX-License-Identifier: Apache-2.0

// `mtf heat --fit`: numbers of the ground's material from its measured temperature; a fitted scene file.

#include "apps/edges/fit_parameters.h"
#include "apps/options.h"
#include "apps/scene/command/heat_fit_report.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"

namespace apps {
namespace {

using namespace scene;

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
