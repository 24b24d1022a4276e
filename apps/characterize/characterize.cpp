// SPDX-License-Identifier: Apache-2.0

// `mtf characterize`: the numbers of a camera from stacks of flat frames.

#include <malloc.h>

#include <cmath>

#include "apps/characterize/camera_file.h"
#include "apps/characterize/characterize_options.h"
#include "apps/characterize/stack_frames.h"
#include "apps/config_command.h"
#include "apps/sensor/sensor_air.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/light/constants.h"

namespace apps {
namespace {

/// The converter's bits: of the stacks' file, else of the nominal.
int bits_of(const StacksFile& stacks, const std::optional<mtf::io::SensorConfig>& nominal) {
  if (stacks.bits) return *stacks.bits;
  if (nominal)
    if (const mtf::SettingsTable* adc = find_table(nominal->tables, "adc"))
      return radiometry::from_table<radiometry::AdcSettings>(*adc).bits;
  throw mtf::UsageError(stacks.file +
                        ": the bits of the converter are not known; write bits = 12 in [camera], or name "
                        "a nominal sensor with [adc]");
}

void require_photon_detector(const std::optional<mtf::io::SensorConfig>& nominal) {
  const mtf::SettingsTable* detector = nominal ? find_table(nominal->tables, "detector") : nullptr;
  if (detector != nullptr &&
      radiometry::from_table<radiometry::DetectorSettings>(*detector).kind == radiometry::DetectorKind::thermal)
    throw mtf::UsageError(nominal->file +
                          ": a thermal detector; its frames of blackbodies cannot be characterized yet: photon "
                          "detectors only");
}

/// Photons at a pixel for each W/m^2 and second.
double photons_per_irradiance(const StacksFile& stacks, const std::optional<mtf::io::SensorConfig>& nominal) {
  if (stacks.unit != LightUnit::irradiance) return 1.0;
  if (!nominal)
    throw mtf::UsageError(stacks.file +
                          ": irradiance gives photons by the area of a pixel; name a nominal sensor with "
                          "its pitch, or give photons");
  const auto& frame = nominal->system.frame;
  const double area_m2 = frame.pitch_um(mtf::Axis::x) * frame.pitch_um(mtf::Axis::y) * 1e-12;
  return area_m2 * *stacks.wavelength_um / radiometry::kPhotonEnergy_j_um;
}

double full_well_of(const StacksFile& stacks, const std::optional<mtf::io::SensorConfig>& nominal) {
  if (stacks.full_well_e) return *stacks.full_well_e;
  const mtf::SettingsTable* detector = nominal ? find_table(nominal->tables, "detector") : nullptr;
  if (detector == nullptr) return 0.0;
  const double given = radiometry::from_table<radiometry::DetectorSettings>(*detector).full_well_e;
  return std::isfinite(given) ? given : 0.0;
}

}  // namespace

int run_characterize(const CharacterizeCommandOptions& options, const Global& global) {
  StacksFile file = load_stacks(options.stacks);
  if (!options.nominal.empty()) file.nominal = options.nominal;
  std::optional<mtf::io::SensorConfig> nominal;
  if (!file.nominal.empty()) nominal = read_sensor(file.nominal, global);
  require_photon_detector(nominal);
  FrameSource source{.bits = bits_of(file, nominal), .threads = global.threads};
  const double photons = photons_per_irradiance(file, nominal);

  const bool by_emva = options.method == CharacterizeMethod::emva1288;
  std::vector<std::string> inputs{file.file, file.nominal};
  for (const StackEntry& entry : file.stacks) inputs.insert(inputs.end(), entry.files.begin(), entry.files.end());
  const std::size_t total = inputs.size();
  OutputSet outputs({.folder = options.out,
                     .force = options.force,
                     .names = by_emva ? std::vector<std::string>{"result.json"}
                                      : std::vector<std::string>{"sensor.toml", "result.json", "levels.csv"},
                     .inputs = std::move(inputs)});

  std::vector<calib::Stack> stacks;
  {
    mallopt(M_MMAP_THRESHOLD, 1 << 20);  // else the planes of each stack leave holes that those of the next do not fit
    ProgressLine progress(global);
    std::size_t read = 0;
    source.progress = [&] { progress.update("reading", static_cast<double>(++read) / static_cast<double>(total)); };
    for (const StackEntry& entry : file.stacks) {
      stacks.push_back(read_stack(entry, file, source));
      if (file.unit == LightUnit::irradiance) stacks.back().light *= photons * entry.time_s;
      calib::drop_planes(stacks);
    }
  }
  const double most = std::ldexp(1.0, source.bits) - 1.0;
  if (2.0 * source.used < most)
    source.warnings.push_back("no value needs all of the " + std::to_string(source.bits) +
                              " bits: if the converter has fewer, correct bits in [camera], or saturation is not seen");
  const calib::CharacterizeOptions how{.nonlinearity = file.nonlinearity,
                                       .full_well_e = full_well_of(file, nominal),
                                       .most_counts = most,
                                       .light_repeatability = file.repeatability,
                                       .counts_time = file.has_times};
  if (by_emva) {
    const bool photons_known = file.unit == LightUnit::photons || file.unit == LightUnit::irradiance;
    calib::Emva1288 standard = calib::emva1288(std::move(stacks), how, photons_known);
    standard.warnings.insert(standard.warnings.begin(), source.warnings.begin(), source.warnings.end());
    const std::string json = json_document(emva1288_json(standard, file));
    if (!options.out.empty()) emit(outputs.in("result.json"), json);
    outputs.commit();
    print(options.format == Format::json ? json : emva1288_table(standard));
    return 0;
  }
  calib::Characterization camera = calib::characterize(std::move(stacks), how);
  camera.warnings.insert(camera.warnings.begin(), source.warnings.begin(), source.warnings.end());

  const radiometry::MeanSquares& size = camera.stacks.front().sums.squares;
  const bool placeholders = !nominal;
  const std::string destination = options.out.empty() ? "sensor.toml" : options.out + "/sensor.toml";
  if (placeholders) {
    const double time_s = camera.stacks.back().time_s;
    mtf::io::ConfigResult least = mtf::io::parse_config(
        least_sensor(static_cast<std::int64_t>(size.columns), static_cast<std::int64_t>(size.rows), source.bits,
                     time_s > 0.0 ? time_s : 0.01),
        destination, sensor_schema());
    mtf::io::cfg::require_no_errors(least.diagnostics, destination);
    nominal = std::move(least.config);
  }
  const CameraFile sensor = camera_file(camera, file, std::move(*nominal), source.bits, placeholders, destination);
  const std::string json = json_document(characterize_json(camera, file, sensor));
  if (!options.out.empty()) {
    emit(outputs.in("sensor.toml"), sensor.text);
    emit(outputs.in("result.json"), json);
    emit(outputs.in("levels.csv"), levels_csv(camera));
  }
  outputs.commit();
  print(options.format == Format::json ? json : characterize_table(camera, sensor.left));
  if (!camera.misfit || options.allow_misfit) return 0;
  note(global,
       "mtf: note: the model does not describe the frames: exit code 3; all outputs are written "
       "(--allow-misfit: exit code 0)");
  return 3;
}

}  // namespace apps
