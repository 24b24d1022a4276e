// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/find_camera.h"

#include <algorithm>
#include <cmath>

#include "apps/sensor/sensor_air.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/replace_value.h"
#include "mtf/words.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/light/constants.h"
#include "radiometry/stages/detector/nonlinearity.h"

namespace apps {
namespace {

using Nominal = std::optional<mtf::io::SensorConfig>;

/// The way in which light is stated goes with the detector.
void require_fitting_light(const StacksFile& stacks, const Nominal& nominal) {
  if (stacks.has_blackbodies() && !nominal)
    throw mtf::UsageError(stacks.file + ": " + std::string(name_of(stacks.unit)) +
                          " counts by the radiance in the camera's band; name a nominal sensor with [band]");
  if (!stacks.has_blackbodies() && nominal && is_thermal(*nominal))
    throw mtf::UsageError(nominal->file +
                          ": a thermal detector, which is characterized by blackbodies; give temperature = \"308 K\" "
                          "in each [[stack]] of " +
                          stacks.file);
}

/// Photons at a pixel for each W/m^2 and second.
double photons_per_irradiance(const StacksFile& stacks, const Nominal& nominal) {
  if (stacks.unit != LightUnit::irradiance) return 1.0;
  if (!nominal)
    throw mtf::UsageError(stacks.file +
                          ": irradiance gives photons by the area of a pixel; name a nominal sensor with "
                          "its pitch, or give photons");
  const auto& frame = nominal->system.frame;
  const double area_m2 = frame.pitch_um(mtf::Axis::x) * frame.pitch_um(mtf::Axis::y) * 1e-12;
  return area_m2 * *stacks.wavelength_um / radiometry::kPhotonEnergy_j_um;
}

double full_well_of(const StacksFile& stacks, const Nominal& nominal) {
  if (stacks.full_well_e) return *stacks.full_well_e;
  const mtf::SettingsTable* detector = nominal ? find_table(nominal->tables, "detector") : nullptr;
  if (detector == nullptr) return 0.0;
  const double given = radiometry::from_table<radiometry::DetectorSettings>(*detector).full_well_e;
  return std::isfinite(given) ? given : 0.0;
}

/// Reads once more the stack whose noisy pixels tell whether they blink, if it has any. `entries`: of the stacks in the
/// file.
void read_noisy_pixels(ReadStacks& read, const std::vector<std::size_t>& entries, const StacksFile& file,
                       const std::vector<StackShapes>& shapes, int threads) {
  const calib::Stack* const chosen = file.has_blackbodies() ? calib::nearest_stack(read.stacks, read.seen.how.radiance)
                                                            : calib::dark_stack(read.stacks);
  if (chosen == nullptr || chosen->sums.frames < calib::kBlinkFrames) return;
  const auto place = static_cast<std::size_t>(chosen - read.stacks.data());
  calib::PixelSeries& series = read.stacks[place].sums.series;
  series = calib::empty_series(chosen->sums);
  if (!series.places.empty()) read_series(file.stacks[entries[place]], shapes[entries[place]], file, threads, series);
}

/// What the frames have gone through, or hold, already: the twin would have it twice.
void warn_of_nominal(const mtf::io::SensorConfig& nominal, calib::Characterization& camera) {
  std::vector<std::string>& warnings = camera.warnings;
  const calib::Finding* const blinking = camera.find("blinking_fraction");
  const bool told = blinking != nullptr && blinking->verdict != calib::Verdict::not_determined;
  if (find_table(nominal.tables, "correction") != nullptr)
    warnings.emplace_back(
        "[correction] of the nominal would be made once more on what the frames have after it; remove it");
  for (const char* const table : {"flicker", "blinking"})
    if (find_table(nominal.tables, table) != nullptr && !(told && std::string_view(table) == "blinking"))
      warnings.push_back("[" + std::string(table) +
                         "] of the nominal is noise beside the components measured here; remove it");
}

}  // namespace

std::function<double(double)> linear_counts(const calib::PhotonTransfer& transfer) {
  if (transfer.a.empty()) return [](double count) { return count; };
  const auto a = [&](std::size_t k) { return k < transfer.a.size() ? transfer.a[k].value : 0.0; };
  const radiometry::Response response({a(0), a(1), a(2)}, transfer.options.full_well_e);
  return [=, gain = transfer.gain.value, offset = transfer.offset.value](double count) {
    return offset + gain * response.inverse((count - offset) / gain);
  };
}

int bits_of(const StacksFile& file, const Nominal& nominal) {
  if (file.bits) return *file.bits;
  if (nominal)
    if (const mtf::SettingsTable* adc = find_table(nominal->tables, "adc"))
      return radiometry::from_table<radiometry::AdcSettings>(*adc).bits;
  throw mtf::UsageError(file.file +
                        ": the bits of the converter are not known; write bits = 12 in [camera], or name "
                        "a nominal sensor with [adc]");
}

std::vector<StackShapes> look_at_stacks(const StacksFile& file, const Nominal& nominal, int threads) {
  require_fitting_light(file, nominal);
  static_cast<void>(photons_per_irradiance(file, nominal));
  return shapes_of(file, bits_of(file, nominal), threads);
}

ReadStacks read_stacks(const StacksFile& file, const Nominal& nominal, int threads,
                       const std::function<void(double)>& progress) {
  const std::vector<StackShapes> shapes = look_at_stacks(file, nominal, threads);
  FrameSource source{.bits = bits_of(file, nominal), .threads = threads};
  const double photons = photons_per_irradiance(file, nominal), most = std::ldexp(1.0, source.bits) - 1.0;
  std::size_t files = 0, done = 0;
  for (const StackEntry& entry : file.stacks) files += entry.memory.empty() ? entry.files.size() : 1;
  source.progress = [&] {
    if (progress) progress(static_cast<double>(++done) / static_cast<double>(files));
  };
  ReadStacks read{.bits = source.bits,
                  .how = {.nonlinearity = file.nonlinearity,
                          .full_well_e = full_well_of(file, nominal),
                          .most_counts = most,
                          .trend = file.trend,
                          .light_repeatability = file.repeatability,
                          .counts_time = file.has_times}};
  std::vector<std::size_t> entries;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const StackEntry& entry = file.stacks[i];
    calib::Stack stack = read_stack(entry, shapes[i], file, source);
    if (entry.step_s > 0.0) {
      try {
        std::vector<calib::Stack> step;
        step.push_back(std::move(stack));
        calib::mark_stuck(step);
        if (!step[0].is_usable())
          throw mtf::UsageError(calib::clipped_words(step[0]) + "; choose less light, or an offset");
        static_cast<void>(calib::fit_lag_step(step[0].sums.frame_means));  // refused before all else
        read.lag = {entry.name, entry.step_s, step[0].sums.frame_means};
      } catch (const mtf::UsageError& error) {
        throw mtf::UsageError(entry.name + ": " + error.what());
      }
      continue;
    }
    read.stacks.push_back(std::move(stack));
    entries.push_back(i);
    if (file.unit == LightUnit::irradiance) read.stacks.back().light *= photons * entry.time_s;
    if (!file.has_blackbodies()) calib::drop_planes(read.stacks);
  }
  if (file.has_blackbodies()) read.seen = see_blackbodies(read.stacks, file, *nominal);
  calib::mark_stuck(read.stacks);
  read_noisy_pixels(read, entries, file, shapes, threads);
  read.warnings = std::move(source.warnings);
  if (2.0 * source.used < most)
    read.warnings.push_back("no value needs all of the " + std::to_string(source.bits) +
                            " bits: if the converter has fewer, correct bits in [camera], or saturation is not seen");
  return read;
}

