// SPDX-License-Identifier: Apache-2.0

// conductivity = { value = "0.3 W/m/K", fit = true, min = "0.05 W/m/K", max = "3 W/m/K", stderr = "0.02 W/m/K" }

#include <algorithm>
#include <charconv>

#include "apps/scene/scene_file/scene_reader.h"
#include "apps/scene/weather/si_units.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/units.h"

namespace apps::scene {
namespace {

constexpr double kOpenShare = 1e-3;  ///< of the value: how near a fit comes to a bound that is not allowed

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

}  // namespace

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

std::string scene_text_with(const SceneFile& scene, std::span<const mtf::io::FitSpec> fits,
                            std::span<const std::optional<double>> values) {
  return mtf::io::splice_numbers(
      scene.text, fits, values, [](const mtf::io::FitSpec& fit, double number, bool is_error) -> std::string {
        if (fit.unit.empty()) return cfg::toml_number(number);
        return cfg::toml_string(mtf::format_double(number) + " " + (is_error && fit.unit == "degC" ? "K" : fit.unit));
      });
}

}  // namespace apps::scene
