// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading a scene file, part by part: what the parts share. Tables are read by the rows of their types
// (scene_sections.h); what no row says follows by hand. As with sensor files nothing throws for what is in the text;
// everything wrong is collected with its place.

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "apps/scene/scene_file/scene_file.h"
#include "mtf/io/config/config_reader.h"

namespace apps::scene {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using cfg::Section;

struct SceneReader {
  cfg::Reader reader;
  Node tree{};
  SceneFile scene{};
  std::vector<std::string_view> material_names{}, mesh_names{};  ///< of the tables, "" where the name is missing
  std::set<std::string, std::less<>> used_materials{}, used_meshes{};

  Section root() { return {reader, tree, "", ""}; }
};

/// The value of `field.name` in `field.unit` ("" for plain numbers), which is in the range of `field`; `field.example`
/// is a value as written. A table { value, fit, min, max, prior, stderr } leaves a FitSpec. Reports a missing required
/// one.
std::optional<double> read_si(const Section& section, const mtf::FieldInfo& field);

// The value of a row by the type of its member: unchanged where the file has none or a wrong one, which is reported.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, double& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<double>& value);
/// A text, or the path of a file.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::string& value);
/// A constant "80 degC" or the name of a schedule "engine.csv" (a name that ends in .csv), in the range of the row.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, radiometry::heat::Schedule& value);
/// The same, or the path of a table of facets.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<GivenTemperature>& value);
/// A number, or the name of a file with bands or a spectrum.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<Emissivity>& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, Emissivity& value);
/// A list of three lengths.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::array<double, 3>& value);
/// The place of a name among the meshes or materials; reports an unknown one with the nearest.
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<std::size_t>& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::size_t& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<CameraPath>& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, CloudSource& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, Convection& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::vector<LayerSection>& value);
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, Inside& value);
template <class Word>
requires std::is_enum_v<Word>
void read_value(SceneReader&, const Section& section, const FieldInfo& row, Word& value) {
  if (const auto word = cfg::read_word(section, row.name, row.words)) value = static_cast<Word>(*word);
}
template <class Word>
requires std::is_enum_v<Word>
void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<Word>& value) {
  Word word{};
  read_value(s, section, row, word);
  if (section.find(row.name) != nullptr && !section.reader.has_failed(section.at(row.name))) value = word;
}

/// The rows of a type, in order; `kind`: see counts_with.
template <class T>
std::vector<FieldInfo> rows_of(std::string_view kind = {}) {
  std::vector<FieldInfo> rows;
  const T prototype{};
  radiometry::for_each_field(prototype, [&](const FieldInfo& row, const auto&) {
    if (counts_with(row, kind)) rows.push_back(row);
  });
  return rows;
}
/// Reports keys without a row.
void check_rows(const Section& section, const std::vector<FieldInfo>& rows);
void require_value(const Section& section, const FieldInfo& row);

/// The values of a table, those of `kind` where it has kinds.
template <class T>
void read_rows(SceneReader& s, const Section& section, T& values, std::string_view kind = {}) {
  radiometry::for_each_field(values, [&](const FieldInfo& row, auto& value) {
    if (!counts_with(row, kind)) return;
    read_value(s, section, row, value);
    require_value(section, row);
  });
}
/// A table that has no other keys.
template <class T>
void read_table(SceneReader& s, const Section& section, T& values) {
  check_rows(section, rows_of<T>());
  read_rows(s, section, values);
}

}  // namespace apps::scene
