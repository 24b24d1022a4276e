// SPDX-License-Identifier: Apache-2.0

// `mtf config kinds --format markdown`: mtf/components/README.md.

#include <algorithm>
#include <array>
#include <sstream>

#include "apps/kinds.h"
#include "apps/schema/own_component.txt.h"
#include "mtf/error.h"

namespace apps {
namespace {

/// The order of the page, along the path of the light and the signal.
struct Group {
  mtf::SensorPart part;
  std::string_view title;
};
constexpr std::array kGroups{Group{mtf::SensorPart::optics, "Optics"},
                             Group{mtf::SensorPart::path, "Path"},
                             Group{mtf::SensorPart::detector, "Focal plane"},
                             Group{mtf::SensorPart::motion, "Motion"},
                             Group{mtf::SensorPart::electronics, "Electronics and digital filters"},
                             Group{mtf::SensorPart::display, "Display and eye"},
                             Group{mtf::SensorPart::unspecified, "Measured, or known by size alone"}};

// Prose becomes paragraphs, indented lines become code blocks.
std::string as_markdown(std::string_view notes) {
  enum class Last { nothing, prose, formula } last = Last::nothing;
  std::istringstream lines{std::string(notes)};
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) {
      last = Last::nothing;
      continue;
    }
    const Last now = line.starts_with("  ") ? Last::formula : Last::prose;
    if (!text.empty()) text += now != last ? "\n\n" : now == Last::prose ? " " : "\n";
    text += now == Last::formula ? "  " + line : line;
    last = now;
  }
  while (text.ends_with(' ')) text.pop_back();
  return text + "\n";
}

/// Bars would end a cell.
std::string cell(std::string text) {
  for (std::size_t i = text.find('|'); i != std::string::npos; i = text.find('|', i + 2)) text.insert(i, "\\");
  return text;
}

std::string code(std::string_view text) { return "`" + std::string(text) + "`"; }

std::string traits_text(const mtf::Traits& traits) {
  std::string text = traits.real ? "real" : "complex";
  const auto add = [&](bool is, const char* words) { text += is ? std::string(", ") + words : ""; };
  add(traits.radial, "radial");
  add(traits.separable, "separable");
  add(traits.even_x && traits.even_y, "even in x and y");
  add(traits.even_x && !traits.even_y, "even in x");
  add(traits.even_y && !traits.even_x, "even in y");
  add(traits.chromatic, "depends on the wavelength in the band");
  add(traits.gain, "may amplify");
  return text;
}

std::string section(const ComponentKind& kind) {
  std::string doc(kind.doc);
  doc.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(doc.front())));
  std::string text =
      "## " + std::string(kind.kind) + "\n\n**" + doc + "**, in " + join_stages(kind.stages, "`[[", "]]`") + ".\n\n";
  std::string_view notes = kind.notes;
  // The source, in parentheses at the end of the notes, gets a line of its own.
  if (!kind.source.empty()) notes.remove_suffix(kind.source.size() + 3);
  text += as_markdown(notes) + (kind.source.empty() ? "" : "\nSource: " + kind.source + "\n");
  text += "\n| parameter | unit | range | presence | example | meaning |\n|---|---|---|---|---|---|\n";
  for (const Parameter& parameter : kind.parameters) {
    const std::string row[] = {written_name(parameter), std::string(parameter.unit),
                               range_of(parameter),     std::string(presence_of(parameter)),
                               code(parameter.example), std::string(parameter.doc)};
    for (const std::string& each : row) text += "| " + cell(each) + (each.empty() ? "" : " ");
    text += "|\n";
  }
  text += "\n```toml\n" + kind.example + "```\n";
  if (kind.traits) text += "\nThe OTF of this example: " + traits_text(*kind.traits) + ".\n";
  return text;
}

}  // namespace

std::string kinds_markdown(const std::string& kind) {
  if (!kind.empty()) {
    require_kind(kind);
    const auto components = mtf::component_kinds();
    if (std::ranges::find(components, kind) == components.end())
      throw mtf::UsageError("--format markdown: describes components only; `mtf config kinds " + kind +
                            "` and --format json describe '" + kind + "'");
    return section(component_kind(kind));
  }
  const SensorKinds kinds = sensor_kinds();
  std::string contents, sections;
  for (const auto& [part, title] : kGroups) {
    contents += "| **" + std::string(title) + "** | | |\n";
    for (const ComponentKind& each : kinds.components) {
      if (each.part != part) continue;
      const std::string kind_name(each.kind);
      contents += "| [" + kind_name + "](#" + kind_name + ") | " + cell(std::string(each.doc)) + " | " +
                  join_stages(each.stages, "", "") + " |\n";
      sections += "\n" + section(each);
    }
  }
  return R"(<!-- Generated from the component headers: mtf config kinds --format markdown > mtf/components/README.md -->
# Components

Every analytic MTF that a sensor file may list, one header each. `mtf config kinds KIND` shows the same text,
`mtf config explain SENSOR` the formulas of one sensor. The system OTF is the product of what is listed, nothing else.

- `otf(f)` is the integral of `psf(x) exp(-2 pi i f.x)`, with `f` in cycles/mm at the focal plane, +x to the right and
  +y down. Lengths and angles are converted by the frame, so `"8 urad"`, `"0.8 um"` and `"0.05 px"` all work where the
  unit says um, urad or px.
- `sinc(x) = sin(pi x)/(pi x)`; `rms` is one sigma of one axis.
- A parameter is required, optional, or taken from `[optics]` (the wavelength from `[band]` or `[optics]`) when the
  component does not give it.

| kind | | lists |
|---|---|---|
)" + contents +
         sections + "\n" + std::string(mtf::embedded::own_component_txt);
}

}  // namespace apps
