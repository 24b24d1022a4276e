// SPDX-License-Identifier: Apache-2.0
#include "apps/live/edits.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "apps/live/model.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/text/message_words.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/replace_value.h"
#include "mtf/units.h"

namespace apps::live {
namespace {

namespace cfg = mtf::io::cfg;
using mtf::UsageError;
using mtf::io::SensorConfig;

constexpr std::size_t kMostEdits = 1000, kLongestName = 200, kLongestValue = 2000;
constexpr std::array<std::string_view, 6> kKindNames{"set", "unset", "remove", "off", "on", "add"};

const Parameter* find_parameter(const std::vector<Parameter>& parameters, std::string_view key) {
  const auto stem = cfg::pair_of_axis(key);
  for (const Parameter& parameter : parameters)
    if (parameter.name == key || (stem && parameter.type == mtf::FieldType::size && parameter.name == *stem))
      return &parameter;
  return nullptr;
}

/// The row of the field table that a parameter of the sensor has; null where it has none.
const Parameter* row_of(const SensorConfig& sensor, const cfg::Target& target, const SensorKinds& kinds) {
  if (target.component) {
    for (const mtf::Stage stage : mtf::kStages) {
      if (stage_name(stage) != target.table || target.index >= sensor.system.list(stage).size()) continue;
      const std::string_view kind = sensor.system.list(stage)[target.index].component.kind();
      for (const ComponentKind& each : kinds.components)
        if (each.kind == kind) return find_parameter(each.parameters, target.key);
    }
    return nullptr;
  }
  // Of tables with several sets of rows the last one that has the key: they differ in units, not in what is a file.
  for (const auto* tables : {&kinds.tables, &kinds.own_tables})
    for (const TableKind& table : *tables)
      if (table.name == target.table)
        if (const Parameter* found = find_parameter(table.parameters, target.key)) return found;
  return nullptr;
}

bool is_number(const Parameter& parameter, const std::string& value) {
  const cfg::Node node = cfg::node_of(value, 0);
  if (parameter.dimension == mtf::Dimension::none) return node.is_number();
  try {
    static_cast<void>(mtf::parse_quantity(value, parameter.dimension));
    return true;
  } catch (const UsageError&) {
    return false;
  }
}

/// Terms of a number over the field that name a table.
bool names_table(const cfg::Node& node) {
  return std::ranges::any_of(node.members,
                             [](const cfg::Member& m) { return m.key == cfg::kTableKey || names_table(m.value); }) ||
         std::ranges::any_of(node.items, names_table);
}

/// A text in such a place would be opened as a file.
void require_no_file(const Parameter& parameter, const Edit& edit) {
  const bool encoding = parameter.name == "encoding" && edit.name.starts_with("scene.");
  if (parameter.type == mtf::FieldType::file)
    throw UsageError(edit.name + ": names a file, which the live view does not change; edit the sensor file");
  if (parameter.type == mtf::FieldType::number_or_file && !is_number(parameter, edit.value))
    throw UsageError(edit.name + ": \"" + edit.value +
                     "\" is no number here; files are named in the sensor file alone");
  if (edit.value.starts_with('{') || edit.value.starts_with('['))
    if (const cfg::Tree tree = cfg::read_tree("value = " + edit.value); tree.error || names_table(tree.root))
      throw UsageError(edit.name + ": names a file, which the live view does not change; edit the sensor file");
  if (encoding && edit.value != "linear" && edit.value != "srgb" && !edit.value.starts_with("gamma"))
    throw UsageError(edit.name + ": linear, srgb or gamma; files are named in the sensor file alone");
}

SensorConfig parsed(const SensorConfig& before, const std::string& text) {
  mtf::io::ConfigResult result = mtf::io::parse_config(text, before.file, before.schema);
  cfg::require_no_errors(result.diagnostics, before.file);
  return std::move(result.config);
}

/// The row of a key that schedules do not reach, such as one of [scene] or a first key of the chain in [optics];
/// "frame.format[0]" is one of the two numbers of a pair. Null where there is none.
const Parameter* row_of_table(const std::string& name, const SensorKinds& kinds) {
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos) return nullptr;
  const bool element = name.ends_with("[0]") || name.ends_with("[1]");
  const std::string key = name.substr(dot + 1, element ? name.size() - dot - 4 : std::string::npos);
  for (const auto* tables : {&kinds.tables, &kinds.own_tables})
    for (const TableKind& table : *tables)
      if (table.name == name.substr(0, dot))
        if (const Parameter* row = find_parameter(table.parameters, key))
          return element && row->type != mtf::FieldType::pair ? nullptr : row;
  return nullptr;
}

/// Its row of the field tables; refuses a name that has none.
const Parameter& row_named(const SensorConfig& sensor, const std::string& name, const SensorKinds& kinds) {
  const cfg::Targets targets = cfg::targets_of(sensor);
  const auto target = cfg::find_target(targets, name);
  const Parameter* row = target ? row_of(sensor, *target, kinds) : row_of_table(name, kinds);
  if (row != nullptr) return *row;
  throw UsageError(target ? name + ": is not changed by the live view" : cfg::unknown_parameter(targets, name));
}

SensorConfig set(const SensorConfig& sensor, const Edit& edit, const SensorKinds& kinds) {
  const Parameter& row = row_named(sensor, edit.name, kinds);
  require_no_file(row, edit);
  try {
    return mtf::io::replaced(sensor, edit.name, edit.value);
  } catch (const UsageError&) {
    if (!mtf::io::stated_value(sensor, edit.name).empty()) throw;
    const std::string owner = edit.name.substr(0, edit.name.rfind('.') + 1);
    for (const std::string_view other : mtf::words_in(row.excludes)) try {
        SensorConfig without = sensor;
        without.text = mtf::io::without_value(sensor, owner + std::string(other));
        return parsed(sensor, mtf::io::replace_value(without, edit.name, edit.value));
      } catch (const UsageError&) {  // that one does not exclude it
      }
    throw;
  }
}

SensorConfig unset(const SensorConfig& sensor, const Edit& edit, const SensorKinds& kinds) {
  static_cast<void>(row_named(sensor, edit.name, kinds));
  return parsed(sensor, mtf::io::without_value(sensor, edit.name));
}

/// The piece of text that a name stands for: "[noise]", or the label of a component.
TomlBlock block_of(const SensorConfig& sensor, const std::string& name) {
  std::string header = name;
  std::size_t index = 0;
  bool list = false;
  if (name.starts_with('[') && name.ends_with(']')) {
    header = name.substr(1, name.size() - 2);
  } else {
    for (const mtf::Stage stage : mtf::kStages)
      for (std::size_t i = 0; i < sensor.system.list(stage).size(); ++i)
        if (sensor.system.list(stage)[i].label == name) {
          header = stage_name(stage);
          index = i;
          list = true;
        }
    if (!list) throw UsageError("the sensor has no component " + one_line(name));
  }
  for (const TomlBlock& block : toml_blocks(sensor.text))
    if (!block.off && block.header == header && block.list == list && block.index == index) return block;
  throw UsageError(one_line(name) + ": does not stand in the file as a table with a header of its own");
}

TomlBlock off_block(const SensorConfig& sensor, const std::string& number) {
  std::size_t at = 0;
  for (const TomlBlock& block : toml_blocks(sensor.text))
    if (block.off && std::to_string(at++) == number) return block;
  throw UsageError("no table is switched off under number " + one_line(number));
}

SensorConfig add_component(const SensorConfig& sensor, const Edit& edit, const SensorKinds& kinds) {
  for (const ComponentKind& kind : kinds.components) {
    if (kind.kind != edit.value) continue;
    for (const Parameter& parameter : kind.parameters)
      if (parameter.type == mtf::FieldType::file && parameter.presence == mtf::Presence::required)
        throw UsageError(edit.value +
                         " needs a file, which the live view does not name; write it into the sensor file");
    for (const mtf::Stage stage : mtf::kStages)
      if (stage_name(stage) == edit.name && kind.stages.allows(stage))
        return parsed(sensor,
                      with_block(sensor.text, "[[" + edit.name + "]]" + kind.example.substr(kind.example.find('\n'))));
    throw UsageError(edit.value + " does not stand in [[" + one_line(edit.name) + "]]");
  }
  throw UsageError("there is no kind " + one_line(edit.value));
}

/// The table with the keys it needs and the examples of all others that go together, file names left out.
SensorConfig add_table(const SensorConfig& sensor, const std::string& name, const SensorKinds& kinds) {
  if (mtf::find_table(sensor.tables, name) != nullptr) throw UsageError("[" + one_line(name) + "] is there already");
  std::string problem = "there is no table [" + one_line(name) + "]";
  const cfg::Tree tree = cfg::read_tree(sensor.text);
  for (const TableKind& table : kinds.tables) {
    if (table.name != name || !holds(table, tree.root)) continue;
    std::string block = "[" + name + "]\n";
    for (const Parameter& parameter : table.parameters)
      if (parameter.presence == mtf::Presence::required)
        block += std::string(parameter.name) + " = " + std::string(parameter.example) + "\n";
    const auto attempt = [&](const std::string& lines) -> std::optional<SensorConfig> {
      try {
        SensorConfig made = parsed(sensor, with_block(sensor.text, lines));
        if (const auto refused = chain_problem(made)) throw UsageError(refused->text);
        return made;
      } catch (const mtf::Error& error) {
        problem = error.what();
        return std::nullopt;
      }
    };
    std::optional<SensorConfig> best = attempt(block);
    for (const Parameter& parameter : table.parameters) {
      if (parameter.presence == mtf::Presence::required || parameter.example.empty()) continue;
      if (parameter.type == mtf::FieldType::file || parameter.type == mtf::FieldType::text) continue;
      const std::string longer = block + std::string(parameter.name) + " = " + std::string(parameter.example) + "\n";
      if (auto made = attempt(longer)) {
        best = std::move(made);
        block = longer;
      }
    }
    if (best) return std::move(*best);
  }
  throw UsageError(problem);
}

/// One edit. `kinds`: sensor_kinds(). Of keys that exclude each other (FieldInfo::excludes) a new one takes the place
/// of the other: an aperture that of an f-number.
SensorConfig with_edit(const SensorConfig& sensor, const Edit& edit, const SensorKinds& kinds) {
  switch (edit.kind) {
    case Edit::Kind::set:
      return set(sensor, edit, kinds);
    case Edit::Kind::unset:
      return unset(sensor, edit, kinds);
    case Edit::Kind::remove:
      return parsed(sensor, without_block(sensor.text, block_of(sensor, edit.name)));
    case Edit::Kind::off:
      return parsed(sensor, switched_off(sensor.text, block_of(sensor, edit.name)));
    case Edit::Kind::on:
      return parsed(sensor, switched_on(sensor.text, off_block(sensor, edit.name)));
    case Edit::Kind::add:
      return edit.name == "table" ? add_table(sensor, edit.value, kinds) : add_component(sensor, edit, kinds);
  }
  return sensor;
}

constexpr std::string_view kOff = "#- ";

struct Line {
  std::size_t begin = 0, end = 0;  ///< with its line break
};

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    lines.push_back({begin, end});
    begin = end;
  }
  return lines;
}

