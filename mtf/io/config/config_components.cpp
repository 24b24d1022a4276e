// SPDX-License-Identifier: Apache-2.0

// The three lists of components: every field through the field table of its kind. Numbers of them may change over the
// field of view (mtf/field_terms.h):
//   w020 = { 1 = -0.3, r2 = 0.5 }   rms = { 1 = "2 urad", x = "0.5 urad" }   w131 = { table = "coma.csv" }
//   orientation = "field"
// The term 1 is the value on the optical axis, 0 where it is not given. A term that mtf fit may change is a fit table,
// w020 = { 1 = -0.3, x = { value = 0.06, fit = true } }, with the path "presample[0].w020.x".

#include <algorithm>
#include <charconv>

#include "mtf/components/field_access.h"
#include "mtf/io/config/config_edit.h"
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
  if (const auto from_file = read_file_over_field(section, field)) return *from_file;
  const auto set = [](auto& target, const auto& value) {
    if (value) target = *value;
    return value.has_value();
  };
  const Node* node = section.find(info.name);
  if (info.type == FieldType::number && node != nullptr && node->kind == Node::Kind::string &&
      std::ranges::find(info.words, node->text) != info.words.end())
    return false;  // as other keys have it
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
                [&](CurveSum<double>* value) {
                  if (auto curve = read_curve(section, info.name)) *value = std::move(curve);
                  return !value->curves.empty();
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

constexpr std::string_view kConstant = "1", kTurns = "field";
constexpr std::size_t kRadius = 0;  // of the terms: the only one that is not smooth on the axis
static_assert(kFieldTerms[kRadius] == "r");

bool is_zero(double value) { return value == 0.0; }

std::optional<std::size_t> term_of(std::string_view key) {
  const auto found = std::find(kFieldTerms.begin(), kFieldTerms.end(), key);
  if (found == kFieldTerms.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kFieldTerms.begin());
}

bool is_angle(const FieldInfo& info) { return info.dimension == Dimension::angle && info.unit == "deg"; }

/// Where in a component a number lies.
struct Place {
  std::size_t field = 0, element = 0;
};

/// Of "rms", "rms_y" or "zernike[3]".
std::optional<Place> place_of(std::span<const FieldRef<double>> fields, std::string_view key) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string_view name = fields[i].info->name;
    if (!key.starts_with(name)) continue;
    const std::string_view rest = key.substr(name.size());
    if (rest.empty() || rest == "_x") return Place{i, 0};
    if (rest == "_y") return Place{i, 1};
    std::size_t element = 0;
    if (rest.starts_with('[') && rest.ends_with(']') &&
        std::from_chars(rest.data() + 1, rest.data() + rest.size() - 1, element).ec == std::errc{})
      return Place{i, element};
  }
  return std::nullopt;
}

/// A number of a presample component, and what changes it over the field: null where nothing does.
struct NumberAt {
  std::size_t entry = 0;
  Place place;
  const FieldNumber<double>* number = nullptr;
};

/// Of "presample[0].zernike[3]".
std::optional<NumberAt> number_at(const System<double>& system, std::string_view path) {
  const std::string start = std::string(stage_name(Stage::presample)) + "[";
  if (!path.starts_with(start)) return std::nullopt;
  NumberAt at;
  const auto [end, status] = std::from_chars(path.data() + start.size(), path.data() + path.size(), at.entry);
  const auto& list = system.list(Stage::presample);
  const std::string_view rest = path.substr(static_cast<std::size_t>(end - path.data()));
  if (status != std::errc{} || !rest.starts_with("].") || at.entry >= list.size()) return std::nullopt;
  const auto place = place_of(list[at.entry].component.fields(), rest.substr(2));
  if (!place) return std::nullopt;
  at.place = *place;
  for (const FieldNumber<double>& number : system.field.numbers)
    if (number.entry == at.entry && number.field == place->field && number.element == place->element)
      at.number = &number;
  return at;
}

/// A table along the distance from the axis that begins with a slope.
bool rises_from_axis(const FieldNumber<double>& number) {
  if (!number.map || !number.map->radial) return false;
  const auto [least, most] = std::ranges::minmax(number.map->column[number.column].value);
  const double near = number.map->at(number.column, FieldPoint<double>{0.02 * number.map->scale, 0.0}),
               axis = number.map->at(number.column, FieldPoint<double>{});
  return std::abs(near - axis) > 2e-3 * (most - least);  // of a square 1e-4
}

