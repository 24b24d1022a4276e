// SPDX-License-Identifier: Apache-2.0

// From mean electrons to the charge that a pixel holds, and what its readout makes of it and adds to it.

#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/steps/stage_rows.h"
#include "radiometry/stages/noise/fixed_pattern.h"

namespace radiometry {
namespace {

/// Limits the charge and counts the pixels that are held. `limit` is fill_well or above_well.
template <class Limit>
void hold_well(FrameRun& run, mtf::Image& image, const Limit& limit) {
  const HeldCounter::Counts held = run.counter.run(image, [&](mtf::ImageView<float> electrons) {
    return limit(electrons, run.chain.pixel.full_well_e, run.threads);
  });
  run.frame.well.high += held.all.high;
  run.frame.held.full_well += held.light().high;
  run.frame.held_defects.full_well += held.stuck.high;
}

void hold_border(FrameRun& run) { run.border = std::min(run.border, run.chain.pixel.full_well_e); }

mtf::DeviceRandom device_random(const FrameRun& run, const NoiseKey& key, Stream stream) {
  const Origin origin = run.maps.origin();
  return {key.seed, key.frame, static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(origin.x),
          static_cast<std::uint32_t>(origin.y)};
}

/// Lines that are fixed are those of all frames of a batch.
void add_lines_on_device(const FrameRun& run, mtf::DeviceImage& image, double rms, const NoiseKey& key, Stream stream,
                         bool of_rows) {
  if (rms == 0.0) return;
  const mtf::Image& pixels = run.frame.image;
  const Origin origin = run.maps.origin();
  const bool changes = stream == Stream::temporal_row || stream == Stream::temporal_column;
  std::vector<float> numbers;
  for (std::int64_t i = 0; i < (changes ? image.frames() : 1); ++i) {
    const NoiseKey of_frame{key.seed, key.frame + static_cast<std::uint32_t>(i) * image.step()};
    const auto lines = of_rows ? line_numbers(rms, of_frame, stream, origin.y, pixels.height())
                               : line_numbers(rms, of_frame, stream, origin.x, pixels.width());
    numbers.insert(numbers.end(), lines.begin(), lines.end());
  }
  image.add_lines(numbers, of_rows);
}

bool has_well(const Sensor& sensor) { return std::isfinite(sensor.settings.detector->full_well_e); }

std::string well_of(const Sensor& sensor) {
  return has_well(sensor) ? rounded(sensor.settings.detector->full_well_e) + " e-" : "";
}

}  // namespace

std::span<const StageRow> charge_rows() {
  static constexpr StageRow kRows[] = {
      {.name = "dark nonuniformity",
       .map = [](const DetectorSource& source, int threads) -> mtf::Image {
         if (!source.nonuniformity || !(source.nonuniformity->dcnu > 0.0)) return mtf::Image();
         mtf::Image map(source.width, source.height);
         dark_current_map(map.view(), source.nonuniformity->dcnu, source.seed, source.origin, threads);
         return map;
       },
       .words = [](const System& system, const Sensor& sensor) -> StageWords {
         if (sensor.settings.thermal) return {false, kNotThermal};
         const auto& unequal = sensor.settings.nonuniformity;
         if (!unequal || unequal->dcnu == 0.0) return {false, "no dcnu in [nonuniformity]"};
         const Pixel<double> pixel = pixel_of(system, sensor);
         return said(terms({{"spread", unequal->dcnu * pixel.dark_e_s * pixel.integration_s}}, "e- rms"),
                     "no dark_current in [detector]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         multiply_add(electrons, {}, {run.chain.dark_e, run.map, -run.chain.dark_e}, run.threads);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         electrons.multiply_add({}, in_float({run.chain.dark_e, run.map, -run.chain.dark_e}, true));
       }},
      {.name = "defects",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& defects = sensor.settings.defects;
         return said(defects ? terms({{"dead", defects->dead_fraction}, {"hot", defects->hot_fraction}}, "of all") : "",
                     "no [defects]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         apply_defects(electrons.view(), run.maps.detector->defects);
         run.counter.mark(run.maps.detector->defects);
       }},
      {.name = "blinking",
       .timing = "defects",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& blinking = sensor.settings.blinking;
         return said(blinking ? rounded(blinking->fraction) + " of all" : "", "no [blinking]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         run.counter.mark(apply_blinking(electrons.view(), run.maps.detector->blinking, *run.chain.settings.blinking,
                                         run.key, run.maps.origin()));
       }},
      {.name = "shot noise",
       .timing = "shot",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& noise = sensor.settings.noise;
         if (sensor.settings.thermal) return {false, kNotThermal};
         if (!noise) return {false, "no [noise]"};
         return said(noise->shot ? "Poisson" : "", "shot = false in [noise]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         shot_noise(electrons.view(), run.key, run.maps.origin(), run.threads, run.noise_rows);
         run.frame.noise_rows = run.noise_rows;
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         electrons.shot_noise(device_random(run, run.key, Stream::shot));
       }},
      {.name = "full well",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         if (sensor.settings.thermal) return {false, kNotThermal};
         if (sensor.settings.blooming) return {false, "[blooming] takes its place"};
         return said(well_of(sensor), "no full_well in [detector]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void { hold_well(run, electrons, fill_well); },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         electrons.hold_well(static_cast<float>(run.chain.pixel.full_well_e));
       },
       .border = hold_border},
      {.name = "blooming",
       .whole_image = "spills charge over any number of pixels",
       .require = [](const System&, const Sensor& sensor) -> void {
         if (!sensor.settings.blooming) return;
         if (sensor.settings.thermal)
           refuse("[blooming]", "of a thermal detector, which has no well whose charge could spill; remove it");
         if (!has_well(sensor)) refuse("[blooming]", "needs detector.full_well, above which charge spills");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         return said(sensor.settings.blooming ? "above " + well_of(sensor) : "", "no [blooming]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         const Spilled spilled =
             bloom(electrons.view(), *run.chain.settings.blooming, run.chain.pixel.full_well_e, run.threads);
         hold_well(run, electrons, above_well);  // with those that spilled charge has filled
         run.frame.spilled.drained_e += spilled.drained_e;
         run.frame.spilled.left_e += spilled.left_e;
       },
       .border = hold_border},
      {.name = "nonlinearity",
       .require = [](const System& system, const Sensor& sensor) -> void {
         if (!sensor.settings.nonlinearity) return;
         if (sensor.settings.thermal)
           refuse("[nonlinearity]",
                  "its coefficients refer to a full well, which a thermal detector does not have; remove it");
         if (!has_well(sensor)) refuse("[nonlinearity]", "needs detector.full_well, which its coefficients refer to");
         Response(*sensor.settings.nonlinearity, pixel_of(system, sensor).full_well_e);
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& bent = sensor.settings.nonlinearity;
         return said(bent ? "a2 " + rounded(bent->a2) + ", a3 " + rounded(bent->a3) + ", a4 " + rounded(bent->a4) : "",
                     "no [nonlinearity]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         apply_response(electrons.view(), *run.chain.response, run.threads);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         const Nonlinearity& bent = *run.chain.settings.nonlinearity;
         electrons.bend(run.chain.pixel.full_well_e, bent.a2, bent.a3, bent.a4);
       },
       .border = [](FrameRun& run) { run.border = (*run.chain.response)(run.border); }},
      {.name = "readout",
       .whole_image = "filters pixels together with their neighbours",
       .words = filters<mtf::Stage::readout>,
       .step = [](FrameRun& run, mtf::Image& electrons) { filter(*run.chain.plan.readout, run, electrons); }},
      {.name = "offsets",
       .timing = "offset",
       .map = [](const DetectorSource& source, int threads) -> mtf::Image {
         if (!source.nonuniformity) return mtf::Image();
         mtf::Image map = part_of(source.offset, "nonuniformity.offset", source);
         if (map.size() > 0 || !(source.nonuniformity->dsnu_e > 0.0)) return map;
         map = mtf::Image(source.width, source.height);
         offset_map(map.view(), source.nonuniformity->dsnu_e, source.seed, source.origin, threads);
         return map;
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& unequal = sensor.settings.nonuniformity;
         if (sensor.offset && unequal) return {true, map_words(unequal->offset)};
         return said(terms({{"dsnu", unequal ? unequal->dsnu_e : 0.0}}, rms_unit(sensor)),
                     "no dsnu in [nonuniformity]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) { add_map(electrons.view(), run.map->view(), run.threads); },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) { electrons.add(run.map); }},
      {.name = "read noise",
       .timing = "read",
       .require = [](const System&, const Sensor& sensor) -> void {
         const SensorSettings& s = sensor.settings;
         if (s.thermal && s.thermal->corner_hz && !(s.frame && s.frame->frame_time_s))
           refuse("frame.frame_time", "missing; 1/f noise is correlated from frame to frame: for example \"20 ms\"");
         if (s.thermal && s.thermal->corner_hz && s.microscan)
           refuse("detector.corner",
                  "1/f noise between the positions of [microscan] is not modelled; remove one of the two");
         if (s.detector->capacitance_f.has_value() != s.detector->temperature_k.has_value())
           refuse("[detector]", "capacitance and temperature go together; they give the reset noise");
         if (s.detector->capacitance_f && s.detector->reset_e > 0.0)
           refuse("detector.reset_noise", "given beside capacitance; remove one of them");
       },
       .words = [](const System& system, const Sensor& sensor) -> StageWords {
         if (!sensor.settings.noise) return {false, "no [noise]"};
         if (sensor.settings.thermal) {
           const double volts = thermal_volts(sensor.settings, pixel_of(system, sensor), thermal_reference(sensor));
           return said(terms({{"pixel and readout", volts}}, rms_unit(sensor)) +
                           (sensor.settings.thermal->corner_hz ? ", its 1/f part correlated from frame to frame" : ""),
                       "no noise beside the rounding of [adc]");
         }
         const DetectorSettings& detector = *sensor.settings.detector;
         return said(
             terms({{"read", detector.read_e}, {"reset", reset_e_of(detector)}, {"other", detector.other_e}}, "e- rms"),
             "no read_noise in [detector]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         add_gaussian(electrons.view(), run.chain.read_e, run.key, Stream::read, run.maps.origin(), run.threads,
                      run.noise_rows);
         run.frame.noise_rows = run.noise_rows;
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         if (run.chain.read_e > 0.0)
           electrons.add_gaussian(static_cast<float>(run.chain.read_e), device_random(run, run.key, Stream::read));
       }},
      {.name = "1/f noise from frame to frame",
       .timing = "read",
       .require = [](const System&, const Sensor& sensor) -> void {
         if (!sensor.settings.frame_flicker) return;
         if (sensor.settings.thermal)
           refuse("[frame_flicker]",
                  "of a thermal detector, whose 1/f noise is detector.corner and lowest_frequency; remove it");
         if (sensor.settings.microscan)
           refuse("[frame_flicker]",
                  "1/f noise between the positions of [microscan] is not modelled; remove one of the two");
       },
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const SensorSettings& s = sensor.settings;
         if (!s.noise) return {false, "no [noise]"};
         if (s.thermal)
           return said(s.thermal->corner_hz ? "corner at " + rounded(*s.thermal->corner_hz) + " Hz" : "",
                       "no corner in [detector]");
         return said(terms({{"octave", s.frame_flicker ? s.frame_flicker->octave_e : 0.0}}, "e- rms"),
                     "no octave in [frame_flicker]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         add_frame_flicker(electrons.view(), run.chain.slow, run.key, run.maps.origin(), run.threads, run.noise_rows);
         run.frame.noise_rows = run.noise_rows;
       }},
      {.name = "1/f noise",
       .timing = "flicker",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& flicker = sensor.settings.flicker;
         return said(flicker ? "corner at " + rounded(flicker->corner_cy_px) + " of the pixel clock" : "",
                     "no [flicker]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         const CompiledChain& chain = run.chain;
         add_flicker(electrons.view(), *chain.settings.flicker, chain.detector.columns, chain.detector.rows, run.key,
                     run.maps.origin(), run.threads);
       }},
      {.name = "row and column noise",
       .timing = "rows and columns",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& noise = sensor.settings.noise;
         if (!noise) return {false, "no [noise]"};
         return said(terms({{"row", noise->row_e},
                            {"column", noise->column_e},
                            {"fixed row", noise->fixed_row_e},
                            {"fixed column", noise->fixed_column_e}},
                           rms_unit(sensor)),
                     "no row or column in [noise]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         const NoiseSettings& noise = *run.chain.settings.noise;
         const NoiseKey fixed{run.key.seed, 0};
         const Origin origin = run.maps.origin();
         add_row_noise(electrons.view(), noise.row_e, run.key, Stream::temporal_row, origin);
         add_column_noise(electrons.view(), noise.column_e, run.key, Stream::temporal_column, origin);
         add_row_noise(electrons.view(), noise.fixed_row_e, fixed, Stream::fixed_row, origin);
         add_column_noise(electrons.view(), noise.fixed_column_e, fixed, Stream::fixed_column, origin);
       },
       .step_on_device = [](FrameRun& run, mtf::DeviceImage& electrons) -> void {
         const NoiseSettings& noise = *run.chain.settings.noise;
         const NoiseKey fixed{run.key.seed, 0};
         add_lines_on_device(run, electrons, noise.row_e, run.key, Stream::temporal_row, true);
         add_lines_on_device(run, electrons, noise.column_e, run.key, Stream::temporal_column, false);
         add_lines_on_device(run, electrons, noise.fixed_row_e, fixed, Stream::fixed_row, true);
         add_lines_on_device(run, electrons, noise.fixed_column_e, fixed, Stream::fixed_column, false);
       }},
      {.name = "3-D noise",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         const auto& cube = sensor.settings.noise_3d;
         return said(cube ? terms({{"total", cube->total()}}, rms_unit(sensor)) : "", "no [noise_3d]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         add_noise_3d(electrons.view(), *run.chain.settings.noise_3d, run.key, run.maps.origin(), run.threads);
       }}};
  return kRows;
}

}  // namespace radiometry
