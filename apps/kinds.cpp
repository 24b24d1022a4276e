// SPDX-License-Identifier: Apache-2.0
#include "apps/kinds.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "apps/schema/own_component.txt.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/units.h"
#include "mtf/words.h"
#ifdef MTFKIT_HAVE_STUDY
#include "apps/study/design/metric_list.h"
#include "apps/study/design/metric_rows.h"
#include "apps/study/study_shape.h"
#endif

namespace apps {
namespace {

/// "[[presample]], [[readout]]", each name between `before` and `after`.
std::string join_stages(const mtf::Stages& stages, const std::string& before, const std::string& after) {
  std::string text;
  for (const mtf::Stage stage : mtf::kStages)
    if (stages.allows(stage)) text += (text.empty() ? "" : ", ") + before + std::string(stage_name(stage)) + after;
  return text;
}

/// "width (or width_x, width_y)".
std::string written_name(const Parameter& parameter) {
  const std::string name(parameter.name);
  return parameter.type == mtf::FieldType::size ? name + " (or " + name + "_x, " + name + "_y)" : name;
}

std::string indented(std::string_view notes) {
  std::istringstream lines{std::string(notes)};
  std::string text;
  for (std::string line; std::getline(lines, line);) text += (line.empty() ? "" : "  " + line) + "\n";
  return text;
}

/// 1e6 for 1e+06.
std::string bound(double value) {
  std::string text = mtf::format_double(value);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  const std::size_t digits = text.find_first_of("123456789", e);
  return text.substr(0, e + 1) + (text[e + 1] == '-' ? "-" : "") + text.substr(digits);
}

std::string interval(const Parameter& parameter) {
  return (parameter.lo_open ? "(" : "[") + bound(parameter.lo) + ", " + bound(parameter.hi) +
         (parameter.hi_open ? ")" : "]");
}

/// Of a key of a table.
std::string values_of(const Parameter& key) {
  switch (key.type) {
    case mtf::FieldType::number_or_file:
      return mtf::with_unit(interval(key), key.unit) + ", or a file";
    case mtf::FieldType::whole:
      return "whole, " + interval(key);
    case mtf::FieldType::flag:
      return "true | false";
    case mtf::FieldType::text:
      return "a name";
    case mtf::FieldType::word:
    case mtf::FieldType::file:
      return range_of(key);
    default:
      if (has_range(key)) return mtf::with_unit(interval(key), key.unit);
      return std::string(key.type == mtf::FieldType::pair ? "two numbers" : "a number") +
             (key.unit.empty() ? "" : " in " + std::string(key.unit));
  }
}

std::string keys_table(const std::vector<Parameter>& keys) {
  TextTable table({"  key", "example", "range", "", ""});
  for (const Parameter& key : keys)
    table.add({"  " + written_name(key), std::string(key.example), values_of(key), std::string(presence_of(key)),
               std::string(key.doc)});
  return table.aligned();
}

/// `use`: what its keys are for.
std::string describe_table(const TableKind& kind, const std::string& use) {
  return "[" + std::string(kind.name) + "]: " + (kind.doc.empty() ? "" : std::string(kind.doc) + "; ") +
         "keys of the sensor file" + use + "\n\n" + keys_table(kind.parameters);
}

std::string describe_component(const ComponentKind& kind) {
  std::string text =
      std::string(kind.kind) + ": " + std::string(kind.doc) + "; in " + join_stages(kind.stages, "[[", "]]") + "\n";
  text += indented(kind.notes) + "\n";
  TextTable table({"  parameter", "example", "range", "", ""});
  for (const Parameter& parameter : kind.parameters)
    table.add({"  " + written_name(parameter), std::string(parameter.example),
               mtf::with_unit(range_of(parameter), parameter.unit), std::string(presence_of(parameter)),
               std::string(parameter.doc)});
  return text + table.aligned();
}

#ifdef MTFKIT_HAVE_STUDY
constexpr std::array kStudyNames{std::string_view("study"), std::string_view("conditions"),
                                 std::string_view("metrics")};

/// Keys of a study. Most take lists or values of another key, so that the example says more than a range.
std::string study_keys(std::span<const mtf::FieldInfo> keys) {
  TextTable table({"  key", "example", "", ""});
  for (const mtf::FieldInfo& key : keys)
    table.add({"  " + std::string(key.name), std::string(key.example), std::string(presence_of({key})),
               std::string(key.doc)});
  return table.aligned();
}

std::string describe_study() {
  std::string text =
      "study: keys of a study file, for mtf sweep and mtf optimize; mtf config init study writes one\n\n" +
      study_keys(study::kHeadKeys);
  for (const study::StudyTable& table : study::kStudyTables) {
    const std::string name(table.name);
    text += "\n" + (table.list ? "[[" + name + "]]" : "[" + name + "]") + ": " + std::string(table.doc) + "\n";
    if (!table.keys.empty()) text += study_keys(table.keys);
  }
  return text;
}

std::string describe_conditions() {
  std::vector<Parameter> keys;
  for (const mtf::FieldInfo& field : study::condition_fields()) keys.push_back({field});
  return "[conditions]: what metrics take from outside of the sensor; keys of a study file\n\n" + keys_table(keys);
}

std::string describe_metrics() {
  TextTable table({"  metric", "unit", "", "needs"});
  for (const study::MetricRow& row : study::metric_rows())
    table.add({"  " + std::string(row.name) + (row.directional ? "*" : ""), std::string(row.unit),
               std::string(row.definition), std::string(row.needs)});
  return "metrics: what a study may ask for in [metrics] list, constraints and objectives\n\n" + table.aligned() +
         "\nThose with * are also taken along one axis: NAME_x, NAME_y. mtf_at_20_cy_mm* is the MTF at any frequency "
         "in "
         "cy_mm, cy_mrad or cy_px.\n";
}

std::string describe_metric(const study::MetricInfo& metric) {
  return metric.name + ": " + mtf::with_unit(metric.definition, metric.unit.empty() ? "" : "[" + metric.unit + "]") +
         "; a metric of studies\n" + (metric.needs.empty() ? "" : "  needs " + metric.needs + "\n") +
         "  source: " + metric.source + "\n";
}

/// Of a study file, a table of it or a metric; "" for another name.
std::string describe_of_studies(const std::string& name) {
  if (name == "study") return describe_study();
  if (name == "conditions") return describe_conditions();
  if (name == "metrics") return describe_metrics();
  const auto metric = study::find_metric(name);
  return metric ? describe_metric(*metric) : "";
}
#else
constexpr std::array<std::string_view, 0> kStudyNames{};
std::string describe_of_studies(const std::string&) { return {}; }
#endif

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

void require_kind(const std::string& kind) {
  const std::vector<std::string> known = names_of_kinds();
  if (kind.empty() || std::ranges::find(known, kind) != known.end() || !describe_of_studies(kind).empty()) return;
  const auto meant = kind.size() <= 64 ? mtf::nearest(kind, known) : std::nullopt;
  throw mtf::UsageError("unknown kind '" + mtf::printable(kind, 60) +
                        "': neither a component nor a table nor a metric; " +
                        (meant ? "did you mean " + *meant + "?" : "mtf config kinds lists components and tables"));
}

std::string range_of(const Parameter& parameter) {
  if (parameter.type == mtf::FieldType::word) return joined(parameter.words, " | ");
  return parameter.type == mtf::FieldType::file ? "a file" : interval(parameter);
}

std::string_view presence_of(const Parameter& parameter) {
  return parameter.presence == mtf::Presence::required   ? "required"
         : parameter.presence == mtf::Presence::optional ? "optional"
                                                         : "or from [optics]";
}

std::vector<std::string> names_of_kinds() {
  const SensorKinds kinds = sensor_kinds();
  std::vector<std::string> names;
  for (const auto* tables : {&kinds.own_tables, &kinds.tables})
    for (const TableKind& table : *tables) names.emplace_back(table.name);
  for (const ComponentKind& component : kinds.components) names.emplace_back(component.kind);
  for (const std::string_view name : kStudyNames) names.emplace_back(name);
#ifdef MTFKIT_HAVE_STUDY
  for (const study::MetricRow& metric : study::metric_rows()) names.emplace_back(metric.name);
#endif
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string describe_kinds(const std::string& kind) {
  require_kind(kind);
  const SensorKinds kinds = sensor_kinds();
  std::string text;
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "\n") + more; };
  std::vector<std::string_view> names;
  for (const TableKind& table : kinds.own_tables) {
    names.push_back(table.name);
    if (table.name == kind) add(describe_table(table, ""));
  }
  for (const TableKind& table : kinds.tables) {  // [detector] once for each kind of detector
    if (std::ranges::find(names, table.name) == names.end()) names.push_back(table.name);
    if (table.name == kind)
      add(describe_table(table, " for " + (table.condition.empty() ? "electrons and counts"
                                                                   : "volts and counts, with " + table.condition)));
  }
  if (!text.empty()) return text;
  for (const ComponentKind& each : kinds.components)
    if (kind.empty() || each.kind == kind) add(describe_component(each));
  if (kind.empty()) {
    add("tables of a sensor file, whose keys `mtf config kinds NAME` lists: " + joined(names) + "\n");
    if (!kStudyNames.empty()) text += "of a study file: " + joined(kStudyNames) + "\n";
  }
  return text.empty() ? describe_of_studies(kind) : text;
}

// `mtf config kinds --format markdown`: mtf/components/README.md.

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
