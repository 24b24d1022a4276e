// SPDX-License-Identifier: Apache-2.0

// A sensor as TOML. Numbers are the shortest decimals that read back as the same double, in the unit the System holds
// them in, so that nothing is lost by a conversion.

#include <algorithm>
#include <filesystem>

#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/round_trip.h"
#include "mtf/otf/same_list.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using cfg::Edit;
using cfg::end_of_value;
using cfg::offset_of;
using cfg::Scalar;
using cfg::toml_number;
using cfg::toml_scalar;
using cfg::toml_string;

class Writer {
 public:
  Writer(const SensorConfig& config, const std::string& destination)
      : config_(config), folder_(cfg::folder_of(destination.empty() ? config.file : destination)) {}

  std::string take() { return std::move(text_); }

  void table(const std::string& header, const std::string& path) {
    text_ += "\n" + header + "\n";
    path_ = path;
  }
  void raw(std::string_view key, const std::string& value) { text_ += std::string(key) + " = " + value + "\n"; }

  void number(std::string_view key, const Scalar& scalar) { raw(key, with_fit(key, scalar)); }
  /// The number, or the fit table of this path if there is one.
  std::string with_fit(std::string_view key, const Scalar& scalar) const {
    const std::string path = path_ + "." + std::string(key);
    const auto term = [this](const std::string& at, const Scalar& number) {
      return number.value == 0.0 && !at.ends_with(".1") && !is_fit(at) ? "" : number_at(at, number);
    };
    const auto file = [this](const std::string& source) { return path_of(source); };
    const std::string terms = cfg::over_field_text(config_.system, path, scalar, term, file);
    return terms.empty() ? number_at(path, scalar) : terms;
  }
  std::string number_at(const std::string& path, const Scalar& scalar) const {
    const auto spec = find_fit(path);
    if (spec == config_.fits.end()) return toml_scalar(scalar);
    std::string fit = "{ value = " + toml_scalar(scalar) + ", fit = " + (spec->fit ? "true" : "false");
    const auto like = [&](double value) { return toml_scalar({value, scalar.unit}); };
    if (spec->min) fit += ", min = " + like(*spec->min);
    if (spec->max) fit += ", max = " + like(*spec->max);
    if (spec->prior)
      fit += ", prior = { mean = " + like((*spec->prior)[0]) + ", sd = " + like((*spec->prior)[1]) + " }";
    if (spec->stderr_value) fit += ", stderr = " + like(*spec->stderr_value);
    if (spec->interval) fit += ", interval = [" + like((*spec->interval)[0]) + ", " + like((*spec->interval)[1]) + "]";
    return fit + " }";
  }
  bool is_fit(const std::string& path) const { return find_fit(path) != config_.fits.end(); }
  void number(const FieldInfo& info, double value) { number(info.name, {value, find_unit(info.unit)}); }
  void number(const FieldInfo& info, const std::optional<double>& value) {
    if (value) number(info, *value);
  }
  void extent(const std::string& key, const Extent<double>& extent) { number(key, {extent.value, extent.unit}); }
  void pair(std::string_view name, const AxisPair<double>& pair) {
    const std::string key(name);
    if (!pair.given()) return;
    extent(pair.split ? key + "_x" : key, pair.x);
    if (pair.split) extent(key + "_y", pair.y);
  }
  void curve(std::string_view key, const std::shared_ptr<const Curve>& curve) {
    if (curve) raw(key, curve->source.empty() ? in_lines(*curve) : toml_string(path_of(curve->source)));
  }
  void encoding(std::string_view key, const Encoding& encoding) {
    raw(key, toml_string(encoding.kind == Encoding::Kind::table ? path_of(encoding.name) : encoding.name));
  }
  void field(const FieldRef<double>& field);
  /// What is given in a table of the schema, below the header that the caller wrote.
  void settings(std::string_view table);

