// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tables of a sensor file that say nothing about the OTF: detector, converter, noise and what else a library beside
// this one brings. The library describes its tables by rows of fields, as components do; reading a file gives the
// values that are there, checked by the rows; the library makes its own types of them. So files know no radiometry, and
// a build without it has no such tables.

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "mtf/band.h"
#include "mtf/component.h"

namespace mtf {

inline bool names_file(const FieldInfo& row) {
  return row.type == FieldType::file || row.type == FieldType::number_or_file;
}

/// A word that stands in the file: [table] key = "word".
struct GivenWord {
  std::string_view table, key, word;
};

/// A key that a table does not have, though a reader might expect it there, and what to write instead.
struct AbsentKey {
  std::string_view name, remedy;
};

struct SettingsTable;

struct TableInfo {
  std::string_view name;  ///< "detector"; the name of a table of the System ("optics") adds rows to that one
  std::string_view doc{};
  std::vector<FieldInfo> settings;  ///< numbers, whole ones, flags, words, texts, files, numbers or files
  /// These rows take the place of those of the same table without a condition where the file has that word.
  std::optional<GivenWord> where{};
  std::vector<AbsentKey> absent{};
  /// What the table says of the path through the air for components; empty where it is no such table. Throws Error
  /// where it says nothing that can be.
  std::function<PathAir<double>(const SettingsTable& table, const std::optional<Band>& band)> path_air{};
};

/// The newest version of sensor files, their key `schema`. What changed with
///   2   `width` alone in [detector] is a square, as in a footprint; before, its height was the pitch
inline constexpr int kSensorVersion = 2;

/// A value as given: a number in FieldInfo::unit; a whole number or the index of a word; true or false; a text or the
/// path of a file.
using SettingValue = std::variant<double, int, bool, std::string>;

struct GivenSetting {
  std::string_view name;  ///< of the row
  SettingValue value;

  bool operator==(const GivenSetting&) const = default;
};

/// A table that is in the file, with what is given in it.
struct SettingsTable {
  std::string_view name;
  std::vector<GivenSetting> settings;
  int version = kSensorVersion;  ///< of its file

  bool operator==(const SettingsTable&) const = default;

  const SettingValue* find(std::string_view key) const {
    for (const GivenSetting& setting : settings)
      if (setting.name == key) return &setting.value;
    return nullptr;
  }
};

/// The table of that name; null when it is not in the file.
inline const SettingsTable* find_table(const std::vector<SettingsTable>& tables, std::string_view name) {
  for (const SettingsTable& table : tables)
    if (table.name == name) return &table;
  return nullptr;
}

}  // namespace mtf
