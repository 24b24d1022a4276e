// SPDX-License-Identifier: Apache-2.0
#pragma once

// Body of System<S>::check, apart from system_impl.h because it is long and read on its own.

#include "mtf/double_counting.h"
#include "mtf/system_impl.h"

namespace mtf {
namespace detail {

/// "kind", or "kind:word" for one with that word chosen in one of its fields.
template <class S>
bool matches(const Component<S>& component, std::string_view pattern) {
  const std::size_t colon = pattern.find(':');
  if (component.kind() != pattern.substr(0, colon)) return false;
  if (colon == std::string_view::npos) return true;
  for (const FieldRef<S>& field : component.fields())
    if (const auto* choice = std::get_if<Choice*>(&field.value))
      if ((*choice)->names[static_cast<std::size_t>((*choice)->index)] == pattern.substr(colon + 1)) return true;
  return false;
}

template <class S>
bool matches_one(const Component<S>& component, const std::array<std::string_view, 3>& patterns) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](std::string_view pattern) { return !pattern.empty() && matches(component, pattern); });
}

/// What `entry` counts that another entry of the system counts already.
template <class S>
std::vector<Problem> counted_twice(const System<S>& system, const Entry<S>& entry) {
  std::vector<Problem> problems;
  for (const DoubleCounting& rule : kDoubleCounting) {
    const bool alike = rule.other.front().empty();
    if (!matches_one(entry.component, alike ? rule.one : rule.other)) continue;
    bool earlier = true;
    for (const Stage stage : kStages)
      for (const Entry<S>& first : system.list(stage)) {
        earlier = earlier && &first != &entry;
        if (&first == &entry || (alike && !earlier) || !matches_one(first.component, rule.one)) continue;
        problems.push_back({.error = false,
                            .text = "\"" + std::string(entry.component.kind()) + "\" beside \"" + first.label +
                                    "\": " + std::string(rule.why)});
      }
  }
  return problems;
}

}  // namespace detail

template <class S>
std::vector<typename System<S>::Finding> System<S>::check() const {
  return findings(true);
}
template <class S>
std::vector<typename System<S>::Finding> System<S>::errors() const {
  return findings(false);
}

template <class S>
std::vector<typename System<S>::Finding> System<S>::findings(bool doubtful) const {
  std::vector<Finding> findings;
  const auto error = [&](std::string where, std::string text) {
    findings.push_back({std::move(where), {.error = true, .field = {}, .text = std::move(text)}});
  };
  const auto within = [&](std::string_view where, const S& value, std::string_view unit, double low, double high) {
    const double v = value_of(value);
    if (!(v >= low && v <= high))
      error(std::string(where), format_double(v) + (unit.empty() ? "" : " ") + std::string(unit) + " is outside [" +
                                    format_double(low) + ", " + format_double(high) + "]");
  };
  within("frame.focal_length", frame.focal_length_mm, "mm", 1e-6, 1e7);
  within("frame.pitch_x", frame.pitch_x_um, "um", 1e-6, 1e6);
  within("frame.pitch_y", frame.pitch_y_um, "um", 1e-6, 1e6);
  if (!(value_of(frame.integration_time_s) >= 0.0 && value_of(frame.integration_time_s) <= 1e9))
    error("frame.integration_time", format_double(value_of(frame.integration_time_s)) + " s is outside [0, 1e9]");
  if (frame.columns < 0 || frame.rows < 0) error("frame.format", "columns and rows have to be positive");
  if (optics.f_number && optics.aperture_mm) error("optics.aperture", "give either f_number or aperture");
  if (optics.f_number) within("optics.f_number", *optics.f_number, "", 0.1, 1e4);
  if (optics.aperture_mm) within("optics.aperture", *optics.aperture_mm, "mm", 1e-6, 1e6);
  if (optics.aperture_mm && value_of(*optics.aperture_mm) > 0.0) {
    const double f_number = value_of(frame.focal_length_mm) / value_of(*optics.aperture_mm);
    if (f_number < 0.1 || f_number > 1e4)
      error("optics.aperture", "focal_length / aperture = " + format_double(f_number) + " is outside [0.1, 1e4]");
  }
  if (optics.obscuration && !(value_of(*optics.obscuration) >= 0.0 && value_of(*optics.obscuration) < 1.0))
    error("optics.obscuration", format_double(value_of(*optics.obscuration)) + " is outside [0, 1)");
  if (optics.wavelength_um) within("optics.wavelength", *optics.wavelength_um, "um", 0.01, 1e5);
  if (band && !(band->lo_um >= 0.01 && band->hi_um > band->lo_um && band->hi_um <= 1e5))
    error("band.wavelength", "has to be two increasing wavelengths in [0.01, 1e5] um");
  if (band && optics.wavelength_um) error("optics.wavelength", "the spectrum is given twice: remove it or [band]");
  if (!findings.empty()) return findings;  // component checks rely on the frame

  for (const Stage stage : kStages) {
    std::string pupil;
    for (std::size_t i = 0; i < list(stage).size(); ++i) {
      const Entry<S>& entry = list(stage)[i];
      const auto where = [&] { return std::string(stage_name(stage)) + "[" + std::to_string(i) + "]"; };
      if (!entry.component.stages().allows(stage))
        error(where() + ".kind", "\"" + std::string(entry.component.kind()) + "\" cannot stand in [[" +
                                     std::string(stage_name(stage)) + "]]");
      // A chromatic component meets its limits at one end of the band.
      std::vector<Problem> problems = entry.component.check(context());
      if (band && problems.empty() && entry.component.traits(context()).chromatic)
        for (const double wavelength : {band->lo_um, band->hi_um})
          if (problems.empty()) problems = entry.component.check(context(S(wavelength)));
      for (Problem& problem : problems)
        if (problem.error || doubtful)
          findings.push_back({where() + (problem.field.empty() ? "" : "." + problem.field), std::move(problem)});
      if (doubtful)
        for (Problem& problem : detail::counted_twice(*this, entry))
          findings.push_back({where() + ".kind", std::move(problem)});
      if (!entry.component.is_pupil()) continue;
      if (!pupil.empty())
        error(where() + ".kind",
              "a second complete pupil OTF beside \"" + pupil +
                  "\": aberrations and diffraction are one integral; use one wavefront with all terms");
      pupil = entry.label;
    }
  }
  return findings;
}

}  // namespace mtf
