// SPDX-License-Identifier: Apache-2.0
#include "radiometry/chain/thermal_settings.h"

#include <algorithm>

#include "radiometry/chain/sensor_numbers.h"

namespace radiometry {
namespace {

[[noreturn]] void refuse_key(const std::string& key, const std::string& why) {
  throw mtf::UsageError("detector." + key + ": " + why);
}

struct Key {
  const char* name;
  bool given;
  const char* example;
};

/// Refuses a figure whose reference lacks some of its keys, all of which are named.
void require_keys(const char* figure, std::initializer_list<Key> keys) {
  std::string names, lines;
  for (const Key& key : keys) {
    if (key.given) continue;
    names += (names.empty() ? "" : ", ") + std::string(key.name);
    lines += (lines.empty() ? "" : ", ") + std::string(key.name) + " = " + key.example;
  }
  if (!names.empty()) refuse_key(figure, "given without " + names + "; write " + lines);
}

/// Refuses keys that say more of a figure that is not given.
void require_figure(bool figure_given, const char* figure, std::initializer_list<Key> keys) {
  for (const Key& key : keys)
    if (!figure_given && key.given)
      refuse_key(key.name, std::string("belongs to ") + figure + ", which is not given; remove it");
}

}  // namespace

void require_thermal(const ThermalSettings& s, double area_m2, double middle_absorptance) {
  std::string forms;
  int count = 0;
  for (const auto& [name, given] :
       {std::pair{"netd", s.netd_k.has_value()}, std::pair{"nep", s.nep_w.has_value()},
        std::pair{"nep_density", s.nep_density.has_value()}, std::pair{"dstar", s.dstar_jones.has_value()},
        std::pair{"the physics (heat_capacity, conductance, temperature, resistance, tcr, bias)", s.physics()}}) {
    if (!given) continue;
    forms += (forms.empty() ? "" : " and ") + std::string(name);
    ++count;
  }
  if (count == 0)
    throw mtf::UsageError(
        "[detector]: a thermal detector without its noise; give netd, nep, nep_density, dstar, or heat_capacity, "
        "conductance, temperature, resistance, tcr and bias");
  if (count > 1) throw mtf::UsageError("[detector]: the noise is given by " + forms + "; keep one of them");
  require_figure(s.netd_k.has_value(), "netd",
                 {{"netd_f_number", s.netd_f_number.has_value(), ""},
                  {"netd_transmission", s.netd_transmission.has_value(), ""},
                  {"netd_temperature", s.netd_temperature_k.has_value(), ""},
                  {"netd_frame_rate", s.netd_frame_rate_hz.has_value(), ""},  // it sets netd_bandwidth
                  {"netd_bandwidth", s.netd_bandwidth_hz.has_value(), ""},
                  {"counts_per_kelvin", s.counts_per_k.has_value(), ""},
                  {"netd_shortest", s.netd_shortest_um.has_value(), ""},
                  {"netd_longest", s.netd_longest_um.has_value(), ""},
                  {"netd_of", s.netd_of != NetdOf::focal_plane, ""}});
  require_figure(s.nep_w.has_value(), "nep", {{"nep_bandwidth", s.nep_bandwidth_hz.has_value(), ""}});
  const Key bandwidth{"noise_bandwidth", s.bandwidth_hz.has_value(), "\"30 Hz\""};
  if (s.netd_k) {
    require_keys("netd", {{"netd_f_number", s.netd_f_number.has_value(), "1.0"},
                          {"netd_transmission", s.netd_transmission.has_value(), "1.0"},
                          {"netd_temperature", s.netd_temperature_k.has_value(), "\"300 K\""}});
    if (s.netd_bandwidth_hz) require_keys("netd_bandwidth", {bandwidth});
    if (s.netd_shortest_um.has_value() != s.netd_longest_um.has_value() ||
        (s.netd_shortest_um && !(*s.netd_shortest_um < *s.netd_longest_um)))
      refuse_key("netd", "its band has two ends; give netd_shortest below netd_longest, or none for [band]");
    if (s.netd_of == NetdOf::camera && s.readout_v > 0.0)
      refuse_key("readout_noise", "is in the NETD of the camera already; remove it, or give netd_of = \"focal_plane\"");
  }
  if (s.nep_bandwidth_hz) require_keys("nep_bandwidth", {bandwidth});
  if (s.nep_density) require_keys("nep_density", {bandwidth});
  if (s.dstar_jones) require_keys("dstar", {bandwidth});
  for (const auto& [key, given] :
       {std::pair{"width", s.width_um.has_value()}, std::pair{"height", s.height_um.has_value()}})
    if (s.fill_factor && given)
      refuse_key("fill_factor",
                 std::string("given beside ") + key + ", which says the active area too; remove one of them");
  if (s.counts_per_k && s.responsivity_v_w)
    refuse_key("counts_per_kelvin",
               "given beside responsivity; it stands for responsivity and volts_per_count together: remove it or that");
  if (!(middle_absorptance > 0.0))
    refuse_key("absorptance", "0 at the middle of the band, where responsivity, NEP and D* are stated; change [band]");
  if (!s.physics()) {
    if (!s.responsivity_v_w && !s.counts_per_k)
      refuse_key("responsivity",
                 "missing; volts need it: write responsivity = 1e5 for 1e5 V for a watt of incident power");
    return;
  }
  if (s.responsivity_v_w)
    refuse_key("responsivity", "given beside bias, tcr and conductance, which are bias |tcr| / conductance; remove it");
  require_keys("conductance", {{"heat_capacity", s.heat_capacity_j_k.has_value(), "3e-10"},
                               {"conductance", s.conductance_w_k.has_value(), "3e-8"},
                               {"temperature", s.temperature_k.has_value(), "\"300 K\""},
                               {"resistance", s.resistance_ohm.has_value(), "1e5"},
                               {"tcr", s.tcr_per_k.has_value(), "-0.02"},
                               {"bias", s.bias_v.has_value(), "\"2 V\""},
                               bandwidth});
  if (s.lowest_hz && !s.corner_hz) refuse_key("lowest_frequency", "belongs to corner, which is not given; remove it");
  require_physics<double>(s, middle_absorptance, area_m2, {});
}

std::string bandwidth_warning(const ThermalSettings& s, double time_constant_s) {
  const bool per_hertz = s.dstar_jones || s.nep_density;
  const std::optional<double>& stated_hz = s.netd_k ? s.netd_bandwidth_hz : s.nep_bandwidth_hz;
  if (!s.bandwidth_hz || !(time_constant_s > 0.0) || !(per_hertz || (stated_hz && *stated_hz != *s.bandwidth_hz)))
    return "";
  const double pixel_hz = 0.25 / time_constant_s, from_hz = per_hertz ? 1.0 : *stated_hz;
  const double widest_hz = std::max(from_hz, *s.bandwidth_hz);
  if (!(widest_hz > 10.0 * pixel_hz)) return "";
  const std::string figure = s.netd_k ? "netd" : s.nep_w ? "nep" : s.nep_density ? "nep_density" : "dstar";
  return figure + " is taken from " + mtf::three_digits(from_hz) + " Hz to " + mtf::three_digits(*s.bandwidth_hz) +
         " Hz by the root of the bandwidths, as white noise; the temperature fluctuation of pixels with a time "
         "constant of " +
         mtf::three_digits(time_constant_s) + " s has no more than 1/(4 tau) = " + mtf::three_digits(pixel_hz) +
         " Hz, so that its part comes out " + (from_hz < *s.bandwidth_hz ? "too large" : "too small") +
         "; give the figure for the noise bandwidth of this camera, or the physics";
}

}  // namespace radiometry