 private:
  std::vector<FitSpec>::const_iterator find_fit(const std::string& path) const {
    return std::find_if(config_.fits.begin(), config_.fits.end(), [&](const FitSpec& fit) { return fit.path == path; });
  }
  static std::string in_lines(const Curve& curve) {
    std::string unit(curve.unit->name), lines;
    std::replace(unit.begin(), unit.end(), '/', '_');
    for (std::size_t i = 0; i < curve.frequency.size(); ++i)
      lines += format_double(curve.frequency[i]) + "," + format_double(curve.value[i]) + "\n";
    return "\"\"\"\nfrequency_" + unit + ",mtf\n" + lines + "\"\"\"";
  }
  std::string path_of(const std::string& source) const {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path file = fs::absolute(source, error).lexically_normal();
    const fs::path base = fs::absolute(folder_.empty() ? "." : folder_, error).lexically_normal();
    if (error) return source;
    const fs::path relative = file.lexically_relative(base);
    return relative.empty() || *relative.begin() == ".." ? file.string() : relative.string();
  }

  const SensorConfig& config_;
  std::string folder_;
  std::string text_;
  std::string path_;
};

void Writer::field(const FieldRef<double>& field) {
  const FieldInfo& info = *field.info;
  for (const cfg::FileKey& key : cfg::kFileKeys)
    if (key.member == info.name)
      if (const auto map = cfg::map_for_member(config_.system, path_ + "." + std::string(info.name), key))
        return raw(key.key, toml_string(path_of(map->source)));
  std::visit(
      [&](const auto* value) {
        using T = std::remove_cvref_t<decltype(*value)>;
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>) {
          number(info, *value);
        } else if constexpr (std::is_same_v<T, AxisPair<double>>) {
          pair(info.name, *value);
        } else if constexpr (std::is_same_v<T, SpatialFrequency<double>>) {
          if (value->unit != nullptr) number(info.name, {value->value, value->unit});
        } else if constexpr (std::is_same_v<T, int>) {
          raw(info.name, std::to_string(*value));
        } else if constexpr (std::is_same_v<T, Choice>) {
          raw(info.name, toml_string(value->names[static_cast<std::size_t>(value->index)]));
        } else if constexpr (std::is_same_v<T, Coefficients<double>>) {
          std::string list;
          for (std::size_t i = 0; i < value->size(); ++i)
            list += (i == 0 ? "" : ", ") +
                    with_fit(std::string(info.name) + "[" + std::to_string(i) + "]", {(*value)[i], nullptr});
          if (!value->empty()) raw(info.name, "[" + list + "]");
        } else if constexpr (std::is_same_v<T, Taps<double>>) {
          const auto row = [](const auto& taps) { return "[" + joined(taps, toml_number) + "]"; };
          raw(info.name, "[" + joined(*value, row) + "]");
        } else {
          curve(info.name, value->curves.empty() ? nullptr : value->curves.front());
        }
      },
      field.value);
}

void Writer::settings(std::string_view table) {
  const SettingsTable* given = find_table(config_.tables, table);
  if (given == nullptr) return;
  for (const TableInfo& info : config_.schema)
    for (const FieldInfo& row : info.settings) {
      const SettingValue* value = info.name == table ? given->find(row.name) : nullptr;
      if (value == nullptr) continue;
      if (const auto* number_value = std::get_if<double>(value))
        number(row, *number_value);
      else if (const auto* whole = std::get_if<int>(value))
        raw(row.name, row.type == FieldType::word ? toml_string(row.words[static_cast<std::size_t>(*whole)])
                                                  : std::to_string(*whole));
      else if (const auto* flag = std::get_if<bool>(value))
        raw(row.name, *flag ? "true" : "false");
      else
        raw(row.name,
            toml_string(names_file(row) ? path_of(std::get<std::string>(*value)) : std::get<std::string>(*value)));
    }
}

void write_frame(Writer& out, const Frame<double>& frame, bool split) {
  out.table("[frame]", "frame");
  out.number(cfg::kFocalLength, frame.focal_length_mm);
  const Unit* um = find_unit("um");
  if (split || frame.pitch_x_um != frame.pitch_y_um) {
    out.number("pitch_x", {frame.pitch_x_um, um});
    out.number("pitch_y", {frame.pitch_y_um, um});
  } else {
    out.number("pitch", {frame.pitch_x_um, um});
  }
  if (frame.columns > 0)
    out.raw("format", "[" + std::to_string(frame.columns) + ", " + std::to_string(frame.rows) + "]");
  if (frame.integration_time_s != 0.0 || out.is_fit("frame.integration_time"))
    out.number(cfg::kIntegrationTime, frame.integration_time_s);
  out.settings("frame");
}