// What grows with the distance from the axis but keeps its direction has a kink on the axis, which lenses do not have.
void warn_of_kinks(Reader& reader, const System<double>& system, std::size_t entry, const std::string& path) {
  const auto fields = system.list(Stage::presample).at(entry).component.fields();
  const auto turns = [&](const FieldAngle& angle) { return angle.entry == entry; };
  if (std::any_of(system.field.angles.begin(), system.field.angles.end(), turns)) return;
  const auto angle =
      std::find_if(fields.begin(), fields.end(), [](const auto& field) { return is_angle(*field.info); });
  if (angle == fields.end()) return;
  for (const FieldNumber<double>& number : system.field.numbers)
    if (number.entry == entry && (number.coefficient[kRadius] != 0.0 || rises_from_axis(number))) {
      const std::string name(angle->info->name);
      return reader.note(
          {}, path + "." + name,
          "numbers that grow with r in one direction have a kink on the optical axis; for a lens write " + name +
              " = \"field\"",
          true);
    }
}

/// A number by a table is what the table has on the optical axis and its own terms. False where the table has nothing
/// there, which is reported.
bool add_axis_value(Reader& reader, const FieldTerms& terms, const FieldNumber<double>& number,
                    System<double>& system) {
  const auto frame = reader.failed.lower_bound("frame.");
  if (frame != reader.failed.end() && frame->starts_with("frame.")) return true;  // no size to go by
  const auto fields = system.list(Stage::presample)[number.entry].component.fields();
  try {
    *detail::number_of(fields[number.field], number.element) += system.mapped(number, {});
    return true;
  } catch (const UsageError& error) {
    reader.error(terms.position, terms.written.empty() ? terms.path : terms.written,
                 std::string(error.what()) + " on the optical axis");
    return false;
  }
}

/// Gives the terms that were read of a component, the `entry`-th of its list, to the system.
void take_over_field(const Section& section, Stage stage, std::size_t entry, System<double>& system) {
  const std::string before = section.path + ".";
  const auto fields = system.list(stage).at(entry).component.fields();
  const FieldMap* faulty = nullptr;  // of many numbers
  std::erase_if(section.reader.terms, [&](const FieldTerms& terms) {
    if (!terms.path.starts_with(before)) return false;
    const auto place = place_of(fields, std::string_view(terms.path).substr(before.size()));
    if (stage != Stage::presample) {
      section.reader.error(terms.position, terms.path,
                           "changes over the field, which components of [[presample]] alone may; write one number");
    } else if (!place || detail::number_of(fields[place->field], place->element) == nullptr) {
      // Something else about it was wrong, and is said.
    } else if (!terms.angle && !terms.map && !terms.fit &&
               std::all_of(terms.coefficient.begin(), terms.coefficient.end(), is_zero)) {
      // The same everywhere.
    } else if (terms.angle) {
      system.field.angles.push_back({entry, place->field});
    } else {
      FieldNumber<double>& number = system.field.numbers.emplace_back(FieldNumber<double>{
          entry, place->field, place->element, terms.coefficient, terms.map, terms.column, terms.factor});
      if (terms.map && terms.map.get() != faulty && !add_axis_value(section.reader, terms, number, system))
        faulty = terms.map.get();
    }
    return true;
  });
  if (stage == Stage::presample) note_maps(section.reader, system, entry, section.table.position, section.path);
  if (stage == Stage::presample) warn_of_kinks(section.reader, system, entry, section.path);
}

}  // namespace

