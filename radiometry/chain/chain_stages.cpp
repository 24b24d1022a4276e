// SPDX-License-Identifier: Apache-2.0

// The table of the stages of the chain, in the order of chain.h: a row has the name of a stage, what it does with a
// sensor or why the sensor leaves it out (`mtf config explain` and reports), what it does to a frame (chain_steps.h)
// and the name of its time.

#include <cmath>

#include "mtf/words.h"
#include "radiometry/chain/chain_steps.h"
#include "radiometry/chain/sensor_budget.h"

namespace radiometry {
namespace {

using System = mtf::System<double>;

/// The words of a stage that is on where it has something to say: numbers above 0, which the text lists.
StageWords said(std::string what, const std::string& otherwise) {
  if (what.empty()) return {false, otherwise};
  return {true, std::move(what)};
}

std::string rounded(double value) { return mtf::significant(value, 6); }

/// The values above 0 with their names, "" where there are none.
std::string terms(std::initializer_list<std::pair<const char*, double>> list, const char* unit) {
  std::string text;
  for (const auto& [name, value] : list)
    if (value > 0.0) text += (text.empty() ? "" : ", ") + std::string(name) + " " + rounded(value) + " " + unit;
  return text;
}

constexpr const char* kNotThermal = "a thermal detector has none";

const char* rms_unit(const Sensor& sensor) { return sensor.settings.thermal ? "V rms" : "e- rms"; }

StageWords filters(const System& system, mtf::Stage stage) {
  std::string labels;
  for (const auto& entry : system.list(stage)) labels += (labels.empty() ? "" : " x ") + entry.label;
  return said(labels, "no [[" + std::string(mtf::stage_name(stage)) + "]]");
}
template <mtf::Stage stage>
StageWords filters(const System& system, const Sensor&) {
  return filters(system, stage);
}

StageWords distortion(const System&, const Sensor& sensor) {
  const auto& radial = sensor.settings.distortion;
  if (!radial) return {false, "no [distortion]"};
  return {true, "k1 " + rounded(radial->k1) + ", k2 " + rounded(radial->k2) + ", k3 " + rounded(radial->k3) +
                    "; interpolation MTF at a quarter cycle a sample " + rounded(distortion_mtf(0.25))};
}

StageWords veiling_glare(const System&, const Sensor& sensor) {
  const VeilingGlare glare = sensor.settings.glare.value_or(VeilingGlare{});
  return said(terms({{"spread", glare.fraction}, {"added", glare.offset}}, "of the mean"), "no [veiling_glare]");
}

StageWords ghost(const System&, const Sensor& sensor) {
  const auto& ghost = sensor.settings.ghost;
  return said(ghost ? rounded(ghost->fraction) + " of the light, mirrored" : "", "no [ghost]");
}

StageWords light(const System& system, const Sensor& sensor) {
  const Camera<double> camera = camera_of(system, sensor);
  const bool weighted = output_quantity(sensor, OutputStage::irradiance).starts_with("weighted");
  const auto& thermal = sensor.settings.thermal;
  return {true, rounded(electrons_per_radiance(camera, pixel_of(system, sensor))) + " " +
                    std::string(signal_unit(sensor)) + " for 1 " + (thermal ? "W" : "ph s^-1") + " m^-2 sr^-1" +
                    (weighted ? ", weighted by the curves" : "") + "; cone of " + rounded(cone_sr(camera)) +
                    " sr by the " + std::string(kConeNames[static_cast<std::size_t>(camera.cone)]) +
                    (thermal && thermal->shutter_k
                         ? "; less that of a shutter " +
                               std::string(thermal->shutter_place == ShutterPlace::optics ? "before the optics"
                                                                                          : "before the detector") +
                               " at " + rounded(*thermal->shutter_k) + " K"
                         : "")};
}

/// A map from a file has its name; one that a program made has none.
std::string map_words(const std::string& file) { return file.empty() ? "a map" : file; }

StageWords vignetting(const System&, const Sensor& sensor) {
  const auto& corners = sensor.settings.vignetting;
  if (!corners) return {false, "no [vignetting]"};
  if (sensor.vignetting) return {true, map_words(corners->map)};
  return {true, corners->cos4 ? "cos^4 of the field angle, and a polynomial" : "a polynomial"};
}

StageWords microscan(const System&, const Sensor& sensor) {
  const auto& scan = sensor.settings.microscan;
  return said(scan ? std::to_string(scan->positions()) + " positions" : "", "no [microscan]");
}

StageWords shutter(const System&, const Sensor& sensor) {
  const auto& shutter = sensor.settings.shutter;
  if (!shutter) return {false, "no [shutter]: global"};
  if (shutter->kind != ShutterKind::rolling) return {false, "global"};
  return {true, "rolling, " + rounded(shutter->line_time_s) + " s a row, over a sequence"};
}

OpticsSettings optics_of(const Sensor& sensor) { return sensor.settings.optics.value_or(OpticsSettings{}); }

StageWords warm_optics(const System&, const Sensor& sensor) {
  const OpticsSettings warm = optics_of(sensor);
  return said(terms({{"emit at", warm.emissivity > 0.0 ? warm.temperature_k : 0.0}}, "K"),
              "no temperature or emissivity in [optics]");
}

StageWords stop(const System&, const Sensor& sensor) {
  const OpticsSettings warm = optics_of(sensor);
  const std::string emits = terms({{"emits at", warm.stop_emissivity > 0.0 ? warm.stop_temperature_k : 0.0}}, "K");
  if (emits.empty()) return {false, "no stop_temperature in [optics]"};
  return {true,
          emits + ", counted from " + describe(stop_range(sensor.curves, warm.stop_band)) + ", past the cold filter"};
}

StageWords narcissus(const System&, const Sensor& sensor) {
  const auto& dark = sensor.settings.narcissus;
  return said(dark ? rounded(dark->depth) + " of the background" : "", "no [narcissus]");
}

NonuniformitySettings nonuniformity_of(const Sensor& sensor) {
  return sensor.settings.nonuniformity.value_or(NonuniformitySettings{});
}

StageWords responsivity(const System&, const Sensor& sensor) {
  const NonuniformitySettings unequal = nonuniformity_of(sensor);
  if (sensor.responsivity && sensor.settings.nonuniformity) return {true, map_words(unequal.responsivity)};
  return said(terms({{"prnu", unequal.prnu}}, "rms"), "no prnu in [nonuniformity]");
}

StageWords dark_current(const System& system, const Sensor& sensor) {
  const Pixel<double> pixel = pixel_of(system, sensor);
  if (pixel.thermal()) return {false, kNotThermal};
  return said(terms({{"mean", pixel.dark_e_s * pixel.integration_s}}, "e-"), "no dark_current in [detector]");
}

StageWords lag(const System&, const Sensor& sensor) {
  const auto& lag = sensor.settings.lag;
  return said(lag ? rounded(lag->time_constant_s) + " s, over a sequence" : "", "no [lag]");
}

StageWords shutter_offset(const System&, const Sensor& sensor) {
  const auto& thermal = sensor.settings.thermal;
  if (!thermal) return {false, "of thermal detectors alone"};
  const double drift = thermal->drift_k_s;
  const std::string warming = drift == 0.0 ? "" : ", while the camera warms by " + rounded(drift) + " K/s";
  if (thermal->shutter_frames > 0)
    return {true, "new every " + std::to_string(thermal->shutter_frames) + " frames" + warming};
  return said(thermal->shutter_interval_s ? "new every " + rounded(*thermal->shutter_interval_s) + " s" + warming : "",
              "no shutter_interval or shutter_frames in [detector]");
}

StageWords defects(const System&, const Sensor& sensor) {
  const auto& defects = sensor.settings.defects;
  return said(defects ? terms({{"dead", defects->dead_fraction}, {"hot", defects->hot_fraction}}, "of all") : "",
              "no [defects]");
}

StageWords blinking(const System&, const Sensor& sensor) {
  const auto& blinking = sensor.settings.blinking;
  return said(blinking ? rounded(blinking->fraction) + " of all" : "", "no [blinking]");
}

StageWords shot_noise(const System&, const Sensor& sensor) {
  const auto& noise = sensor.settings.noise;
  if (sensor.settings.thermal) return {false, kNotThermal};
  if (!noise) return {false, "no [noise]"};
  return said(noise->shot ? "Poisson" : "", "shot = false in [noise]");
}

std::string well_of(const Sensor& sensor) {
  const double well_e = sensor.settings.detector->full_well_e;
  return std::isfinite(well_e) ? rounded(well_e) + " e-" : "";
}

StageWords full_well(const System&, const Sensor& sensor) {
  if (sensor.settings.thermal) return {false, kNotThermal};
  if (sensor.settings.blooming) return {false, "[blooming] takes its place"};
  return said(well_of(sensor), "no full_well in [detector]");
}

StageWords blooming(const System&, const Sensor& sensor) {
  return said(sensor.settings.blooming ? "above " + well_of(sensor) : "", "no [blooming]");
}

StageWords nonlinearity(const System&, const Sensor& sensor) {
  const auto& bent = sensor.settings.nonlinearity;
  return said(bent ? "a2 " + rounded(bent->a2) + ", a3 " + rounded(bent->a3) : "", "no [nonlinearity]");
}

StageWords offsets(const System&, const Sensor& sensor) {
  const NonuniformitySettings unequal = nonuniformity_of(sensor);
  if (sensor.offset && sensor.settings.nonuniformity) return {true, map_words(unequal.offset)};
  return said(terms({{"dsnu", unequal.dsnu_e}}, rms_unit(sensor)), "no dsnu in [nonuniformity]");
}

StageWords read_noise(const System& system, const Sensor& sensor) {
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
}

StageWords flicker(const System&, const Sensor& sensor) {
  const auto& flicker = sensor.settings.flicker;
  return said(flicker ? "corner at " + rounded(flicker->corner_cy_px) + " of the pixel clock" : "", "no [flicker]");
}

StageWords line_noise(const System&, const Sensor& sensor) {
  const auto& noise = sensor.settings.noise;
  if (!noise) return {false, "no [noise]"};
  return said(terms({{"row", noise->row_e},
                     {"column", noise->column_e},
                     {"fixed row", noise->fixed_row_e},
                     {"fixed column", noise->fixed_column_e}},
                    rms_unit(sensor)),
              "no row or column in [noise]");
}

StageWords noise_3d(const System&, const Sensor& sensor) {
  const auto& cube = sensor.settings.noise_3d;
  return said(cube ? terms({{"total", cube->total()}}, rms_unit(sensor)) : "", "no [noise_3d]");
}

StageWords converter(const System&, const Sensor& sensor) {
  if (!sensor.settings.adc) return {false, "no [adc]"};
  const Adc adc = adc_of(sensor);
  return {true, std::to_string(adc.bits) + " bits, " + rounded(adc.electrons_per_count) + " " +
                    std::string(signal_unit(sensor)) + " a count"};
}

StageWords two_points(const System&, const Sensor& sensor) {
  const auto& correction = sensor.settings.correction;
  if (!correction) return {false, "no [correction]"};
  if (correction->cold_k && correction->hot_k)
    return {true, "two points, blackbodies at " + rounded(*correction->cold_k) + " K and " +
                      rounded(*correction->hot_k) + " K, mean of " + std::to_string(correction->frames)};
  return {true, "two points, flats at " + rounded(correction->low) + " and " + rounded(correction->high) +
                    " of full well, mean of " + std::to_string(correction->frames)};
}

StageWords agc(const System&, const Sensor& sensor) {
  const auto& agc = sensor.settings.agc;
  return said(agc ? "to " + rounded(agc->most_level) + " levels" : "", "no [agc]");
}

using enum StageRow::Part;

// Light, vignetting and the rows from the warm optics to the dark current act in `collect`; Chain::run makes the
// positions of `microscan`.
constexpr std::array kChain{
    StageRow{.name = "distortion",
             .part = optics,
             .words = distortion,
             .step = step::distort,
             .whole_image = "moves light across the image"},
    StageRow{.name = "presample", .part = optics, .words = filters<mtf::Stage::presample>},
    // The pitch samples the image without a filter too.
    StageRow{.name = "presample", .part = optics, .step = step::sample},
    StageRow{.name = "veiling glare",
             .part = optics,
             .words = veiling_glare,
             .step = step::glare,
             .whole_image = "adds the mean of the whole image"},
    StageRow{.name = "ghost",
             .part = optics,
             .words = ghost,
             .step = step::ghost,
             .whole_image = "adds the image mirrored at its axis"},
    StageRow{.name = "light", .part = detector, .words = light},
    StageRow{.name = "vignetting", .part = detector, .words = vignetting},
    // Its steps run in the detector's part; its finer sampling is in the image of every output stage.
    StageRow{.name = "microscan",
             .part = optics,
             .words = microscan,
             .whole_image = "samples between the pixels, where tiles sample at the pitch"},
    StageRow{.name = "shutter", .part = detector, .words = shutter, .step = step::shutter, .in_sequence = true},
    StageRow{.name = "warm optics", .part = detector, .words = warm_optics},
    StageRow{.name = "stop", .part = detector, .words = stop},
    StageRow{.name = "narcissus", .part = detector, .words = narcissus},
    StageRow{.name = "responsivity", .part = detector, .words = responsivity},
    StageRow{.name = "dark current", .part = detector, .words = dark_current},
    StageRow{.name = "collect", .part = detector, .step = step::collect},
    StageRow{.name = "lag", .part = detector, .words = lag, .step = step::lag, .in_sequence = true},
    StageRow{.name = "shutter offset", .part = detector, .words = shutter_offset, .step = step::shutter_offset},
    StageRow{.name = "defects", .part = detector, .words = defects, .step = step::defects},
    StageRow{.name = "blinking", .part = detector, .words = blinking, .step = step::blinking, .timing = "defects"},
    StageRow{.name = "shot noise", .part = detector, .words = shot_noise, .step = step::shot_noise, .timing = "shot"},
    StageRow{.name = "full well", .part = detector, .words = full_well, .step = step::full_well},
    StageRow{.name = "blooming",
             .part = detector,
             .words = blooming,
             .step = step::blooming,
             .whole_image = "spills charge over any number of pixels"},
    StageRow{.name = "nonlinearity", .part = detector, .words = nonlinearity, .step = step::nonlinearity},
    StageRow{.name = "readout",
             .part = detector,
             .words = filters<mtf::Stage::readout>,
             .step = step::readout,
             .whole_image = "filters pixels together with their neighbours"},
    StageRow{.name = "offsets", .part = detector, .words = offsets, .step = step::offsets, .timing = "offset"},
    StageRow{.name = "read noise", .part = detector, .words = read_noise, .step = step::read_noise, .timing = "read"},
    StageRow{.name = "1/f noise", .part = detector, .words = flicker, .step = step::flicker, .timing = "flicker"},
    StageRow{.name = "row and column noise",
             .part = detector,
             .words = line_noise,
             .step = step::line_noise,
             .timing = "rows and columns"},
    StageRow{.name = "3-D noise", .part = detector, .words = noise_3d, .step = step::noise_3d},
    StageRow{.name = "adc", .part = conversion, .words = converter, .step = step::convert},
    StageRow{.name = "correction",
             .part = correction,
             .words = two_points,
             .step = step::correct,
             .whole_image = "refers to the mean of all pixels in flat frames"},
    StageRow{.name = "postsample",
             .part = display,
             .words = filters<mtf::Stage::postsample>,
             .step = step::postsample,
             .whole_image = "filters pixels together with their neighbours"},
    StageRow{.name = "agc",
             .part = display,
             .words = agc,
             .step = step::agc,
             .whole_image = "takes its curve from the histogram of all pixels"}};

}  // namespace

bool goes_through(StageRow::Part part, OutputStage stage) {
  constexpr std::array kFirst{OutputStage::radiance, OutputStage::electrons, OutputStage::dn, OutputStage::display,
                              OutputStage::display};
  return stage >= kFirst[static_cast<std::size_t>(part)];
}

std::string whole_image_stages(const System& system, const Sensor& sensor, OutputStage stage) {
  std::string text;
  for (const StageRow& row : kChain)
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
  for (const StageRow& row : kChain)
    if (row.words != nullptr) add(row.name, row.words(system, sensor));
  return stages;
}

std::vector<StageRow> stages_to_run(const System& system, const Sensor& sensor) {
  std::vector<StageRow> stages;
  for (const StageRow& row : kChain)
    if (row.step != nullptr && (row.words == nullptr || row.words(system, sensor).on)) stages.push_back(row);
  return stages;
}

}  // namespace radiometry
