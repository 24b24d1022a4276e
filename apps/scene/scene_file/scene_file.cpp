// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/scene_file/scene_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;
using mtf::io::Diagnostic;
using enum WeatherQuantity;

/// The table [key] of the file, which has to be there if `remedy` is not empty; reports what is wrong.
std::optional<Section> find_section(SceneReader& s, std::string_view key, std::string_view remedy) {
  const Node* node = cfg::find_table(s.root(), key);
  if (node != nullptr) return Section{s.reader, *node, std::string(key), "[" + std::string(key) + "]"};
  if (!remedy.empty() && !s.reader.has_failed(key))
    s.reader.error({}, std::string(key), "missing; " + std::string(remedy));
  return std::nullopt;
}

/// The tables of the list [[key]]; none when absent, and when it is none (reported).
std::vector<Section> find_sections(SceneReader& s, std::string_view key) {
  const Node* node = cfg::find_tables(s.root(), key);
  if (node == nullptr) return {};
  std::vector<Section> sections;
  for (const Node& item : node->items)
    sections.push_back({s.reader, item, std::string(key) + "[" + std::to_string(sections.size()) + "]",
                        "[[" + std::string(key) + "]]"});
  return sections;
}

/// A name that others refer to: not empty, not that of another; it joins `names`, "" where it is missing or wrong.
void add_name(const Section& section, std::vector<std::string_view>& names) {
  const Node* node = section.find("name");
  const bool good = node != nullptr && !section.reader.has_failed(section.at("name"));
  const std::string_view name = good ? node->text : std::string_view();
  if (good && name.empty()) section.error("name", "an empty name");
  if (!name.empty() && std::ranges::find(names, name) != names.end()) section.error("name", "the name stands twice");
  names.push_back(name);
}

/// Of a region or the ground: a material, a temperature, or both; then the material is the surface's alone.
void require_surface(const Section& section) {
  for (const char* key : {"material", "temperature"})
    if (section.find(key) != nullptr || section.reader.has_failed(section.at(key))) return;
  section.error("material", "missing; write the name of a [[material]], or temperature = \"300 K\" instead of solving");
}

bool same_faces(const RegionSection& a, const RegionSection& b) {
  return a.mesh == b.mesh && a.group == b.group && a.mesh_material == b.mesh_material;
}

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

/// One record of the values; the relative humidity becomes the vapour pressure.
void read_constant_weather(SceneReader& s, const Section& section) {
  heat::Weather& weather = s.scene.weather.constant;
  weather.source = s.scene.file;
  weather.time_s = {s.scene.time.start_s};
  for (std::size_t q = 0; q < kConstants.size(); ++q)
    if (const auto value = read_si(section, kConstants[q])) weather.values[q] = {*value};
  if (weather.has(global_horizontal) && weather.has(direct_normal) != weather.has(diffuse_horizontal))
    section.error(quantity_name(global_horizontal),
                  "of constant weather nothing follows from it, as the sun moves; give direct_normal and "
                  "diffuse_horizontal");
  const auto humidity = read_si(section, kHumidity);
  if (!humidity) return;
  if (weather.has(vapour_pressure))
    section.error(kHumidity.name, "given together with vapour_pressure; remove one of them");
  else if (!weather.has(air_temperature))
    section.error(kHumidity.name, "needs air_temperature = \"15 degC\" beside it");
  else
    weather[vapour_pressure] = {*humidity * heat::saturation_pressure_pa(weather[air_temperature].front())};
}

/// False when the file is of another version: its keys mean something else then.
bool read_schema(SceneReader& s) {
  const cfg::Node* schema = s.tree.find("schema");
  if (schema != nullptr && schema->kind == cfg::Node::Kind::integer && schema->integer == 1) return true;
  s.reader.error(schema != nullptr ? schema->position : mtf::io::Position{}, "schema",
                 schema == nullptr ? "missing; write schema = 1 on the first line" : "this mtfkit reads schema = 1");
  return schema == nullptr;
}

/// Such a scene is one open facet of what the ground is.
void add_open_facet(SceneFile& scene) {
  if (!scene.ground) return;
  scene.meshes.push_back({.name = "ground", .file = {}});
  scene.regions.push_back(
      {.name = "ground", .mesh = 0, .material = scene.ground->material, .temperature = scene.ground->temperature});
}

