// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config.h"

#include <algorithm>
#include <iterator>

#include "mtf/components/path_air.h"
#include "mtf/error.h"
#include "mtf/field/sample_ranges.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/sensor_starter.toml.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"

namespace mtf::io {
namespace {

using cfg::Node;

constexpr std::size_t kMaxName = 200;

/// False when the file is of a version that is not known, so that nothing else in it can be checked.
bool read_version(const cfg::Section& root, int& version) {
  const Node* schema = root.find("schema");
  if (schema == nullptr) {
    if (!root.reader.has_failed("schema"))
      root.reader.error({}, "schema",
                        "missing; write schema = " + std::to_string(kSensorVersion) + " as the first line");
    return true;
  }
  if (schema->kind == Node::Kind::integer && schema->integer >= 1 && schema->integer <= kSensorVersion) {
    version = static_cast<int>(schema->integer);
    return true;
  }
  root.error("schema", cfg::shown(*schema) + " is not supported; this program reads schema = 1 to " +
                           std::to_string(kSensorVersion));
  return false;
}

void read_name(const cfg::Section& root, System<double>& system) {
  const auto name = cfg::read_string(root, "name");
  if (!name) return;
  if (name->size() > kMaxName) return root.error("name", "longer than " + std::to_string(kMaxName) + " characters");
  system.name = *name;
}

void note_what_is_missing(cfg::Reader& reader, const System<double>& system) {
  const auto& list = system.list(Stage::presample);
  const auto any = [&](auto test) {
    return std::any_of(list.begin(), list.end(), [&](const auto& entry) { return test(entry.component); });
  };
  if (!any([](const auto& component) { return component.is_pupil(); }))
    reader.note({}, "presample",
                "no diffraction: [optics] and [band] add none by themselves; add [[presample]] with "
                "kind = \"diffraction\" unless the optics are meant to be perfect",
                true);
  if (!any([](const auto& component) { return component.is_footprint(); }))
    reader.note({}, "presample",
                "no detector footprint: the pitch adds none by itself; add [[presample]] with "
                "kind = \"footprint\" unless the pixels are meant to be points",
                true);
}

/// The path for components that state none; why there is none where the table cannot be, refused where it is used.
std::optional<Diagnostic> read_path_air(const Node& tree, SensorConfig& config) {
  const SettingsTable* scene = find_table(config.tables, "scene");
  if (scene != nullptr && scene->find("depth_channel") != nullptr) return std::nullopt;  // each pixel has its own
  for (const TableInfo& info : config.schema)
    if (const SettingsTable* table = info.path_air ? find_table(config.tables, info.name) : nullptr) try {
        config.system.air = info.path_air(*table, config.system.band);
      } catch (const Error& error) {
        const Node* node = tree.find(info.name);
        return Diagnostic{.error = true,
                          .position = node != nullptr ? node->position : Position{},
                          .path = std::string(info.name),
                          .text = error.what()};
      }
  return std::nullopt;
}

}  // namespace

std::string_view quantity_name(Quantity quantity) { return cfg::kQuantityNames[static_cast<std::size_t>(quantity)]; }

std::string_view quantity_unit(Quantity quantity) {
  constexpr std::array kUnitNames{"W.m^-2.sr^-1", "ph.s^-1.m^-2.sr^-1", "W.m^-2.sr^-1.um^-1", "K", "counts"};
  return kUnitNames[static_cast<std::size_t>(quantity)];
}

bool ConfigResult::ok() const {
  return std::none_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) { return d.error; });
}

