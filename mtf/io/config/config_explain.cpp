// SPDX-License-Identifier: Apache-2.0

// `mtf config explain`: a table of every number as written, as used, and where it came from; then derived figures.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "mtf/components/component_docs.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using cfg::Node;

std::string rounded(double value) { return significant(value, 10); }

std::string with_unit(double value, std::string_view unit) { return mtf::with_unit(rounded(value), unit); }

/// One value for both axes, or both of them.
std::string per_axis(double x, double y, std::string_view unit) {
  return x == y ? with_unit(x, unit) : "x " + with_unit(x, unit) + ", y " + with_unit(y, unit);
}

class Table {
 public:
  Table(const SensorConfig& config, const Node& root) : config_(config), root_(root) {}

  /// `keys`: the keys by which the table `section` may give the value; `otherwise`: origin when it has none of them.
  void row(const std::string& path, const Node* section, std::initializer_list<std::string> keys, std::string resolved,
           const std::string& otherwise) {
    std::string written, origin;
    for (const std::string& key : keys) {
      const Node* node = section != nullptr ? section->find(key) : nullptr;
      if (node == nullptr) continue;
      written += (written.empty() ? "" : ", ") + (key == *keys.begin() ? "" : key + " = ") + cfg::shown(*node);
      if (origin.empty()) origin = config_.file + ":" + std::to_string(node->position.line);
    }
    rows_.push_back({path, written.empty() ? "-" : written, std::move(resolved), origin.empty() ? otherwise : origin});
  }
  const Node* section(std::string_view name) const { return root_.find(name); }
  const Node* component(Stage stage, std::size_t i) const {
    const Node* list = root_.find(stage_name(stage));
    return list != nullptr && i < list->items.size() ? &list->items[i] : nullptr;
  }
  std::string origin(std::string_view table, std::string_view key) const {
    const Node* node = section(table);
    node = node != nullptr ? node->find(key) : nullptr;
    return "[" + std::string(table) + "]" + (node != nullptr ? " line " + std::to_string(node->position.line) : "");
  }

  std::string text() const {
    std::array<std::size_t, 3> width{};
    for (const auto& row : rows_)
      for (std::size_t i = 0; i < width.size(); ++i) width[i] = std::max(width[i], row[i].size());
    std::string text;
    for (const auto& row : rows_) {
      for (std::size_t i = 0; i < width.size(); ++i) text += row[i] + std::string(width[i] - row[i].size() + 2, ' ');
      text += row.back() + "\n";
    }
    return text;
  }

 private:
  const SensorConfig& config_;
  const Node& root_;
  std::vector<std::array<std::string, 4>> rows_{{"value", "as written", "as used", "from"}};
};

void explain_frame(Table& table, const System<double>& system) {
  const Frame<double>& frame = system.frame;
  const Node* node = table.section("frame");
  table.row("frame.focal_length", node, {"focal_length"}, with_unit(frame.focal_length_mm, "mm"), "set by program");
  table.row("frame.pitch", node, {"pitch", "pitch_x", "pitch_y"}, per_axis(frame.pitch_x_um, frame.pitch_y_um, "um"),
            "set by program");
  table.row("frame.format", node, {"format"},
            frame.columns > 0 ? std::to_string(frame.columns) + " x " + std::to_string(frame.rows) + " px"
                              : "whole pixels in the scene",
            "default");
  table.row("frame.integration_time", node, {"integration_time"},
            frame.integration_time_s > 0.0 ? with_unit(frame.integration_time_s, "s") : "not given", "default");
  const Optics<double>& optics = system.optics;
  node = table.section("optics");
  const auto optional = [&](const FieldInfo& info, const std::optional<double>& value) {
    if (value)
      table.row("optics." + std::string(info.name), node, {std::string(info.name)}, with_unit(*value, info.unit),
                "set by program");
  };
  optional(cfg::kFNumber, optics.f_number);
  optional(cfg::kApertureDiameter, optics.aperture_mm);
  optional(cfg::kObscuration, optics.obscuration);
  optional(cfg::kWavelength, optics.wavelength_um);
  if (system.band)
    table.row("band.wavelength", table.section("band"), {"wavelength"},
              rounded(system.band->lo_um) + " to " + with_unit(system.band->hi_um, "um"), "set by program");
}

