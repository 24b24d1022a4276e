// SPDX-License-Identifier: Apache-2.0

// `mtf characterize`: the numbers of a camera from stacks of flat frames.

#include <algorithm>

#include "apps/characterize/blackbodies.h"
#include "apps/characterize/camera_edges.h"
#include "apps/characterize/characterize_options.h"
#include "apps/characterize/page.h"
#include "apps/config_command.h"
#include "apps/edges/fit_command.h"
#include "apps/sensor/sensor_air.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "mtf/work/heap.h"

namespace apps {
namespace {

std::string command_of(const CharacterizeCommandOptions& options) {
  return "mtf characterize " + shell_word(options.stacks) +
         (options.nominal.empty() ? "" : " --nominal " + shell_word(options.nominal)) + " -o " +
         shell_word(options.out) +
         joined(
             options.edges, [](const std::string& image) { return " --edges " + shell_word(image); }, "") +
         (options.maps ? " --maps" : "") + (options.allow_misfit ? " --allow-misfit" : "");
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

  if (!options.edges.empty() && (by_emva || !nominal || !has_sensor))
    throw mtf::UsageError(
        "--edges: they are fitted to a sensor file, which takes a nominal with numbers of its MTF as { value = ..., "
        "fit "
        "= true }, the default method, and stacks by light or a thermal detector");
  if (!options.edges.empty()) static_cast<void>(fit_parameters(*nominal));

  std::vector<std::string> inputs{file.file, file.nominal};
  inputs.insert(inputs.end(), options.edges.begin(), options.edges.end());
  for (const StackEntry& entry : file.stacks) inputs.insert(inputs.end(), entry.files.begin(), entry.files.end());
  OutputSet outputs(
      {.folder = options.out,
       .force = options.force,  // Those that a run does not make are removed, as they would be of another one.
       .names = {"sensor.toml", "report.html", "result.json", "levels.csv", "defects.csv", "offset.exr",
                 "responsivity.exr"},
       .inputs = std::move(inputs)});
  mtf::set_heap({.returned_from = 1 << 20});  // else planes of a stack leave holes that those of the next do not fit
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
  const bool has_page = !options.out.empty();
  const std::vector<PatternPlane> planes = has_page ? pattern_planes(camera) : std::vector<PatternPlane>();
  PageWords words{
      .camera = found.name,
      .command = command_of(options),
      .left = not_measured(found.sensor),
      .bits = found.bits,
      .predicted = has_page ? predicted_figures(camera, found.sensor.text, destination) : std::vector<Figure>()};
  Json report = found.report;
  std::vector<std::string> written;
  const auto write = [&](const std::string& name, const std::string& text) {
    if (options.out.empty()) return;
    emit(outputs.in(name), text);
    if (std::ranges::find(written, name) == written.end()) written.push_back(name);
  };
  const auto write_main = [&](const std::string& sensor) {
    if (has_sensor) write("sensor.toml", sensor);
    if (has_page) write("report.html", characterize_page(camera, planes, file, words));
    write("result.json", json_document(report));
  };
  write_main(found.sensor.text);
  write("levels.csv", levels_csv(camera));
  if (has_page) write("defects.csv", defects_csv(camera, planes));
  if (options.maps) {
    const PatternMaps maps = pattern_maps(camera, planes);
    mtf::io::write_exr(outputs.in("offset.exr"), {{"Y", maps.offset.view()}}, {});
    mtf::io::write_exr(outputs.in("responsivity.exr"), {{"Y", maps.responsivity.view()}}, {});
  }
  outputs.commit();  // What the frames have told is whole, whatever becomes of the edges.

  if (options.format != Format::json) print(characterize_table(camera, found.sensor));

  std::optional<CameraEdges> edges;
  std::exception_ptr failure;
  if (!options.edges.empty()) {
    const InterruptNote interrupted("mtf: the edges are not finished; the numbers of the frames are whole\n");
    try {
      std::vector<EdgePicture> pictures;
      for (const std::string& image : options.edges) pictures.push_back({image, mtf::io::read_image(image)});
      ProgressLine progress(global);
      edges = fit_camera_edges(found, file, std::move(pictures), destination, global.threads, [&](double share) {
        progress.update("fitting", share);
        return true;
      });
      report["edges"] = std::move(edges->report);
      words.edges = edges->words;
      write_main(edges->sensor_text.empty() ? found.sensor.text : edges->sensor_text);
      outputs.commit();
    } catch (const mtf::Error&) {
      note(global, "mtf: note: the edges failed; the numbers of the frames are whole");
      failure = std::current_exception();
    }
  }
  if (options.format == Format::json) print(json_document(report));
  if (failure) std::rethrow_exception(failure);
  if (edges && options.format != Format::json) print("\n" + edges->table);
  if (!written.empty())
    note(global, "written to " + shell_word(options.out) + ": " + joined(written) +
                     (has_sensor ? "\nnext: mtf simulate " + shell_word(destination) + " SCENE -o image.exr" : ""));
  if (edges && edges->sensor_text.empty()) return 1;
  if (options.allow_misfit || !(camera.misfit || (edges && edges->misfit()))) return 0;
  note(global,
       std::string("mtf: note: ") +
           (camera.misfit ? "the model does not describe the frames" : "the sensor does not describe the edges") +
           ": exit code 3; all outputs are written (--allow-misfit: exit code 0)");
  return 3;
}

}  // namespace apps
