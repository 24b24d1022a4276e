// SPDX-License-Identifier: Apache-2.0

// [frame], [optics], [band] and [scene]; and tables of the file that other libraries own (mtf/settings.h), which are
// read by their rows and kept as values.

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

/// A number, also out of a fit table whose `fit` is false: only the OTF is fitted, which the optical axis is part of
/// where it changes over the field.
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
  if (spec.path == section.at(info.name) && spec.fit && section.path != "optical_axis") {
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

void read_pitch(const Section& section, Frame<double>& frame) {
  AxisPair<double> pitch;
  if (read_axis_pair(section, kPitch, pitch, true)) {
    frame.pitch_x_um = pitch.x.value;
    frame.pitch_y_um = (pitch.split ? pitch.y : pitch.x).value;
  } else if (!section.reader.has_failed("frame.pitch") && !section.reader.has_failed("frame.pitch_x")) {
    section.error("pitch", missing_text(kPitch));
  }
}

void read_format(const Section& section, Frame<double>& frame) {
  constexpr std::int64_t limit = 1'000'000;
  const Node* node = section.find("format");
  if (node == nullptr) return;
  section.reader.positions[section.at("format")] = node->position;
  const auto is_size = [](const Node& item) {
    return item.kind == Node::Kind::integer && item.integer >= 1 && item.integer <= limit;
  };
  if (node->kind != Node::Kind::array || node->items.size() != 2 || !is_size(node->items[0]) ||
      !is_size(node->items[1]))
    return section.error("format", shown(*node) + " has to be [columns, rows], whole numbers in [1, " +
                                       std::to_string(limit) + "], such as [640, 512]");
  frame.columns = static_cast<int>(node->items[0].integer);
  frame.rows = static_cast<int>(node->items[1].integer);
}

void read_frame(const Section& root, Frame<double>& frame) {
  const Node* table = find_table(root, "frame");
  if (table == nullptr) {
    if (!root.reader.has_failed("frame"))
      root.reader.error({}, "frame", "missing; write [frame] with focal_length = \"100 mm\" and pitch = \"15 um\"");
    return;
  }
  const Section section{root.reader, *table, "frame", "[frame]"};
  check_keys(section, known_keys(root.reader.schema, "frame"));
  if (const auto focal_length = read_scalar(section, kFocalLength, "focal_length"))
    frame.focal_length_mm = focal_length->value;
  else if (!root.reader.has_failed("frame.focal_length"))
    section.error("focal_length", missing_text(kFocalLength));
  read_pitch(section, frame);
  read_format(section, frame);
  if (const auto time = read_scalar(section, kIntegrationTime, "integration_time"))
    frame.integration_time_s = time->value;
}

void read_optics(const Section& root, Optics<double>& optics) {
  const Node* table = find_table(root, "optics");
  if (table == nullptr) return;
  const Section section{root.reader, *table, "optics", "[optics]"};
  check_keys(section, known_keys(root.reader.schema, "optics"));
  const auto read = [&](const FieldInfo& info, std::optional<double>& value) {
    if (const auto scalar = read_scalar(section, info, info.name)) value = scalar->value;
  };
  read(kFNumber, optics.f_number);
  read(kApertureDiameter, optics.aperture_mm);
  read(kObscuration, optics.obscuration);
  read(kWavelength, optics.wavelength_um);
}

void read_band(const Section& root, std::optional<Band>& band) {
  const Node* table = find_table(root, "band");
  if (table == nullptr) return;
  const Section section{root.reader, *table, "band", "[band]"};
  check_keys(section, known_keys({}, "band"));
  constexpr std::string_view remedy = "write wavelength = [\"3.4 um\", \"4.8 um\"], shortest and longest";
  const Node* node = section.find("wavelength");
  if (node == nullptr) {
    if (!root.reader.has_failed("band.wavelength")) section.error("wavelength", "missing; " + std::string(remedy));
    return;
  }
  if (node->kind != Node::Kind::array || node->items.size() != 2) {
    section.error("wavelength", shown(*node) + " is no pair of wavelengths; " + std::string(remedy));
    return;
  }
  const std::string path = section.at("wavelength");
  const auto lo = read_plain(root.reader, node->items[0], kWavelength, path);
  const auto hi = read_plain(root.reader, node->items[1], kWavelength, path);
  root.reader.positions[path] = node->position;
  if (lo && hi) band = Band{lo->value, hi->value};
}

void read_sample(const Section& section, const Frame<double>& frame, SceneDefaults& scene) {
  const auto given = [&](std::string_view key) { return section.find(key) != nullptr; };
  std::string first;
  for (const std::string_view way : {"sample", "sample_x", "ifov", "gsd"}) {
    const std::string_view also = way == "sample_x" ? "sample_y" : way == "gsd" ? "range" : way;
    if (!given(way) && !given(also)) continue;
    if (given(way) != given(also))
      return section.error(given(way) ? way : also,
                           "given without " + std::string(given(way) ? also : way) + "; they go together");
    if (!first.empty())
      return section.error(way, "the sample spacing is given already by " + first + "; remove one of them");
    first = way;
  }
  const auto focal_plane_um = [&](double angle_urad, std::string_view key) -> std::optional<double> {
    if (!(frame.focal_length_mm > 0.0)) return std::nullopt;  // reported there
    const double um = frame.um_from_urad(angle_urad);
    if (in_range(kSample, um)) return um;
    section.error(
        key, "a sample of " + format_double(um) + " um at the focal plane is outside " + range_text(kSample, "um"));
    return std::nullopt;
  };
  if (first == "sample") scene.sample_x_um = scene.sample_y_um = read_number(section, kSample, "sample");
  if (first == "sample_x") {
    scene.sample_x_um = read_number(section, kSample, "sample_x");
    scene.sample_y_um = read_number(section, kSample, "sample_y");
  }
  if (first == "ifov") {
    if (const auto angle = read_number(section, kIfov, "ifov"))
      scene.sample_x_um = scene.sample_y_um = focal_plane_um(*angle, "ifov");
  }
  if (first == "gsd") {
    const auto gsd = read_number(section, kGsd, "gsd"), range = read_number(section, kRange, "range");
    if (gsd && range) scene.sample_x_um = scene.sample_y_um = focal_plane_um(*gsd / *range * 1e6, "gsd");
  }
}

void read_scene_aperture(const Section& section, SceneDefaults& scene) {
  if (const auto word = read_word(section, "aperture", kApertureNames)) scene.aperture = static_cast<Aperture>(*word);
  if (section.reader.has_failed("scene.aperture")) return;
  const bool sized = scene.aperture == Aperture::box || scene.aperture == Aperture::gaussian;
  const auto only_with = [&](std::string_view key, bool fits, const std::string& needed) {
    if (section.find(key) == nullptr || fits) return fits;
    section.error(key, "needs aperture = " + needed + "; remove it or set that");
    return false;
  };
  for (const std::string_view key : {"aperture_size", "aperture_size_x", "aperture_size_y"})
    only_with(key, sized, "\"box\" or \"gaussian\"");
  if (sized && read_axis_pair(section, kApertureSize, scene.aperture_size, false)) {
    const auto check = [&](std::string_view key, const Extent<double>& size) {
      if (!in_range(kApertureSize, size.value))
        section.error(key, outside_text(kApertureSize, size.value, size.unit->name));
    };
    check(scene.aperture_size.split ? "aperture_size_x" : "aperture_size", scene.aperture_size.x);
    if (scene.aperture_size.split) check("aperture_size_y", scene.aperture_size.y);
  }
  if (scene.aperture == Aperture::gaussian && !scene.aperture_size.given() &&
      !section.reader.has_failed("scene.aperture_size"))
    section.error("aperture_size", "missing; write its sigma, for example aperture_size = \"2 um\"");
  if (only_with("aperture_file", scene.aperture == Aperture::curve, "\"curve\"")) {
    scene.aperture_curve = read_curve(section, "aperture_file");
    if (!scene.aperture_curve && !section.reader.has_failed("scene.aperture_file"))
      section.error("aperture_file",
                    "missing; name the CSV file of the curve, for example aperture_file = \"scene.csv\"");
  }
  if (only_with("aperture_gain_limit", scene.aperture != Aperture::point, "\"box\", \"gaussian\" or \"curve\""))
    scene.aperture_gain_limit =
        read_number(section, kApertureGainLimit, "aperture_gain_limit").value_or(scene.aperture_gain_limit);
}

void read_scene(const Section& root, const Frame<double>& frame, SceneDefaults& scene) {
  const Node* table = find_table(root, "scene");
  if (table == nullptr) return;
  const Section section{root.reader, *table, "scene", "[scene]"};
  check_keys(section, known_keys(root.reader.schema, "scene"));
  read_sample(section, frame, scene);
  if (const auto word = read_word(section, "quantity", kQuantityNames)) scene.quantity = static_cast<Quantity>(*word);
  scene.gain = read_number(section, kGain, "gain");
  if (scene.gain == 0.0) section.error("gain", "0 would make every pixel the same; value = gain x file + offset");
  scene.offset = read_number(section, kOffset, "offset");
  scene.encoding = read_encoding(section, "encoding");
  if (const auto word = read_word(section, "border", kBorderNames)) scene.border = static_cast<Border>(*word);
  if (section.find("border_value") != nullptr && scene.border != Border::constant &&
      !root.reader.has_failed("scene.border"))
    section.error("border_value", "needs border = \"constant\"; remove it or set that");
  else
    scene.border_value = read_number(section, kBorderValue, "border_value").value_or(0.0);
  read_scene_aperture(section, scene);
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

void read_sections(const Section& root, SensorConfig& config) {
  read_frame(root, config.system.frame);
  read_optics(root, config.system.optics);
  read_band(root, config.system.band);
  read_scene(root, config.system.frame, config.scene);
}

}  // namespace mtf::io::cfg