void explain_scene(Table& table, const SceneDefaults& scene, const Frame<double>& frame) {
  const Node* node = table.section("scene");
  table.row("scene.sample", node, {"sample", "sample_x", "sample_y", "ifov", "gsd", "range"},
            scene.sample_x_um && scene.sample_y_um ? per_axis(*scene.sample_x_um, *scene.sample_y_um, "um")
                                                   : "from the image file",
            "default");
  table.row("scene.quantity", node, {"quantity"},
            scene.quantity
                ? std::string(quantity_name(*scene.quantity)) + " (" + std::string(quantity_unit(*scene.quantity)) + ")"
                : "from the image file",
            "default");
  table.row("scene.gain", node, {"gain"}, scene.gain ? rounded(*scene.gain) : "not given", "default");
  table.row("scene.offset", node, {"offset"}, scene.offset ? rounded(*scene.offset) : "not given", "default");
  table.row("scene.encoding", node, {"encoding"}, scene.encoding ? scene.encoding->name : "from the image file",
            "default");
  table.row("scene.border", node, {"border", "border_value"},
            std::string(kBorderNames[static_cast<std::size_t>(scene.border)]) +
                (scene.border == Border::constant ? " at " + rounded(scene.border_value) : ""),
            "default");
  table.row("scene.aperture", node, {"aperture"},
            std::string(cfg::kApertureNames[static_cast<std::size_t>(scene.aperture)]), "default");
  if (scene.aperture == Aperture::point) return;
  if (scene.aperture == Aperture::curve)
    table.row("scene.aperture_file", node, {"aperture_file"},
              !scene.aperture_curve                  ? "-"
              : scene.aperture_curve->source.empty() ? "in the file"
                                                     : scene.aperture_curve->source,
              "set by program");
  else
    table.row("scene.aperture_size", node, {"aperture_size", "aperture_size_x", "aperture_size_y"},
              scene.aperture_size.given()
                  ? per_axis(scene.aperture_size.x_um(frame), scene.aperture_size.y_um(frame), "um")
                  : "one sample",
              "default");
  table.row("scene.aperture_gain_limit", node, {"aperture_gain_limit"}, rounded(scene.aperture_gain_limit), "default");
}

std::string shown(const FieldInfo& row, const SettingValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return with_unit(*number, row.unit);
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  const int whole = std::get<int>(value);
  return row.type == FieldType::word ? std::string(row.words[static_cast<std::size_t>(whole)]) : std::to_string(whole);
}

void explain_settings(Table& table, const SensorConfig& config) {
  for (const SettingsTable& given : config.tables)
    for (const TableInfo& info : config.schema)
      for (const FieldInfo& row : info.settings) {
        const SettingValue* value = info.name == given.name ? given.find(row.name) : nullptr;
        if (value == nullptr) continue;
        const std::string key(row.name);
        table.row(std::string(given.name) + "." + key, table.section(given.name), {key}, shown(row, *value),
                  "set by program");
      }
}

struct Resolved {
  std::string value;
  std::string origin = "default";
};

/// A shared field that the component does not give itself.
Resolved shared_value(const FieldInfo& info, const System<double>& system, const Table& table) {
  const Optics<double>& optics = system.optics;
  if (info.name == "f_number") {
    if (optics.f_number) return {rounded(*optics.f_number), table.origin("optics", "f_number")};
    if (optics.aperture_mm)
      return {rounded(system.frame.focal_length_mm / *optics.aperture_mm), table.origin("optics", "aperture")};
  }
  if (info.name == "obscuration")
    return optics.obscuration ? Resolved{rounded(*optics.obscuration), table.origin("optics", "obscuration")}
                              : Resolved{"0"};
  if (info.name == "wavelength" && system.band)
    return {rounded(system.band->lo_um) + " to " + with_unit(system.band->hi_um, "um"),
            table.origin("band", "wavelength")};
  if (info.name == "wavelength" && optics.wavelength_um)
    return {with_unit(*optics.wavelength_um, "um"), table.origin("optics", "wavelength")};
  return {};
}

