// SPDX-License-Identifier: Apache-2.0

// What the readout adds to the charge: fixed patterns and noise.

#include "radiometry/chain/sensor_budget.h"
#include "radiometry/chain/steps/stage_rows.h"

namespace radiometry {

std::span<const StageRow> noise_rows() {
  static constexpr StageRow kRows[] = {
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
       .step = [](FrameRun& run, mtf::Image& electrons) { add_map(electrons.view(), run.map->view(), run.threads); }},
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
         if (run.chain.slow.strength > 0.0)
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