void write_scene(Writer& out, const SceneDefaults& scene) {
  out.table("[scene]", "scene");
  const Unit* um = find_unit("um");
  if (scene.sample_x_um && scene.sample_x_um == scene.sample_y_um) {
    out.number("sample", {*scene.sample_x_um, um});
  } else if (scene.sample_x_um && scene.sample_y_um) {
    out.number("sample_x", {*scene.sample_x_um, um});
    out.number("sample_y", {*scene.sample_y_um, um});
  }
  if (scene.quantity) out.raw("quantity", toml_string(quantity_name(*scene.quantity)));
  out.number(cfg::kGain, scene.gain);
  out.number(cfg::kOffset, scene.offset);
  if (scene.encoding) out.encoding("encoding", *scene.encoding);
  out.raw("border", toml_string(kBorderNames[static_cast<std::size_t>(scene.border)]));
  if (scene.border == Border::constant) out.number(cfg::kBorderValue, scene.border_value);
  out.settings("scene");
  out.raw("aperture", toml_string(cfg::kApertureNames[static_cast<std::size_t>(scene.aperture)]));
  if (scene.aperture == Aperture::point) return;
  if (scene.aperture != Aperture::curve) out.pair("aperture_size", scene.aperture_size);
  if (scene.aperture == Aperture::curve) out.curve("aperture_file", scene.aperture_curve);
  out.number(cfg::kApertureGainLimit, scene.aperture_gain_limit);
}

void write_optics(Writer& out, const Optics<double>& optics, bool settings) {
  if (!optics.f_number && !optics.aperture_mm && !optics.obscuration && !optics.wavelength_um && !settings) return;
  out.table("[optics]", "optics");
  out.number(cfg::kFNumber, optics.f_number);
  out.number(cfg::kApertureDiameter, optics.aperture_mm);
  out.number(cfg::kObscuration, optics.obscuration);
  out.number(cfg::kWavelength, optics.wavelength_um);
  out.settings("optics");
}

/// Labels to write: none for those that reading would give by itself.
std::vector<std::optional<std::string>> labels_to_write(const System<double>& system) {
  std::vector<std::string> kinds, labels;
  std::vector<std::optional<std::string>> own, all;
  for (const Stage stage : kStages)
    for (const auto& entry : system.list(stage)) {
      const std::string kind(entry.component.kind());
      kinds.push_back(kind);
      labels.push_back(entry.label);
      const bool numbered = entry.label.starts_with(kind + "_");
      own.push_back(entry.label == kind || numbered ? std::nullopt : std::optional(entry.label));
      all.emplace_back(entry.label);
    }
  return cfg::complete_labels(kinds, own) == labels ? own : all;
}

// New values and standard errors put into the text of a sensor file, which otherwise stays as its author wrote it:
// comments, order, units of other numbers. Values are found by their positions in the text.

/// Begin of `, stderr = ` before its value; the value itself where something else comes before it.
std::size_t begin_of_stderr(std::string_view text, std::size_t value) {
  std::string_view before = text.substr(0, value);
  const auto take = [&](std::string_view word) {
    while (!before.empty() && (before.back() == ' ' || before.back() == '\t')) before.remove_suffix(1);
    if (!before.ends_with(word)) return false;
    before.remove_suffix(word.size());
    return true;
  };
  return take("=") && take("stderr") && take(",") ? before.size() : value;
}

std::vector<FieldRef<double>> without_files(std::span<const FieldRef<double>> fields) {
  std::vector<FieldRef<double>> rest;
  for (const FieldRef<double>& field : fields)
    if (!std::holds_alternative<CurveSum<double>*>(field.value)) rest.push_back(field);
  return rest;
}

}  // namespace

std::string cfg::toml_scalar(const Scalar& scalar) {
  if (scalar.unit == nullptr) return toml_number(scalar.value);
  return "\"" + format_double(scalar.value) + " " + std::string(scalar.unit->name) + "\"";
}