void read_fields(const Section& section, std::span<const FieldRef<double>> fields) {
  std::vector<std::string> known{"kind", "label"};
  for (const auto& field : fields)
    for (std::string& key : keys_of(*field.info)) known.push_back(std::move(key));
  for (const FileKey& key : kFileKeys)
    if (const Node* kind = section.find("kind"); kind != nullptr && kind->text == key.kind) known.emplace_back(key.key);
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
      const std::optional<Node> filled = with_columns(section, component->fields());
      read_fields({root.reader, filled ? *filled : section.table, section.path, section.title}, component->fields());
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

bool is_field_term(std::string_view key) { return key == kConstant || term_of(key); }

bool is_over_field(const Node& node, const FieldInfo& info) {
  if (node.kind == Node::Kind::string) return is_angle(info) && node.text == kTurns;
  if (node.kind != Node::Kind::table || node.members.empty()) return false;
  // Keys of a fit are longer than those of terms, which may be mistyped.
  const auto any = [&](const auto& is) { return std::any_of(node.members.begin(), node.members.end(), is); };
  if (any([](const Member& member) { return member.key == kTableKey || is_field_term(member.key); })) return true;
  constexpr std::size_t kShort = 2;
  return !any([](const Member& member) { return member.key.size() > kShort; });
}

std::optional<Scalar> read_over_field(Reader& reader, const Node& node, const FieldInfo& info,
                                      const std::string& path) {
  reader.positions[path] = node.position;
  FieldTerms terms{.path = path, .position = node.position};
  if (node.kind == Node::Kind::string) {
    terms.angle = true;
    reader.terms.push_back(std::move(terms));
    return Scalar{0.0, find_unit(info.unit)};
  }
  const Section section{reader, node, path, "the terms of " + std::string(info.name)};
  std::vector<std::string_view> known{kTableKey, kConstant};
  known.insert(known.end(), kFieldTerms.begin(), kFieldTerms.end());
  check_keys(section, known);
  std::optional<Scalar> on_axis;
  bool good = !reader.has_failed(path);
  std::optional<Scalar> first;  // in whose unit all are held
  if (const Node* file = node.find(kTableKey)) {
    first = read_column(reader, *file, info, terms);
    good = good && first;
  }
  for (const Member& member : node.members) {
    if (member.key == kTableKey) continue;
    const std::optional<std::size_t> term = term_of(member.key);
    if (!term && member.key != kConstant) {
      good = false;
      continue;
    }
    const bool fit = member.value.kind == Node::Kind::table;
    if (fit && !term && node.find(kTableKey) != nullptr) {  // the parameter would be the sum of both
      section.error(member.key, "cannot be fitted beside a table; fit another term, or write a number");
      good = false;
      continue;
    }
    auto scalar = (fit ? read_fit : read_plain)(reader, member.value, info, section.at(member.key));
    terms.fit = terms.fit || fit;
    if (scalar && first && scalar->unit != first->unit) {
      if (!fit && scalar->unit->dimension == first->unit->dimension &&
          scalar->unit->dimension != Dimension::frequency) {
        scalar = Scalar{convert({scalar->value, scalar->unit}, first->unit->name), first->unit};
      } else {
        section.error(member.key, shown(member.value) + " does not go with terms in " + std::string(first->unit->name) +
                                      "; write all in one unit");
        scalar.reset();
      }
    }
    good = good && scalar;
    if (!scalar) continue;
    if (!first) first = scalar;
    if (term)
      terms.coefficient[*term] = scalar->value;
    else
      on_axis = scalar;
  }
  if (!good) {
    reader.failed.insert(path);
    return std::nullopt;
  }
  reader.terms.push_back(std::move(terms));
  return on_axis.value_or(Scalar{0.0, first->unit});
}

void refuse_over_field(Reader& reader) {
  for (const FieldTerms& terms : reader.terms)
    if (!reader.has_failed(terms.path))
      reader.error(terms.position, terms.path,
                   "cannot change over the field; numbers of [[presample]] components can, here write one number");
  reader.terms.clear();
}

std::string over_field_text(const System<double>& system, std::string_view path, const Scalar& on_axis,
                            const std::function<std::string(const std::string& path, const Scalar& number)>& text_of,
                            const std::function<std::string(const std::string& source)>& file) {
  const std::optional<NumberAt> at = number_at(system, path);
  if (!at) return {};
  for (const FieldAngle& angle : system.field.angles)
    if (angle == FieldAngle{at->entry, at->place.field}) return "\"" + std::string(kTurns) + "\"";
  const FieldNumber<double>* number = at->number;
  if (number == nullptr) return {};
  std::vector<std::string> members;
  const auto add = [&](std::string_view name, double value) {
    const std::string text = text_of(std::string(path) + "." + std::string(name), {value, on_axis.unit});
    if (!text.empty()) members.push_back(std::string(name) + " = " + text);
  };
  if (number->map) members.push_back(std::string(kTableKey) + " = " + toml_string(file(number->map->source)));
  const double constant = number->map ? on_axis.value - system.mapped(*number, {}) : on_axis.value;
  if (constant != 0.0 || !number->map) add(kConstant, constant);
  for (std::size_t i = 0; i < kFieldTerms.size(); ++i) add(kFieldTerms[i], number->coefficient[i]);
  return "{ " + joined(members) + " }";
}

std::shared_ptr<const FieldMap> map_for_member(const System<double>& system, std::string_view path,
                                               const FileKey& key) {
  const bool pair = key.kind == "flow";  // whose numbers may have tables of their own
  const std::optional<NumberAt> first = number_at(system, std::string(path) + (pair ? "_x" : "[0]"));
  if (!first || first->number == nullptr || !first->number->map) return nullptr;
  return !pair || first->number->map->is_image() ? first->number->map : nullptr;
}

}  // namespace mtf::io::cfg