/// The scan among the fields of a filter of the electronics.
Scan<double> scan_of(const std::vector<FieldRef<double>>& fields) {
  Scan<double> scan;
  for (const FieldRef<double>& field : fields) {
    const auto* const* value = std::get_if<std::optional<double>*>(&field.value);
    if (value == nullptr) continue;
    if (field.info->name == "scan_velocity") scan.velocity_um_s = **value;
    if (field.info->name == "scan_rate") scan.rate_urad_s = **value;
    if (field.info->name == "pixel_clock") scan.pixel_clock_hz = **value;
  }
  return scan;
}

/// Empty for an optional value that is not given.
Resolved resolved(const FieldRef<double>& field, const System<double>& system, const Scan<double>& scan,
                  const Table& table) {
  const FieldInfo& info = *field.info;
  const Frame<double>& frame = system.frame;
  return std::visit(
      [&](const auto* value) -> Resolved {
        using T = std::remove_cvref_t<decltype(*value)>;
        if constexpr (std::is_same_v<T, double>) {
          return {with_unit(*value, info.unit)};
        } else if constexpr (std::is_same_v<T, std::optional<double>>) {
          if (*value) return {with_unit(**value, info.unit)};
          return info.presence == Presence::shared ? shared_value(info, system, table) : Resolved{};
        } else if constexpr (std::is_same_v<T, AxisPair<double>>) {
          return value->given() ? Resolved{per_axis(value->x_um(frame), value->y_um(frame), "um")} : Resolved{};
        } else if constexpr (std::is_same_v<T, SpatialFrequency<double>>) {
          if (value->unit == nullptr) return {};
          return {per_axis(value->cy_mm(frame, Axis::x, scan), value->cy_mm(frame, Axis::y, scan), "cy/mm")};
        } else if constexpr (std::is_same_v<T, int>) {
          return {std::to_string(*value)};
        } else if constexpr (std::is_same_v<T, Choice>) {
          return {std::string(value->names[static_cast<std::size_t>(value->index)])};
        } else if constexpr (std::is_same_v<T, Coefficients<double>>) {
          return value->empty() ? Resolved{} : Resolved{"[" + joined(*value, rounded) + "]"};
        } else if constexpr (std::is_same_v<T, Taps<double>>) {
          double sum = 0.0;
          for (const auto& row : *value)
            for (const double tap : row) sum += tap;
          return {std::to_string(value->size()) + " rows x " +
                  std::to_string(value->empty() ? 0 : value->front().size()) + " columns" +
                  (info.name == "taps" ? ", sum " + rounded(sum) : "")};
        } else {
          if (value->curves.empty()) return {};
          if (value->curves.size() > 1) return {std::to_string(value->curves.size()) + " curves over the field"};
          const Curve& one = *value->curves.front();
          return {std::to_string(one.frequency.size()) + " samples to " +
                  with_unit(one.frequency.back(), one.unit->name)};
        }
      },
      field.value);
}

void explain_components(Table& table, const System<double>& system) {
  const std::string over_field = names_over_field(system);
  for (const Stage stage : kStages)
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const auto& entry = system.list(stage)[i];
      const Node* node = table.component(stage, i);
      const std::string path = std::string(stage_name(stage)) + "[" + std::to_string(i) + "]";
      table.row(path, node, {"kind"}, std::string(entry.component.description()), "set by program");
      table.row(path + ".label", node, {"label"}, entry.label, "default");
      const auto fields = entry.component.fields();
      for (const FieldRef<double>& field : fields) {
        const Resolved value = resolved(field, system, scan_of(fields), table);
        const std::string name(field.info->name);
        if (value.value.empty()) continue;
        const bool varies = (", " + over_field + ",").find(", " + path + "." + name + ",") != std::string::npos;
        table.row(path + "." + name, node, {name, name + "_x", name + "_y"},
                  value.value + (varies ? " on the axis" : ""), value.origin);
      }
    }
}