std::string cfg::write_fields(std::span<const FieldRef<double>> fields) {
  const SensorConfig no_fits;
  Writer out(no_fits, {});
  for (const FieldRef<double>& field : fields) out.field(field);
  return out.take();
}

std::string round_trip(std::string_view kind, std::span<const FieldRef<double>> written,
                       std::span<const FieldRef<double>> read) {
  const auto from = without_files(written), to = without_files(read);
  const std::string text = "kind = " + cfg::toml_string(kind) + "\n" + cfg::write_fields(from);
  const cfg::Tree tree = cfg::read_tree(text);
  if (tree.error) return format_diagnostic(*tree.error, "") + "\n" + text;
  cfg::Reader reader;
  cfg::read_fields({reader, tree.root, "", "the component"}, to);
  for (const Diagnostic& diagnostic : reader.diagnostics)
    if (diagnostic.error) return format_diagnostic(diagnostic, "") + "\n" + text;
  for (std::size_t i = 0; i < from.size(); ++i)
    if (!same_value(from[i], to[i]))
      return "\"" + std::string(from[i].info->name) + "\" comes back as another value\n" + text;
  return "";
}

std::string write_config(const SensorConfig& config, const std::string& destination) {
  const System<double>& system = config.system;
  Writer out(config, destination);
  out.raw("schema", std::to_string(config.version));
  if (!system.name.empty()) out.raw("name", toml_string(system.name));
  const bool split = std::any_of(config.fits.begin(), config.fits.end(),
                                 [](const FitSpec& f) { return f.path.starts_with("frame.pitch_"); });
  write_frame(out, system.frame, split);
  write_scene(out, config.scene);
  write_optics(out, system.optics, find_table(config.tables, "optics") != nullptr);
  if (system.band) {
    const auto um = [](double value) { return "\"" + format_double(value) + " um\""; };
    out.table("[band]", "band");
    out.raw("wavelength", "[" + um(system.band->lo_um) + ", " + um(system.band->hi_um) + "]");
  }
  for (const SettingsTable& table : config.tables) {
    if (table.name == "frame" || table.name == "scene" || table.name == "optics") continue;
    const std::string name(table.name);
    out.table("[" + name + "]", name);
    out.settings(name);
  }
  const auto labels = labels_to_write(system);
  std::size_t n = 0;
  for (const Stage stage : kStages) {
    const std::string name(stage_name(stage));
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const Component<double>& component = system.list(stage)[i].component;
      out.table("[[" + name + "]]", name + "[" + std::to_string(i) + "]");
      out.raw("kind", toml_string(component.kind()));
      if (const auto& label = labels[n++]) out.raw("label", toml_string(*label));
      for (const FieldRef<double>& field : component.fields()) out.field(field);
    }
  }
  return out.take();
}

std::string splice_numbers(std::string_view text, std::span<const FitSpec> fits,
                           std::span<const std::optional<double>> values,
                           const std::function<std::string(const FitSpec& fit, double number, bool is_error)>& toml) {
  std::vector<Edit> edits;
  for (std::size_t i = 0; i < fits.size() && i < values.size(); ++i) {
    const FitSpec& fit = fits[i];
    if (!values[i] || fit.value_at.line == 0) continue;
    const std::size_t begin = offset_of(text, fit.value_at), end = end_of_value(text, begin);
    const std::string error = fit.stderr_value ? toml(fit, *fit.stderr_value, true) : "";
    const bool has_error = fit.stderr_at.line > 0;
    edits.push_back({begin, end, toml(fit, *values[i], false)});
    if (!has_error && !error.empty()) edits.back().text += ", stderr = " + error;
    if (!has_error) continue;
    const std::size_t old = offset_of(text, fit.stderr_at);
    edits.push_back({error.empty() ? begin_of_stderr(text, old) : old, end_of_value(text, old), error});
  }
  return cfg::edited(text, std::move(edits));
}

std::string splice_fits(const SensorConfig& config, std::span<const std::optional<double>> values) {
  return splice_numbers(config.text, config.fits, values, [](const FitSpec& fit, double number, bool) {
    return cfg::toml_scalar({number, fit.unit.empty() ? nullptr : find_unit(fit.unit)});
  });
}

}  // namespace mtf::io
