// SPDX-License-Identifier: Apache-2.0
#include "apps/live/space/scene_rows.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "apps/live/model.h"
#include "apps/scene/scene_file/scene_file.h"
#include "apps/scene/weather/si_units.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"

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

/// One number. `node` and `table` are of the tree that it was made from.
struct SceneRow {
  std::string name;  ///< "material.engine_deck.inside.temperature"
  std::string key;   ///< "inside temperature"
  mtf::FieldInfo field;
  const Node* table = nullptr;  ///< that has the key
  const Node* node = nullptr;   ///< its value; null where the file does not state it
  std::string otherwise{};      ///< what counts then
};

struct SceneTable {
  std::string title;  ///< "weather", "material engine_deck"
  std::string doc;
  std::vector<SceneRow> rows;
};

/// The numbers of one table of the file, by the rows of its type.
class Rows {
 public:
  Rows(std::string owner, const Node& table) : owner_(std::move(owner)), table_(&table) {}

  template <class T>
  Rows& of() {
    const T prototype{};
    radiometry::for_each_field(prototype, [this](const FieldInfo& row, const auto& value) { add(row, value); });
    return *this;
  }
  /// A number that the file states; where it does not, `otherwise` counts, unless that is empty.
  void number(const FieldInfo& row, const std::string& otherwise = "") {
    const Node* node = table_->find(row.name);
    if (node == nullptr && otherwise.empty()) return;
    const std::string path = part_ + std::string(row.name);
    std::string key = path;
    std::replace(key.begin(), key.end(), '.', ' ');
    rows_.push_back({owner_ + "." + path, key, row, table_, cfg::number_of(node), otherwise});
  }
  SceneTable table(std::string title, std::string doc) && {
    return {std::move(title), std::move(doc), std::move(rows_)};
  }

 private:
  // Texts, words and points have no slider; what may be a number or the name of a file has one.
  template <class Other>
  void add(const FieldInfo&, const Other&) {}
  void add(const FieldInfo& row, double value) {
    number(row, row.presence == mtf::Presence::required ? ""
                : row.unit.empty()                      ? cfg::toml_number(value)
                                                        : mtf::with_unit(mtf::format_double(value), row.unit));
  }
  void add(const FieldInfo& row, const std::optional<double>&) { number(row); }
  void add(const FieldInfo& row, const radiometry::heat::Schedule&) { number(row); }
  void add(const FieldInfo& row, const std::optional<scene::GivenTemperature>&) { number(row); }
  void add(const FieldInfo& row, const scene::Emissivity&) { number(row); }
  void add(const FieldInfo& row, const std::optional<scene::Emissivity>&) { number(row); }
  void add(const FieldInfo& row, scene::CloudSource) {
    const Node* cloud = table_->find(row.name);
    if (cloud != nullptr && quantity_in(written(*cloud), row)) number(row);
  }
  void add(const FieldInfo& row, const scene::Inside&) { within<scene::Inside>(row.name, table_->find(row.name)); }
  void add(const FieldInfo& row, const scene::Convection&) {
    within<scene::Convection>(row.name, table_->find(row.name));
  }
  void add(const FieldInfo& row, const std::vector<scene::LayerSection>&) {
    const Node* layers = table_->find(row.name);
    for (std::size_t i = 0; layers != nullptr && i < layers->items.size(); ++i)
      within<scene::LayerSection>(std::string(row.name) + "[" + std::to_string(i) + "]", &layers->items[i]);
  }
  /// Of a table within this one, what the file states: "inside", "layers[0]".
  template <class T>
  void within(std::string_view part, const Node* table) {
    if (table == nullptr || table->kind != Node::Kind::table) return;
    const T prototype{};
    Rows rows(owner_, *table);
    rows.part_ = part_ + std::string(part) + ".";
    radiometry::for_each_field(prototype, [&](const FieldInfo& row, const auto& value) {
      if (table->find(row.name) != nullptr) rows.add(row, value);
    });
    rows_.insert(rows_.end(), rows.rows_.begin(), rows.rows_.end());
  }

  std::string owner_, part_{};
  const Node* table_;
  std::vector<SceneRow> rows_{};
};

/// Constant weather has the values that the file states, weather of a file what changes its records.
SceneTable weather_table(const Node& weather) {
  Rows rows("weather", weather);
  if (weather.find("file") != nullptr)
    return std::move(rows.of<scene::WeatherChange>())
        .table("weather", "changes of the weather that the scene's file names");
  for (const FieldInfo& row : scene::kConstants) rows.number(row);
  rows.number(scene::kHumidity);
  return std::move(rows).table("weather", "constant weather");
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

/// Tables without a number are left out.
std::vector<SceneTable> scene_tables(const Node& root) {
  std::vector<SceneTable> tables;
  if (const Node* weather = root.find("weather")) tables.push_back(weather_table(*weather));
  const auto add = [&]<class T>(T, const std::string& owner, const Node& node, const std::string& title,
                                const std::string& doc) {
    tables.push_back(std::move(Rows(owner, node).of<T>()).table(title, doc));
  };
  if (const Node* sky = root.find("sky")) add(scene::SkySection{}, "sky", *sky, "sky", "clouds");
  for_items(root, "material", [&](const Node& material, const std::string& name) {
    add(scene::MaterialSection{}, "material." + name, material, "material " + name,
        "what surfaces of this material are made of, from the outside inwards");
  });
  for_items(root, "region", [&](const Node& region, const std::string& name) {
    const Node* group = region.find("group");
    add(scene::RegionSection{}, "region." + name, region, "region " + (group != nullptr ? group->text : name),
        "a temperature that is given");
  });
  if (const Node* ground = root.find("ground"))
    add(scene::GroundSection{}, "ground", *ground, "ground", "beyond the meshes");
  std::erase_if(tables, [](const SceneTable& table) { return table.rows.empty(); });
  return tables;
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
  FieldInfo row = field;
  if (field.unit == "K") row.dimension = mtf::Dimension::temperature;
  return slider_range(row, number, lo, hi);
}

Json row_json(const SceneRow& row) {
  const FieldInfo& field = row.field;
  const std::string text = row.node != nullptr ? written(*row.node) : row.otherwise, example = example_of(field);
  Json json = row_head(field, row.name, row.key, row.node != nullptr, text);
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

Json scene_json(const std::string& text) {
  const cfg::Tree tree = cfg::read_tree(text);
  Json tables = Json::array();
  for (const SceneTable& table : scene_tables(tree.root))
    tables.push_back(
        {{"name", table.title}, {"doc", table.doc}, {"fixed", true}, {"rows", Json::array(table.rows, row_json)}});
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
