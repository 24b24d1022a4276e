// SPDX-License-Identifier: Apache-2.0

// [links] and [[as_built]]: parameters that follow from others, and what varies about its design value.

#include <algorithm>
#include <cmath>

#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"
#include "mtf/words.h"

namespace study {
namespace {

/// `a.b = "..."` in TOML is a table in a table: their keys joined again.
void collect(StudyReader& s, const Node& table, const std::string& before) {
  for (const cfg::Member& member : table.members) {
    const std::string name = before + member.key;
    const std::string path = "links." + mtf::printable(name, 80);
    if (member.value.kind == Node::Kind::table) {
      collect(s, member.value, name + ".");
    } else if (member.value.kind == Node::Kind::string) {
      s.links.push_back({name, member.position, {member.value.text, member.value.position, path, 0}});
    } else {
      s.error(member.value.position, path,
              cfg::shown(member.value) + " has to be an expression in quotes, such as \"f_number * aperture\"");
    }
  }
}

/// Names that links, constraints and objectives read, and the link that does when it is the only one, else -1.
std::map<std::string, int, std::less<>> readers_of(const StudyReader& s) {
  std::map<std::string, int, std::less<>> readers;
  const auto add = [&](const std::string& text, int reader) {
    for (const NameAt& at : names_in(text)) {
      const auto [known, fresh] = readers.try_emplace(at.name, reader);
      if (!fresh && known->second != reader) known->second = -1;
    }
  };
  for (std::size_t i = 0; i < s.links.size(); ++i) add(s.links[i].source.text, static_cast<int>(i));
  for (const char* key : {"constraints", "objectives"})
    if (const Node* list = s.tree.find(key); list != nullptr)
      for (const Node& item : list->items)
        if (item.kind == Node::Kind::string) add(item.text, -1);
  return readers;
}

void declare(StudyReader& s, LinkSource& link, bool read_by_others) {
  const std::string path = link.source.path;
  const auto fail = [&](const std::string& text) { s.error(link.target_at, path, text); };
  const auto clashes = [&](const Parameter& other) {
    if (other.role == Parameter::Role::axis)
      return fail("is an axis already; it cannot follow from others too: remove one of them");
    fail("is linked twice (" + other.name + "); leave one of them");
  };
  if (const auto known = s.by_name.find(link.target); known != s.by_name.end())
    return clashes(s.study.parameters[static_cast<std::size_t>(known->second)]);
  const Found found = find_place(s.views.front(), link.target);
  Parameter parameter;
  if (found.place) {
    parameter = parameter_of(link.target, *found.place);
    for (const Parameter& other : s.study.parameters)
      if (overlap(other.path, parameter.path)) return clashes(other);
    if (found.place->kind != Place::Kind::number)
      return fail("is " + found.place->what + "; only numbers follow from others");
  } else {
    // A name that something reads is a number of the study's own; one that nothing reads is misspelt.
    if (!is_identifier(link.target) || !read_by_others) return fail(found.problem);
    if (find_metric(link.target)) return fail(link.target + " is a metric; take another name");
    parameter = {.name = link.target, .path = {}, .unit = {}, .scale = {}, .lo = -HUGE_VAL, .hi = HUGE_VAL};
    parameter.base = std::nan("");
    link.own = true;
    s.own.insert(link.target);
  }
  parameter.role = Parameter::Role::link;
  link.parameter = static_cast<int>(s.study.parameters.size());
  s.by_name.emplace(link.target, link.parameter);
  s.by_name.emplace(parameter.name, link.parameter);
  s.study.parameters.push_back(std::move(parameter));
}

/// Links in the order of what they read; those on a cycle are reported and left out.
class LinkOrder {
 public:
  explicit LinkOrder(StudyReader& s) : s_(s), state_(s.links.size()) {
    for (std::size_t i = 0; i < s.links.size(); ++i) {
      if (s.links[i].parameter >= 0) by_parameter_[s.links[i].parameter] = i;
    }
  }

  std::vector<std::size_t> sorted() {
    for (std::size_t i = 0; i < s_.links.size(); ++i)
      if (s_.links[i].parameter >= 0) visit(i);
    return order_;
  }

 private:
  enum class State { fresh, open, done };

  void visit(std::size_t i) {
    if (state_[i] == State::done) return;
    if (state_[i] == State::open) return report(i);
    state_[i] = State::open;
    path_.push_back(i);
    for (const NameAt& at : names_in(s_.links[i].source.text))
      if (const auto known = s_.by_name.find(at.name); known != s_.by_name.end())
        if (const auto next = by_parameter_.find(known->second); next != by_parameter_.end()) visit(next->second);
    path_.pop_back();
    state_[i] = State::done;
    order_.push_back(i);
  }

  void report(std::size_t i) {
    const auto first = std::find(path_.begin(), path_.end(), i);
    std::string cycle;
    for (auto at = first; at != path_.end(); ++at) {
      cycle += s_.links[*at].target + " -> ";
      s_.reader.failed.insert(s_.links[*at].source.path);
    }
    s_.error(s_.links[i].target_at, s_.links[i].source.path,
             first + 1 == path_.end()
                 ? "follows from itself; name another parameter in its expression"
                 : "follows from itself: " + mtf::printable(cycle, 600) + s_.links[i].target + "; break the cycle");
  }

