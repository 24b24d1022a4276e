// SPDX-License-Identifier: Apache-2.0

// Systems of doubles and of floats, and what is wrong or doubtful about one.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "mtf/components/defocus.h"
#include "mtf/components/double_counting.h"
#include "mtf/components/linear_motion.h"
#include "mtf/error.h"
#include "mtf/otf/system_impl.h"
#include "mtf/words.h"

namespace mtf {
namespace {

using Finding = System<double>::Finding;

/// "kind", or "kind:word" for one with that word chosen in one of its fields.
bool matches(const Component<double>& component, std::string_view pattern) {
  const std::size_t colon = pattern.find(':');
  if (component.kind() != pattern.substr(0, colon)) return false;
  if (colon == std::string_view::npos) return true;
  for (const FieldRef<double>& field : component.fields())
    if (const auto* choice = std::get_if<Choice*>(&field.value))
      if ((*choice)->names[static_cast<std::size_t>((*choice)->index)] == pattern.substr(colon + 1)) return true;
  return false;
}

bool matches_one(const Component<double>& component, const std::array<std::string_view, 3>& patterns) {
  return std::ranges::any_of(patterns,
                             [&](std::string_view pattern) { return !pattern.empty() && matches(component, pattern); });
}

/// What `entry` counts that another entry of the system counts already.
std::vector<Problem> counted_twice(const System<double>& system, const Entry<double>& entry) {
  std::vector<Problem> problems;
  for (const DoubleCounting& rule : kDoubleCounting) {
    const bool alike = rule.other.front().empty();
    if (!matches_one(entry.component, alike ? rule.one : rule.other)) continue;
    bool earlier = true;
    for (const Stage stage : kStages)
      for (const Entry<double>& first : system.list(stage)) {
        earlier = earlier && &first != &entry;
        if (&first == &entry || (alike && !earlier) || !matches_one(first.component, rule.one)) continue;
        problems.push_back({.error = false,
                            .text = "\"" + std::string(entry.component.kind()) + "\" beside \"" + first.label +
                                    "\": " + std::string(rule.why)});
      }
  }
  return problems;
}

/// Says where Q, the sampling frequency over the optical cutoff (Fiete, Opt. Eng. 38, 1229, 1999), is far from what
/// cameras have. For most that is 0.05 to 5, for scanners with large pixels down to 0.002; a unit that is wrong by 1000
/// mostly leaves the bounds here.
std::vector<Finding> doubtful_sampling(const System<double>& system, const Component<double>& pupil) {
  constexpr double kLeast = 0.0015, kMost = 30.0;
  std::vector<Finding> doubts;
  const double lambda_n_um = 1e3 / pupil.cutoff_cy_mm(system.context());
  for (const Axis axis : {Axis::x, Axis::y}) {
    const double pitch_um = system.frame.pitch_um(axis), q = lambda_n_um / pitch_um;
    if (q >= kLeast && q <= kMost) continue;
    doubts.push_back({axis == Axis::x ? "frame.pitch_x" : "frame.pitch_y",
                      {.error = false,
                       .text = "Q = lambda N / pitch = " + significant(lambda_n_um, 6) + " um / " +
                               significant(pitch_um, 6) + " um = " + significant(q, 3) +
                               ", where most cameras have 0.05 to 5; compare the units of the pitch, the wavelength, "
                               "the focal length and the aperture"}});
  }
  return doubts;
}

/// Of a flow whose points do not move along straight lines.
std::vector<Problem> large_flow(const Flow<double>& flow) {
  constexpr double kSmall = 0.1, kAsLarge = 1.0;  // as the whole
  std::vector<Problem> problems;
  for (const auto& [name, share] :
       {std::pair{"zoom", flow.zoom.value_or(0.0)}, {"rotation", 1e-6 * flow.rotation_urad.value_or(0.0)}})
    if (std::abs(share) > kSmall)
      problems.push_back({.error = std::abs(share) >= kAsLarge,
                          .field = name,
                          .text = "is " + significant(std::abs(share), 3) + (name[0] == 'z' ? "" : " rad") +
                                  " in one integration time; the formula takes paths for straight, which is right to "
                                  "about the square of that: give 0.1 or less, or a shorter integration time"});
  return problems;
}

/// Where a component is used beyond what its formula is made for, as the frame shows. A lens of focal length F that is
/// focused at the range f has its image at F/(1 - F/f), and F/# N/(1 - F/f) there.
std::vector<Problem> beyond_formula(const System<double>& system, const Component<double>& component) {
  if (const auto* const flow = component.get_if<Flow<double>>()) return large_flow(*flow);
  const auto* const defocus = component.get_if<Defocus<double>>();
  if (defocus == nullptr || !defocus->focus_m) return {};
  const double focus_m = value_of(*defocus->focus_m), focal_m = 1e-3 * system.frame.focal_length_mm,
               share = focal_m / focus_m;
  if (share >= 1.0)
    return {{.field = "focus",
             .text = format_double(focus_m) + " m lies within the focal length of " + significant(focal_m, 6) +
                     " m, where nothing has a real image; focus farther, or correct frame.focal_length"}};
  constexpr double kShare = 0.01;
  if (share <= kShare) return {};
  return {{.error = false,
           .field = "focus",
           .text = "is so near that the F/# of the image and its distance from the lens are " +
                   significant(1.0 / (1.0 - share), 3) +
                   " times those for infinity; f_number and focal_length have to be those of this focus"}};
}

/// Places all over the image at which numbers that change over the field are looked at: the whole detector, or, where
/// its format is not given, a square.
std::vector<FieldPoint<double>> points_over_field(const System<double>& system) {
  constexpr int kSteps = 8;
  const Frame<double>& frame = system.frame;
  const bool known = frame.columns > 0 && frame.rows > 0;
  const double width = known ? frame.columns * frame.pitch_x_um : 1.0,
               height = known ? frame.rows * frame.pitch_y_um : 1.0, radius = 0.5 * std::hypot(width, height);
  const double axis_x = system.field.axis_x_px * frame.pitch_x_um / radius,
               axis_y = system.field.axis_y_px * frame.pitch_y_um / radius;
  std::vector<FieldPoint<double>> points;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i)
      points.push_back({(static_cast<double>(i) / kSteps - 0.5) * width / radius - (known ? axis_x : 0.0),
                        (static_cast<double>(j) / kSteps - 0.5) * height / radius - (known ? axis_y : 0.0)});
  return points;
}

/// What is wrong with a component somewhere in the image, the first place of each.
std::vector<Problem> wrong_over_field(const System<double>& system, std::size_t entry) {
  std::vector<Problem> problems;
  System<double> alone = system;
  std::erase_if(alone.field.numbers, [entry](const auto& number) { return number.entry != entry; });
  const bool mapped = std::ranges::any_of(alone.field.numbers, [](const auto& number) {
    return number.map != nullptr && number.map->unit != FieldUnit::half_diagonal;
  });
  if (!mapped) alone.half_diagonal_um = 1.0;  // at() asks for a size
  for (const FieldPoint<double>& q : points_over_field(system)) {
    const auto add = [&](Problem problem) {
      problem.text += " at the field point (" + significant(q.x, 3) + ", " + significant(q.y, 3) + ")";
      problems.push_back(std::move(problem));
    };
    try {
      const System<double> here = alone.at(q);
      for (Problem& problem : here.list(Stage::presample)[entry].component.check(here.context()))
        if (problem.error) add(std::move(problem));
    } catch (const UsageError& error) {  // outside a map
      const auto with_map =
          std::ranges::find_if(alone.field.numbers, [](const auto& number) { return number.map != nullptr; });
      const auto fields = alone.list(Stage::presample)[entry].component.fields();
      add({.field = std::string(fields[with_map->field].info->name), .text = error.what()});
    }
    if (!problems.empty()) break;
  }
  return problems;
}

/// What is wrong, and where `doubtful` also what is only doubtful.
std::vector<Finding> findings_of(const System<double>& system, bool doubtful) {
  const Frame<double>& frame = system.frame;
  const Optics<double>& optics = system.optics;
  const std::optional<Band>& band = system.band;
  std::vector<Finding> findings;
  const auto error = [&](std::string where, std::string text) {
    findings.push_back({std::move(where), {.error = true, .text = std::move(text)}});
  };
  const auto within = [&](std::string_view where, double value, std::string_view unit, double low, double high) {
    const FieldInfo info{.name = where, .lo = low, .hi = high};
    if (!in_range(info, value)) error(std::string(where), outside_text(info, value, unit));
  };
  within("frame.focal_length", frame.focal_length_mm, "mm", 1e-6, 1e7);
  within("frame.pitch_x", frame.pitch_x_um, "um", 1e-6, 1e6);
  within("frame.pitch_y", frame.pitch_y_um, "um", 1e-6, 1e6);
  if (!(frame.integration_time_s >= 0.0 && frame.integration_time_s <= 1e9))
    error("frame.integration_time", format_double(frame.integration_time_s) + " s is outside [0, 1e9]");
  if (frame.columns < 0 || frame.rows < 0) error("frame.format", "columns and rows have to be positive");
  if (optics.f_number && optics.aperture_mm) error("optics.aperture", "give either f_number or aperture");
  if (optics.f_number) within("optics.f_number", *optics.f_number, "", 0.1, 1e4);
  if (optics.aperture_mm) within("optics.aperture", *optics.aperture_mm, "mm", 1e-6, 1e6);
  if (optics.aperture_mm && *optics.aperture_mm > 0.0) {
    const double f_number = frame.focal_length_mm / *optics.aperture_mm;
    if (f_number < 0.1 || f_number > 1e4)
      error("optics.aperture", "focal_length / aperture = " + format_double(f_number) + " is outside [0.1, 1e4]");
  }
  if (optics.obscuration && !(*optics.obscuration >= 0.0 && *optics.obscuration < 1.0))
    error("optics.obscuration", format_double(*optics.obscuration) + " is outside [0, 1)");
  if (optics.wavelength_um) within("optics.wavelength", *optics.wavelength_um, "um", 0.01, 1e5);
  if (band && !(band->lo_um >= 0.01 && band->hi_um > band->lo_um && band->hi_um <= 1e5))
    error("band.wavelength", "has to be two increasing wavelengths in [0.01, 1e5] um");
  if (band && optics.wavelength_um) error("optics.wavelength", "the spectrum is given twice: remove it or [band]");
  if (!findings.empty()) return findings;  // component checks rely on the frame
  const double f_number = f_number_of<double>(std::nullopt, system.context());
  if (constexpr double kLeast = 0.5; doubtful && f_number > 0.0 && f_number < kLeast)
    findings.push_back({optics.f_number ? "optics.f_number" : "optics.aperture",
                        {.error = false,
                         .text = "an f-number of " + format_double(f_number) +
                                 "; a lens in air has at least 0.5, where its cone of light is a half-space"}});

  for (const Stage stage : kStages) {
    std::string pupil;
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const Entry<double>& entry = system.list(stage)[i];
      const auto where = [&] { return std::string(stage_name(stage)) + "[" + std::to_string(i) + "]"; };
      if (!entry.component.stages().allows(stage))
        error(where() + ".kind", "\"" + std::string(entry.component.kind()) + "\" cannot stand in [[" +
                                     std::string(stage_name(stage)) + "]]");
      // A chromatic component meets its limits at one end of the band.
      std::vector<Problem> problems = entry.component.check(system.context());
      if (band && problems.empty() && entry.component.traits(system.context()).chromatic)
        for (const double wavelength : {band->lo_um, band->hi_um})
          if (problems.empty()) problems = entry.component.check(system.context(wavelength));
      const bool varies = stage == Stage::presample &&
                          std::ranges::any_of(system.field.numbers, [i](const auto& n) { return n.entry == i; });
      if (problems.empty() && varies) problems = wrong_over_field(system, i);
      if (problems.empty()) problems = beyond_formula(system, entry.component);
      const bool sound = std::ranges::none_of(problems, [](const Problem& p) { return p.error; });
      for (Problem& problem : problems)
        if (problem.error || doubtful)
          findings.push_back({where() + (problem.field.empty() ? "" : "." + problem.field), std::move(problem)});
      if (doubtful)
        for (Problem& problem : counted_twice(system, entry))
          findings.push_back({where() + ".kind", std::move(problem)});
      if (!entry.component.is_pupil()) continue;
      if (doubtful && sound)
        for (Finding& doubt : doubtful_sampling(system, entry.component)) findings.push_back(std::move(doubt));
      if (!pupil.empty())
        error(where() + ".kind", "a second complete pupil OTF beside \"" + pupil +
                                     "\": aberrations and diffraction are one integral; remove one of the two, as "
                                     "defocus and wavefront contain diffraction, or give all terms in one wavefront");
      pupil = entry.label;
    }
  }
  return findings;
}

}  // namespace

