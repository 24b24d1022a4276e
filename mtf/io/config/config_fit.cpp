// SPDX-License-Identifier: Apache-2.0

// rms = { value = "8 urad", fit = true, min = "0 urad", max = "50 urad", prior = { mean, sd }, stderr = "0.1 urad" }

#include <cmath>

#include "mtf/io/config/config_reader.h"

namespace mtf::io::cfg {
namespace {

constexpr std::array<std::string_view, 6> kFitKeys{"value", "fit", "min", "max", "prior", "stderr"};
constexpr std::array<std::string_view, 2> kPriorKeys{"mean", "sd"};

/// The other numbers of a fit table, in the unit of its value.
std::optional<double> read_like(const Section& section, const FieldInfo& info, std::string_view key,
                                const Scalar& value) {
  const Node* node = section.find(key);
  if (node == nullptr) return std::nullopt;
  const auto scalar = read_plain(section.reader, *node, info, section.at(key));
  if (!scalar || scalar->unit == value.unit) return scalar ? std::optional(scalar->value) : std::nullopt;
  const std::string unit(value.unit->name);
  // Cycles per mm, mrad and pixel are one dimension, but only the frame converts them.
  if (scalar->unit->dimension != value.unit->dimension || value.unit->dimension == Dimension::frequency) {
    section.error(key, shown(*node) + " does not go with the value in " + unit + "; write it in " + unit);
    return std::nullopt;
  }
  return convert({scalar->value, scalar->unit}, value.unit->name);
}

}  // namespace

std::optional<Scalar> read_fit(Reader& reader, const Node& table, const FieldInfo& info, const std::string& path) {
  const Section section{reader, table, path, "the table of " + std::string(info.name)};
  reader.positions[path] = table.position;
  check_keys(section, kFitKeys);
  const Node* value_node = section.find("value");
  if (value_node == nullptr) {
    reader.error(table.position, path, "has no value; write { value = " + std::string(info.example) + ", fit = true }");
    return std::nullopt;
  }
  const auto value = read_plain(reader, *value_node, info, path + ".value");
  reader.positions[path] = value_node->position;
  if (!value) {
    reader.failed.insert(path);
    return std::nullopt;
  }
  FitSpec spec{.path = path, .fit = false, .min = {}, .max = {}, .stderr_value = {}, .prior = {}};
  if (value->unit != nullptr) spec.unit = value->unit->name;
  spec.value = value->value;
  if (const Node* fit = section.find("fit")) {
    if (fit->kind != Node::Kind::boolean)
      section.error("fit", std::string(kind_word(fit->kind)) + " where true or false belongs");
    spec.fit = fit->boolean;
  }
  spec.min = read_like(section, info, "min", *value);
  spec.max = read_like(section, info, "max", *value);
  spec.stderr_value = read_like(section, info, "stderr", *value);
  spec.value_at = value_node->position;
  if (const Node* node = section.find("stderr")) spec.stderr_at = node->position;
  if (spec.min && spec.max && *spec.min > *spec.max)
    section.error("max", shown(*section.find("max")) + " is below min " + shown(*section.find("min")));
  else if (spec.min && value->value < *spec.min)
    section.error("min", shown(*section.find("min")) + " is above the value " + shown(*value_node));
  else if (spec.max && value->value > *spec.max)
    section.error("max", shown(*section.find("max")) + " is below the value " + shown(*value_node));
  if (spec.stderr_value && *spec.stderr_value < 0.0) section.error("stderr", "has to be 0 or more");

  if (const Node* node = section.find("prior")) {
    if (node->kind != Node::Kind::table) {
      section.error("prior", std::string(kind_word(node->kind)) + " where { mean = …, sd = … } belongs");
    } else {
      const Section prior{reader, *node, section.at("prior"), "prior"};
      check_keys(prior, kPriorKeys);
      for (const std::string_view key : kPriorKeys)
        if (prior.find(key) == nullptr && !reader.has_failed(prior.at(key)))
          prior.error(key, "missing; a prior is { mean = …, sd = … }");
      const auto mean = read_like(prior, info, "mean", *value), sd = read_like(prior, info, "sd", *value);
      if (sd && !(*sd > 0.0)) prior.error("sd", shown(*prior.find("sd")) + " has to be above 0");
      if (mean && sd) spec.prior = {*mean, *sd};
    }
  }
  reader.fits.push_back(std::move(spec));
  return value;
}

}  // namespace mtf::io::cfg
