// SPDX-License-Identifier: Apache-2.0

// [[material]]: what a surface is made of, from the outside inwards, and what is behind it.

#include <algorithm>

#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps::scene {
namespace {

/// The largest emissivity along the normal, at any wavelength.
double largest_along_normal(const Emissivity& emissivity) {
  return emissivity.spectrum ? *std::ranges::max_element(emissivity.spectrum->value) : emissivity.along_normal;
}

void apply_angles(const Section& material, MaterialSection& out) {
  const auto exponent = out.schlick_exponent, index = out.refractive_index;
  const std::string& table = out.emissivity_angles;
  const std::string_view key = !table.empty() ? "emissivity_angles"
                               : exponent     ? "schlick_exponent"
                                              : "refractive_index";
  if ((exponent ? 1 : 0) + (index ? 1 : 0) + (table.empty() ? 0 : 1) > 1)
    return material.error(table.empty() ? "refractive_index" : key,
                          "schlick_exponent, refractive_index and emissivity_angles exclude each other; keep one");
  try {
    if (exponent) out.by_angle = radiometry::schlick(*exponent);
    if (index) out.by_angle = radiometry::dielectric(*index);
    if (!table.empty()) {
      const std::string remedy = "write angle_deg,relative";
      const auto columns = mtf::io::read_csv_numbers(
          mtf::io::read_table_text(table), table, remedy, [&](const auto& cells, const std::string& where) {
            if (cells.size() != 2 || cells[0] != "angle_deg" || cells[1] != "relative")
              throw mtf::UsageError(where + "a table of emissivity by angle has other columns; " + remedy);
            return std::vector<std::size_t>{0, 1};
          });
      out.by_angle = radiometry::angle_table(columns.column[0], columns.column[1]);
    }
  } catch (const mtf::Error& error) {
    return material.error(key, mtf::printable(error.what(), 600));
  }
  const double most = largest(out.by_angle) * largest_along_normal(out.emissivity);
  if (most > 1.0 + 1e-6)
    material.error("emissivity_angles",
                   "the emissivity reaches " + mtf::format_double(most) + " at some angle, which is above 1");
  // The balance takes what the surface gives off to all sides.
  out.emissivity.value *= hemispherical_mean(out.by_angle);
  if (out.inside.back_emissivity) out.inside.back_emissivity->value *= hemispherical_mean(out.by_angle);
}

}  // namespace

void read_value(SceneReader& s, const Section& material, const FieldInfo& row, std::vector<LayerSection>& layers) {
  const Node* node = material.find(row.name);
  const std::string remedy =
      "write layers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
      "thickness = \"20 mm\" }], from the outside inwards";
  if (node == nullptr) {
    if (!material.reader.has_failed(material.at(row.name))) material.error(row.name, "missing; " + remedy);
    return;
  }
  const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
  if (node->kind != Node::Kind::array || node->items.empty() || !std::ranges::all_of(node->items, is_table))
    return material.error(row.name, "a list of at least one layer belongs here; " + remedy);
  for (const Node& item : node->items) {
    const std::string path = material.at("layers[" + std::to_string(layers.size()) + "]");
    read_table(s, {material.reader, item, path, "a layer of " + material.title}, layers.emplace_back());
  }
}

void read_value(SceneReader& s, const Section& material, const FieldInfo& row, Convection& convection) {
  const Node* node = material.find(row.name);
  if (node == nullptr) return;
  if (node->kind == Node::Kind::table) {
    convection.model = ConvectionModel::linear;
    return read_table(s, {material.reader, *node, material.at(row.name), "convection of " + material.title},
                      convection);
  }
  if (node->kind != Node::Kind::string)
    return material.error(row.name, std::string(cfg::kind_word(node->kind)) +
                                        " where a word or a table belongs; write \"mcadams\", \"tarp\", \"none\" "
                                        "or { h0 = \"5 W/m2/K\", h1 = \"3.8 W/m2/K/(m/s)\" }");
  if (const auto word = cfg::read_word(material, row.name, kConvectionWords))
    convection.model = static_cast<ConvectionModel>(*word);
}

void read_value(SceneReader& s, const Section& material, const FieldInfo& row, Inside& inside) {
  const Node* node = material.find(row.name);
  if (node == nullptr) return;
  if (node->kind != Node::Kind::table)
    return material.error(row.name,
                          std::string(cfg::kind_word(node->kind)) +
                              " where a table belongs; write for example inside = " + std::string(row.example));
  const Section section{material.reader, *node, material.at(row.name), "inside of " + material.title};
  const Node* word = section.find("kind");
  if (word == nullptr)
    return section.error("kind",
                         "missing; write kind = \"adiabatic\", \"fixed\", \"film\", \"flux\", \"sheet\" or "
                         "\"pair\"");
  if (!cfg::read_word(section, "kind", kInsideNames)) return;
  check_rows(section, rows_of<Inside>(word->text));
  read_rows(s, section, inside, word->text);
}

void read_materials(SceneReader& s) {
  for (Section& section : find_sections(s, "material")) {
    const Node* name = section.find("name");
    if (name != nullptr && name->kind == Node::Kind::string) section.title += " " + mtf::printable(name->text, 40);
    MaterialSection& material = s.scene.materials.emplace_back();
    read_table(s, section, material);
    add_name(section, s.material_names);
    apply_angles(section, material);
  }
}

}  // namespace apps::scene
