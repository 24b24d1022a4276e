// SPDX-License-Identifier: Apache-2.0

// [[material]]: what a surface is made of, from the outside inwards, and what is behind it.

#include <algorithm>

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

constexpr FieldInfo kConductivity{.name = "conductivity",
                                  .unit = "W/m/K",
                                  .lo = 0.0,
                                  .hi = 1e4,
                                  .lo_open = true,
                                  .example = "\"45 W/m/K\"",
                                  .doc = "thermal"};
constexpr FieldInfo kDensity{.name = "density",
                             .unit = "kg/m3",
                             .lo = 0.0,
                             .hi = 3e4,
                             .lo_open = true,
                             .example = "\"7800 kg/m3\"",
                             .doc = "mass per volume"};
constexpr FieldInfo kHeatCapacity{.name = "heat_capacity",
                                  .unit = "J/kg/K",
                                  .lo = 0.0,
                                  .hi = 2e4,
                                  .lo_open = true,
                                  .example = "\"480 J/kg/K\"",
                                  .doc = "per mass, at constant pressure"};
constexpr FieldInfo kThickness{.name = "thickness",
                               .unit = "m",
                               .lo = 0.0,
                               .hi = 100.0,
                               .lo_open = true,
                               .example = "\"20 mm\"",
                               .doc = "of the layer"};
constexpr FieldInfo kSource{.name = "source",
                            .unit = "W/m3",
                            .lo = -1e9,
                            .hi = 1e9,
                            .presence = Presence::optional,
                            .example = "\"500 W/m3\"",
                            .doc = "heat that the layer generates; a constant, or the name of a schedule.csv"};
constexpr FieldInfo kSolarAbsorptance{.name = "solar_absorptance",
                                      .lo = 0.0,
                                      .hi = 1.0,
                                      .example = "0.7",
                                      .doc = "share of the sunlight that is absorbed"};
constexpr FieldInfo kWetFraction{.name = "wet_fraction",
                                 .lo = 0.0,
                                 .hi = 1.0,
                                 .presence = Presence::optional,
                                 .example = "0.2",
                                 .doc = "of the surface that evaporates"};
constexpr FieldInfo kGloss{.name = "gloss",
                           .lo = 0.0,
                           .hi = 1.0,
                           .presence = Presence::optional,
                           .example = "0.8",
                           .doc = "share of the reflected light that a mirror would show"};
constexpr FieldInfo kSchlick{.name = "schlick_exponent",
                             .lo = 1.0,
                             .hi = 100.0,
                             .presence = Presence::optional,
                             .example = "5",
                             .doc = "emissivity by angle: 1 - (1 - cos)^exponent of that along the normal"};
constexpr FieldInfo kIndex{.name = "refractive_index",
                           .lo = 1.0,
                           .hi = 10.0,
                           .lo_open = true,
                           .presence = Presence::optional,
                           .example = "1.5",
                           .doc = "emissivity by angle: Fresnel's law for a dielectric"};
constexpr FieldInfo kFilm{.name = "h",
                          .unit = "W/m2/K",
                          .lo = 0.0,
                          .hi = 1e5,
                          .example = "\"10 W/m2/K\"",
                          .doc = "heat transfer coefficient"};
constexpr FieldInfo kFlux{.name = "flux",
                          .unit = "W/m2",
                          .lo = -1e6,
                          .hi = 1e6,
                          .example = "\"200 W/m2\"",
                          .doc = "into the inner surface; a constant, or the name of a schedule.csv"};
constexpr FieldInfo kPairThickness{.name = "thickness",
                                   .unit = "m",
                                   .lo = 0.0,
                                   .hi = 100.0,
                                   .lo_open = true,
                                   .presence = Presence::optional,
                                   .example = "\"50 mm\"",
                                   .doc = "longest distance to the opposite face"};

/// The keys of [material.inside] by kind, beside `kind`.
std::vector<std::string_view> inside_keys(InsideKind kind) {
  switch (kind) {
    case InsideKind::adiabatic:
      return {"kind"};
    case InsideKind::fixed:
      return {"kind", "temperature"};
    case InsideKind::film:
      return {"kind", "h", "temperature"};
    case InsideKind::flux:
      return {"kind", "flux"};
    case InsideKind::sheet:
      return {"kind", "solar_absorptance", "emissivity"};
    case InsideKind::pair:
      return {"kind", "thickness"};
  }
  return {};
}

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
    cfg::check_keys(section,
                    std::array<std::string_view, 5>{"conductivity", "density", "heat_capacity", "thickness", "source"});
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
    cfg::check_keys(section, std::array<std::string_view, 2>{"h0", "h1"});
    convection.model = ConvectionModel::linear;
    convection.h0_w_m2_k =
        read_si(
            section,
            {.name = "h0", .unit = "W/m2/K", .lo = 0.0, .hi = 1e5, .example = "\"5 W/m2/K\"", .doc = "without wind"})
            .value_or(0.0);
    convection.h1_j_m3_k = read_si(section, {.name = "h1",
                                             .unit = "J/m3/K",
                                             .lo = 0.0,
                                             .hi = 1e5,
                                             .example = "\"3.8 W/m2/K/(m/s)\"",
                                             .doc = "per wind speed"})
                               .value_or(0.0);
    return;
  }
  constexpr std::array<std::string_view, 3> words{"none", "mcadams", "tarp"};
  if (node->kind != Node::Kind::string) {
    material.error("convection", std::string(cfg::kind_word(node->kind)) +
                                     " where a word or a table belongs; write \"mcadams\", \"tarp\", \"none\" or "
                                     "{ h0 = \"5 W/m2/K\", h1 = \"3.8 W/m2/K/(m/s)\" }");
    return;
  }
  if (const auto word = cfg::read_word(material, "convection", words))
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
    cfg::check_keys(section, std::array<std::string_view, 11>{
                                 "name", "solar_absorptance", "emissivity", "convection", "layers", "inside",
                                 "wet_fraction", "gloss", "schlick_exponent", "refractive_index", "emissivity_angles"});
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