/// What is defined and not used is more often a slip than a wish.
void note_unused(SceneReader& s) {
  const auto note = [&](std::string_view list, const std::vector<std::string_view>& names,
                        const std::set<std::string, std::less<>>& used, const std::string& text) {
    const cfg::Node* tables = s.tree.find(list);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (!names[i].empty() && !used.contains(names[i]))
        s.reader.note(tables->items[i].position, std::string(list) + "[" + std::to_string(i) + "]", text, false);
  };
  note("material", s.material_names, s.used_materials, "no region and no ground has this material");
  note("mesh", s.mesh_names, s.used_meshes, "no region has faces of this mesh");
}

/// Whether the file has [ground] and neither meshes nor regions.
bool is_ground_alone(const SceneReader& s) {
  return s.tree.find("ground") != nullptr && s.tree.find("mesh") == nullptr && s.tree.find("region") == nullptr;
}

void read_place(SceneReader& s) {
  const auto section = find_section(s, "place", "write [place] with latitude, longitude and altitude");
  if (!section) return;
  PlaceSection place;
  read_table(s, *section, place);
  constexpr double degree = std::numbers::pi / 180.0;
  s.scene.place = {.latitude_rad = degree * place.latitude_deg,
                   .longitude_rad = degree * place.longitude_deg,
                   .altitude_m = place.altitude_m};
  s.scene.north_rad = degree * place.north_deg;
}

void read_time(SceneReader& s) {
  constexpr double kMostOutputs = 1e6;
  const auto section = find_section(s, "time", "write [time] with start, end and step");
  if (!section) return;
  TimeSection& time = s.scene.time;
  read_table(s, *section, time);
  const auto has_failed = [&](std::string_view key) { return s.reader.has_failed(section->at(key)); };
  for (const auto& [key, instant] : {std::pair{"start", time.start_s}, std::pair{"end", time.end_s}})
    if (!has_failed(key) && !(instant >= heat::instant_of({1900, 1, 1}) && instant <= heat::instant_of({2101, 1, 1})))
      section->error(key, "the sun is known for the years 1900 to 2100");
  if (has_failed("start") || has_failed("end") || has_failed("step")) return;
  const double steps = (time.end_s - time.start_s) / time.step_s;
  if (!(time.end_s > time.start_s))
    section->error("end", "the end is not after the start");
  else if (steps > kMostOutputs)
    section->error("step", "more than a million output times; take longer steps");
  else if (std::abs(steps - std::round(steps)) > 1e-6 || steps < 0.5)
    section->error("step", "the step is no divisor of the time from start to end");
}

void read_weather_section(SceneReader& s) {
  const auto found = find_section(s, "weather", "write [weather] with file = \"weather.csv\", or constant values");
  if (!found) return;
  const Section& section = *found;
  WeatherSection& weather = s.scene.weather;
  std::vector<FieldInfo> known = rows_of<WeatherSection>(), changes = rows_of<WeatherChange>(), constants{kHumidity};
  constants.insert(constants.end(), kConstants.begin(), kConstants.end());
  known.insert(known.end(), constants.begin(), constants.end());
  known.insert(known.end(), changes.begin(), changes.end());
  check_rows(section, known);
  read_rows(s, section, weather);
  const bool failed = s.reader.has_failed("weather.file");
  const Node* file = section.find("file");
  if (file != nullptr) weather.file_at = file->position;
  for (const FieldInfo& row : changes)
    if (file == nullptr && !failed && section.find(row.name) != nullptr)
      section.error(row.name, "changes the records of a file; of constant weather change the values themselves");
  read_rows(s, section, weather.change);
  const auto constant = std::find_if(constants.begin(), constants.end(),
                                     [&](const FieldInfo& row) { return section.find(row.name) != nullptr; });
  if (constant == constants.end()) {
    if (file == nullptr && !failed)
      section.error("file",
                    "missing; write for example file = \"weather.csv\", or constant values such as "
                    "air_temperature = \"15 degC\"");
  } else if (file != nullptr) {
    section.error(constant->name, "a constant value beside a file; remove one of them");
  } else {
    read_constant_weather(s, section);
  }
}

void read_sky(SceneReader& s) {
  if (const auto section = find_section(s, "sky", "")) read_table(s, *section, s.scene.sky);
}

