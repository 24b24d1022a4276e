// SPDX-License-Identifier: Apache-2.0

// The three lists of components: every field through the field table of its kind.

#include <algorithm>

#include "mtf/io/config/config_reader.h"
#include "mtf/words.h"

namespace mtf::io::cfg {
namespace {

constexpr std::size_t kMaxComponents = 256;
constexpr std::size_t kMaxLabel = 80;

template <class... F>
struct Overloads : F... {
  using F::operator()...;
};
template <class... F>
Overloads(F...) -> Overloads<F...>;

/// True when the value was there and good.
bool read_value(const Section& section, const FieldRef<double>& field) {
  const FieldInfo& info = *field.info;
  const auto set = [](auto& target, const auto& value) {
    if (value) target = *value;
    return value.has_value();
  };
  const auto number = [&](auto& target) {
    const auto scalar = read_scalar(section, info, info.name);
    if (scalar) target = scalar->value;
    return scalar.has_value();
  };
  return std::visit(
      Overloads{[&](double* value) { return number(*value); },
                [&](std::optional<double>* value) { return number(*value); },
                [&](SpatialFrequency<double>* value) {
                  const auto scalar = read_scalar(section, info, info.name);
                  if (scalar) *value = {scalar->value, scalar->unit};
                  return scalar.has_value();
                },
                [&](AxisPair<double>* value) { return read_axis_pair(section, info, *value, true); },
                [&](int* value) { return set(*value, read_whole(section, info)); },
                [&](Choice* value) { return set(value->index, read_word(section, info.name, value->names)); },
                [&](Coefficients<double>* value) { return set(*value, read_coefficients(section, info)); },
                [&](Taps<double>* value) { return set(*value, read_taps(section, info.name)); },
                [&](std::shared_ptr<const Curve>* value) {
                  *value = read_curve(section, info.name);
                  return *value != nullptr;
                }},
      field.value);
}

std::optional<Component<double>> make_component(const Section& section) {
  const auto kinds = component_kinds();
  if (section.find("kind") == nullptr) {
    section.error("kind", "missing" + suggestion("", kinds));
    return std::nullopt;
  }
  const auto kind = read_string(section, "kind");
  if (!kind) return std::nullopt;
  if (std::find(kinds.begin(), kinds.end(), *kind) != kinds.end()) return Component<double>::make(*kind);
  section.error("kind", "unknown kind \"" + printable(*kind, 60) + "\"" + suggestion(*kind, kinds));
  return std::nullopt;
}

std::optional<std::string> read_label(const Section& section, std::vector<std::string>& taken) {
  const auto label = read_string(section, "label");
  if (!label) return std::nullopt;
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (label->empty() || label->size() > kMaxLabel || std::any_of(label->begin(), label->end(), is_control)) {
    section.error("label", "has to be 1 to " + std::to_string(kMaxLabel) + " printable characters");
    return std::nullopt;
  }
  if (std::find(taken.begin(), taken.end(), *label) != taken.end()) {
    section.error("label", "\"" + *label + "\" is the label of another component already; labels are unique");
    return std::nullopt;
  }
  taken.push_back(*label);
  return label;
}

}  // namespace

void read_fields(const Section& section, std::span<const FieldRef<double>> fields) {
  std::vector<std::string> known{"kind", "label"};
  for (const auto& field : fields)
    for (std::string& key : keys_of(*field.info)) known.push_back(std::move(key));
  check_keys(section, known);
  for (const auto& field : fields) {
    const std::string path = section.at(field.info->name);
    if (read_value(section, field) || field.info->presence != Presence::required) continue;
    const bool axis_failed = section.reader.has_failed(path + "_x") || section.reader.has_failed(path + "_y");
    if (!section.reader.has_failed(path) && !axis_failed) section.error(field.info->name, missing_text(*field.info));
  }
}

std::vector<std::string> complete_labels(const std::vector<std::string>& kinds,
                                         const std::vector<std::optional<std::string>>& labels) {
  std::set<std::string> taken;
  for (const auto& label : labels)
    if (label) taken.insert(*label);
  std::vector<std::string> result;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    std::string label = labels[i].value_or(kinds[i]);
    for (int n = 2; !labels[i] && taken.contains(label); ++n) label = kinds[i] + "_" + std::to_string(n);
    taken.insert(label);
    result.push_back(std::move(label));
  }
  return result;
}

Origin read_components(const Section& root, System<double>& system) {
  Origin origin;
  std::vector<std::string> taken, kinds;
  std::vector<std::optional<std::string>> labels;
  for (const Stage stage : kStages) {
    const std::string name(stage_name(stage));
    const Node* list = root.find(name);
    if (list == nullptr) continue;
    root.reader.positions[name] = list->position;
    const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
    if (list->kind != Node::Kind::array || !std::all_of(list->items.begin(), list->items.end(), is_table)) {
      root.reader.error(
          list->position, name,
          "has to be a list of components; write [[" + name + "]] with double brackets and kind = \"…\" below it");
      continue;
    }
    if (list->items.size() > kMaxComponents) {
      root.reader.error(list->position, name, "more than " + std::to_string(kMaxComponents) + " components");
      continue;
    }
    for (std::size_t i = 0; i < list->items.size(); ++i) {
      Section section{root.reader, list->items[i], name + "[" + std::to_string(i) + "]", "[[" + name + "]]"};
      root.reader.positions[section.path] = list->items[i].position;
      auto component = make_component(section);
      auto label = read_label(section, taken);
      if (!component) continue;
      section.title += " " + std::string(component->kind());
      read_fields(section, component->fields());
      kinds.emplace_back(component->kind());
      labels.push_back(std::move(label));
      origin[static_cast<std::size_t>(stage)].push_back(i);
      system.list(stage).push_back({std::move(*component), ""});
      take_over_field(section, stage, system.list(stage).size() - 1, system);
    }
  }
  const auto complete = complete_labels(kinds, labels);
  std::size_t n = 0;
  for (const Stage stage : kStages)
    for (auto& entry : system.list(stage)) entry.label = complete[n++];
  return origin;
}

}  // namespace mtf::io::cfg
