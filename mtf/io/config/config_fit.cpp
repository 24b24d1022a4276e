// SPDX-License-Identifier: Apache-2.0

// rms = { value = "8 urad", fit = true, min = "0 urad", max = "50 urad", prior = { mean, sd }, stderr = "0.1 urad" }
// read_noise = { value = "0.03 e-", interval = ["0 e-", "0.11 e-"] }

#include "mtf/io/config/config_reader.h"

namespace mtf::io::cfg {
namespace {

constexpr std::array<std::string_view, 7> kFitKeys{"value", "fit", "min", "max", "prior", "stderr", "interval"};
constexpr std::array<std::string_view, 2> kPriorKeys{"mean", "sd"};

/// The other numbers of a fit table, in the unit of its value.
std::optional<double> read_like(const Section& section, std::string_view key, const Node& node, const FieldInfo& info,
                                const Scalar& value) {
  const auto scalar = read_plain(section.reader, node, info, section.at(key));
  if (!scalar || scalar->unit == value.unit) return scalar ? std::optional(scalar->value) : std::nullopt;
  const std::string unit(value.unit->name);
  // Cycles per mm, mrad and pixel are one dimension, but only the frame converts them.
  if (scalar->unit->dimension != value.unit->dimension || value.unit->dimension == Dimension::frequency) {
    section.error(key, shown(node) + " does not go with the value in " + unit + "; write it in " + unit);
    return std::nullopt;
  }
  return convert({scalar->value, scalar->unit}, value.unit->name);
}

}  // namespace

const Node* find_value(const Section& table, const FieldInfo& info) {
  table.reader.positions[table.path] = table.table.position;
  check_keys(table, kFitKeys);
  const Node* value = table.find("value");
  if (value == nullptr)
    table.reader.error(table.table.position, table.path,
                       "has no value; write { value = " + std::string(info.example) + ", ... }");
  else
    table.reader.positions[table.path] = value->position;
  return value;
}

void read_beside_value(const Section& section, FitSpec& spec, const ReadNumber& like, const ReadNumber& spread) {
  const auto number = [](const ReadNumber& read, const Section& from, std::string_view key) {
    const Node* node = from.find(key);
    return node != nullptr ? read(from, key, *node) : std::nullopt;
  };
  const auto shown_at = [](const Section& table, std::string_view key) { return shown(*table.find(key)); };
  if (const Node* fit = section.find("fit")) {
    if (fit->kind != Node::Kind::boolean)
      section.error("fit", std::string(kind_word(fit->kind)) + " where true or false belongs");
    spec.fit = fit->boolean;
  }
  spec.min = number(like, section, "min");
  spec.max = number(like, section, "max");
  spec.stderr_value = number(spread, section, "stderr");
  spec.value_at = section.find("value")->position;
  if (const Node* node = section.find("stderr")) spec.stderr_at = node->position;
  if (spec.min && spec.max && *spec.min > *spec.max)
    section.error("max", shown_at(section, "max") + " is below min " + shown_at(section, "min"));
  else if (spec.min && spec.value < *spec.min)
    section.error("min", shown_at(section, "min") + " is above the value " + shown_at(section, "value"));
  else if (spec.max && spec.value > *spec.max)
    section.error("max", shown_at(section, "max") + " is below the value " + shown_at(section, "value"));
  if (spec.stderr_value && *spec.stderr_value < 0.0) section.error("stderr", "has to be 0 or more");

  if (const Node* interval = section.find("interval")) {
    if (interval->kind != Node::Kind::array || interval->items.size() != 2)
      return section.error("interval", "write [low, high], the ends of 95 %");
    const auto low = like(section, "interval", interval->items[0]),
               high = like(section, "interval", interval->items[1]);
    if (low && high && *low > *high)
      section.error("interval", "its low end is above its high end; write [low, high]");
    else if (low && high && !(*low <= spec.value && spec.value <= *high))
      section.error("interval", "does not hold the value " + shown_at(section, "value"));
    if (spec.fit || spec.stderr_value)
      section.error("interval", "is what was measured of a number that may be 0; it stands without " +
                                    std::string(spec.fit ? "fit = true" : "stderr"));
    if (low && high) spec.interval = {*low, *high};
  }

  const Node* node = section.find("prior");
  if (node == nullptr) return;
  if (node->kind != Node::Kind::table)
    return section.error("prior", std::string(kind_word(node->kind)) + " where { mean = …, sd = … } belongs");
  const Section prior{section.reader, *node, section.at("prior"), "prior"};
  check_keys(prior, kPriorKeys);
  for (const std::string_view key : kPriorKeys)
    if (prior.find(key) == nullptr && !section.reader.has_failed(prior.at(key)))
      prior.error(key, "missing; a prior is { mean = …, sd = … }");
  const auto mean = number(like, prior, "mean"), sd = number(spread, prior, "sd");
  if (sd && !(*sd > 0.0)) prior.error("sd", shown_at(prior, "sd") + " has to be above 0");
  if (mean && sd) spec.prior = {*mean, *sd};
}

std::optional<Scalar> read_fit(Reader& reader, const Node& table, const FieldInfo& info, const std::string& path) {
  const Section section{reader, table, path, "the table of " + std::string(info.name)};
  const Node* node = find_value(section, info);
  if (node == nullptr) return std::nullopt;
  const auto value = read_plain(reader, *node, info, path + ".value");
  if (!value) {
    reader.failed.insert(path);
    return std::nullopt;
  }
  FitSpec spec;
  spec.path = path;
  if (value->unit != nullptr) spec.unit = value->unit->name;
  spec.value = value->value;
  const ReadNumber like = [&](const Section& from, std::string_view key, const Node& number) {
    return read_like(from, key, number, info, *value);
  };
  read_beside_value(section, spec, like, like);
  reader.fits.push_back(std::move(spec));
  return value;
}

}  // namespace mtf::io::cfg