template <class S>
std::vector<typename System<S>::Finding> System<S>::check() const requires std::same_as<S, double> {
  return findings_of(*this, true);
}
template <class S>
std::vector<typename System<S>::Finding> System<S>::errors() const requires std::same_as<S, double> {
  return findings_of(*this, false);
}

template struct System<double>;
template struct System<float>;
template System<float> cast<float, double>(const System<double>&);

std::string_view stage_name(Stage stage) {
  return stage == Stage::presample ? "presample" : stage == Stage::readout ? "readout" : "postsample";
}

Choice choice_of(std::span<const std::string_view> names, std::string_view word) {
  const auto found = std::ranges::find(names, word);
  if (found != names.end()) return {static_cast<int>(found - names.begin()), names};
  throw UsageError("\"" + std::string(word) + "\" is none of: " + joined(names));
}

std::string names_over_field(const System<double>& system) {
  std::string names;
  const auto add = [&](std::size_t entry, std::string_view field) {
    const std::string name =
        std::string(stage_name(Stage::presample)) + "[" + std::to_string(entry) + "]." + std::string(field);
    if (names.find(name) == std::string::npos) names += (names.empty() ? "" : ", ") + name;
  };
  if (system.is_isoplanatic()) return names;
  const auto& list = system.list(Stage::presample);
  for (const FieldNumber<double>& number : system.field.numbers)
    add(number.entry, list.at(number.entry).component.fields().at(number.field).info->name);
  for (const FieldAngle& angle : system.field.angles)
    add(angle.entry, list.at(angle.entry).component.fields().at(angle.field).info->name);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].component.traits(system.context()).placed) add(i, list[i].component.kind());
  return names;
}

void require_isoplanatic(const System<double>& system, std::string_view what) {
  if (system.is_isoplanatic()) return;
  throw UsageError(std::string(what) + " takes one OTF for the whole image; here it changes over the field by " +
                   names_over_field(system));
}

void require_valid(const System<double>& system) {
  const auto said = [](const System<double>::Finding& finding) { return finding.where + ": " + finding.problem.text; };
  if (const auto errors = system.errors(); !errors.empty()) throw UsageError(joined(errors, said, "; "));
}

}  // namespace mtf
