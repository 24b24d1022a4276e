// SPDX-License-Identifier: Apache-2.0
#include "apps/live/space/scene_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "apps/scene/scene_file/scene_fields.h"
#include "apps/scene/weather/si_units.h"
#include "apps/text/words.h"
#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/config_text.h"

namespace apps::live {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using mtf::FieldInfo;
using mtf::UsageError;

std::string example_of(const FieldInfo& field) {
  std::string text(field.example);
  std::erase(text, '"');
  return text;
}

/// Collects the rows of one table.
class Rows {
 public:
  Rows(std::string owner, const Node& table) : owner_(std::move(owner)), table_(&table) {}

  /// A key that is in the file.
  void stated(const FieldInfo& field) {
    if (const Node* node = table_->find(field.name)) add(*table_, field, std::string(field.name), node, "");
  }
  /// A key that the file may leave out; `otherwise` counts then.
  void optional(const FieldInfo& field, const std::string& otherwise) {
    add(*table_, field, std::string(field.name), table_->find(field.name), otherwise);
  }
  /// Keys of a table within this one, that are in the file: "inside", "layers[0]".
  void within(const std::string& part, const Node& table, std::span<const FieldInfo> fields) {
    for (const FieldInfo& field : fields)
      if (const Node* node = table.find(field.name)) add(table, field, part + "." + std::string(field.name), node, "");
  }
  SceneTable table(std::string title, std::string doc) && {
    return {std::move(title), std::move(doc), std::move(rows_)};
  }

 private:
  void add(const Node& table, const FieldInfo& field, const std::string& path, const Node* node,
           const std::string& otherwise) {
    std::string key = path;
    std::replace(key.begin(), key.end(), '.', ' ');
    rows_.push_back({owner_ + "." + path, key, field, &table, cfg::number_of(node), otherwise});
  }

  std::string owner_;
  const Node* table_;
  std::vector<SceneRow> rows_{};
};

SceneTable weather_table(const Node& weather) {
  Rows rows("weather", weather);
  if (weather.find("file") == nullptr) {
    for (const FieldInfo& field : scene::kConstants) rows.stated(field);
    rows.stated(scene::kHumidity);
    return std::move(rows).table("weather", "constant weather");
  }
  for (const FieldInfo& field : scene::kWeatherChanges)
    rows.optional(field, field.unit.empty() ? "1.0" : "0 " + std::string(field.unit));
  return std::move(rows).table("weather", "changes of the weather that the scene's file names");
}

SceneTable material_table(const Node& material, const std::string& name) {
  const std::array layer_fields{scene::kThickness, scene::kConductivity, scene::kDensity, scene::kHeatCapacity,
                                scene::kSource};
  // Of the kinds of insides each has some of these.
  const std::array inside_fields{scene::kTemperature,      scene::kFilm,       scene::kFlux,
                                 scene::kSolarAbsorptance, scene::kEmissivity, scene::kPairThickness};
  Rows rows("material." + name, material);
  if (const Node* inside = material.find("inside")) rows.within("inside", *inside, inside_fields);
  rows.stated(scene::kSolarAbsorptance);
  rows.stated(scene::kEmissivity);
  if (const Node* layers = material.find("layers"))
    for (std::size_t i = 0; i < layers->items.size(); ++i)
      rows.within("layers[" + std::to_string(i) + "]", layers->items[i], layer_fields);
  rows.optional(scene::kWetFraction, "0.0");
  rows.optional(scene::kGloss, "0.0");
  return std::move(rows).table("material " + name,
                               "what surfaces of this material are made of, from the outside inwards");
}

/// The part of `list` that is called `name` is item i of it.
template <class Visit>
void for_items(const Node& root, std::string_view list, const Visit& visit) {
  const Node* found = root.find(list);
  if (found == nullptr) return;
  for (std::size_t i = 0; i < found->items.size(); ++i) {
    const Node* name = found->items[i].find("name");
    visit(found->items[i], name != nullptr ? name->text : std::to_string(i + 1));
  }
}

struct Written {
  double number = 0.0;
  std::string unit;
};

/// "20 mm" in its parts, where it is a quantity of the row; null for the name of a file.
std::optional<Written> quantity_in(const std::string& text, const FieldInfo& field) {
  try {
    static_cast<void>(scene::parse_si(text, field.unit, example_of(field)));
  } catch (const UsageError&) {
    return std::nullopt;
  }
  char* rest = nullptr;
  const double number = std::strtod(text.c_str(), &rest);
  while (*rest == ' ' || *rest == '\t') ++rest;
  return Written{number, rest};
}

/// A value in SI in that unit: units of scene files are linear.
double in_unit(double si, const std::string& unit, const FieldInfo& field) {
  const double zero = scene::parse_si("0 " + unit, field.unit, example_of(field));
  const double one = scene::parse_si("1 " + unit, field.unit, example_of(field));
  return (si - zero) / (one - zero);
}

SliderRange range_of(const FieldInfo& field, double number, double lo, double hi) {
  constexpr double kLargestOffset = 300.0;  // of weather: an offset to either side
  if (field.lo == -field.hi && field.hi <= kLargestOffset) return {lo, hi, false};
  const Parameter row{.name = field.name,
                      .unit = field.unit,
                      .dimension = field.unit == "K" ? mtf::Dimension::temperature : mtf::Dimension::none,
                      .lo = field.lo,
                      .hi = field.hi,
                      .lo_open = field.lo_open,
                      .hi_open = field.hi_open};
  return slider_range(row, number, lo, hi);
}

Json row_json(const SceneRow& row) {
  const FieldInfo& field = row.field;
  const std::string text = row.node != nullptr ? written(*row.node) : row.otherwise, example = example_of(field);
  Json json{{"name", row.name},
            {"key", row.key},
            {"given", row.node != nullptr},
            {"doc", field.doc},
            {"text", text},
            {"example", example},
            {"presence", field.presence == mtf::Presence::required ? "required" : "optional"}};
  // In place of a schedule the slider begins at the example, which shows what is usual.
  const auto stated = quantity_in(text, field);
  const Written now = stated ? *stated : quantity_in(example, field).value();
  const double lo = in_unit(field.lo, now.unit, field), hi = in_unit(field.hi, now.unit, field);
  const SliderRange range = range_of(field, now.number, lo, hi);
  add_number(json, now.number, now.unit, lo, hi, range);
  json["units"] = Json::array();
  json["whole"] = false;
  return json;
}

const SceneRow* find_row(const std::vector<SceneTable>& tables, std::string_view name) {
  for (const SceneTable& table : tables)
    for (const SceneRow& row : table.rows)
      if (row.name == name) return &row;
  return nullptr;
}

/// The value as the file has it: a text in quotes, a number where the row has no unit, as a text there names a file.
std::string toml_of(const std::string& value, const FieldInfo& field) {
  const Node node = cfg::node_of(value, 0);
  if (field.unit.empty() && node.is_number()) return cfg::toml_number(node.number);
  if (field.unit.empty()) return cfg::toml_number(scene::parse_si(value, field.unit, example_of(field)));
  return cfg::toml_string(value);
}

/// What the text of the start has there, which need not be a number.
std::string text_at_start(const std::string& start, const std::string& name) {
  const cfg::Tree tree = cfg::read_tree(start);
  const std::vector<SceneTable> tables = scene_tables(tree.root);
  const SceneRow* row = find_row(tables, name);
  return row != nullptr && row->node != nullptr ? written(*row->node) : std::string();
}

std::string with_value(const std::string& text, const std::string& start, const Edit& edit) {
  const cfg::Tree tree = cfg::read_tree(text);
  const std::vector<SceneTable> tables = scene_tables(tree.root);
  const bool of_value = edit.kind == Edit::Kind::set || edit.kind == Edit::Kind::unset;
  const SceneRow* row = of_value ? find_row(tables, edit.name) : nullptr;
  if (row == nullptr) throw UsageError(one_line(edit.name) + ": is not changed by the live view");
  const FieldInfo& field = row->field;
  cfg::TableText out(text, *row->table);
  if (edit.kind == Edit::Kind::unset) {
    if (row->node == nullptr) throw UsageError(edit.name + ": the file does not state it");
    out.remove_line(field.name);
    return out.text();
  }
  std::string value;
  try {
    value = toml_of(edit.value, field);
    if (!field.unit.empty()) static_cast<void>(scene::parse_si(edit.value, field.unit, example_of(field)));
  } catch (const UsageError& error) {
    if (edit.value != text_at_start(start, edit.name))
      throw UsageError(edit.name + ": " + error.what() + " (files are named in the scene file alone)");
    value = cfg::toml_string(edit.value);
  }
  if (row->node != nullptr)
    out.replace(*row->node, value);
  else
    out.add_line(std::string(field.name) + " = " + value);
  return out.text();
}

}  // namespace

