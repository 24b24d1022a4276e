// SPDX-License-Identifier: Apache-2.0
#include "apps/live/model.h"

#include <algorithm>
#include <cmath>

#include "apps/live/edits.h"
#include "mtf/components/component_docs.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/units.h"

namespace apps::live {
namespace {

namespace cfg = mtf::io::cfg;
using Type = mtf::FieldType;

constexpr double kAround = 30.0;  ///< a logarithmic slider reaches so far to both sides of its value

bool is_numeric(Type type) {
  return type == Type::number || type == Type::size || type == Type::frequency || type == Type::whole ||
         type == Type::number_or_file;
}

/// The number of a fit table or of terms over the field, else the node itself.
const cfg::Node* value_node(const cfg::Node* table, std::string_view key) {
  return cfg::number_of(table != nullptr ? table->find(key) : nullptr);
}

struct Number {
  double value = 0.0;
  std::string unit;
};

std::optional<Number> number_in(const std::string& text, mtf::Dimension dimension) {
  try {
    if (dimension != mtf::Dimension::none) {
      const mtf::Quantity quantity = mtf::parse_quantity(text, dimension);
      return Number{quantity.value, std::string(quantity.unit->name)};
    }
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    return used == text.size() && std::isfinite(value) ? std::optional(Number{value, ""}) : std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::string unquoted(std::string_view example) {
  return std::string(example.starts_with('"') && example.size() > 1 ? example.substr(1, example.size() - 2) : example);
}

/// A bound of the row in the unit that the value is written in.
double bound_in(double bound, const Parameter& parameter, const std::string& unit) {
  const mtf::Unit* held = mtf::find_unit(parameter.unit);
  const mtf::Unit* wanted = mtf::find_unit(unit);
  if (held == nullptr || wanted == nullptr || held->dimension != wanted->dimension || !std::isfinite(bound))
    return bound;
  return mtf::convert({bound, held}, wanted->name);
}

/// `node`: what the file has there, null for nothing.
Json row_json(const Parameter& parameter, const std::string& owner, const std::string& key, const cfg::Node* node) {
  const std::string example = unquoted(parameter.example);
  const std::string text = node != nullptr ? written(*node) : unquoted(parameter.default_value);
  Json row = row_head(parameter, owner + "." + key, key, node != nullptr, text);
  row["control"] = "text";
  if (parameter.type == Type::flag) row["control"] = "flag";
  if (parameter.type == Type::file ||
      (parameter.type == Type::number_or_file && node != nullptr && !number_in(text, parameter.dimension)))
    row["control"] = "file";
  if (parameter.type == Type::word) {
    row["control"] = "word";
    row["words"] = parameter.words;
  }
  if (!is_numeric(parameter.type) || row["control"].get<std::string>() == "file") return row;
  // Without a value the slider begins at the example, which shows what is usual.
  const auto number = number_in(text.empty() ? example : text, parameter.dimension);
  if (!number) return row;
  const double lo = has_range(parameter) ? bound_in(parameter.lo, parameter, number->unit) : -HUGE_VAL;
  const double hi = has_range(parameter) ? bound_in(parameter.hi, parameter, number->unit) : HUGE_VAL;
  const SliderRange range = slider_range(parameter, number->value, lo, hi);
  add_number(row, number->value, number->unit, lo, hi, range);
  row["units"] = mtf::units_of(parameter.dimension);
  row["whole"] = parameter.type == Type::whole;
  return row;
}

/// A number that changes over the field, a row for each of its terms: in its unit, of either sign, without bounds.
void add_terms(Json& rows, const Parameter& parameter, const std::string& owner, const std::string& key,
               const cfg::Node& terms) {
  Parameter term = parameter;
  term.lo = -HUGE_VAL;
  term.hi = HUGE_VAL;
  term.lo_open = term.hi_open = false;
  for (const cfg::Member& member : terms.members) {
    if (!cfg::is_field_term(member.key)) continue;  // a table, which is a file
    Json row = row_json(term, owner, key + "." + member.key, cfg::number_of(&member.value));
    if (row.contains("number")) {
      const double size = std::abs(row["number"].get<double>()), reach = size > 0.0 ? 4.0 * size : 1.0;
      row["low"] = -reach;
      row["high"] = reach;
      row["log"] = false;
    }
    rows.push_back(std::move(row));
  }
}

/// One of the two numbers of a pair.
Parameter element_of(Parameter pair) {
  pair.type = pair.dimension == mtf::Dimension::none ? Type::whole : Type::number;
  return pair;
}

Json rows_json(const std::vector<Parameter>& parameters, const std::string& owner, const cfg::Node* table) {
  Json rows = Json::array();
  for (const Parameter& parameter : parameters) {
    const std::string name(parameter.name);
    const cfg::Node* node = value_node(table, name);
    const bool split = parameter.type == Type::size && table != nullptr && table->find(name + "_x") != nullptr;
    const auto add = [&](const std::string& key) {
      const cfg::Node* whole = table != nullptr ? table->find(key) : nullptr;
      if (whole != nullptr && whole->kind == cfg::Node::Kind::table && cfg::is_over_field(*whole, parameter))
        add_terms(rows, parameter, owner, key, *whole);
      else
        rows.push_back(row_json(parameter, owner, key, value_node(table, key)));
    };
    if (split)
      for (const char* axis : {"_x", "_y"}) add(name + axis);
    else if (parameter.type == Type::pair && node != nullptr && node->items.size() == 2)
      for (const std::size_t i : {0U, 1U})
        rows.push_back(row_json(element_of(parameter), owner, name + "[" + std::to_string(i) + "]", &node->items[i]));
    else
      add(name);
  }
  return rows;
}

const cfg::Node* component_node(const cfg::Node& root, mtf::Stage stage, std::size_t index) {
  const cfg::Node* list = root.find(stage_name(stage));
  return list != nullptr && index < list->items.size() ? &list->items[index] : nullptr;
}

Json components_json(const mtf::io::SensorConfig& sensor, const cfg::Node& root, const SensorKinds& kinds) {
  Json components = Json::array();
  for (const mtf::Stage stage : mtf::kStages)
    for (std::size_t i = 0; i < sensor.system.list(stage).size(); ++i) {
      const auto& entry = sensor.system.list(stage)[i];
      const auto kind = std::find_if(kinds.components.begin(), kinds.components.end(),
                                     [&](const ComponentKind& k) { return k.kind == entry.component.kind(); });
      components.push_back({{"label", entry.label},
                            {"kind", entry.component.kind()},
                            {"list", std::string(stage_name(stage))},
                            {"doc", entry.component.doc()},
                            {"rows", rows_json(kind->parameters, entry.label, component_node(root, stage, i))}});
    }
  return components;
}

/// The rows of the tables that are in the file. A table that several sets of rows describe has those of which the
/// reader took its values.
Json tables_json(const cfg::Node& root, const SensorKinds& kinds) {
  Json tables = Json::array();
  std::vector<std::string_view> names;
  for (const auto* list : {&kinds.own_tables, &kinds.tables})
    for (const TableKind& table : *list)
      if (std::find(names.begin(), names.end(), table.name) == names.end()) names.push_back(table.name);
  for (const std::string_view name : names) {
    const cfg::Node* node = root.find(name);
    if (node == nullptr) continue;
    const TableKind* chain = nullptr;
    std::string_view doc;
    std::vector<Parameter> rows;
    for (const TableKind& own : kinds.own_tables)
      if (own.name == name) {
        rows = own.parameters;
        doc = own.doc;
      }
    const bool fixed = !doc.empty();
    for (const TableKind& table : kinds.tables)
      if (table.name == name && (table.condition.empty() ? chain == nullptr : holds(table, root))) chain = &table;
    if (chain != nullptr) {
      rows.insert(rows.end(), chain->parameters.begin(), chain->parameters.end());
      if (doc.empty()) doc = chain->doc;
    }
    // Samples, quantity and border are those of the scene that is shown.
    if (name == "scene") std::erase_if(rows, [](const Parameter& p) { return p.type == Type::file; });
    tables.push_back({{"name", std::string(name)},
                      {"doc", doc},
                      {"fixed", fixed || name == "detector"},
                      {"rows", rows_json(rows, std::string(name), node)}});
  }
  return tables;
}

Json off_json(std::string_view text) {
  Json off = Json::array();
  for (const TomlBlock& block : toml_blocks(text)) {
    if (!block.off) continue;
    const cfg::Tree tree = cfg::read_tree(text_of_off(text, block));
    const cfg::Node* list = tree.error ? nullptr : tree.root.find(block.header);
    std::string title = "[" + block.header + "]";
    if (list != nullptr && block.list && !list->items.empty()) {
      const cfg::Node* label = list->items.front().find("label");
      const cfg::Node* kind = list->items.front().find("kind");
      if (label != nullptr || kind != nullptr) title = (label != nullptr ? label : kind)->text;
    }
    off.push_back({{"number", std::to_string(off.size())}, {"title", title}, {"table", block.header}});
  }
  return off;
}

Json addable_json(const cfg::Node& root, const SensorKinds& kinds) {
  Json lists = Json::object();
  for (const mtf::Stage stage : mtf::kStages) {
    Json names = Json::array();
    for (const ComponentKind& kind : kinds.components) {
      const bool file = std::any_of(kind.parameters.begin(), kind.parameters.end(), [](const Parameter& p) {
        return p.type == Type::file && p.presence == mtf::Presence::required;
      });
      if (kind.stages.allows(stage) && !file) names.push_back({kind.kind, kind.doc});
    }
    lists[std::string(stage_name(stage))] = std::move(names);
  }
  Json tables = Json::array();
  std::vector<std::string_view> seen;
  for (const TableKind& table : kinds.tables) {
    if (root.find(table.name) != nullptr || std::find(seen.begin(), seen.end(), table.name) != seen.end()) continue;
    seen.push_back(table.name);
    tables.push_back({table.name, table.doc});
  }
  lists["table"] = std::move(tables);
  return lists;
}

}  // namespace

bool holds(const TableKind& table, const mtf::io::cfg::Node& root) {
  const std::string_view text = table.condition;
  if (text.empty()) return true;
  // "[detector] kind = \"thermal\""
  const std::size_t close = text.find(']'), equals = text.find(" = "), quote = text.find('"');
  const cfg::Node* section = root.find(text.substr(1, close - 1));
  const cfg::Node* word = section != nullptr ? section->find(text.substr(close + 2, equals - close - 2)) : nullptr;
  return word != nullptr && word->text == text.substr(quote + 1, text.rfind('"') - quote - 1);
}

SliderRange slider_range(const mtf::FieldInfo& parameter, double value, double lo, double hi) {
  constexpr double kShort = 50.0;  // a range that one linear slider resolves
  SliderRange range;
  const bool bounded = std::isfinite(lo) && std::isfinite(hi);
  if (bounded && hi - lo <= kShort && !(lo > 0.0 && hi > kShort * lo)) {
    range = {lo, hi, false};
  } else if (parameter.dimension == mtf::Dimension::temperature) {
    // Of optics, stops and scenes: by tens of kelvin, about what it is.
    constexpr double kReach_k = 60.0;
    range = {std::max(lo, value - kReach_k), std::min(hi, value + kReach_k), false};
  } else if (value > 0.0 && (wants_log_scale(parameter) || !has_range(parameter))) {
    range = {std::max(lo, value / kAround), std::min(hi, value * kAround), true};
  } else {
    const double reach = value != 0.0 ? 4.0 * std::abs(value) : 10.0;
    range = {std::max(lo, value - reach), std::min(hi, value + reach), false};
  }
  if (parameter.type == mtf::FieldType::whole) {
    range.low = std::max(lo, std::floor(std::min(range.low, value)));
    range.high = std::min(hi, std::ceil(std::max(range.high, value + 8.0)));
    range.log = false;
  }
  // An end that is not allowed itself is approached to a thousandth of the way.
  const double step = 1e-3 * (range.high - range.low);
  if (parameter.lo_open && range.low <= lo) range.low = range.log ? range.low * 1.001 : range.low + step;
  if (parameter.hi_open && range.high >= hi) range.high -= step;
  return range;
}

std::string written(const cfg::Node& node) {
  return node.kind == cfg::Node::Kind::string ? node.text : cfg::shown(node);
}

Json row_head(const mtf::FieldInfo& row, const std::string& name, const std::string& key, bool given,
              const std::string& text) {
  return {{"name", name},
          {"key", key},
          {"given", given},
          {"doc", row.doc},
          {"text", text},
          {"example", unquoted(row.example)},
          {"presence", presence_name(row.presence)}};
}

void add_number(Json& row, double number, const std::string& unit, double lo, double hi, const SliderRange& range) {
  row["control"] = "number";
  row["number"] = number;
  row["unit"] = unit;
  row["min"] = lo;
  row["max"] = hi;
  row["low"] = range.low;
  row["high"] = range.high;
  row["log"] = range.log;
}

Json model_json(const mtf::io::SensorConfig& sensor, const SensorKinds& kinds) {
  const cfg::Tree tree = cfg::read_tree(sensor.text);
  return {{"name", sensor.system.name},
          {"components", components_json(sensor, tree.root, kinds)},
          {"tables", tables_json(tree.root, kinds)},
          {"off", off_json(sensor.text)},
          {"addable", addable_json(tree.root, kinds)}};
}

}  // namespace apps::live
