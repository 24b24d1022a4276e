// SPDX-License-Identifier: Apache-2.0

// Tables of the file that other libraries own (mtf/settings.h): read by their rows, kept as values.

#include <algorithm>

#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"

namespace mtf::io::cfg {
namespace {

bool is_own(std::string_view table) { return std::find(kTopKeys.begin(), kTopKeys.end(), table) != kTopKeys.end(); }

/// Path of a file: its contents are checked by the library that reads it.
std::optional<SettingValue> read_file(const Section& section, std::string_view key) {
  const auto name = read_string(section, key);
  if (!name) return std::nullopt;
  if (!name->empty() && name->find('\0') == std::string::npos) return section.reader.file(*name);
  section.error(key, "no file name");
  return std::nullopt;
}

std::optional<SettingValue> read_flag(const Section& section, std::string_view key) {
  const Node& node = *section.find(key);
  section.reader.positions[section.at(key)] = node.position;
  if (node.kind == Node::Kind::boolean) return node.boolean;
  section.error(key, std::string(kind_word(node.kind)) + " where true or false belongs");
  return std::nullopt;
}

/// A number, also out of a fit table whose `fit` is false: only the OTF is fitted.
std::optional<SettingValue> read_bounded(const Section& section, const FieldInfo& info) {
  const Node& node = *section.find(info.name);
  if (node.kind != Node::Kind::table) {
    const auto value = read_number(section, info, info.name);
    return value ? std::optional<SettingValue>(*value) : std::nullopt;
  }
  const auto scalar = read_scalar(section, info, info.name);
  if (is_over_field(node, info)) {
    refuse_over_field(section.reader);
    return std::nullopt;
  }
  if (!scalar) return std::nullopt;
  const FitSpec& spec = section.reader.fits.back();
  if (spec.path == section.at(info.name) && spec.fit) {
    section.error(info.name, "cannot be fitted: it is no part of the OTF; remove fit = true");
    return std::nullopt;
  }
  if (in_range(info, scalar->value)) return scalar->value;
  section.error(info.name, outside_text(info, scalar->value, info.unit));
  return std::nullopt;
}

template <class T>
std::optional<SettingValue> as_value(const std::optional<T>& value) {
  return value ? std::optional<SettingValue>(*value) : std::nullopt;
}

std::optional<SettingValue> read_setting(const Section& section, const FieldInfo& info) {
  const Node* node = section.find(info.name);
  if (node == nullptr) return std::nullopt;
  const auto is = [&](FieldType type) { return info.type == type; };
  if (is(FieldType::number)) return read_bounded(section, info);
  if (is(FieldType::whole)) return as_value(read_whole(section, info));
  if (is(FieldType::flag)) return read_flag(section, info.name);
  if (is(FieldType::word)) return as_value(read_word(section, info.name, info.words));
  if (is(FieldType::file)) return read_file(section, info.name);
  if (!is(FieldType::number_or_file)) return as_value(read_string(section, info.name));
  // A text that is no number of this unit is the name of a file.
  if (node->kind != Node::Kind::string) return read_bounded(section, info);
  if (info.dimension == Dimension::none) return read_file(section, info.name);
  try {
    static_cast<void>(parse_quantity(node->text, info.dimension));
  } catch (const UsageError&) {
    return read_file(section, info.name);
  }
  return read_bounded(section, info);
}

SettingsTable read_table(const Section& section, const TableInfo& info) {
  SettingsTable table{info.name, {}};
  for (const FieldInfo& row : info.settings) {
    if (auto value = read_setting(section, row))
      table.settings.push_back({row.name, *std::move(value)});
    else if (row.presence == Presence::required && !section.reader.has_failed(section.at(row.name)))
      section.error(row.name, missing_text(row));
  }
  return table;
}

}  // namespace

const std::vector<TableInfo>& own_tables() {
  static const std::vector<TableInfo> tables{
      {.name = "frame", .doc = "the focal plane", .settings = {kFocalLength, kPitch, kFormat, kIntegrationTime}},
      {.name = "scene",
       .doc = "what a scene file does not say itself",
       .settings = {kSample, kIfov, kGsd, kRange, kQuantity, kGain, kOffset, kEncoding, kBorder, kBorderValue,
                    kAperture, kApertureSize, kApertureFile, kApertureGainLimit}},
      {.name = "optics",
       .doc = "shared by every component that has the key and does not give it",
       .settings = {kFNumber, kApertureDiameter, kObscuration, kWavelength}},
      {.name = "band", .doc = "the spectral band", .settings = {kBand}}};
  return tables;
}

const std::vector<FieldInfo>& own_rows(std::string_view table) {
  return std::find_if(own_tables().begin(), own_tables().end(), [&](const TableInfo& t) { return t.name == table; })
      ->settings;
}

std::vector<std::string> keys_of(const FieldInfo& row) {
  const std::string name(row.name);
  return row.type == FieldType::size ? std::vector{name, name + "_x", name + "_y"} : std::vector{name};
}

std::vector<TableInfo> schema_of(const Node& root, std::vector<TableInfo> schema) {
  const auto holds = [&](const GivenWord& given) {
    const Node* table = root.find(given.table);
    const Node* word = table != nullptr && table->kind == Node::Kind::table ? table->find(given.key) : nullptr;
    return word != nullptr && word->kind == Node::Kind::string && word->text == given.word;
  };
  std::erase_if(schema, [&](const TableInfo& info) { return info.where && !holds(*info.where); });
  std::vector<std::string_view> special;
  for (const TableInfo& info : schema)
    if (info.where) special.push_back(info.name);
  std::erase_if(schema, [&](const TableInfo& info) {
    return !info.where && std::find(special.begin(), special.end(), info.name) != special.end();
  });
  return schema;
}

std::vector<std::string_view> known_tables(std::span<const TableInfo> schema) {
  std::vector<std::string_view> known(kTopKeys.begin(), kTopKeys.end());
  for (const TableInfo& table : schema)
    if (!is_own(table.name)) known.push_back(table.name);
  return known;
}

std::vector<std::string> known_keys(std::span<const TableInfo> schema, std::string_view table) {
  std::vector<std::string> known;
  for (const std::span<const TableInfo> tables : {std::span<const TableInfo>(own_tables()), schema})
    for (const TableInfo& info : tables)
      if (info.name == table)
        for (const FieldInfo& row : info.settings)
          for (std::string& key : keys_of(row)) known.push_back(std::move(key));
  return known;
}

std::vector<SettingsTable> read_settings(const Section& root) {
  std::vector<SettingsTable> tables;
  for (const TableInfo& info : root.reader.schema) {
    const bool own = is_own(info.name);
    // The keys of a table of the system were checked with it, and whether it is a table at all.
    if (own && (root.find(info.name) == nullptr || root.find(info.name)->kind != Node::Kind::table)) continue;
    const Node* node = own ? root.find(info.name) : find_table(root, info.name);
    if (node == nullptr) continue;
    const std::string name(info.name);
    const Section section{root.reader, *node, name, "[" + name + "]"};
    if (!own) {
      std::vector<std::string> known = known_keys(root.reader.schema, info.name);
      for (const AbsentKey& absent : info.absent) {
        if (section.find(absent.name) == nullptr) continue;
        known.emplace_back(absent.name);
        section.error(absent.name, std::string(absent.remedy));
      }
      check_keys(section, known);
    }
    SettingsTable table = read_table(section, info);
    if (!own || !table.settings.empty()) tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace mtf::io::cfg
