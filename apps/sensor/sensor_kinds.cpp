// SPDX-License-Identifier: Apache-2.0
#include "apps/sensor/sensor_kinds.h"

#include <algorithm>
#include <utility>

#include "mtf/border.h"
#include "mtf/components/component_docs.h"
#include "mtf/io/config/config_reader.h"
#include "radiometry/chain/sensor_settings.h"

namespace apps {
namespace {

using mtf::Component;
using mtf::FieldInfo;
using mtf::FieldRef;
using mtf::Presence;
using Type = Parameter::Type;

Parameter row_of(const FieldInfo& info, Type type) {
  return {.name = info.name,
          .type = type,
          .unit = info.unit,
          .dimension = info.dimension,
          .lo = info.lo,
          .hi = info.hi,
          .lo_open = info.lo_open,
          .hi_open = info.hi_open,
          .presence = info.presence,
          .example = info.example,
          .doc = info.doc};
}

Type type_of(const FieldRef<double>& field) {
  return std::visit(
      [](const auto* value) {
        using T = std::remove_cvref_t<decltype(*value)>;
        if constexpr (std::is_same_v<T, mtf::AxisPair<double>>)
          return Type::size;
        else if constexpr (std::is_same_v<T, mtf::SpatialFrequency<double>>)
          return Type::frequency;
        else if constexpr (std::is_same_v<T, int>)
          return Type::whole;
        else if constexpr (std::is_same_v<T, mtf::Choice>)
          return Type::word;
        else if constexpr (std::is_same_v<T, mtf::Coefficients<double>>)
          return Type::numbers;
        else if constexpr (std::is_same_v<T, mtf::Taps<double>>)
          return Type::rows;
        else if constexpr (std::is_same_v<T, std::shared_ptr<const mtf::Curve>>)
          return Type::file;
        else
          return Type::number;
      },
      field.value);
}

/// What a component with default values would be written with.
std::string default_of(const FieldRef<double>& field) {
  if (field.info->presence != Presence::optional) return "";
  const std::string line = mtf::io::cfg::write_fields({&field, 1});
  const std::size_t equals = line.find(" = ");
  return equals == std::string::npos ? "" : line.substr(equals + 3, line.find('\n') - equals - 3);
}

/// `field`: of a component with default values.
Parameter parameter_of(const FieldRef<double>& field) {
  Parameter parameter = row_of(*field.info, type_of(field));
  if (parameter.type == Type::size) parameter.unit = "um, urad or px";
  if (parameter.type == Type::frequency)
    parameter.unit =
        field.info->dimension == mtf::Dimension::cutoff ? "cy/mm, cy/mrad, cy/px or Hz" : "cy/mm, cy/mrad or cy/px";
  if (const auto* choice = std::get_if<mtf::Choice*>(&field.value))
    parameter.words.assign((*choice)->names.begin(), (*choice)->names.end());
  parameter.default_value = default_of(field);
  return parameter;
}

Parameter parameter_of(const mtf::SettingInfo& row) {
  using mtf::SettingType;
  constexpr std::pair<SettingType, Type> types[] = {{SettingType::number, Type::number},
                                                    {SettingType::whole, Type::whole},
                                                    {SettingType::flag, Type::flag},
                                                    {SettingType::word, Type::word},
                                                    {SettingType::text, Type::text},
                                                    {SettingType::file, Type::file},
                                                    {SettingType::number_or_file, Type::number_or_file}};
  const auto* type =
      std::find_if(std::begin(types), std::end(types), [&](const auto& t) { return t.first == row.type; });
  Parameter parameter = row_of(row.info, type->second);
  parameter.words.assign(row.words.begin(), row.words.end());
  return parameter;
}

// Tables of the core: their rows are those that config_sections.cpp reads them by, but for what is no number.

Parameter own_row(const FieldInfo& info, Type type = Type::number) { return row_of(info, type); }

Parameter own_word(std::string_view name, std::span<const std::string_view> words, std::string_view example,
                   std::string_view doc) {
  Parameter parameter{.name = name, .type = Type::word, .presence = Presence::optional, .example = example, .doc = doc};
  parameter.words.assign(words.begin(), words.end());
  return parameter;
}

Parameter own_text(std::string_view name, Type type, std::string_view example, std::string_view doc) {
  return {.name = name, .type = type, .presence = Presence::optional, .example = example, .doc = doc};
}

std::vector<TableKind> own_tables() {
  namespace cfg = mtf::io::cfg;
  Parameter wavelength = own_row(cfg::kWavelength, Type::pair);
  wavelength.presence = Presence::required;
  wavelength.example = "[\"3.4 um\", \"4.8 um\"]";
  wavelength.doc = "shortest and longest";
  return {
      {.name = "frame",
       .doc = "the focal plane",
       .parameters = {own_row(cfg::kFocalLength),
                      own_row(cfg::kPitch, Type::size),
                      {.name = "format",
                       .type = Type::pair,
                       .lo = 1,
                       .hi = 1e6,
                       .presence = Presence::optional,
                       .example = "[640, 512]",
                       .doc = "columns and rows, the largest size of an image"},
                      own_row(cfg::kIntegrationTime)}},
      {.name = "scene",
       .doc = "what a scene file does not say itself",
       .parameters = {own_row(cfg::kSample, Type::size), own_row(cfg::kIfov), own_row(cfg::kGsd), own_row(cfg::kRange),
                      own_word("quantity", cfg::kQuantityNames, "\"radiance\"", "what the values are"),
                      own_row(cfg::kGain), own_row(cfg::kOffset),
                      own_text("encoding", Type::text, "\"linear\"",
                               "of PNG and TIFF: linear, srgb, gamma, gamma:1.8 or the file of a table"),
                      own_word("border", mtf::kBorderNames, "\"reflect\"", "how the scene goes on beyond its edge"),
                      own_row(cfg::kBorderValue),
                      own_word("aperture", cfg::kApertureNames, "\"box\"",
                               "blur already in the samples, which is divided out"),
                      own_row(cfg::kApertureSize, Type::size),
                      own_text("aperture_file", Type::file, "\"scene.csv\"", "CSV file of that blur's curve"),
                      own_row(cfg::kApertureGainLimit)}},
      {.name = "optics",
       .doc = "shared by every component that has the key and does not give it",
       .parameters = {own_row(cfg::kFNumber), own_row(cfg::kApertureDiameter), own_row(cfg::kObscuration),
                      own_row(cfg::kWavelength)}},
      {.name = "band", .doc = "the spectral band", .parameters = {wavelength}}};
}

/// The required fields; without any, or when they do not do, the first of the others that will, or the first two
/// neighbours among them.
void add_example(const Component<double>& blank, ComponentKind& kind) {
  const auto fields = blank.fields();
  std::string list;
  for (const mtf::Stage stage : mtf::kStages)
    if (list.empty() && blank.stages().allows(stage)) list = stage_name(stage);
  const auto with = [&](const FieldRef<double>* extra, const FieldRef<double>* more = nullptr) {
    std::string text = "[[" + list + "]]\nkind = \"" + std::string(kind.kind) + "\"\n";
    for (const FieldRef<double>& field : fields)
      if (field.info->presence == Presence::required || &field == extra || &field == more)
        text += std::string(field.info->name) + " = " + std::string(field.info->example) + "\n";
    return text;
  };
  const std::string sensor =
      "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\nintegration_time = \"10 ms\"\n"
      "[optics]\nf_number = 2.0\n[band]\nwavelength = [\"3.4 um\", \"4.8 um\"]\n";
  std::vector<const FieldRef<double>*> extras;
  const auto add_all = [&](Presence presence) {
    for (const FieldRef<double>& field : fields)
      if (field.info->presence == presence) extras.push_back(&field);
  };
  const bool some_required = std::any_of(fields.begin(), fields.end(), [](const FieldRef<double>& field) {
    return field.info->presence == Presence::required;
  });
  if (some_required) extras.push_back(nullptr);
  add_all(Presence::optional);
  if (!some_required) extras.push_back(nullptr);
  add_all(Presence::shared);
  kind.example = with(nullptr);
  std::vector<std::string> examples;
  for (const FieldRef<double>* extra : extras) examples.push_back(with(extra));
  for (std::size_t i = 1; i < extras.size(); ++i) examples.push_back(with(extras[i - 1], extras[i]));
  for (const std::string& example : examples) {
    const mtf::io::ConfigResult result = mtf::io::parse_config(sensor + example, "");
    if (!result.ok()) continue;
    const mtf::System<double>& system = result.config.system;
    for (const auto& entries : system.stages)
      for (const auto& entry : entries) {
        kind.example = example;
        kind.traits = entry.component.traits(system.context());
        return;
      }
  }
}

}  // namespace

std::string_view type_name(Parameter::Type type) {
  using enum Parameter::Type;
  switch (type) {
    case number:
      return "number";
    case size:
      return "size";
    case frequency:
      return "frequency";
    case whole:
      return "whole";
    case flag:
      return "flag";
    case word:
      return "word";
    case numbers:
      return "numbers";
    case rows:
      return "rows";
    case text:
      return "text";
    case file:
      return "file";
    case number_or_file:
      return "number_or_file";
    case pair:
      return "pair";
  }
  return "";
}

bool has_range(const Parameter& parameter) { return parameter.lo != parameter.hi; }

bool wants_log_scale(const Parameter& parameter) {
  constexpr double kSpan = 50.0;
  return has_range(parameter) && parameter.lo >= 0.0 && parameter.hi > kSpan * parameter.lo &&
         (parameter.lo > 0.0 || parameter.hi > kSpan);
}

ComponentKind component_kind(std::string_view kind) {
  const Component<double> blank = Component<double>::make(kind);
  ComponentKind result{.kind = blank.kind(),
                       .doc = blank.doc(),
                       .notes = mtf::component_notes(kind),
                       .source = mtf::component_source(kind),
                       .stages = blank.stages(),
                       .part = blank.part(),
                       .parameters = {},
                       .example = {},
                       .traits = {}};
  for (const FieldRef<double>& field : blank.fields()) result.parameters.push_back(parameter_of(field));
  add_example(blank, result);
  return result;
}

SensorKinds sensor_kinds() {
  SensorKinds kinds;
  for (const std::string_view kind : mtf::component_kinds()) kinds.components.push_back(component_kind(kind));
  for (const mtf::TableInfo& table : radiometry::sensor_tables()) {
    TableKind& added = kinds.tables.emplace_back(TableKind{table.name, table.doc, {}});
    if (table.where)
      added.condition = "[" + std::string(table.where->table) + "] " + std::string(table.where->key) + " = \"" +
                        std::string(table.where->word) + "\"";
    for (const mtf::SettingInfo& row : table.settings) added.parameters.push_back(parameter_of(row));
  }
  kinds.own_tables = own_tables();
  return kinds;
}

}  // namespace apps
