// SPDX-License-Identifier: Apache-2.0

// `mtf characterize`: the numbers of a camera from stacks of flat frames.

#include <malloc.h>

#include "apps/characterize/blackbodies.h"
#include "apps/characterize/characterize_options.h"
#include "apps/characterize/find_camera.h"
#include "apps/characterize/page.h"
#include "apps/config_command.h"
#include "apps/sensor/sensor_air.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

std::string command_of(const CharacterizeCommandOptions& options) {
  return "mtf characterize " + shell_word(options.stacks) +
         (options.nominal.empty() ? "" : " --nominal " + shell_word(options.nominal)) + " -o " +
         shell_word(options.out) + (options.maps ? " --maps" : "") + (options.allow_misfit ? " --allow-misfit" : "");
}

}  // namespace

int run_characterize(const CharacterizeCommandOptions& options, const Global& global) {
  if (options.maps && options.out.empty())
    throw mtf::UsageError("--maps: there is no folder for the maps; give -o FOLDER");
  StacksFile file = load_stacks(options.stacks);
  if (!options.nominal.empty()) file.nominal = options.nominal;
  std::optional<mtf::io::SensorConfig> nominal;
  if (!file.nominal.empty()) nominal = read_sensor(file.nominal, global);
  if (options.check) {
    check_stacks(file, bits_of(file, nominal), options.format, global.threads);
    return 0;
  }
  if (options.maps && file.has_blackbodies())
    throw mtf::UsageError("--maps: maps are of stacks by light; those of blackbodies have none");
  const bool by_emva = options.method == CharacterizeMethod::emva1288;
  if (by_emva && (options.maps || file.has_blackbodies()))
    throw mtf::UsageError(options.maps ? "--maps: the standard's numbers make no maps; leave --method out"
                                       : "--method emva1288: the standard knows no blackbodies; leave it out");

  std::vector<std::string> inputs{file.file, file.nominal};
  for (const StackEntry& entry : file.stacks) inputs.insert(inputs.end(), entry.files.begin(), entry.files.end());
  const bool has_sensor = !file.has_blackbodies() || (nominal && is_thermal(*nominal));
  OutputSet outputs(
      {.folder = options.out,
       .force = options.force,  // Those that a run does not make are removed, as they would be of another one.
       .names = {"sensor.toml", "report.html", "result.json", "levels.csv", "defects.csv", "offset.exr",
                 "responsivity.exr"},
       .inputs = std::move(inputs)});
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 20);  // else the planes of each stack leave holes that those of the next do not fit
#endif
  ReadStacks read;
  {
    ProgressLine progress(global);
    read = read_stacks(file, nominal, global.threads, [&](double share) { progress.update("reading", share); });
  }
  if (by_emva) {
    const bool photons = file.tells_photons();
    calib::Emva1288 standard = calib::emva1288(std::move(read.stacks), read.how, photons);
    standard.warnings.insert(standard.warnings.begin(), read.warnings.begin(), read.warnings.end());
    const std::string json = json_document(emva1288_json(standard, file));
    if (!options.out.empty()) emit(outputs.in("result.json"), json);
    outputs.commit();
    print(options.format == Format::json ? json : emva1288_table(standard));
    return 0;
  }
  const int bits = read.bits;
  const std::string destination = options.out.empty() ? "sensor.toml" : options.out + "/sensor.toml";
  const FoundCamera found = find_camera(file, std::move(nominal), std::move(read), destination, options.maps);
  const calib::Characterization& camera = found.camera;
  const std::string json = json_document(found.report);
  if (!options.out.empty()) {
    if (has_sensor) emit(outputs.in("sensor.toml"), found.sensor.text);
    emit(outputs.in("result.json"), json);
    emit(outputs.in("levels.csv"), levels_csv(camera));
  }
  if (!options.out.empty()) {
    const std::vector<PatternPlane> planes = pattern_planes(camera);
    emit(outputs.in("defects.csv"), defects_csv(planes));
    const PageWords words{.camera = found.name,
                          .command = command_of(options),
                          .left = found.sensor.left,
                          .bits = bits,
                          .predicted = predicted_figures(camera, found.sensor.text, destination)};
    emit(outputs.in("report.html"), characterize_page(camera, planes, file, words));
    if (options.maps) {
      const PatternMaps maps = pattern_maps(camera, planes);
      mtf::io::write_exr(outputs.in("offset.exr"), {{"Y", maps.offset.view()}}, {});
      mtf::io::write_exr(outputs.in("responsivity.exr"), {{"Y", maps.responsivity.view()}}, {});
    }
  }
  outputs.commit();
  print(options.format == Format::json ? json : characterize_table(camera, found.sensor.left));
  if (!camera.misfit || options.allow_misfit) return 0;
  note(global,
       "mtf: note: the model does not describe the frames: exit code 3; all outputs are written "
       "(--allow-misfit: exit code 0)");
  return 3;
}

}  // namespace apps