/// The air, by the same table as in sensor files.
void read_atmosphere(SceneReader& s) {
  const std::array schema{
      radiometry::table_info<radiometry::AtmosphereSettings>("atmosphere", "the air, by a band model")};
  s.reader.schema = schema;
  for (const mtf::SettingsTable& table : cfg::read_settings(s.root()))
    s.scene.atmosphere = radiometry::from_table<radiometry::AtmosphereSettings>(table);
  s.reader.schema = {};
  if (!s.scene.atmosphere || !s.reader.failed.empty()) return;
  try {
    static_cast<void>(air_above(*s.scene.atmosphere, s.scene.place.altitude_m));
  } catch (const mtf::Error& refused) {
    // "atmosphere.KEY: ..." at the key, "[atmosphere]: ..." at the table.
    constexpr std::string_view prefix = "atmosphere.", table = "[atmosphere]: ";
    const std::string text = refused.what();
    const std::size_t colon = text.find(": ");
    const bool of_key = text.starts_with(prefix) && colon != std::string::npos;
    const cfg::Node* node = s.tree.find("atmosphere");
    const cfg::Node* key = of_key ? node->find(text.substr(prefix.size(), colon - prefix.size())) : nullptr;
    s.reader.error((key != nullptr ? key : node)->position, of_key ? text.substr(0, colon) : "atmosphere",
                   of_key                    ? text.substr(colon + 2)
                   : text.starts_with(table) ? text.substr(table.size())
                                             : text);
  }
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

void read_meshes(SceneReader& s) {
  if (s.tree.find("mesh") == nullptr && !s.reader.has_failed("mesh") && !is_ground_alone(s))
    s.reader.error({}, "mesh",
                   "missing; write [[mesh]] with name = \"vehicle\" and file = \"vehicle.obj\"; a scene of one open "
                   "facet has [ground], no mesh and no region");
  for (const Section& section : find_sections(s, "mesh")) {
    MeshSection& mesh = s.scene.meshes.emplace_back();
    read_table(s, section, mesh);
    add_name(section, s.mesh_names);
    if (const Node* file = section.find("file")) mesh.file_at = file->position;
  }
}

void read_regions(SceneReader& s) {
  if (s.tree.find("region") == nullptr && !s.reader.has_failed("region") && !is_ground_alone(s))
    s.reader.error({}, "region", "missing; write [[region]] with mesh = \"vehicle\" and material = \"armour\"");
  for (const Section& section : find_sections(s, "region")) {
    RegionSection region;
    read_table(s, section, region);
    require_surface(section);
    const bool on_mesh = !s.reader.has_failed(section.at("mesh"));
    if (region.name.empty())
      region.name = !region.group.empty()           ? region.group
                    : !region.mesh_material.empty() ? region.mesh_material
                    : on_mesh                       ? std::string(s.mesh_names[region.mesh])
                                                    : std::string();
    const auto& regions = s.scene.regions;
    if (on_mesh && std::ranges::any_of(regions, [&](const auto& other) { return same_faces(other, region); }))
      section.error("mesh", "there is a region of the same faces already");
    if (std::any_of(regions.begin(), regions.end(), [&](const auto& other) { return other.name == region.name; }))
      section.error("name", "there is a region \"" + mtf::printable(region.name, 40) +
                                "\" already; give this one a name of its own");
    s.scene.regions.push_back(std::move(region));
  }
}

void read_ground(SceneReader& s) {
  const auto section = find_section(s, "ground", "");
  if (!section) return;
  read_table(s, *section, s.scene.ground.emplace());
  require_surface(*section);
}

void read_measured(SceneReader& s) {
  const auto section = find_section(s, "measured", "");
  if (!section) return;
  MeasuredSection& measured = s.scene.measured.emplace();
  read_table(s, *section, measured);
  if (measured.temperature.constant())
    section->error("temperature", "a measured day is a table of times; write the name of a CSV file");
}

void read_camera(SceneReader& s) {
  const auto found = find_section(s, "camera", "");
  if (!found) return;
  const Section& section = *found;
  CameraSection camera;
  read_table(s, section, camera);
  if (camera.up == std::array<double, 3>{}) section.error("up", "a direction of length 0");
  if (section.find("path") != nullptr) {
    for (const std::string_view key : {"position", "look_at"})
      if (section.find(key) != nullptr) section.error(key, "the camera has a path already; leave out one of them");
    if (!camera.path) return;
    camera.position_m = camera.path->place.front().position_m;
    camera.look_at_m = camera.path->place.front().look_at_m;
  } else {
    for (const FieldInfo& row : rows_of<CameraSection>())
      if (row.name == "position" || row.name == "look_at") require_value(section, required(row));
    if (s.reader.has_failed("camera.position") || s.reader.has_failed("camera.look_at")) return;
    if (camera.position_m == camera.look_at_m) section.error("look_at", "the camera looks at its own position");
  }
  s.scene.camera = std::move(camera);
}

}  // namespace

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<CameraPath>& value) {
  std::string file;
  read_value(s, section, of_type(FieldType::file, row), file);
  if (!file.empty()) try {
      value = read_camera_path(file);
    } catch (const mtf::Error& error) {
      section.error(row.name, mtf::printable(error.what(), 400));
    }
}

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

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, CloudSource& value) {
  const Node* cloud = section.find(row.name);
  if (cloud == nullptr) return;
  if (cloud->kind == Node::Kind::string && !cloud->text.ends_with("%")) {
    if (const auto word = cfg::read_word(section, row.name, row.words)) value = static_cast<CloudSource>(*word);
  } else if (const auto cover = read_si(section, row)) {
    value = CloudSource::constant;
    s.scene.sky.cloud_cover = *cover;
  }
}

