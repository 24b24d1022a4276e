// SPDX-License-Identifier: Apache-2.0

// One value of each kind, from the tree of a scene file into SI.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "apps/scene/scene_file/scene_reader.h"
#include "apps/scene/weather/si_units.h"
#include "apps/scene/weather/weather_file.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/spectrum_csv.h"
#include "mtf/units.h"
#include "mtf/words.h"
#include "radiometry/light/blackbody.h"
#include "radiometry/light/constants.h"

namespace apps::scene {
namespace {

using mtf::printable;
using radiometry::heat::Schedule;

constexpr std::size_t kLongestText = 1024;

/// The example without its quotes: "45 W/m/K".
std::string bare_example(const FieldInfo& field) {
  std::string text(field.example);
  std::erase(text, '"');
  return text;
}

bool names_table(std::string_view text) { return text.ends_with(".csv") || text.ends_with(".CSV"); }

/// The first cell of the first line that is no comment.
std::string first_cell(std::string_view text) {
  text = mtf::io::without_mark(text);
  while (!text.empty()) {
    const std::string_view row = mtf::io::take_text_line(text);
    if (!mtf::io::is_comment(row)) return std::string(mtf::io::split_cells(row, mtf::io::separator_of(row)).front());
  }
  return {};
}

/// An instant as a TOML date and time, or the same in quotes.
std::optional<double> read_instant(const Section& section, const FieldInfo& row) {
  const Node* node = section.find(row.name);
  if (node == nullptr) return std::nullopt;
  if (node->kind != Node::Kind::date && node->kind != Node::Kind::string) {
    section.error(row.name, std::string(cfg::kind_word(node->kind)) +
                                " where a date and time belongs; write for example " + std::string(row.name) + " = " +
                                std::string(row.example));
    return std::nullopt;
  }
  radiometry::heat::InstantError error;
  const auto instant = radiometry::heat::parse_instant(node->text, error);
  if (!instant) section.error(row.name, printable(node->text, 60) + ": " + error.text);
  return instant;
}

std::optional<std::string> read_path(const Section& section, std::string_view key) {
  const auto name = cfg::read_string(section, key);
  if (!name) return std::nullopt;
  if (!name->empty() && name->find('\0') == std::string::npos) return section.reader.file(*name);
  section.error(key, "no file name");
  return std::nullopt;
}

/// A schedule has to stay within the range of a field; the value that does not, in words.
std::optional<std::string> out_of_range(const Schedule& schedule, const FieldInfo& field, double origin_s) {
  for (std::size_t i = 0; i < schedule.value.size(); ++i) {
    if (mtf::in_range(field, schedule.value[i])) continue;
    const TimedTable table = parse_timed_table(mtf::io::read_table_text(schedule.source), schedule.source, origin_s);
    const auto at = std::find(table.time_s.begin(), table.time_s.end(), schedule.time_s[i]) - table.time_s.begin();
    return error_at(schedule.source, table.line.at(static_cast<std::size_t>(at))) +
           mtf::outside_text(field, schedule.value[i], field.unit);
  }
  return std::nullopt;
}

template <class T>
void assign(T& value, std::optional<T>&& read) {
  if (read) value = *std::move(read);
}

using radiometry::Spectrum;

constexpr double kMeanTemperature_k = 300.0;

/// Bands as a spectrum that jumps: both samples of a jump are as close as doubles can be.
Spectrum spectrum_of_bands(std::string_view text, const std::string& path) {
  const std::string remedy = "write from_um,to_um,emissivity";
  const auto table = mtf::io::read_csv_numbers(text, path, remedy, [&](const auto& cells, const std::string& where) {
    if (cells.size() != 3 || cells[1] != "to_um" || cells[2] != "emissivity")
      throw mtf::UsageError(where + "a table of bands has other columns; " + remedy);
    return std::vector<std::size_t>{0, 1, 2};
  });
  std::vector<double> wavelength_um, value;
  for (std::size_t i = 0; i < table.line.size(); ++i) {
    const double from = table.column[0][i], to = table.column[1][i];
    const auto where = [&] { return path + ":" + std::to_string(table.line[i]) + ": "; };
    if (!(from > 0.0 && to > from))
      throw mtf::UsageError(where() + "the band has to go from above 0 um to a longer wavelength");
    if (i > 0 && from < table.column[1][i - 1])
      throw mtf::UsageError(where() + "the band overlaps the one above it; sort the bands by wavelength");
    wavelength_um.insert(wavelength_um.end(), {from, std::nextafter(to, 0.0)});
    value.insert(value.end(), {table.column[2][i], table.column[2][i]});
  }
  return radiometry::make_spectrum(path, std::move(wavelength_um), std::move(value), 1.0);
}

Spectrum read_table(const std::string& path) {
  const std::string text = mtf::io::read_table_text(path);
  std::string_view rest = mtf::io::without_mark(text);
  std::string_view header;
  while (!rest.empty() && mtf::io::is_comment(header)) header = mtf::io::take_text_line(rest);
  if (mtf::io::trimmed_cell(header).starts_with("from_")) return spectrum_of_bands(text, path);
  auto columns = mtf::io::parse_spectrum_csv(text, path, {"emissivity"});
  return radiometry::make_spectrum(path, std::move(columns.wavelength_um), std::move(columns.columns.front()), 1.0);
}

constexpr double kOpenShare = 1e-3;  ///< of the value: how near a fit comes to a bound that is not allowed

/// A number or a string with its unit, no table.
std::optional<double> read_plain_si(const Section& section, const Node& node, const FieldInfo& field,
                                    const std::string& path) {
  const auto fail = [&](const std::string& text) {
    section.reader.error(node.position, path, text);
    return std::nullopt;
  };
  double value = 0.0;
  if (node.is_number() && field.unit.empty()) {
    if (!std::isfinite(node.number)) return fail(cfg::shown(node) + " is not finite; write an ordinary number");
    value = node.number;
  } else if (node.is_number()) {
    return fail(cfg::lacks_unit_text(node, field));
  } else if (node.kind != Node::Kind::string || node.text.size() > kLongestText) {
    return fail(std::string(cfg::kind_word(node.kind)) + " where a number" + (field.unit.empty() ? "" : " with unit") +
                " belongs; write for example " + std::string(field.name) + " = " + std::string(field.example));
  } else {
    try {
      value = parse_si(node.text, field.unit, bare_example(field));
    } catch (const mtf::UsageError& error) {
      return fail(printable(error.what(), 400));
    }
  }
  if (mtf::in_range(field, value)) return value;
  const bool in_other_unit =
      !node.is_number() && !field.unit.empty() && !node.text.ends_with(" " + std::string(field.unit));
  const std::string given = in_other_unit ? printable(node.text, 60) + ", which is " + significant(value, 9) + " " +
                                                std::string(field.unit) + ","
                                          : mtf::with_unit(mtf::format_double(value), field.unit);
  return fail(given + " is outside " + mtf::range_text(field, field.unit));
}

/// A standard error or deviation: 0 or more, and no point on a scale of temperature.
std::optional<double> read_spread(const Section& section, const FieldInfo& field, std::string_view key,
                                  const Node& node) {
  if (node.kind == Node::Kind::string && node.text.ends_with("degC")) {
    section.error(key, "a difference of temperatures; write it in K");
    return std::nullopt;
  }
  FieldInfo spread = field;
  spread.name = key;
  spread.lo = 0.0;
  spread.hi = 1e12;
  spread.lo_open = false;
  return read_plain_si(section, node, spread, section.at(key));
}

/// The unit of a value that was read: what follows the number.
std::string written_unit(const Node& node) {
  if (node.kind != Node::Kind::string) return {};
  double number = 0.0;
  std::string_view rest = node.text;
  rest.remove_prefix(std::min(rest.find_first_not_of(" \t+"), rest.size()));
  rest.remove_prefix(
      static_cast<std::size_t>(std::from_chars(rest.data(), rest.data() + rest.size(), number).ptr - rest.data()));
  rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
  return std::string(rest);
}

/// Numbers in the unit of the key into that of the value as written; a spread has no zero of its own.
void to_written_unit(const FieldInfo& field, mtf::io::FitSpec& spec) {
  const SiUnit key = field.unit.empty() ? SiUnit{} : parse_unit(field.unit).value();
  const SiUnit own = spec.unit.empty() ? SiUnit{} : parse_unit(spec.unit).value();
  const double factor = key.factor / own.factor, offset = (key.offset - own.offset) / own.factor;
  const auto point = [&](double& number) { number = number * factor + offset; };
  point(spec.value);
  point(*spec.min);
  point(*spec.max);
  if (spec.stderr_value) *spec.stderr_value *= factor;
  if (spec.interval)
    for (double& end : *spec.interval) point(end);
  if (spec.prior) {
    point((*spec.prior)[0]);
    (*spec.prior)[1] *= factor;
  }
}

/// A fit table; its value when usable.
std::optional<double> read_marked(const Section& outer, const Node& table, const FieldInfo& field,
                                  const std::string& path) {
  const Section section{outer.reader, table, path, "the table of " + std::string(field.name)};
  const Node* node = cfg::find_value(section, field);
  if (node == nullptr) return std::nullopt;
  const auto value = read_plain_si(section, *node, field, path + ".value");
  if (!value) {
    section.reader.failed.insert(path);
    return std::nullopt;
  }
  mtf::io::FitSpec spec;
  spec.path = path;
  spec.unit = written_unit(*node);
  spec.value = *value;
  cfg::read_beside_value(
      section, spec,
      [&](const Section& from, std::string_view key, const Node& number) {
        return read_plain_si(from, number, field, from.at(key));
      },
      [&](const Section& from, std::string_view key, const Node& number) {
        return read_spread(from, field, key, number);
      });
  if (!spec.min) spec.min = field.lo_open ? field.lo + kOpenShare * (*value - field.lo) : field.lo;
  if (!spec.max) spec.max = field.hi;
  to_written_unit(field, spec);
  section.reader.fits.push_back(std::move(spec));
  return value;
}

}  // namespace

std::optional<double> read_si(const Section& section, const FieldInfo& field) {
  const Node* node = section.find(field.name);
  const std::string path = section.at(field.name);
  if (node != nullptr && node->kind == Node::Kind::table) return read_marked(section, *node, field, path);
  if (node != nullptr) return read_plain_si(section, *node, field, path);
  if (field.presence == mtf::Presence::required && !section.reader.has_failed(path))
    section.error(field.name, cfg::missing_text(field));
  return std::nullopt;
}

bool counts_with(const FieldInfo& row, std::string_view kind) {
  const auto kinds = mtf::words_in(row.kinds);
  return kinds.empty() || std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

void check_rows(const Section& section, const std::vector<FieldInfo>& rows) {
  std::vector<std::string_view> known;
  for (const FieldInfo& row : rows) known.push_back(row.name);
  cfg::check_keys(section, known);
}

void require_value(const Section& section, const FieldInfo& row) {
  if (row.presence == mtf::Presence::required && section.find(row.name) == nullptr &&
      !section.reader.has_failed(section.at(row.name)))
    section.error(row.name, cfg::missing_text(row));
}

void read_value(SceneReader&, const Section& section, const FieldInfo& row, double& value) {
  assign(value, row.type == mtf::FieldType::date ? read_instant(section, row) : read_si(section, row));
}

void read_value(SceneReader&, const Section& section, const FieldInfo& row, std::optional<double>& value) {
  value = read_si(section, row);
}

void read_value(SceneReader&, const Section& section, const FieldInfo& row, std::string& value) {
  assign(value, row.type == mtf::FieldType::file ? read_path(section, row.name) : cfg::read_string(section, row.name));
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, Schedule& value) {
  const Node* node = section.find(row.name);
  if (node == nullptr || node->kind != Node::Kind::string || !names_table(node->text)) {
    if (const auto constant = read_si(section, row)) value = radiometry::heat::constant_schedule(*constant);
    return;
  }
  const auto path = read_path(section, row.name);
  if (!path) return;
  try {
    Schedule schedule = read_schedule(*path, row.unit, s.scene.time.start_s);
    if (const auto problem = out_of_range(schedule, row, s.scene.time.start_s))
      return section.error(row.name, printable(*problem, 600));
    value = std::move(schedule);
  } catch (const mtf::Error& error) {
    section.error(row.name, printable(error.what(), 600));
  }
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<GivenTemperature>& value) {
  const Node* node = section.find(row.name);
  if (node == nullptr) return;
  const bool text = node->kind == Node::Kind::string;
  if (text && node->text.ends_with(".npy")) {
    auto path = read_path(section, row.name);
    if (!path) return;
    section.reader.file((std::filesystem::path(node->text).parent_path() / "times.csv").string());
    value = {.schedule = {}, .table = *std::move(path)};
    return;
  }
  if (text && names_table(node->text)) try {
      std::string path = section.reader.file(node->text);
      if (first_cell(mtf::io::read_table_text(path)) == "facet") {
        value = {.schedule = {}, .table = std::move(path)};
        return;
      }
    } catch (const mtf::Error& error) {
      return section.error(row.name, printable(error.what(), 600));
    }
  GivenTemperature given;
  read_value(s, section, row, given.schedule);
  if (!given.schedule.value.empty()) value = std::move(given);
}

void read_value(SceneReader&, const Section& section, const FieldInfo& row, std::array<double, 3>& value) {
  constexpr double kFarthest_m = 1e6;
  const Node* node = section.find(row.name);
  if (node == nullptr) return;
  const FieldInfo length = number_row(row.name, "m", -kFarthest_m, kFarthest_m, "\"14 m\"", "");
  if (node->kind != Node::Kind::array || node->items.size() != 3)
    return section.error(
        row.name,
        "a list of three lengths belongs here: x east, y north, z up, such as [\"14 m\", \"-12 m\", \"5 m\"]");
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string path = section.at(row.name) + "[" + std::to_string(i) + "]";
    assign(value[i], read_plain_si(section, node->items[i], length, path));
    if (section.reader.has_failed(path)) section.reader.failed.insert(section.at(row.name));
  }
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<std::size_t>& value) {
  const bool mesh = row.name == "mesh";
  const auto& names = mesh ? s.mesh_names : s.material_names;
  const auto name = cfg::read_string(section, row.name);
  if (!name) return;
  const auto found = std::find(names.begin(), names.end(), *name);
  if (found != names.end() && !name->empty()) {
    (mesh ? s.used_meshes : s.used_materials).insert(*name);
    value = static_cast<std::size_t>(found - names.begin());
    return;
  }
  // A table whose name is missing, which was reported, may be the one that is meant.
  if (std::find(names.begin(), names.end(), "") != names.end()) {
    section.reader.failed.insert(section.at(row.name));
    return;
  }
  const std::string what(row.name);
  section.error(row.name, "there is no " + what + " \"" + printable(*name, 60) + "\"" +
                              (names.empty() ? "; define it as [[" + what + "]]" : cfg::suggestion(*name, names)));
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::size_t& value) {
  std::optional<std::size_t> place;
  read_value(s, section, row, place);
  if (section.find(row.name) == nullptr && !section.reader.has_failed(section.at(row.name)))
    section.error(row.name, "missing; write the name of a [[" + std::string(row.name) + "]]");
  assign(value, std::move(place));
}

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, Emissivity& value) {
  std::optional<Emissivity> emissivity;
  read_value(s, section, row, emissivity);
  assign(value, std::move(emissivity));
}

