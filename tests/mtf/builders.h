// SPDX-License-Identifier: Apache-2.0
#pragma once

// Short ways to build systems in tests, through the same field tables as the config.

#include <string>

#include "mtf/system.h"

namespace mtf::test {

inline FieldRef<double> field(Component<double>& component, std::string_view name) {
  for (const FieldRef<double>& f : component.fields())
    if (f.info->name == name) return f;
  throw std::runtime_error("no field " + std::string(name));
}

inline void set(Component<double>& component, std::string_view name, double value) {
  const FieldRef<double> f = field(component, name);
  if (auto* p = std::get_if<double*>(&f.value))
    **p = value;
  else if (auto* o = std::get_if<std::optional<double>*>(&f.value))
    **o = value;
  else if (auto* i = std::get_if<int*>(&f.value))
    **i = static_cast<int>(value);
}

inline void set(Component<double>& component, std::string_view name, double value, const char* unit) {
  const FieldRef<double> f = field(component, name);
  if (auto* p = std::get_if<AxisPair<double>*>(&f.value)) **p = {{value, find_unit(unit)}, {}, false};
  if (auto* s = std::get_if<SpatialFrequency<double>*>(&f.value)) **s = {value, find_unit(unit)};
}

inline void set_xy(Component<double>& component, std::string_view name, double x, double y, const char* unit) {
  *std::get<AxisPair<double>*>(field(component, name).value) = {{x, find_unit(unit)}, {y, find_unit(unit)}, true};
}

inline void choose(Component<double>& component, std::string_view name, int index) {
  std::get<Choice*>(field(component, name).value)->index = index;
}

inline Component<double> gaussian(double sigma_um) {
  auto c = Component<double>::make("gaussian");
  set(c, "sigma", sigma_um, "um");
  return c;
}

inline Component<double> footprint(double width_um) {
  auto c = Component<double>::make("footprint");
  set(c, "width", width_um, "um");
  return c;
}

inline Component<double> jitter(double rms, const char* unit = "um") {
  auto c = Component<double>::make("jitter");
  set(c, "rms", rms, unit);
  return c;
}

inline Component<double> motion(double travel_um, double direction_deg) {
  auto c = Component<double>::make("linear_motion");
  set(c, "travel", travel_um, "um");
  set(c, "direction", direction_deg);
  return c;
}

inline Component<double> rc(double cutoff_cy_mm, int axis) {
  auto c = Component<double>::make("rc_lowpass");
  set(c, "cutoff", cutoff_cy_mm, "cy/mm");
  choose(c, "axis", axis);
  return c;
}

inline Component<double> fir(Taps<double> taps) {
  auto c = Component<double>::make("fir");
  *std::get<Taps<double>*>(field(c, "taps").value) = std::move(taps);
  return c;
}

/// The sensor of the README: MWIR 4 um, F/2, 15 um pitch and footprint, jitter 2 um rms.
inline System<double> mwir() {
  System<double> s;
  s.name = "MWIR";
  s.frame = {100.0, 15.0, 15.0, 0.01, 0, 0};
  s.optics.f_number = 2.0;
  s.optics.wavelength_um = 4.0;
  s.add(Stage::presample, Component<double>::make("diffraction"));
  s.add(Stage::presample, footprint(15.0));
  s.add(Stage::presample, jitter(2.0));
  return s;
}

}  // namespace mtf::test