std::vector<SceneTable> scene_tables(const Node& root) {
  std::vector<SceneTable> tables;
  if (const Node* weather = root.find("weather")) tables.push_back(weather_table(*weather));
  if (const Node* sky = root.find("sky")) {
    Rows rows("sky", *sky);
    if (const Node* cloud = sky->find("cloud"); cloud != nullptr && quantity_in(written(*cloud), scene::kCloud))
      rows.stated(scene::kCloud);
    tables.push_back(std::move(rows).table("sky", "clouds"));
  }
  for_items(root, "material",
            [&](const Node& material, const std::string& name) { tables.push_back(material_table(material, name)); });
  for_items(root, "region", [&](const Node& region, const std::string& name) {
    Rows rows("region." + name, region);
    rows.stated(scene::kTemperature);
    const Node* group = region.find("group");
    tables.push_back(
        std::move(rows).table("region " + (group != nullptr ? group->text : name), "a temperature that is given"));
  });
  if (const Node* ground = root.find("ground")) {
    Rows rows("ground", *ground);
    rows.stated(scene::kTemperature);
    tables.push_back(std::move(rows).table("ground", "beyond the meshes"));
  }
  std::erase_if(tables, [](const SceneTable& table) { return table.rows.empty(); });
  return tables;
}

Json scene_json(const std::string& text) {
  const cfg::Tree tree = cfg::read_tree(text);
  Json tables = Json::array();
  for (const SceneTable& table : scene_tables(tree.root)) {
    Json rows = Json::array();
    for (const SceneRow& row : table.rows) rows.push_back(row_json(row));
    tables.push_back({{"name", table.title}, {"doc", table.doc}, {"fixed", true}, {"rows", std::move(rows)}});
  }
  return {{"tables", std::move(tables)}};
}

std::string edited_scene(const std::string& start, const std::string& file, std::span<const Edit> edits) {
  std::string text = start;
  for (std::size_t i = 0; i < edits.size(); ++i) try {
      text = with_value(text, start, edits[i]);
      cfg::require_no_errors(scene::parse_scene(text, file).diagnostics, file);
    } catch (const UsageError& error) {
      throw RefusedEdit(error.what(), i, "scene");
    }
  return text;
}

}  // namespace apps::live