  StudyReader& s_;
  std::vector<State> state_;
  std::map<int, std::size_t> by_parameter_;
  std::vector<std::size_t> path_, order_;
};

/// "2 %" as a fraction; null for anything else.
std::optional<double> percent(const Node& node) {
  if (node.kind != Node::Kind::string || !node.text.ends_with('%')) return std::nullopt;
  const auto none = [](std::string_view) { return std::optional<Symbol>(); };
  try {
    const Expression value = Expression::parse(node.text, none, {});
    return value.dimensions().plain() ? std::optional(value.evaluate<double>({})) : std::nullopt;
  } catch (const ExpressionError&) {
    return std::nullopt;
  }
}

void read_variation(StudyReader& s, const Node& table, std::size_t index) {
  const std::string path = "as_built[" + std::to_string(index) + "]";
  const Section section{s.reader, table, path, "[[as_built]]"};
  check_study_keys(section, kAsBuiltKeys);
  const auto name = cfg::read_string(section, "parameter");
  if (!name) {
    if (!s.reader.has_failed(section.at("parameter")))
      section.error("parameter", "missing; write for example parameter = \"optics.obscuration\"");
    return;
  }
  const Node *sd = section.find("sd"), *half = section.find("plus_minus");
  if ((sd != nullptr) == (half != nullptr))
    return section.error(sd != nullptr ? "plus_minus" : "sd",
                         sd != nullptr ? "given together with sd; leave one of them"
                                       : "missing; write sd (normal) or plus_minus (uniform)");
  if (!s.axes_good) return;
  std::string problem;
  const int parameter = parameter_named(s, *name, problem);
  if (parameter < 0) return section.error("parameter", problem);
  const Parameter& varied = s.study.parameters[static_cast<std::size_t>(parameter)];
  if (varied.path.empty())
    return section.error("parameter", "is a number of the study's own; name the parameter of the sensor that varies");
  const auto is_axis = [&](const Axis& axis) { return axis.parameter == parameter && axis.discrete(); };
  if (std::any_of(s.study.axes.begin(), s.study.axes.end(), is_axis))
    return section.error("parameter", "is a discrete axis; only numbers vary as built");
  for (const AsBuilt& other : s.study.as_built)
    if (other.parameter == parameter ||
        overlap(s.study.parameters[static_cast<std::size_t>(other.parameter)].path, varied.path))
      return section.error("parameter", "varies in another [[as_built]] already; leave one of them");
  AsBuilt built{.parameter = parameter, .law = sd != nullptr ? AsBuilt::Law::normal : AsBuilt::Law::uniform};
  const Node& spread = sd != nullptr ? *sd : *half;
  const std::string_view key = sd != nullptr ? "sd" : "plus_minus";
  if (const auto fraction = percent(spread)) {
    built.relative = true;
    built.spread = *fraction;
  } else {
    const mtf::Unit* unit = varied.unit.empty() ? nullptr : mtf::find_unit(varied.unit);
    mtf::FieldInfo info{.name = key, .lo = -HUGE_VAL, .hi = HUGE_VAL, .example = "0.01"};
    if (unit != nullptr) {
      info.unit = unit->name;
      const bool absolute = unit->dimension == mtf::Dimension::temperature;
      info.dimension = absolute ? mtf::Dimension::temperature_difference : unit->dimension;
    }
    const auto number = read_held(s, spread, info, section.at(key));
    if (!number) return;
    built.spread = *number;
  }
  if (!(built.spread > 0.0) || !std::isfinite(built.spread))
    return section.error(key, cfg::shown(spread) + " has to be above 0");
  s.study.as_built.push_back(built);
}

}  // namespace

void read_links(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "links");
  if (table == nullptr) return;
  collect(s, *table, "");
  if (s.links.size() > kMostExpressions) {
    s.error(table->position, "links", "more than " + std::to_string(kMostExpressions));
    s.links.clear();
  }
  if (!s.axes_good) return;
  const auto readers = readers_of(s);
  for (std::size_t i = 0; i < s.links.size(); ++i) {
    const auto reader = readers.find(s.links[i].target);
    declare(s, s.links[i], reader != readers.end() && reader->second != static_cast<int>(i));
  }
}

void read_link_expressions(StudyReader& s) {
  for (const std::size_t i : LinkOrder(s).sorted()) {
    const LinkSource& link = s.links[i];
    if (s.reader.failed.contains(link.source.path)) continue;
    auto expression = read_expression(s, link.source, false);
    if (!expression) {
      if (link.own) s.why[link.target] = "its link is wrong";
      continue;
    }
    Parameter& parameter = s.study.parameters[static_cast<std::size_t>(link.parameter)];
    if (link.own) {
      parameter.scale = {expression->dimensions(), 1.0};
      parameter.unit = si_unit(expression->dimensions());
    } else if (expression->dimensions() != parameter.scale.dimensions) {
      s.error_in(link.source, 0,
                 parameter.name + " is " + describe(parameter.scale.dimensions) + ", the expression is " +
                     describe(expression->dimensions()));
      continue;
    }
    s.study.links.push_back({link.parameter, std::move(*expression)});
  }
}

void read_as_built(StudyReader& s) {
  const Node* list = cfg::find_tables(s.root(), "as_built");
  if (list == nullptr) {
    s.study.draws = 0;
    return;
  }
  if (list->items.size() > kMostExpressions)
    return s.error(list->position, "as_built", "more than " + std::to_string(kMostExpressions));
  for (std::size_t i = 0; i < list->items.size(); ++i) read_variation(s, list->items[i], i);
  if (s.study.draws == 0) s.study.draws = 200;
  const Node* constraints = s.tree.find("constraints");
  if (constraints == nullptr || constraints->items.empty())
    s.warn(list->position, "as_built",
           "without constraints every draw is good; write constraints = [...] to get a yield");
}

}  // namespace study