namespace cfg {
namespace {

// Findings of System::check at their place in the file. What could not be read is replaced by something plausible
// first, so that one bad table does not hide what is wrong in the others, and findings that only repeat a cause are
// left out.

bool is_shared(std::string_view where) {
  return where.starts_with("frame.") || where.starts_with("optics.") || where.starts_with("band.");
}

void repair(const Reader& reader, System<double>& system) {
  const auto failed = [&](const char* path) { return reader.has_failed(path); };
  Frame<double>& frame = system.frame;
  if (failed("frame.focal_length")) frame.focal_length_mm = 100.0;
  if (failed("frame.pitch") || failed("frame.pitch_x")) frame.pitch_x_um = 15.0;
  if (failed("frame.pitch") || failed("frame.pitch_y")) frame.pitch_y_um = 15.0;
  if (failed("frame.integration_time")) frame.integration_time_s = 0.01;
  if (failed("frame.format")) frame.columns = frame.rows = 0;
  Optics<double>& optics = system.optics;
  if (failed("optics.f_number") || failed("optics.aperture")) {
    optics.f_number = 2.0;
    optics.aperture_mm.reset();
  }
  if (failed("optics.obscuration")) optics.obscuration.reset();
  if (failed("band.wavelength")) system.band = Band{3.0, 5.0};
  if (failed("optics.wavelength")) optics.wavelength_um.reset();
  if (failed("optics.wavelength") && !system.band) optics.wavelength_um = 4.0;
  if (failed("band.wavelength")) optics.wavelength_um.reset();
}

/// "presample[0].rms" of the lists that were made, to the place in the file.
std::string in_file(std::string where, const Origin& origin) {
  for (const Stage stage : kStages) {
    const std::string start = std::string(stage_name(stage)) + "[";
    const std::size_t end = where.find(']');
    if (!where.starts_with(start) || end == std::string::npos) continue;
    const std::size_t i = std::stoul(where.substr(start.size(), end - start.size()));
    return start + std::to_string(origin[static_cast<std::size_t>(stage)].at(i)) + where.substr(end);
  }
  return where;
}

bool any_failed_below(const Reader& reader, const std::string& table) {
  const auto after = reader.failed.lower_bound(table + ".");
  return after != reader.failed.end() && after->starts_with(table + ".");
}

/// True for a finding that follows from something reported already.
bool is_follow_up(const Reader& reader, const std::string& path, const std::string& text) {
  if (reader.has_failed(path)) return true;
  const std::size_t dot = path.rfind('.');
  const std::string table = path.substr(0, dot);
  if (is_shared(path) || !any_failed_below(reader, table)) return false;
  // The component's fields are incomplete: believe only what concerns a value that is there, or plainly not there.
  const bool present = dot != std::string::npos && reader.positions.contains(path);
  return !present && !text.starts_with("missing");
}

void check_system(Reader& reader, const System<double>& system, const Origin& origin) {
  System<double> copy = system;
  repair(reader, copy);
  const bool intact = reader.failed.empty();
  std::set<std::pair<std::string, std::string>> seen;
  bool frame_wrong = false;
  const auto report = [&](bool components) {
    for (const auto& finding : copy.check()) {
      if (is_shared(finding.where) == components) continue;
      std::string path = in_file(finding.where, origin);
      const std::string stem = path.substr(0, path.size() < 2 ? 0 : path.size() - 2);
      if ((path.ends_with("_x") || path.ends_with("_y")) && !reader.positions.contains(path) &&
          reader.positions.contains(stem))
        path = stem;
      for (const FileKey& key : kFileKeys)  // of a member that a file stands for the key that is written
        if (const std::string written = path.substr(0, path.rfind('.') + 1) + std::string(key.key);
            path.ends_with("." + std::string(key.member)) && reader.positions.contains(written))
          path = written;
      // What a replaced value gives rise to is no news.
      if (!finding.problem.error && (!intact || frame_wrong)) continue;
      if (seen.contains({path, finding.problem.text}) || is_follow_up(reader, path, finding.problem.text)) continue;
      seen.insert({path, finding.problem.text});
      if (!finding.problem.error) {
        reader.note(reader.position_of(path), path, finding.problem.text, false);
        continue;
      }
      frame_wrong = frame_wrong || !components;
      reader.error(reader.position_of(path), path, finding.problem.text);
    }
  };
  report(false);
  repair(reader, copy);
  report(true);
}

}  // namespace

void interpret(const Node& tree, ConfigResult& result) {
  result.config.schema = schema_of(tree, std::move(result.config.schema));
  Reader reader{.folder = folder_of(result.config.file), .schema = result.config.schema};
  const Section root{reader, tree, "", ""};
  if (read_version(root, result.config.version)) {
    System<double>& system = result.config.system;
    check_keys(root, known_tables(reader.schema));
    read_name(root, system);
    read_sections(root, result.config);
    result.config.tables = read_settings(root);
    for (SettingsTable& table : result.config.tables) table.version = result.config.version;
    if (const SettingsTable* axis = find_table(result.config.tables, "optical_axis"))
      for (const auto& [key, value] : {std::pair{"x", &system.field.axis_x_px}, {"y", &system.field.axis_y_px}})
        if (const SettingValue* given = axis->find(key)) *value = std::get<double>(*given);
    const Origin origin = read_components(root, system);
    refuse_over_field(reader);
    if (takes_path_air(system))
      if (const auto no_air = read_path_air(tree, result.config)) reader.diagnostics.push_back(*no_air);
    check_system(reader, system, origin);
    if (reader.failed.empty()) note_what_is_missing(reader, system);
    if (const auto entry = entry_by_range(system); reader.failed.empty() && entry)
      reader.note({}, "presample[" + std::to_string(*entry) + "].focus",
                  "in an image each sample is out of focus by its range (channel Z of the scene); figures of merit, "
                  "budgets and curves are those of what is in focus",
                  true);
    if (reader.failed.empty() && !system.is_isoplanatic())
      reader.note({}, "presample",
                  "the OTF changes over the field by " + names_over_field(system) +
                      ": an image has the OTF of each of its pixels, figures of merit and curves are those of the "
                      "optical axis (mtf curve --field shows others)",
                  true);
  }
  result.config.fits = std::move(reader.fits);
  result.config.files = std::move(reader.files);
  result.diagnostics = std::move(reader.diagnostics);
  cfg::sort_diagnostics(result.diagnostics);
}

}  // namespace cfg

