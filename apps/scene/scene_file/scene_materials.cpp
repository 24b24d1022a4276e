// SPDX-License-Identifier: Apache-2.0

// [[material]]: what a surface is made of, from the outside inwards, and what is behind it.

#include <algorithm>

#include "apps/scene/scene_file/scene_fields.h"
#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/file_checks.h"
#include "mtf/units.h"

namespace apps::scene {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node;
using cfg::Section;
using mtf::FieldInfo;
using mtf::Presence;

void read_layers(SceneReader& s, const Section& material, std::vector<LayerSection>& layers) {
  const Node* node = material.find("layers");
  const std::string remedy =
      "write layers = [{ conductivity = \"45 W/m/K\", density = \"7800 kg/m3\", heat_capacity = \"480 J/kg/K\", "
      "thickness = \"20 mm\" }], from the outside inwards";
  if (node == nullptr) {
    if (!material.reader.has_failed(material.at("layers"))) material.error("layers", "missing; " + remedy);
    return;
  }
  const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
  if (node->kind != Node::Kind::array || node->items.empty() ||
      !std::all_of(node->items.begin(), node->items.end(), is_table)) {
    material.error("layers", "a list of at least one layer belongs here; " + remedy);
    return;
  }
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const Section section{material.reader, node->items[i], material.at("layers[" + std::to_string(i) + "]"),
                          "a layer of " + material.title};
    cfg::check_keys(section, kLayerKeys);
    layers.push_back({.conductivity_w_m_k = read_si(section, kConductivity).value_or(1.0),
                      .density_kg_m3 = read_si(section, kDensity).value_or(1.0),
                      .heat_capacity_j_kg_k = read_si(section, kHeatCapacity).value_or(1.0),
                      .thickness_m = read_si(section, kThickness).value_or(1.0),
                      .source = read_schedule_value(s, section, kSource).value_or(radiometry::heat::Schedule{})});
  }
}

void read_convection(const Section& material, Convection& convection) {
  const Node* node = material.find("convection");
  if (node == nullptr) return;
  if (node->kind == Node::Kind::table) {
    const Section section{material.reader, *node, material.at("convection"), "convection of " + material.title};
    cfg::check_keys(section, std::array{kFilmStill.name, kFilmWind.name});
    convection.model = ConvectionModel::linear;
    convection.h0_w_m2_k = read_si(section, kFilmStill).value_or(0.0);
    convection.h1_j_m3_k = read_si(section, kFilmWind).value_or(0.0);
    return;
  }
  if (node->kind != Node::Kind::string) {
    material.error("convection", std::string(cfg::kind_word(node->kind)) +
                                     " where a word or a table belongs; write \"mcadams\", \"tarp\", \"none\" or "
                                     "{ h0 = \"5 W/m2/K\", h1 = \"3.8 W/m2/K/(m/s)\" }");
    return;
  }
  if (const auto word = cfg::read_word(material, "convection", kConvectionWords))
    convection.model = static_cast<ConvectionModel>(*word);
}

void read_inside(SceneReader& s, const Section& material, Inside& inside) {
  const Node* node = material.find("inside");
  if (node == nullptr) return;
  if (node->kind != Node::Kind::table) {
    material.error("inside", std::string(cfg::kind_word(node->kind)) +
                                 " where a table belongs; write for example inside = { kind = \"adiabatic\" }");
    return;
  }
  const Section section{material.reader, *node, material.at("inside"), "inside of " + material.title};
  if (section.find("kind") == nullptr) {
    section.error("kind", "missing; write kind = \"adiabatic\", \"fixed\", \"film\", \"flux\", \"sheet\" or \"pair\"");
    return;
  }
  const auto kind = cfg::read_word(section, "kind", kInsideNames);
  if (!kind) return;
  inside.kind = static_cast<InsideKind>(*kind);
  cfg::check_keys(section, inside_keys(inside.kind));
  if (inside.kind == InsideKind::fixed || inside.kind == InsideKind::film)
    inside.temperature = read_schedule_value(s, section, kTemperature).value_or(radiometry::heat::Schedule{});
  if (inside.kind == InsideKind::film) inside.h_w_m2_k = read_si(section, kFilm).value_or(0.0);
  if (inside.kind == InsideKind::flux)
    inside.flux = read_schedule_value(s, section, kFlux).value_or(radiometry::heat::Schedule{});
  if (inside.kind == InsideKind::pair) inside.thickness_m = read_si(section, kPairThickness);
  if (inside.kind == InsideKind::sheet) {
    FieldInfo absorptance = kSolarAbsorptance;
    absorptance.presence = Presence::optional;
    inside.back_solar_absorptance = read_si(section, absorptance);
    inside.back_emissivity = read_emissivity(section, "emissivity");
  }
}