std::string_view trimmed(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r\n") - first + 1);
}

/// The name of "[name]" or "[[name]]", maybe with a comment behind it; "" for other lines.
std::pair<std::string, bool> header_of(std::string_view line) {
  line = trimmed(line);
  const bool list = line.starts_with("[[");
  if (!line.starts_with("[")) return {};
  const std::size_t open = list ? 2 : 1, close = line.find(list ? "]]" : "]", open);
  if (close == std::string_view::npos) return {};
  const std::string_view after = trimmed(line.substr(close + open));
  if (!after.empty() && !after.starts_with("#")) return {};
  return {std::string(trimmed(line.substr(open, close - open))), list};
}

/// Whether a line begins or ends a string of several lines: an odd number of its marks.
bool toggles(std::string_view line, std::string_view mark) {
  bool odd = false;
  for (std::size_t at = line.find(mark); at != std::string_view::npos; at = line.find(mark, at + 3)) odd = !odd;
  return odd;
}

}  // namespace

std::vector<Edit> read_edits(const Json& list) {
  const auto fail = [](const char* what) { return UsageError(std::string("edits: ") + what); };
  if (!list.is_array()) throw fail("a list belongs here");
  if (list.size() > kMostEdits) throw fail("more than 1000; save the sensor file and start from it");
  std::vector<Edit> edits;
  for (const Json& item : list.elements()) {
    const bool words = item.is_array() && item.size() >= 2 && item.size() <= 3 &&
                       std::ranges::all_of(item.elements(), [](const Json& word) { return word.is_string(); });
    if (!words) throw fail("each is a list of two or three texts");
    const auto kind = std::find(kKindNames.begin(), kKindNames.end(), item[0].get<std::string>());
    if (kind == kKindNames.end()) throw fail("set, unset, remove, off, on or add");
    Edit edit{.kind = static_cast<Edit::Kind>(kind - kKindNames.begin()), .name = item[1].get<std::string>()};
    if (item.size() == 3) edit.value = item[2].get<std::string>();
    if (edit.name.size() > kLongestName || edit.value.size() > kLongestValue) throw fail("a name or value is too long");
    const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
    if (std::ranges::any_of(edit.name, control) || std::any_of(edit.value.begin(), edit.value.end(), control))
      throw fail("control characters");
    edits.push_back(std::move(edit));
  }
  return edits;
}

