// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/scene_file/scene_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "apps/scene/scene_file/scene_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "mtf/words.h"

namespace apps::scene {
namespace {

using mtf::io::Diagnostic;

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

}  // namespace

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
