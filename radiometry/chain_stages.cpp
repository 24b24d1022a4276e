// SPDX-License-Identifier: Apache-2.0

// The chain in words, for `mtf config explain` and reports.

#include <cmath>
#include <cstdio>

#include "radiometry/chain.h"

namespace radiometry {
namespace {

std::string rounded(double value) {
  std::array<char, 32> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), "%.6g", value));
  return text.data();
}

std::string terms(std::initializer_list<std::pair<const char*, double>> list, const char* unit) {
  std::string text;
  for (const auto& [name, value] : list)
    if (value > 0.0) text += (text.empty() ? "" : ", ") + std::string(name) + " " + rounded(value) + " " + unit;
  return text;
}

std::string components(const mtf::System<double>& system, mtf::Stage stage) {
  std::string text;
  for (const auto& entry : system.list(stage)) text += (text.empty() ? "" : " x ") + entry.label;
  return text;
}

}  // namespace

std::vector<ChainStage> chain_stages(const mtf::System<double>& system, const Sensor& sensor) {
  const SensorSettings& s = sensor.settings;
  std::vector<ChainStage> stages;
  const auto add = [&](std::string name, std::string what, const std::string& otherwise) {
    const bool on = !what.empty();
    stages.push_back({std::move(name), on, on ? std::move(what) : otherwise});
  };
  const auto list = [&](mtf::Stage stage) {
    const std::string name(mtf::stage_name(stage));
    add(name, components(system, stage), "no [[" + name + "]]");
  };
  if (!s.detector) {
    for (const mtf::Stage stage : mtf::kStages) list(stage);
    add("electrons", "", "no [detector]: the output stays in the quantity of the scene");
    return stages;
  }
  const Camera<double> camera = camera_of(system, sensor);
  const Pixel<double> pixel = pixel_of(system, sensor);
  const OpticsSettings warm = s.optics.value_or(OpticsSettings{});
  const NonuniformitySettings unequal = s.nonuniformity.value_or(NonuniformitySettings{});
  const std::string no_noise = s.noise ? "" : "no [noise]";
  const auto or_else = [&](const std::string& reason) { return no_noise.empty() ? reason : no_noise; };

  add("distortion",
      s.distortion ? "k1 " + rounded(s.distortion->k1) + ", k2 " + rounded(s.distortion->k2) + ", k3 " +
                         rounded(s.distortion->k3) + "; interpolation MTF at a quarter cycle a sample " +
                         rounded(distortion_mtf(0.25))
                   : "",
      "no [distortion]");
  list(mtf::Stage::presample);
  add("veiling glare", s.glare ? terms({{"spread", s.glare->fraction}, {"added", s.glare->offset}}, "of the mean") : "",
      "no [veiling_glare]");
  add("ghost", s.ghost ? rounded(s.ghost->fraction) + " of the light, mirrored" : "", "no [ghost]");
  const bool weighted =
      output_quantity(sensor, OutputStage::irradiance) != output_quantity({}, OutputStage::irradiance);
  add("light",
      rounded(electrons_per_radiance(camera, pixel)) + " e- for 1 ph s^-1 m^-2 sr^-1" +
          (weighted ? ", weighted by the curves" : "") + "; cone of " + rounded(cone_sr(camera)) + " sr by the " +
          std::string(kConeNames[static_cast<std::size_t>(camera.cone)]),
      "");
  add("vignetting",
      !s.vignetting        ? ""
      : sensor.vignetting  ? s.vignetting->map
      : s.vignetting->cos4 ? "cos^4 of the field angle, and a polynomial"
                           : "a polynomial",
      "no [vignetting]");
  add("microscan", s.microscan ? std::to_string(s.microscan->positions()) + " positions" : "", "no [microscan]");
  add("shutter",
      s.shutter && s.shutter->kind == ShutterKind::rolling
          ? "rolling, " + rounded(s.shutter->line_time_s) + " s a row, over a sequence"
          : "",
      s.shutter ? "global" : "no [shutter]: global");
  add("warm optics", terms({{"emit at", warm.emissivity > 0.0 ? warm.temperature_k : 0.0}}, "K"),
      "no temperature or emissivity in [optics]");
  const std::string stop = terms({{"emits at", warm.stop_emissivity > 0.0 ? warm.stop_temperature_k : 0.0}}, "K");
  add("stop",
      stop.empty()
          ? ""
          : stop + ", counted from " + describe(stop_range(sensor.curves, warm.stop_band)) + ", past the cold filter",
      "no stop_temperature in [optics]");
  add("narcissus", s.narcissus ? rounded(s.narcissus->depth) + " of the background" : "", "no [narcissus]");
  add("responsivity", sensor.responsivity ? unequal.responsivity : terms({{"prnu", unequal.prnu}}, "rms"),
      "no prnu in [nonuniformity]");
  add("dark current", terms({{"mean", pixel.dark_e_s * pixel.integration_s}}, "e-"), "no dark_current in [detector]");
  add("lag", s.lag ? rounded(s.lag->time_constant_s) + " s, over a sequence" : "", "no [lag]");
  add("defects",
      s.defects ? terms({{"dead", s.defects->dead_fraction}, {"hot", s.defects->hot_fraction}}, "of all") : "",
      "no [defects]");
  add("blinking", s.blinking ? rounded(s.blinking->fraction) + " of all" : "", "no [blinking]");
  add("shot noise", s.noise && s.noise->shot ? "Poisson" : "", or_else("shot = false in [noise]"));
  const std::string well = std::isfinite(pixel.full_well_e) ? rounded(pixel.full_well_e) + " e-" : "";
  add("full well", s.blooming ? "" : well, s.blooming ? "[blooming] takes its place" : "no full_well in [detector]");
  add("blooming", s.blooming ? "above " + well : "", "no [blooming]");
  add("nonlinearity", s.nonlinearity ? "a2 " + rounded(s.nonlinearity->a2) + ", a3 " + rounded(s.nonlinearity->a3) : "",
      "no [nonlinearity]");
  list(mtf::Stage::readout);
  add("offsets", sensor.offset ? unequal.offset : terms({{"dsnu", unequal.dsnu_e}}, "e- rms"),
      "no dsnu in [nonuniformity]");
  add("read noise",
      s.noise
          ? terms({{"read", s.detector->read_e}, {"reset", reset_e_of(*s.detector)}, {"other", s.detector->other_e}},
                  "e- rms")
          : "",
      or_else("no read_noise in [detector]"));
  add("1/f noise", s.flicker ? "corner at " + rounded(s.flicker->corner_cy_px) + " of the pixel clock" : "",
      "no [flicker]");
  add("row and column noise",
      s.noise ? terms({{"row", s.noise->row_e},
                       {"column", s.noise->column_e},
                       {"fixed row", s.noise->fixed_row_e},
                       {"fixed column", s.noise->fixed_column_e}},
                      "e- rms")
              : "",
      or_else("no row or column in [noise]"));
  add("3-D noise", s.noise_3d ? terms({{"total", s.noise_3d->total()}}, "e- rms") : "", "no [noise_3d]");
  std::string converter;
  if (s.adc) {
    const Adc adc = adc_of(sensor);
    converter = std::to_string(adc.bits) + " bits, " + rounded(adc.electrons_per_count) + " e- a count";
  }
  add("adc", converter, "no [adc]");
  add("correction",
      s.correction ? "two points, flats at " + rounded(s.correction->low) + " and " + rounded(s.correction->high) +
                         " of full well, mean of " + std::to_string(s.correction->frames)
                   : "",
      "no [correction]");
  list(mtf::Stage::postsample);
  add("agc", s.agc ? "to " + rounded(s.agc->most_level) + " levels" : "", "no [agc]");
  return stages;
}

}  // namespace radiometry
