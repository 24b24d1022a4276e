// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain.h"

#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/chain_impl.h"
#include "radiometry/light/band_response.h"
#include "radiometry/performance/sensor_numbers.h"

namespace radiometry {
namespace {

/// The part of a map of the whole detector that an image at `origin` has.
mtf::Image crop(const mtf::Image& map, const char* what, const FocalPlane& detector, Origin origin, std::int64_t width,
                std::int64_t height) {
  if (map.width() != detector.columns || map.height() != detector.rows)
    throw mtf::UsageError(std::string(what) + ": the map has " + std::to_string(map.width()) + "x" +
                          std::to_string(map.height()) + " pixels, the detector " + std::to_string(detector.columns) +
                          "x" + std::to_string(detector.rows) + "; give a map of the whole detector");
  mtf::Image part(width, height);
  for (std::int64_t y = 0; y < height; ++y)
    std::copy_n(map.data() + (origin.y + y) * map.width() + origin.x, width, part.data() + y * width);
  return part;
}

/// factors *= map; an empty image stands for factors of 1.
void multiply(mtf::Image& factors, mtf::Image&& map) {
  if (map.size() == 0) return;
  if (factors.size() == 0)
    factors = std::move(map);
  else
    multiply_by(factors.view(), map.view());
}

/// number x map + added, or number + added where there is no map.
Factor factor_of(double number, const mtf::Image& map, double added) {
  Factor result{number + added};
  if (map.size() == 0 || number == 0.0) return result;
  result.map = mtf::Image(map.width(), map.height());
  for (std::int64_t i = 0; i < map.size(); ++i)
    result.map.data()[i] = static_cast<float>(number * static_cast<double>(map.data()[i]) + added);
  return result;
}

void refuse(const char* where, const std::string& why) { throw mtf::UsageError(std::string(where) + ": " + why); }

}  // namespace

void require_consistent(const mtf::System<double>& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  if (!s.detector) return;
  camera_of(system, sensor);
  stop_range(sensor.curves, s.optics.value_or(OpticsSettings{}).stop_band);
  const Pixel<double> pixel = pixel_of(system, sensor);
  if (s.adc) adc_of(sensor);
  if (s.nonlinearity && std::isfinite(pixel.full_well_e)) Response(*s.nonlinearity, pixel.full_well_e);
  if (s.microscan) {
    require_valid("microscan", *s.microscan);
    if (!system.list(mtf::Stage::readout).empty())
      refuse("[microscan]",
             "together with [[readout]]: a readout filter acts on one frame, not on what is put together of several; "
             "remove one of them");
    if (s.lag || (s.shutter && s.shutter->kind == ShutterKind::rolling))
      refuse("[microscan]",
             "together with [lag] or a rolling [shutter], which follow one position; remove one of them");
  }
  if (s.vignetting && !s.vignetting->map.empty() &&
      (s.vignetting->a2 != 0.0 || s.vignetting->a4 != 0.0 || s.vignetting->a6 != 0.0))
    refuse("vignetting.map", "given beside a2, a4 or a6; remove one of them");
  if (s.shutter && s.shutter->kind == ShutterKind::rolling && !(s.shutter->line_time_s > 0.0))
    refuse("shutter.line_time", "missing; a rolling shutter needs it, for example \"30 us\"");
  const bool well = std::isfinite(s.detector->full_well_e);
  if (s.nonlinearity && !well) refuse("[nonlinearity]", "needs detector.full_well, which its coefficients refer to");
  if (s.blooming && !well) refuse("[blooming]", "needs detector.full_well, above which charge spills");
  if (s.correction && !well) refuse("[correction]", "needs detector.full_well, of which low and high are parts");
  if (s.detector->capacitance_f.has_value() != s.detector->temperature_k.has_value())
    refuse("[detector]", "capacitance and temperature go together; they give the reset noise");
  if (s.detector->capacitance_f && s.detector->reset_e > 0.0)
    refuse("detector.reset_noise", "given beside capacitance; remove one of them");
}

void require_response(const Sensor& sensor) {
  const char* const detector = "detector.quantum_efficiency";
  if (sensor.settings.detector && sensor.settings.detector->quantum_efficiency.file.empty() &&
      sensor.settings.detector->quantum_efficiency.number == 0.0)
    refuse(detector, "0, so that no light makes electrons; give the electrons per photon, for example 0.75");
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
      refuse(key, curve.source + " is 0 everywhere in the band of " + describe(all.band) +
                      ", so that no light makes electrons; check its values, and that its wavelengths are in um");
    }
  };
  check(detector, sensor.curves.quantum_efficiency);
  check("optics.transmission", sensor.curves.optics);
  check("optics.cold_transmission", sensor.curves.cold_filter);
  if (names.empty() || BandResponse(all.band, all.curves).integral() > 0.0) return;
  refuse(sensor.curves.quantum_efficiency.empty() ? "optics.transmission" : detector,
         "the curves " + names + " multiply to 0 everywhere in the band of " + describe(all.band) +
             ", so that no light makes electrons; check that they overlap there, with wavelengths in um");
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
  if (!(system.frame.integration_time_s > 0.0))
    throw mtf::UsageError("frame.integration_time: missing; [detector] needs it, for example \"10 ms\"");
  const Pixel<double> pixel = pixel_numbers(system, sensor.settings);
  require_valid("detector", pixel);
  return pixel;
}