/// The largest emissivity along the normal, at any wavelength.
double largest_along_normal(const Emissivity& emissivity) {
  return emissivity.spectrum ? *std::max_element(emissivity.spectrum->value.begin(), emissivity.spectrum->value.end())
                             : emissivity.along_normal;
}

void read_angles(const Section& material, MaterialSection& out) {
  out.gloss = read_si(material, kGloss).value_or(0.0);
  const auto exponent = read_si(material, kSchlick), index = read_si(material, kIndex);
  const bool table = material.find("emissivity_angles") != nullptr;
  if ((exponent ? 1 : 0) + (index ? 1 : 0) + (table ? 1 : 0) > 1) {
    material.error(table ? "emissivity_angles" : "refractive_index",
                   "schlick_exponent, refractive_index and emissivity_angles exclude each other; keep one");
    return;
  }
  try {
    if (exponent) out.by_angle = radiometry::schlick(*exponent);
    if (index) out.by_angle = radiometry::dielectric(*index);
    if (table) {
      const auto path = read_path(material, "emissivity_angles");
      if (!path) return;
      const std::string remedy = "write angle_deg,relative";
      const auto columns = mtf::io::read_csv_numbers(
          mtf::io::read_table_text(*path), *path, remedy, [&](const auto& cells, const std::string& where) {
            if (cells.size() != 2 || cells[0] != "angle_deg" || cells[1] != "relative")
              throw mtf::UsageError(where + "a table of emissivity by angle has other columns; " + remedy);
            return std::vector<std::size_t>{0, 1};
          });
      out.by_angle = radiometry::angle_table(columns.column[0], columns.column[1]);
    }
  } catch (const mtf::Error& error) {
    material.error(table      ? "emissivity_angles"
                   : exponent ? "schlick_exponent"
                              : "refractive_index",
                   mtf::io::printable(error.what(), 600));
    return;
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

void read_materials(SceneReader& s) {
  const Node* list = find_tables(s, "material");
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const Node& node = list->items[i];
    const Node* name = node.find("name");
    const bool named = name != nullptr && name->kind == Node::Kind::string;
    const Section section{s.reader, node, "material[" + std::to_string(i) + "]",
                          "[[material]]" + (named ? " " + mtf::io::printable(name->text, 40) : "")};
    cfg::check_keys(section, kMaterialKeys);
    MaterialSection material;
    material.name = read_name(section, s.material_names, "armour");
    material.solar_absorptance = read_si(section, kSolarAbsorptance).value_or(0.0);
    if (section.find("emissivity") == nullptr && !s.reader.has_failed(section.at("emissivity")))
      section.error("emissivity", "missing; write emissivity = 0.9, or the name of a table such as \"paint.csv\"");
    material.emissivity = read_emissivity(section, "emissivity").value_or(Emissivity{});
    material.wet_fraction = read_si(section, kWetFraction).value_or(0.0);
    read_convection(section, material.convection);
    read_layers(s, section, material.layers);
    read_inside(s, section, material.inside);
    read_angles(section, material);
    s.scene.materials.push_back(std::move(material));
  }
}

}  // namespace apps::scene
