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
  if (nominal) file.nominal_sha256 = nominal->sha256;
  if (options.check) {
    check_stacks(file, nominal, options.format, global.threads);
    return 0;
  }
  if (options.maps && file.has_blackbodies())
    throw mtf::UsageError("--maps: maps are of stacks by light; those of blackbodies have none");
  const bool has_sensor = !file.has_blackbodies() || (nominal && is_thermal(*nominal));
  const bool by_emva = options.method == CharacterizeMethod::emva1288;
  if (by_emva && (options.maps || file.has_blackbodies()))
    throw mtf::UsageError(options.maps ? "--maps: the standard's numbers make no maps; leave --method out"
                                       : "--method emva1288: the standard knows no blackbodies; leave it out");

  std::vector<std::string> inputs{file.file, file.nominal};
  for (const StackEntry& entry : file.stacks) inputs.insert(inputs.end(), entry.files.begin(), entry.files.end());
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
  const std::string destination = options.out.empty() ? "sensor.toml" : options.out + "/sensor.toml";
  const FoundCamera found = find_camera(file, std::move(nominal), std::move(read), destination, options.maps);
  const calib::Characterization& camera = found.camera;
  const bool has_page = !options.out.empty() && !file.has_blackbodies();
  const std::vector<PatternPlane> planes = has_page ? pattern_planes(camera) : std::vector<PatternPlane>();
  const PageWords words{
      .camera = found.name, .command = command_of(options), .left = not_measured(found.sensor), .bits = found.bits};
  std::vector<std::string> written;
  const auto write = [&](const std::string& name, const std::string& text) {
    if (options.out.empty()) return;
    emit(outputs.in(name), text);
    written.push_back(name);
  };
  if (has_sensor) write("sensor.toml", found.sensor.text);
  if (has_page) write("report.html", characterize_page(camera, planes, file, words));
  const std::string json = json_document(found.report);
  write("result.json", json);
  write("levels.csv", levels_csv(camera));
  if (has_page) write("defects.csv", defects_csv(planes));
  if (options.maps) {
    const PatternMaps maps = pattern_maps(camera, planes);
    mtf::io::write_exr(outputs.in("offset.exr"), {{"Y", maps.offset.view()}}, {});
    mtf::io::write_exr(outputs.in("responsivity.exr"), {{"Y", maps.responsivity.view()}}, {});
  }
  outputs.commit();
  print(options.format == Format::json ? json : characterize_table(camera, found.sensor));
  if (!written.empty())
    note(global, "written to " + shell_word(options.out) + ": " + joined(written) +
                     (has_sensor ? "\nnext: mtf simulate " + shell_word(destination) + " SCENE -o image.exr" : ""));
  if (options.allow_misfit || !camera.misfit) return 0;
  note(global,
       "mtf: note: the model does not describe the frames: exit code 3; all outputs are written "
       "(--allow-misfit: exit code 0)");
  return 3;
}

}  // namespace apps