EditedSensor::Sensor EditedSensor::with(std::span<const Edit> edits) {
  std::size_t same = 0;
  while (same < edits.size() && same < edits_.size() && edits[same] == edits_[same]) ++same;
  edits_.resize(same);
  after_.resize(same);
  for (; same < edits.size(); ++same) {
    const Sensor& before = same == 0 ? start_ : after_.back();
    try {
      after_.push_back(std::make_shared<const SensorConfig>(with_edit(*before, edits[same], kinds_)));
    } catch (const UsageError& error) {
      throw RefusedEdit(error.what(), same, "edits");
    }
    edits_.push_back(edits[same]);
  }
  return after_.empty() ? start_ : after_.back();
}

std::vector<TomlBlock> toml_blocks(std::string_view text) {
  std::vector<TomlBlock> blocks;
  std::map<std::pair<std::string, bool>, std::size_t> count;
  const std::vector<Line> lines = lines_of(text);
  bool in_string = false, in_literal = false, off_before = false;
  std::size_t last_content = 0;  // end of the last line that is part of the block at work
  const auto close = [&] {
    if (!blocks.empty() && blocks.back().end == 0) blocks.back().end = last_content;
  };
  for (const Line& at : lines) {
    const std::string_view line = text.substr(at.begin, at.end - at.begin), bare = trimmed(line);
    if (!in_string && !in_literal) {
      const bool off = bare.starts_with(kOff) || bare == trimmed(kOff);  // of a line that was empty
      const auto [name, list] = header_of(bare.starts_with(kOff) ? bare.substr(kOff.size()) : bare);
      // A comment of "#- " lines ends where they end.
      if (!name.empty() || (off_before && !off)) close();
      if (!name.empty()) {
        blocks.push_back({name, list, off, count[{name, off}]++, at.begin, 0});
        last_content = at.end;
      } else if (!bare.empty() && (off || !bare.starts_with("#"))) {
        last_content = at.end;
      }
      off_before = off;
    } else {
      last_content = at.end;
    }
    if (!in_literal && (in_string || !bare.starts_with("#"))) in_string ^= toggles(line, "\"\"\"");
    if (!in_string && (in_literal || !bare.starts_with("#"))) in_literal ^= toggles(line, "'''");
  }
  close();
  return blocks;
}

