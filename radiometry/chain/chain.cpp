// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain/chain.h"

#include <array>
#include <cmath>
#include <utility>

#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/steps/stage_rows.h"
#include "radiometry/light/band_response.h"

namespace radiometry {
namespace {

/// What a thermal pixel and its readout add anew to every frame, and the 1/f noise that goes on from frame to frame.
void set_thermal_noise(CompiledChain& chain, const Sensor& sensor) {
  const ThermalSettings& thermal = *chain.settings.thermal;
  const ThermalReference<double> reference = thermal_reference(sensor);
  chain.read_e = thermal_volts(chain.settings, chain.pixel, reference);
  if (!thermal.corner_hz) return;
  ThermalNoise<double> noise = thermal_noise_of(chain.settings, chain.pixel, reference);
  const double flicker_v = chain.pixel.volts_per_watt * std::exchange(noise.flicker_w, 0.0);
  chain.read_e = chain.pixel.volts_per_watt * noise.total_w();
  chain.slow.lowest = *thermal.lowest_hz * chain.frame_time_s;
  chain.slow.highest = *thermal.bandwidth_hz * chain.frame_time_s;
  chain.slow.strength = flicker_v * flicker_v / std::log(chain.slow.highest / chain.slow.lowest);
}

}  // namespace

std::optional<MovingBolometer> moving_bolometer(const mtf::System<double>& system) {
  const auto number_of = [](const mtf::Component<double>& component, std::string_view name) {
    for (const auto& field : component.fields()) {
      if (field.info->name != name) continue;
      if (const auto* number = std::get_if<double*>(&field.value)) return **number;
      if (const auto* number = std::get_if<std::optional<double>*>(&field.value)) return (*number)->value_or(0.0);
    }
    return 0.0;
  };
  for (const auto& entry : system.list(mtf::Stage::presample)) {
    if (entry.component.kind() != "bolometer") continue;
    const double time_constant_s = number_of(entry.component, "time_constant");
    const bool moves = number_of(entry.component, "velocity") != 0.0 || number_of(entry.component, "rate") != 0.0;
    if (moves && time_constant_s != 0.0) return MovingBolometer{entry.label, time_constant_s};
  }
  return std::nullopt;
}

void require_consistent(const mtf::System<double>& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  if (!s.detector) return;
  camera_of(system, sensor);
  pixel_of(system, sensor);
  if (sensor.curves.flux != flux_of(s))
    refuse("[detector]", "the curves of the sensor are of another kind; set their flux to flux_of(settings)");
  stop_range(sensor.curves, s.optics.value_or(OpticsSettings{}).stop_band);
  for (const StageRow& row : stage_table())
    if (row.require != nullptr) row.require(system, sensor);
}

void require_response(const Sensor& sensor) {
  const bool thermal = sensor.settings.thermal.has_value();
  const char* const detector = thermal ? "detector.absorptance" : "detector.quantum_efficiency";
  const std::string no_signal = thermal ? ", so that no light is absorbed" : ", so that no light makes electrons";
  if (sensor.settings.detector && sensor.settings.detector->quantum_efficiency.file.empty() &&
      sensor.settings.detector->quantum_efficiency.number == 0.0)
    refuse(detector,
           "0" + no_signal + "; give " +
               (thermal ? "the part of the power, for example 0.8" : "the electrons per photon, for example 0.75"));
  const SceneBand all = scene_band(sensor.curves);
  std::string names;
  const auto check = [&](const char* key, const std::vector<Spectrum>& curves) {
    for (const Spectrum& curve : curves) {
      names += (names.empty() ? "" : ", ") + curve.source;
      try {
        if (BandResponse(all.band, {&curve, 1}).integral() > 0.0) continue;
      } catch (const mtf::UsageError& outside) {
        refuse(key, outside.what());
      }
      refuse(key, curve.source + " is 0 everywhere in the band of " + describe(all.band) + no_signal +
                      "; check its values, and that its wavelengths are in um");
    }
  };
  check(detector, sensor.curves.quantum_efficiency);
  check("optics.transmission", sensor.curves.optics);
  check("optics.cold_transmission", sensor.curves.cold_filter);
  if (names.empty() || BandResponse(all.band, all.curves).integral() > 0.0) return;
  refuse(sensor.curves.quantum_efficiency.empty() ? "optics.transmission" : detector,
         "the curves " + names + " multiply to 0 everywhere in the band of " + describe(all.band) + no_signal +
             "; check that they overlap there, with wavelengths in um");
}

Camera<double> camera_of(const mtf::System<double>& system, const Sensor& sensor) {
  const Camera<double> camera = camera_numbers(system, sensor.settings);
  if (!(camera.f_number > 0.0))
    throw mtf::UsageError("optics.f_number: missing; electrons need it: write f_number or aperture in [optics]");
  require_valid("optics", camera);
  static_cast<void>(cone_sr(camera));
  return camera;
}

Pixel<double> pixel_of(const mtf::System<double>& system, const Sensor& sensor) {
  if (!sensor.settings.detector)
    throw mtf::UsageError("[detector]: missing; electrons need it: write [detector] quantum_efficiency = 0.75");
  const auto& thermal = sensor.settings.thermal;
  if (!thermal && !(system.frame.integration_time_s > 0.0))
    throw mtf::UsageError("frame.integration_time: missing; [detector] needs it, for example \"10 ms\"");
  if (const std::string why = frame_time_problem(system, sensor.settings); !why.empty()) throw mtf::UsageError(why);
  const ThermalReference<double> reference = thermal_reference(sensor);
  const Pixel<double> pixel = pixel_numbers(system, sensor.settings, {}, reference);
  if (thermal) require_thermal(*thermal, pixel.area_m2(), pixel.quantum_efficiency * reference.middle);
  require_valid("detector", pixel);
  return pixel;
}

Adc adc_of(const Sensor& sensor) {
  const auto& adc = sensor.settings.adc;
  if (!adc) throw mtf::UsageError("[adc]: missing; counts need it");
  const double well = sensor.settings.detector ? sensor.settings.detector->full_well_e : mtf::kInfinity;
  if (!adc->electrons_per_count && sensor.settings.thermal)
    throw mtf::UsageError("adc.volts_per_count: missing; give it, for example \"50 uV\"");
  if (!adc->electrons_per_count && !std::isfinite(well))
    throw mtf::UsageError(
        "adc.electrons_per_count: missing; give it, or detector.full_well, which then fills the range");
  Adc result{.electrons_per_count = adc->electrons_per_count.value_or(1.0),
             .offset_counts = adc->offset_counts,
             .bits = adc->bits,
             .rounding = adc->rounding};
  if (!adc->electrons_per_count) {
    const double counts = result.most_counts() - result.offset_counts;  // of a full well
    if (!(counts > 0.0))
      throw mtf::UsageError("adc.offset: " + mtf::format_double(adc->offset_counts) + " counts leave none of " +
                            mtf::format_double(result.most_counts()) + " for the full well");
    result.electrons_per_count = well / counts;
  }
  require_valid("adc", result);
  return result;
}

std::optional<double> adc_tolerance(const mtf::System<double>& system, const Sensor& sensor, double std) {
  if (!sensor.settings.adc || !(std > 0.0)) return std::nullopt;
  const double electrons = electrons_per_radiance(camera_of(system, sensor), pixel_of(system, sensor)) * std;
  const double tolerance = 0.1 * adc_of(sensor).electrons_per_count / electrons;
  return std::isfinite(tolerance) ? std::optional(std::min(tolerance, 1e-2)) : std::nullopt;
}

void require_output_stage(OutputStage stage, OutputStage last, bool has_converter, bool thermal) {
  if (!may_have_stage(stage, thermal))
    throw mtf::UsageError("stage " + output_stage_name(stage) +
                          (thermal ? ": a thermal detector has none; take watts or volts"
                                   : ": of thermal detectors alone ([detector] kind = \"thermal\"); take electrons"));
  if (stage > last)
    throw mtf::UsageError("stage " + output_stage_name(stage) + ": this sensor has none such; its last one is " +
                          output_stage_name(last));
  if (stage == OutputStage::dn && !has_converter)
    throw mtf::UsageError("stage dn: this sensor has no [adc], so no counts");
}

OutputStage last_output_stage(const mtf::System<double>& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  if (!system.list(mtf::Stage::postsample).empty() || s.correction || s.agc) return OutputStage::display;
  if (s.adc) return OutputStage::dn;
  return s.thermal ? OutputStage::volts : OutputStage::electrons;
}

std::string_view signal_unit(const Sensor& sensor) { return sensor.settings.thermal ? "V" : "e-"; }

std::string_view output_unit(const Sensor& sensor, OutputStage stage) {
  const bool thermal = sensor.settings.thermal.has_value();
  if (stage == OutputStage::radiance) return thermal ? "W.m^-2.sr^-1" : "ph.s^-1.m^-2.sr^-1";
  if (stage == OutputStage::irradiance) return thermal ? "W.m^-2" : "ph.s^-1.m^-2";
  if (stage == OutputStage::watts) return "W";
  if (stage == OutputStage::display && sensor.settings.agc) return "levels";
  return stage <= OutputStage::volts || !sensor.settings.adc ? signal_unit(sensor) : "counts";
}

std::string_view output_quantity(const Sensor& sensor, OutputStage stage) {
  const SpectralCamera& curves = sensor.curves;
  const bool weighted = !(curves.optics.empty() && curves.cold_filter.empty() && curves.quantum_efficiency.empty());
  const bool thermal = sensor.settings.thermal.has_value();
  if (stage == OutputStage::radiance)
    return thermal ? (weighted ? "weighted_radiance" : "radiance")
                   : (weighted ? "weighted_photon_radiance" : "photon_radiance");
  if (stage == OutputStage::irradiance)
    return thermal ? (weighted ? "weighted_irradiance" : "irradiance")
                   : (weighted ? "weighted_photon_irradiance" : "photon_irradiance");
  const std::string_view unit = output_unit(sensor, stage);
  return unit == "e-"       ? "electrons"
         : unit == "V"      ? "voltage"
         : unit == "W"      ? "power"
         : unit == "levels" ? "display"
                            : "counts";
}

int samples_a_pitch(const Sensor& sensor) {
  const auto& scan = sensor.settings.microscan;
  return scan ? scan->steps : 1;
}

CompiledChain::CompiledChain(const mtf::SensorPlan& filters, const mtf::System<double>& system, const Sensor& sensor,
                             std::int64_t columns, std::int64_t rows)
    : plan(filters), settings(sensor.settings) {
  last = last_output_stage(system, sensor);
  camera = camera_of(system, sensor);
  pixel = pixel_of(system, sensor);
  require_consistent(system, sensor);
  require_response(sensor);
  stages = stages_to_run(system, sensor);
  seed = settings.noise ? static_cast<std::uint64_t>(settings.noise->seed) : 0;
  if (settings.adc) adc = adc_of(sensor);
  if (settings.nonlinearity) response.emplace(*settings.nonlinearity, pixel.full_well_e);
  frame_time_s = settings.frame ? settings.frame->frame_time_s.value_or(pixel.integration_s) : pixel.integration_s;
  if (settings.thermal)
    set_thermal_noise(*this, sensor);
  else
    read_e = std::hypot(settings.detector->read_e, reset_e_of(*settings.detector), settings.detector->other_e);
  if (!settings.thermal && settings.frame_flicker) slow = settings.frame_flicker->noise();
  gain = radiometry::electrons_per_radiance(camera, pixel);
  focal_length_mm = system.frame.focal_length_mm;
  detector = focal_plane(system.frame.columns > 0 ? system.frame.columns : columns,
                         system.frame.rows > 0 ? system.frame.rows : rows, system.frame.pitch_x_um,
                         system.frame.pitch_y_um, settings.axis.value_or(OpticalAxis{}));
  curves = sensor.curves;
  emission = emission_of(settings);
  if (settings.thermal && settings.thermal->closes()) events = shutter_events(settings);
  const BandRadiances<double> radiances = own_radiances(curves, emission);
  warm = own_light(camera, pixel, radiances);
  if (!events) {
    const Directions<double> closed = closed_shutter(camera, pixel, radiances);
    warm = {warm.cone_e - closed.cone_e, warm.around_e - closed.around_e};
  }
  dark_e = signal(camera, pixel, BandRadiances<double>{}).dark_e;
}

Chain::Chain(const mtf::SensorPlan& plan, const mtf::System<double>& system, const Sensor& sensor, Origin origin,
             int threads, const Chain* before, bool keep_shading) {
  if (plan.readout.has_value() == system.list(mtf::Stage::readout).empty() ||
      plan.post.has_value() == system.list(mtf::Stage::postsample).empty())
    refuse("the plan of a chain",
           "made for other filters than [[readout]] and [[postsample]] of its sensor; compile "
           "it from the same system, with PlanOptions::separate_readout");
  const int steps = samples_a_pitch(sensor);
  const std::int64_t width = plan.out().width / steps, height = plan.out().height / steps;
  auto compiled = std::make_shared<CompiledChain>(plan, system, sensor, origin.x + width, origin.y + height);
  if (width * steps != plan.out().width || height * steps != plan.out().height)
    refuse("[microscan]", "the image is not a whole number of " + size_of(steps, steps) +
                              " positions; give frame.format, or a scene of whole pitches");
  if (before != nullptr) {
    const auto& owner = before->compiled_->corrected_by ? before->compiled_->corrected_by : before->compiled_;
    if (sensor.settings.correction && owner->settings.correction && owner->plan.out() == compiled->plan.out() &&
        owner->plan.samples_a_pitch == compiled->plan.samples_a_pitch)
      compiled->corrected_by = owner;
  }
  MapSource source = map_source(*compiled, sensor, origin, width, height);
  if (keep_shading && compiled->corrected_by && !same_shading(source, compiled->corrected_by->maps->made_from))
    source.shading = compiled->corrected_by->maps;
  const std::shared_ptr<const PixelMaps> known = before != nullptr ? before->compiled_->maps : nullptr;
  compiled->maps = known && known->made_from == source
                       ? known
                       : std::make_shared<const PixelMaps>(pixel_maps(*compiled, source, threads, known.get()));
  compiled_ = std::move(compiled);
}

double Chain::electrons_per_radiance() const { return compiled_->gain; }

std::vector<StageRow> stage_table() {
  std::vector<StageRow> table;
  for (const auto rows : {optics_rows(), light_rows(), charge_rows(), count_rows()})
    table.insert(table.end(), rows.begin(), rows.end());
  return table;
}

bool goes_through(StageRow::Part part, OutputStage stage) {
  constexpr std::array kFirst{OutputStage::radiance, OutputStage::electrons, OutputStage::dn, OutputStage::display,
                              OutputStage::display};
  return stage >= kFirst[static_cast<std::size_t>(part)];
}

std::string whole_image_stages(const System& system, const Sensor& sensor, OutputStage stage) {
  std::string text;
  for (const StageRow& row : stage_table())
    if (!row.whole_image.empty() && goes_through(row.part, stage) && row.words(system, sensor).on)
      text += (text.empty() ? "" : ", ") + std::string(row.name) + " (" + std::string(row.whole_image) + ")";
  return text;
}

std::vector<ChainStage> chain_stages(const System& system, const Sensor& sensor) {
  std::vector<ChainStage> stages;
  const auto add = [&](std::string_view name, StageWords words) {
    stages.push_back({std::string(name), words.on, std::move(words.what)});
  };
  if (!sensor.settings.detector) {
    for (const mtf::Stage stage : mtf::kStages) add(mtf::stage_name(stage), filters(system, stage));
    add("electrons", {false, "no [detector]: the output stays in the quantity of the scene"});
    return stages;
  }
  for (const StageRow& row : stage_table())
    if (row.words != nullptr) add(row.name, row.words(system, sensor));
  return stages;
}

std::vector<StageRow> stages_to_run(const System& system, const Sensor& sensor) {
  std::vector<StageRow> stages;
  for (const StageRow& row : stage_table())
    if (row.step != nullptr && (row.words == nullptr || row.words(system, sensor).on)) stages.push_back(row);
  return stages;
}

}  // namespace radiometry
