// SPDX-License-Identifier: Apache-2.0

// From mean electrons to the charge that a pixel holds and what its readout makes of it.

#include "radiometry/chain/steps/stage_rows.h"
#include "radiometry/stages/noise/dark_nonuniformity.h"

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

bool has_well(const Sensor& sensor) { return std::isfinite(sensor.settings.detector->full_well_e); }

std::string well_of(const Sensor& sensor) {
  return has_well(sensor) ? rounded(sensor.settings.detector->full_well_e) + " e-" : "";
}

}  // namespace

std::span<const StageRow> pixel_rows() {
  static constexpr StageRow kRows[] = {
      {.name = "dark nonuniformity",
       .require = [](const System&, const Sensor& sensor) -> void {
         const auto& unequal = sensor.settings.nonuniformity;
         if (sensor.settings.thermal && unequal && unequal->dcnu != 0.0)
           refuse("nonuniformity.dcnu", "a thermal detector has no dark current; remove it");
       },
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
       }},
      {.name = "full well",
       .words = [](const System&, const Sensor& sensor) -> StageWords {
         if (sensor.settings.thermal) return {false, kNotThermal};
         if (sensor.settings.blooming) return {false, "[blooming] takes its place"};
         return said(well_of(sensor), "no full_well in [detector]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         hold_well(run, electrons, fill_well);
         run.border = std::min(run.border, run.chain.pixel.full_well_e);
       }},
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
         hold_well(run, electrons, above_well);
         const Spilled spilled =
             bloom(electrons.view(), *run.chain.settings.blooming, run.chain.pixel.full_well_e, run.threads);
         run.frame.spilled.drained_e += spilled.drained_e;
         run.frame.spilled.left_e += spilled.left_e;
       }},
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
         return said(bent ? "a2 " + rounded(bent->a2) + ", a3 " + rounded(bent->a3) : "", "no [nonlinearity]");
       },
       .step = [](FrameRun& run, mtf::Image& electrons) -> void {
         apply_response(electrons.view(), *run.chain.response, run.threads);
         run.border = (*run.chain.response)(run.border);
       }},
      {.name = "readout",
       .whole_image = "filters pixels together with their neighbours",
       .words = filters<mtf::Stage::readout>,
       .step = [](FrameRun& run, mtf::Image& electrons) { filter(*run.chain.plan.readout, run, electrons); }}};
  return kRows;
}

}  // namespace radiometry
