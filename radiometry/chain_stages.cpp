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
  add("presample", components(system, mtf::Stage::presample), "no [[presample]]");
  if (!s.detector) {
    add("readout", components(system, mtf::Stage::readout), "no [[readout]]");
    add("electrons", "", "no [detector]: the output stays in the quantity of the scene");
    add("postsample", components(system, mtf::Stage::postsample), "no [[postsample]]");
    return stages;
  }
  const Camera<double> camera = camera_of(system, sensor);
  const Pixel<double> pixel = pixel_of(system, sensor);
  add("light", rounded(electrons_per_radiance(camera, pixel)) + " e- for 1 ph s^-1 m^-2 sr^-1", "");
  add("warm optics and stop",
      s.optics ? terms({{"optics", s.optics->temperature_k * (s.optics->emissivity > 0.0 ? 1.0 : 0.0)},
                        {"stop", s.optics->stop_temperature_k}},
                       "K")
               : "",
      "no temperature or emissivity in [optics]");
  add("responsivity",
      s.nonuniformity
          ? (sensor.responsivity ? s.nonuniformity->responsivity : terms({{"prnu", s.nonuniformity->prnu}}, "rms"))
          : "",
      "no prnu in [nonuniformity]");
  add("dark current", terms({{"mean", pixel.dark_e_s * pixel.integration_s}}, "e-"), "no dark_current in [detector]");
  add("defects",
      s.defects ? terms({{"dead", s.defects->dead_fraction}, {"hot", s.defects->hot_fraction}}, "of all") : "",
      "no [defects]");
  add("shot noise", s.noise && s.noise->shot ? "Poisson" : "", s.noise ? "shot = false in [noise]" : "no [noise]");
  add("full well", std::isfinite(pixel.full_well_e) ? rounded(pixel.full_well_e) + " e-" : "",
      "no full_well in [detector]");
  add("readout", components(system, mtf::Stage::readout), "no [[readout]]");
  add("offsets",
      s.nonuniformity ? (sensor.offset ? s.nonuniformity->offset : terms({{"dsnu", s.nonuniformity->dsnu_e}}, "e- rms"))
                      : "",
      "no dsnu in [nonuniformity]");
  add("read noise",
      s.noise ? terms({{"read", s.detector->read_e}, {"reset", s.detector->reset_e}, {"other", s.detector->other_e}},
                      "e- rms")
              : "",
      s.noise ? "no read_noise in [detector]" : "no [noise]");
  add("row and column noise",
      s.noise ? terms({{"row", s.noise->row_e},
                       {"column", s.noise->column_e},
                       {"fixed row", s.noise->fixed_row_e},
                       {"fixed column", s.noise->fixed_column_e}},
                      "e- rms")
              : "",
      s.noise ? "no row or column in [noise]" : "no [noise]");
  add("3-D noise", s.noise_3d ? terms({{"total", s.noise_3d->total()}}, "e- rms") : "", "no [noise_3d]");
  if (s.adc) {
    const Adc adc = adc_of(sensor);
    add("adc", std::to_string(adc.bits) + " bits, " + rounded(adc.electrons_per_count) + " e- a count", "");
  } else {
    add("adc", "", "no [adc]");
  }
  add("postsample", components(system, mtf::Stage::postsample), "no [[postsample]]");
  add("agc", s.agc ? "to " + rounded(s.agc->most_level) + " levels" : "", "no [agc]");
  return stages;
}

}  // namespace radiometry