ConfigResult parse_config(const std::string& text, const std::string& file, std::vector<TableInfo> schema) {
  ConfigResult result;
  result.config.file = file;
  result.config.text = text;
  result.config.schema = std::move(schema);
  result.config.sha256 = sha256_hex(text);
  const cfg::Tree tree = cfg::read_tree(text);
  if (tree.error)
    result.diagnostics.push_back(*tree.error);
  else
    cfg::interpret(tree.root, result);
  return result;
}

std::string format_diagnostic(const Diagnostic& diagnostic, const std::string& file) {
  std::string line = file + ":";
  if (diagnostic.position.line > 0)
    line += std::to_string(diagnostic.position.line) + ":" + std::to_string(diagnostic.position.column) + ":";
  line += diagnostic.error ? " error: " : diagnostic.remark ? " note: " : " warning: ";
  return line + (diagnostic.path.empty() ? "" : diagnostic.path + ": ") + diagnostic.text;
}

SensorConfig load_config(const std::string& file, std::vector<Diagnostic>* warnings, std::vector<TableInfo> schema) {
  const std::string text = read_text_file(file, cfg::kMaxBytes);
  ConfigResult result = parse_config(text, file, std::move(schema));
  if (const std::string kind = cfg::another_kind(result.diagnostics, text, "frame"); !kind.empty())
    throw UsageError(file + ": " + kind + "; a sensor file belongs here");
  cfg::require_no_errors(result.diagnostics, file);
  if (warnings != nullptr)
    std::move(result.diagnostics.begin(), result.diagnostics.end(), std::back_inserter(*warnings));
  return std::move(result.config);
}

std::string starter_config() { return std::string(embedded::sensor_starter_toml); }

}  // namespace mtf::io