FoundCamera find_camera(const StacksFile& file, Nominal nominal, ReadStacks read, const std::string& destination,
                        bool maps) {
  FoundCamera found;
  found.camera = file.has_blackbodies() ? characterize_blackbodies(std::move(read.stacks), read.seen)
                                        : calib::characterize(std::move(read.stacks), read.how);
  found.camera.warnings.insert(found.camera.warnings.begin(), read.warnings.begin(), read.warnings.end());
  const bool placeholders = !nominal;
  if (placeholders) {
    const radiometry::MeanSquares& size = found.camera.stacks.front().sums.squares;
    const double given_s = found.camera.stacks.back().time_s;
    const double most_s = read.lag ? read.lag->frame_time_s : mtf::kInfinity;  // no exposure outlasts a frame
    mtf::io::ConfigResult least = mtf::io::parse_config(
        least_sensor(static_cast<std::int64_t>(size.columns), static_cast<std::int64_t>(size.rows), read.bits,
                     std::min(most_s, given_s > 0.0 ? given_s : 0.01)),
        destination, sensor_schema());
    mtf::io::cfg::require_no_errors(least.diagnostics, destination);
    nominal = std::move(least.config);
  }
  if (read.lag) {
    std::ranges::transform(read.lag->means, read.lag->means.begin(), linear_counts(found.camera.transfer));
    calib::add_lag(calib::fit_lag_step(read.lag->means), read.lag->frame_time_s, read.lag->name, found.camera);
    const mtf::SettingsTable* frame = find_table(nominal->tables, "frame");
    if (found.camera.find("lag_time_constant") && (frame == nullptr || frame->find("frame_time") == nullptr))
      nominal = mtf::io::replaced(*nominal, "frame.frame_time", mtf::format_double(read.lag->frame_time_s) + " s");
  }
  found.name = nominal->system.name;
  found.bits = read.bits;
  warn_of_nominal(*nominal, found.camera);
  const calib::Finding* const rate = found.camera.find("rate");
  if (rate != nullptr && rate->low95 > 1.0 && file.tells_photons())
    found.camera.warnings.push_back(
        "rate is " + mtf::significant(rate->value, 4) +
        " electrons a photon, more than 1: the photons are stated too low, or the frames are "
        "averages; quantum_efficiency is not set");
  found.sensor = file.has_blackbodies()
                     ? thermal_camera_file(found.camera, file, std::move(*nominal), read.bits, destination)
                     : camera_file(found.camera, file, std::move(*nominal), read.bits, placeholders, maps, destination);
  found.report = characterize_json(found.camera, file, found.sensor);
  return found;
}

}  // namespace apps