bool SceneResult::ok() const {
  return std::none_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) { return d.error; });
}

SceneResult parse_scene(const std::string& text, const std::string& file) {
  SceneReader s{
      .reader = {
          .folder = cfg::folder_of(file), .schema = {}, .diagnostics = {}, .positions = {}, .failed = {}, .fits = {}}};
  s.scene.file = file;
  s.scene.text = text;
  s.scene.sha256 = mtf::io::sha256_hex(text);
  cfg::Tree tree = cfg::read_tree(text);
  if (tree.error) return {.scene = std::move(s.scene), .diagnostics = {*tree.error}};
  s.tree = std::move(tree.root);
  if (read_schema(s)) {
    cfg::check_keys(s.root(), kTables);
    read_place(s);
    read_time(s);
    read_weather_section(s);
    read_sky(s);
    read_atmosphere(s);
    read_materials(s);
    read_meshes(s);
    read_regions(s);
    read_ground(s);
    read_measured(s);
    read_camera(s);
    if (is_ground_alone(s)) add_open_facet(s.scene);
    if (s.reader.failed.empty()) note_unused(s);
  }
  cfg::sort_diagnostics(s.reader.diagnostics);
  s.scene.fits = std::move(s.reader.fits);
  s.scene.files = std::move(s.reader.files);
  return {.scene = std::move(s.scene), .diagnostics = std::move(s.reader.diagnostics)};
}

std::vector<std::string> files_of(const SceneFile& scene) {
  std::vector<std::string> files{scene.file};
  for (const std::string& file : scene.files) {
    files.push_back(file);
    if (!file.ends_with(".gltf")) continue;
    std::ifstream text(file);
    const std::string json{std::istreambuf_iterator<char>(text), std::istreambuf_iterator<char>()};
    for (std::size_t at = json.find("\"uri\""); at != std::string::npos; at = json.find("\"uri\"", at + 1)) {
      const std::size_t begin = json.find('"', at + 5), end = json.find('"', begin + 1);
      if (end != std::string::npos && end - begin < 4096)
        files.push_back((std::filesystem::path(file).parent_path() / json.substr(begin + 1, end - begin - 1)).string());
    }
  }
  return files;
}

void require_files(const SceneFile& scene) {
  std::string missing;
  const auto look = [&](const std::string& file, mtf::io::Position at, const std::string& path) {
    std::error_code ignored;
    if (file.empty() || std::filesystem::exists(file, ignored)) return;
    missing +=
        (missing.empty() ? "" : "\n") +
        mtf::io::format_diagnostic(
            {.error = true, .position = at, .path = path, .text = "there is no file " + mtf::printable(file, 400)},
            scene.file);
  };
  look(scene.weather.file, scene.weather.file_at, "weather.file");
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    look(scene.meshes[m].file, scene.meshes[m].file_at, "mesh[" + std::to_string(m) + "].file");
  if (!missing.empty()) throw mtf::RuntimeError(missing);
}

SceneFile load_scene(const std::string& file, std::vector<Diagnostic>* warnings) {
  const std::string text = mtf::io::read_text_file(file, cfg::kMaxBytes);
  SceneResult result = parse_scene(text, file);
  if (const std::string kind = cfg::another_kind(result.diagnostics, text, "mesh"); !kind.empty())
    throw mtf::UsageError(file + ": " + kind + "; the file of a 3-D scene belongs here");
  cfg::require_no_errors(result.diagnostics, file);
  if (warnings != nullptr)
    std::move(result.diagnostics.begin(), result.diagnostics.end(), std::back_inserter(*warnings));
  return std::move(result.scene);
}

}  // namespace apps::scene