double planck_mean(const Spectrum& emissivity, double temperature_k) {
  constexpr double kWidestPart = 0.01;  // of the wavelength
  constexpr int kMostParts = 400;
  const auto& l = emissivity.wavelength_um;
  const auto& e = emissivity.value;
  const auto radiance = [&](double lo, double hi) {
    return radiometry::band_radiance(radiometry::Flux::watts, lo, hi, temperature_k);
  };
  double sum =
      e.front() * radiance(0.0, l.front()) + e.back() * radiance(l.back(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i + 1 < l.size(); ++i) {
    const double width = l[i + 1] - l[i];
    const int parts =
        e[i] == e[i + 1] ? 1 : std::clamp(static_cast<int>(std::ceil(width / (kWidestPart * l[i]))), 1, kMostParts);
    for (int k = 0; k < parts; ++k)
      sum += std::lerp(e[i], e[i + 1], (k + 0.5) / parts) *
             radiance(l[i] + width * k / parts, l[i] + width * (k + 1) / parts);
  }
  return sum * std::numbers::pi / (radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(temperature_k, 4));
}

namespace {

/// Of a blackbody's radiance, what lies beyond the ends of a curve.
double share_beyond(const Spectrum& curve, double temperature_k) {
  const auto [lo_um, hi_um] = radiometry::range_of(curve);
  const double whole = radiometry::kStefanBoltzmann_w_m2_k4 * std::pow(temperature_k, 4) / std::numbers::pi;
  return 1.0 - radiometry::band_radiance(radiometry::Flux::watts, lo_um, hi_um, temperature_k) / whole;
}

}  // namespace

void read_value(SceneReader& s, const Section& section, const FieldInfo& row, std::optional<Emissivity>& value) {
  const cfg::Node* node = section.find(row.name);
  if (node == nullptr) return;
  const auto fail = [&](const std::string& text) { section.error(row.name, mtf::printable(text, 600)); };
  if (node->kind != cfg::Node::Kind::string) {
    if (const auto number = read_si(section, row)) value = {.value = *number, .spectrum = {}, .along_normal = *number};
    return;
  }
  if (mtf::io::cell_number(node->text))
    return fail(cfg::shown(*node) + " is a string; write the number without quotes");
  std::string path;
  read_value(s, section, of_type(FieldType::file, row), path);
  if (path.empty()) return;
  try {
    Spectrum spectrum = read_table(path);
    const double mean = planck_mean(spectrum, kMeanTemperature_k), beyond = share_beyond(spectrum, kMeanTemperature_k);
    constexpr double kMostBeyond = 0.5;  // 0.48 of tables from 3 to 14 um, as of both windows of the air
    if (beyond > kMostBeyond)
      section.reader.note(node->position, section.at(row.name),
                          "the heat balance holds the first and the last emissivity beyond the table, where " +
                              significant(100.0 * beyond, 3) +
                              " % of what a surface of 300 K radiates lies; it covers " + describe(range_of(spectrum)),
                          false);
    value = {.value = std::min(mean, 1.0), .spectrum = std::move(spectrum), .along_normal = mean};
  } catch (const mtf::Error& error) {
    fail(error.what());
  }
}

std::string scene_text_with(const SceneFile& scene, std::span<const mtf::io::FitSpec> fits,
                            std::span<const std::optional<double>> values) {
  return mtf::io::splice_numbers(
      scene.text, fits, values, [](const mtf::io::FitSpec& fit, double number, bool is_error) -> std::string {
        if (fit.unit.empty()) return cfg::toml_number(number);
        return cfg::toml_string(mtf::format_double(number) + " " + (is_error && fit.unit == "degC" ? "K" : fit.unit));
      });
}

}  // namespace apps::scene
