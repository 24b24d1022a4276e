// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal_settings.h"

#include "radiometry/performance/thermal_numbers.h"

namespace radiometry {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& why) {
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
  if (!names.empty()) refuse(figure, "given without " + names + "; write " + lines);
}

/// Refuses keys that say more of a figure that is not given.
void require_figure(bool figure_given, const char* figure, std::initializer_list<Key> keys) {
  for (const Key& key : keys)
    if (!figure_given && key.given)
      refuse(key.name, std::string("belongs to ") + figure + ", which is not given; remove it");
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
                  {"netd_bandwidth", s.netd_bandwidth_hz.has_value(), ""},
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
      refuse("netd", "its band has two ends; give netd_shortest below netd_longest, or none for [band]");
    if (s.netd_of == NetdOf::camera && s.readout_v > 0.0)
      refuse("readout_noise", "is in the NETD of the camera already; remove it, or give netd_of = \"focal_plane\"");
  }
  if (s.nep_bandwidth_hz) require_keys("nep_bandwidth", {bandwidth});
  if (s.nep_density) require_keys("nep_density", {bandwidth});
  if (s.dstar_jones) require_keys("dstar", {bandwidth});
  if (!(middle_absorptance > 0.0))
    refuse("absorptance", "0 at the middle of the band, where responsivity, NEP and D* are stated; change [band]");
  if (!s.physics()) {
    if (!s.responsivity_v_w)
      refuse("responsivity", "missing; volts need it: write responsivity = 1e5 for 1e5 V for a watt of incident power");
    return;
  }
  if (s.responsivity_v_w)
    refuse("responsivity", "given beside bias, tcr and conductance, which are bias |tcr| / conductance; remove it");
  require_keys("conductance", {{"heat_capacity", s.heat_capacity_j_k.has_value(), "3e-10"},
                               {"conductance", s.conductance_w_k.has_value(), "3e-8"},
                               {"temperature", s.temperature_k.has_value(), "\"300 K\""},
                               {"resistance", s.resistance_ohm.has_value(), "1e5"},
                               {"tcr", s.tcr_per_k.has_value(), "-0.02"},
                               {"bias", s.bias_v.has_value(), "\"2 V\""},
                               bandwidth});
  if (s.lowest_hz && !s.corner_hz) refuse("lowest_frequency", "belongs to corner, which is not given; remove it");
  require_physics<double>(s, middle_absorptance, area_m2, {});
}

}  // namespace radiometry