Adc adc_of(const Sensor& sensor) {
  const auto& adc = sensor.settings.adc;
  if (!adc) throw mtf::UsageError("[adc]: missing; counts need it");
  const double well = sensor.settings.detector ? sensor.settings.detector->full_well_e : mtf::kInfinity;
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

void require_output_stage(OutputStage stage, OutputStage last, bool has_converter) {
  if (stage > last)
    throw mtf::UsageError("stage " + output_stage_name(stage) + ": this sensor has none such; its last one is " +
                          output_stage_name(last));
  if (stage == OutputStage::dn && !has_converter)
    throw mtf::UsageError("stage dn: this sensor has no [adc], so no counts");
}

OutputStage last_output_stage(const mtf::System<double>& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  if (!system.list(mtf::Stage::postsample).empty() || s.correction || s.agc) return OutputStage::display;
  return s.adc ? OutputStage::dn : OutputStage::electrons;
}

std::string_view output_unit(const Sensor& sensor, OutputStage stage) {
  if (stage == OutputStage::radiance) return "ph.s^-1.m^-2.sr^-1";
  if (stage == OutputStage::irradiance) return "ph.s^-1.m^-2";
  if (stage == OutputStage::display && sensor.settings.agc) return "levels";
  return stage == OutputStage::electrons || !sensor.settings.adc ? "e-" : "counts";
}

std::string_view output_quantity(const Sensor& sensor, OutputStage stage) {
  const SpectralCamera& curves = sensor.curves;
  const bool weighted = !(curves.optics.empty() && curves.cold_filter.empty() && curves.quantum_efficiency.empty());
  if (stage == OutputStage::radiance) return weighted ? "weighted_photon_radiance" : "photon_radiance";
  if (stage == OutputStage::irradiance) return weighted ? "weighted_photon_irradiance" : "photon_irradiance";
  const std::string_view unit = output_unit(sensor, stage);
  return unit == "e-" ? "electrons" : unit == "levels" ? "display" : "counts";
}

int samples_a_pitch(const Sensor& sensor) {
  const auto& scan = sensor.settings.microscan;
  return scan ? scan->steps : 1;
}

Chain::Chain(const mtf::SensorPlan& plan, const mtf::System<double>& system, const Sensor& sensor, Origin origin,
             int threads, const Chain* before) {
  const SensorSettings& s = sensor.settings;
  if (plan.readout.has_value() == system.list(mtf::Stage::readout).empty() ||
      plan.post.has_value() == system.list(mtf::Stage::postsample).empty())
    refuse("the plan of a chain",
           "made for other filters than [[readout]] and [[postsample]] of its sensor; compile "
           "it from the same system, with PlanOptions::separate_readout");
  auto compiled = std::make_shared<CompiledChain>(plan);
  compiled->last = last_output_stage(system, sensor);
  compiled->camera = camera_of(system, sensor);
  compiled->pixel = pixel_of(system, sensor);
  require_consistent(system, sensor);
  require_response(sensor);
  compiled->stages = stages_to_run(system, sensor);
  compiled->settings = s;
  compiled->seed = s.noise ? static_cast<std::uint64_t>(s.noise->seed) : 0;
  compiled->origin = origin;
  if (s.adc) compiled->adc = adc_of(sensor);
  if (s.nonlinearity) compiled->response.emplace(*s.nonlinearity, compiled->pixel.full_well_e);
  compiled->frame_time_s =
      s.frame ? s.frame->frame_time_s.value_or(compiled->pixel.integration_s) : compiled->pixel.integration_s;
  compiled->read_e = std::hypot(s.detector->read_e, reset_e_of(*s.detector), s.detector->other_e);
  compiled->gain = radiometry::electrons_per_radiance(compiled->camera, compiled->pixel);

  const int cores = mtf::threads_of(threads), steps = samples_a_pitch(sensor);
  const std::int64_t width = plan.out().width / steps, height = plan.out().height / steps;
  if (width * steps != plan.out().width || height * steps != plan.out().height)
    refuse("[microscan]", "the image is not a whole number of " + std::to_string(steps) + " x " +
                              std::to_string(steps) + " positions; give frame.format, or a scene of whole pitches");
  require_on_detector(origin, width, height);
  compiled->detector = focal_plane(system.frame.columns > 0 ? system.frame.columns : origin.x + width,
                                   system.frame.rows > 0 ? system.frame.rows : origin.y + height,
                                   system.frame.pitch_x_um, system.frame.pitch_y_um, s.axis.value_or(OpticalAxis{}));

  const OpticsSettings warm = s.optics.value_or(OpticsSettings{});
  const BandRadiances<double> radiances = band_radiances(sensor.curves, {.temperature_k = 0.0}, {}, emission_of(warm));
  const Signal<double> background =
      signal(compiled->camera, compiled->pixel,
             {.scene = 0.0, .path = 0.0, .optics = radiances.optics, .stop = radiances.stop});

  const auto detector_map = [&](const std::shared_ptr<const mtf::Image>& whole, const char* what) {
    return whole ? crop(*whole, what, compiled->detector, origin, width, height) : mtf::Image();
  };
  if (s.vignetting) {
    const mtf::Image given = detector_map(sensor.vignetting, "vignetting.map");
    compiled->corners = mtf::Image(width, height);
    vignetting_map(compiled->corners.view(), *s.vignetting, compiled->detector, system.frame.focal_length_mm, origin,
                   given.view());
  }
  mtf::Image responsivity, offset;
  if (const auto& unequal = s.nonuniformity) {
    responsivity = detector_map(sensor.responsivity, "nonuniformity.responsivity");
    if (responsivity.size() == 0 && unequal->prnu > 0.0) {
      responsivity = mtf::Image(width, height);
      responsivity_map(responsivity.view(), unequal->prnu, compiled->seed, origin, cores);
    }
    offset = detector_map(sensor.offset, "nonuniformity.offset");
    if (offset.size() == 0 && unequal->dsnu_e > 0.0) {
      offset = mtf::Image(width, height);
      offset_map(offset.view(), unequal->dsnu_e, compiled->seed, origin, cores);
    }
  }
  compiled->offset = std::move(offset);

  mtf::Image seen = compiled->corners.clone(), around;
  multiply(seen, responsivity.clone());
  compiled->light = factor_of(compiled->gain, seen, 0.0);
  if (s.narcissus) {
    around = mtf::Image(width, height);
    narcissus_map(around.view(), *s.narcissus, compiled->detector, origin);
    for (float& missing : std::span(around.data(), static_cast<std::size_t>(around.size()))) missing = 1.0F - missing;
  }
  multiply(around, std::move(responsivity));
  compiled->glow = factor_of(background.optics_e + background.stop_e, around, background.dark_e);

  if (s.defects) compiled->defects = find_defects(width, height, *s.defects, compiled->seed, origin);
  if (s.blinking) compiled->blinking = find_blinking(width, height, *s.blinking, compiled->seed, origin);
  if (before != nullptr) {
    const auto& owner = before->compiled_->corrected_by ? before->compiled_->corrected_by : before->compiled_;
    if (s.correction && owner->settings.correction && owner->plan.out() == compiled->plan.out())
      compiled->corrected_by = owner;
  }
  compiled_ = std::move(compiled);
}

double Chain::electrons_per_radiance() const { return compiled_->gain; }

}  // namespace radiometry