/// Each kind once: who uses it, formula, source.
std::string formulas(const System<double>& system) {
  std::vector<std::pair<std::string_view, std::string>> users;
  for (const auto& list : system.stages)
    for (const auto& entry : list) {
      const std::string_view kind = entry.component.kind();
      const auto known = std::find_if(users.begin(), users.end(), [&](const auto& user) { return user.first == kind; });
      if (known == users.end())
        users.emplace_back(kind, entry.label);
      else
        known->second += ", " + entry.label;
    }
  std::string text;
  for (const auto& [kind, labels] : users) {
    text += "\n" + labels + (labels == kind ? "" : " (" + std::string(kind) + ")") + "\n";
    std::istringstream lines(component_formula(kind));
    for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
    if (const std::string source = component_source(kind); !source.empty()) text += "  source: " + source + "\n";
  }
  return text.empty() ? text : text + "\nmtf config kinds KIND shows units, signs and validity\n";
}

std::string derived(const SensorConfig& config) {
  const System<double>& system = config.system;
  const Frame<double>& frame = system.frame;
  const double nyquist_x = frame.nyquist_cy_mm(Axis::x), nyquist_y = frame.nyquist_cy_mm(Axis::y);
  std::string text;
  const auto line = [&](const std::string& name, const std::string& value) {
    text += name + std::string(name.size() < 24 ? 24 - name.size() : 1, ' ') + value + "\n";
  };
  line("sampling frequency", per_axis(2.0 * nyquist_x, 2.0 * nyquist_y, "cy/mm"));
  line("Nyquist frequency", per_axis(nyquist_x, nyquist_y, "cy/mm"));
  for (const auto& entry : system.list(Stage::presample)) {
    if (!entry.component.is_pupil()) continue;
    const Context<double> middle = system.context();
    const double cutoff = entry.component.cutoff_cy_mm(middle);
    const std::string at = " (" + entry.label + (system.band ? ", middle of the band)" : ")");
    line("optical cutoff", with_unit(cutoff, "cy/mm") + at);
    line("Q = lambda N / pitch", per_axis(2.0 * nyquist_x / cutoff, 2.0 * nyquist_y / cutoff, "") + at);
  }
  line("IFOV of a pixel", per_axis(frame.pitch_x_um / frame.focal_length_mm * 1e3,
                                   frame.pitch_y_um / frame.focal_length_mm * 1e3, "urad"));
  const auto field_deg = [&](int n, double pitch_um) {
    return 2.0 * std::atan(0.5 * n * pitch_um * 1e-3 / frame.focal_length_mm) * 180.0 / std::numbers::pi;
  };
  if (frame.columns > 0)
    line("field of view", with_unit(field_deg(frame.columns, frame.pitch_x_um), "deg") + " x " +
                              with_unit(field_deg(frame.rows, frame.pitch_y_um), "deg"));
  const SceneDefaults& scene = config.scene;
  if (scene.sample_x_um && scene.sample_y_um)
    line("scene samples per pitch",
         per_axis(frame.pitch_x_um / *scene.sample_x_um, frame.pitch_y_um / *scene.sample_y_um, ""));
  return text;
}

}  // namespace

std::string explain_config(const SensorConfig& config) {
  const cfg::Tree tree = cfg::read_tree(config.text);
  Table table(config, tree.root);
  explain_frame(table, config.system);
  explain_scene(table, config.scene, config.system.frame);
  explain_settings(table, config);
  explain_components(table, config.system);
  std::string fits;
  for (const FitSpec& fit : config.fits)
    if (fit.fit) fits += "  " + fit.path + "\n";
  return table.text() + "\n" + derived(config) + (fits.empty() ? "" : "\nto be fitted:\n" + fits) +
         formulas(config.system);
}

}  // namespace mtf::io
