// SPDX-License-Identifier: Apache-2.0

// From light to the mean electrons of each pixel, and what they keep from frame to frame. Light, vignetting and the
// rows from the warm optics to the dark current act in `collect`; Chain::run makes the positions of `microscan`.

#include "radiometry/chain/steps/stage_rows.h"

namespace radiometry {
namespace {

bool rolls(const SensorSettings& s) { return s.shutter && s.shutter->kind == ShutterKind::rolling; }
bool has_frame_time(const SensorSettings& s) { return s.frame && s.frame->frame_time_s; }

/// A thermal pixel has one time constant, which is counted once.
void require_lag(const System& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  if (!s.thermal) return;
  const ThermalSettings& thermal = *s.thermal;
  const std::optional<MovingBolometer> moving = moving_bolometer(system);
  if (moving && thermal.heat_capacity_j_k && thermal.conductance_w_k) {
    const double own_s = *thermal.heat_capacity_j_k / *thermal.conductance_w_k;
    if (!(std::abs(moving->time_constant_s - own_s) <= 1e-6 * own_s))
      refuse("[detector]", "heat_capacity / conductance is " + mtf::format_double(own_s) + " s, \"" + moving->label +
                               "\" of [[presample]] has " + mtf::format_double(moving->time_constant_s) +
                               " s; a pixel has one time constant: give the component the first");
  }
  if (!s.lag) return;
  if (moving)
    refuse("[lag]", "counts the thermal time constant of the pixels, which \"" + moving->label +
                        "\" of [[presample]] counts too; keep [lag] for sequences, the component for single images of "
                        "steady motion");
  if (!has_frame_time(s))
    refuse("frame.frame_time",
           "missing; the [lag] of a thermal detector goes from frame to frame: for example \"20 ms\"");
}

/// What the shutter of a thermal camera needs, and what needs one.
void require_closing(const System&, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  if (!s.thermal) return;
  const ThermalSettings& thermal = *s.thermal;
  const bool closes = thermal.closes();
  const bool before_optics = thermal.shutter_place == ShutterPlace::optics;
  for (const auto& [key, given] : {std::pair{"detector.shutter_place", before_optics},
                                   std::pair{"detector.shutter_drift", thermal.drift_k_s != 0.0},
                                   std::pair{"detector.shutter_interval", thermal.shutter_interval_s.has_value()},
                                   std::pair{"detector.shutter_frames", thermal.shutter_frames > 0}})
    if (given && !thermal.shutter_k)
      refuse(key, "belongs to a shutter, which has no temperature; give detector.shutter_temperature, or remove it");
  if (!thermal.shutter_k) return;
  const double housing_k = s.optics.value_or(OpticsSettings{}).stop_temperature_k;
  if (!before_optics && !(housing_k > 0.0))
    refuse("detector.shutter_temperature",
           "the signal is the difference to a shutter that fills the hemisphere of a pixel, and what the pixel sees "
           "around the lens has no temperature; give optics.stop_temperature, that of the housing");
  if (thermal.shutter_interval_s && thermal.shutter_frames > 0)
    refuse("detector.shutter_frames", "given beside shutter_interval, which says the same in time; remove one of them");
  if (thermal.drift_k_s != 0.0 && !closes)
    refuse("detector.shutter_drift",
           "the signal is the difference to the shutter when it closed last; give shutter_interval, for example "
           "\"60 s\", or shutter_frames");
  if (closes && !has_frame_time(s))
    refuse("frame.frame_time", "missing; a shutter that closes now and then needs it: for example \"20 ms\"");
  if (thermal.shutter_interval_s && *thermal.shutter_interval_s < (1.0 - 1e-9) * *s.frame->frame_time_s)
    refuse("detector.shutter_interval",
           mtf::format_double(*thermal.shutter_interval_s) + " s is shorter than frame.frame_time, " +
               mtf::format_double(*s.frame->frame_time_s) +
               " s; give that at least, or remove it: without it every frame has an offset of its own");
}

void add_offset(mtf::Image& image, const Linear& offset, int threads) { multiply_add(image, {}, offset, threads); }
void add_offset(mtf::DeviceImage& image, const Linear& offset, int) { image.multiply_add({}, in_float(offset, true)); }

/// Adds light of the camera itself to a frame of volts.
template <class Frame>
void add_glow(FrameRun& run, Frame& image, const Directions<double>& light) {
  if (light.cone_e == 0.0 && light.around_e == 0.0) return;
  add_offset(image, glow_of(run.chain, light, run.maps.corners, run.maps.detector->responsivity, 0.0, run.threads),
             run.threads);
  run.border += light.total_e();
}

/// What follows the light of the scene: the border, and what the camera has warmed since frame 0.
template <class Frame>
void warm_up(FrameRun& run, Frame& image) {
  const CompiledChain& chain = run.chain;
  run.border = chain.gain * run.border + chain.glow_e();
  if (chain.events) add_glow(run, image, warming_of(chain, run.number));
}

}  // namespace

std::span<const StageRow> light_rows() {
  using enum StageRow::Part;
  static constexpr StageRow kRows[] = {
      {.name = "light",
       .words = [](const System& system, const Sensor& sensor) -> StageWords {
         const Camera<double> camera = camera_of(system, sensor);
         const bool weighted = output_quantity(sensor, OutputStage::irradiance).starts_with("weighted");
         const auto& thermal = sensor.settings.thermal;
         std::string what = rounded(electrons_per_radiance(camera, pixel_of(system, sensor))) + " " +
                            std::string(signal_unit(sensor)) + " for 1 " + (thermal ? "W" : "ph s^-1") + " m^-2 sr^-1" +
                            (weighted ? ", weighted by the curves" : "") + "; cone of " + rounded(cone_sr(camera)) +
                            " sr by the " + std::string(kConeNames[static_cast<std::size_t>(camera.cone)]);
         if (thermal && thermal->shutter_k)
           what += std::string("; less that of a shutter before the ") +
                   (thermal->shutter_place == ShutterPlace::optics ? "optics" : "detector") + " at " +
                   rounded(*thermal->shutter_k) + " K";
         return {true, std::move(what)};
       }},
      {.name = "vignetting",
       .require = [](const System&, const Sensor& sensor) -> void {
         const auto& corners = sensor.settings.vignetting;
         if (corners && !corners->map.empty() && (corners->a2 != 0.0 || corners->a4 != 0.0 || corners->a6 != 0.0))
           refuse("vignetting.map", "given beside a2, a4 or a6; remove one of them");
         if (corners && corners->of == VignettingOf::wavefront &&
             (!corners->map.empty() || corners->a2 != 0.0 || corners->a4 != 0.0 || corners->a6 != 0.0))
           refuse("vignetting.of", "wavefront, beside a map, a2, a4 or a6; remove one of them");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& corners = sensor.settings.vignetting;
         if (!corners) return {false, "no [vignetting]"};
         if (corners->of == VignettingOf::wavefront)
           return {true, std::string(corners->cos4 ? "cos^4 of the field angle, and " : "") +
                             "the share of the pupil that rims leave"};
         if (sensor.vignetting) return {true, map_words(corners->map)};
         return {true, corners->cos4 ? "cos^4 of the field angle, and a polynomial" : "a polynomial"};
       }},
      // Its steps run in the detector's part; its finer sampling is in the image of every output stage.
      {.name = "microscan",
       .part = optics,
       .whole_image = "samples between the pixels, where tiles sample at the pitch",
       .require = [](const System& system, const Sensor& sensor) -> void {
         const SensorSettings& s = sensor.settings;
         if (!s.microscan) return;
         require_valid("microscan", *s.microscan);
         if (!system.list(mtf::Stage::readout).empty())
           refuse("[microscan]",
                  "together with [[readout]]: a readout filter acts on one frame, not on what is put together of "
                  "several; remove one of them");
         if (s.lag || rolls(s))
           refuse("[microscan]",
                  "together with [lag] or a rolling [shutter], which follow one position; remove one of them");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& scan = sensor.settings.microscan;
         return said(scan ? std::to_string(scan->positions()) + " positions" : "", "no [microscan]");
       }},
      {.name = "shutter",
       .in_sequence = true,
       .require = [](const System&, const Sensor& sensor) -> void {
         const SensorSettings& s = sensor.settings;
         if (!rolls(s)) return;
         if (s.thermal && !has_frame_time(s))
           refuse("frame.frame_time",
                  "missing; a rolling readout needs the time from frame to frame: for example \"20 ms\"");
         if (!(s.shutter->line_time_s > 0.0))
           refuse("shutter.line_time", "missing; a rolling shutter needs it, for example \"30 us\"");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& shutter = sensor.settings.shutter;
         if (!shutter) return {false, "no [shutter]: global"};
         if (!rolls(sensor.settings)) return {false, "global"};
         return {true, "rolling, " + rounded(shutter->line_time_s) + " s a row, over a sequence"};
       },
       .step = [](FrameRun& run, mtf::Image& radiance) -> void {
         const CompiledChain& chain = run.chain;
         ShutterState& state = run.state->shutter;
         if (run.frames_passed > 1) state = {};
         apply_shutter(radiance.view(), *chain.settings.shutter, chain.frame_time_s, chain.detector.rows, state,
                       run.maps.origin().y);
       }},
      {.name = "warm optics",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const OpticsSettings warm = sensor.settings.optics.value_or(OpticsSettings{});
         return said(terms({{"emit at", warm.emissivity > 0.0 ? warm.temperature_k : 0.0}}, "K"),
                     "no temperature or emissivity in [optics]");
       }},
      {.name = "stop",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const OpticsSettings warm = sensor.settings.optics.value_or(OpticsSettings{});
         const std::string emits =
             terms({{"emits at", warm.stop_emissivity > 0.0 ? warm.stop_temperature_k : 0.0}}, "K");
         if (emits.empty()) return {false, "no stop_temperature in [optics]"};
         return {true, emits + ", counted from " + describe(stop_range(sensor.curves, warm.stop_band)) +
                           ", past the cold filter"};
       }},
      {.name = "narcissus",
       .require = [](const System&, const Sensor& sensor) -> void {
         if (sensor.settings.thermal && sensor.settings.narcissus)
           refuse("[narcissus]",
                  "the pixels of a thermal detector are as warm as what they see around the lens; remove it");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& dark = sensor.settings.narcissus;
         return said(dark ? rounded(dark->depth) + " of the background" : "", "no [narcissus]");
       }},
      {.name = "responsivity",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& unequal = sensor.settings.nonuniformity;
         if (sensor.responsivity && unequal) return {true, map_words(unequal->responsivity)};
         const NonuniformitySettings rms = unequal.value_or(NonuniformitySettings{});
         return said(terms({{"prnu", rms.prnu}, {"rows", rms.prnu_row}, {"columns", rms.prnu_column}}, "rms"),
                     "no prnu in [nonuniformity]");
       }},
      {.name = "dark current",
       .words = [](const System& system, const Sensor& sensor) -> StageWords {
         const Pixel<double> pixel = pixel_of(system, sensor);
         if (pixel.thermal()) return {false, kNotThermal};
         return said(terms({{"mean", pixel.dark_e_s * pixel.integration_s}}, "e-"), "no dark_current in [detector]");
       }},
      {.name = "collect",
       .step = [](FrameRun& run, mtf::Image& image) -> void {
         multiply_add(image, run.maps.light, run.maps.glow, run.threads);
         warm_up(run, image);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& image) -> void {
         image.multiply_add(in_float(run.maps.light, false), in_float(run.maps.glow, true));
         warm_up(run, image);
       }},
      {.name = "lag",
       .in_sequence = true,
       .require = require_lag,
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& lag = sensor.settings.lag;
         return said(lag ? rounded(lag->time_constant_s) + " s, over a sequence" : "", "no [lag]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         const double passed_s = run.frames_passed * run.chain.frame_time_s;
         apply_lag(electrons.view(), *run.chain.settings.lag, passed_s, run.state->lag);
       }},
      {.name = "shutter offset",
       .require = require_closing,
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& thermal = sensor.settings.thermal;
         if (!thermal) return {false, "of thermal detectors alone"};
         const double drift = thermal->drift_k_s;
         const std::string warming = drift == 0.0 ? "" : ", while the camera warms by " + rounded(drift) + " K/s";
         if (thermal->shutter_frames > 0)
           return {true, "new every " + std::to_string(thermal->shutter_frames) + " frames" + warming};
         return said(
             thermal->shutter_interval_s ? "new every " + rounded(*thermal->shutter_interval_s) + " s" + warming : "",
             "no shutter_interval or shutter_frames in [detector]");
       },
       .step = [](FrameRun& run, mtf::Image& volts) -> void {
         const Directions<double> closed = last_closed(run.chain, run.number, run.state);
         add_glow(run, volts, {-closed.cone_e, -closed.around_e});
       }}};
  return kRows;
}

}  // namespace radiometry
