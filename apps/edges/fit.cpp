// SPDX-License-Identifier: Apache-2.0

// `mtf fit`: the sensor's parameters from images of edges, curves and spots.

#include "apps/config_command.h"
#include "apps/edges/fit_data.h"
#include "apps/edges/fit_outputs.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

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
  const std::string json = fit_json(result, sensor, loaded.files);
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