std::string without_block(std::string_view text, const TomlBlock& block) {
  return std::string(text.substr(0, block.begin)) + std::string(text.substr(block.end));
}

std::string switched_off(std::string_view text, const TomlBlock& block) {
  std::string lines;
  const std::string_view body = text.substr(block.begin, block.end - block.begin);
  for (const Line& line : lines_of(body))
    lines += std::string(kOff) + std::string(body.substr(line.begin, line.end - line.begin));
  return std::string(text.substr(0, block.begin)) + lines + std::string(text.substr(block.end));
}

std::string text_of_off(std::string_view text, const TomlBlock& block) {
  std::string lines;
  const std::string_view body = text.substr(block.begin, block.end - block.begin);
  for (const Line& at : lines_of(body)) {
    const std::string_view line = body.substr(at.begin, at.end - at.begin);
    const std::size_t mark = line.find(kOff);
    lines += mark == std::string_view::npos ? std::string(line) : std::string(line.substr(mark + kOff.size()));
  }
  return lines;
}

std::string switched_on(std::string_view text, const TomlBlock& block) {
  return std::string(text.substr(0, block.begin)) + text_of_off(text, block) + std::string(text.substr(block.end));
}

std::string with_block(std::string_view text, std::string_view block) {
  return std::string(text) + (text.empty() || text.ends_with('\n') ? "" : "\n") + "\n" + std::string(block);
}

}  // namespace apps::live
