// SPDX-License-Identifier: Apache-2.0

// [metrics], constraints and objectives.

#include <algorithm>
#include <map>
#include <set>

#include "apps/study/design/metric_rows.h"
#include "apps/study/result_columns.h"
#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/words.h"

namespace study {
namespace {

constexpr std::size_t kMostUnknown = 200;  // guesses what was meant are slow
constexpr std::array<std::string_view, 4> kDirections{"maximize", "minimize", "maximise", "minimise"};

/// The strings of a list at the top level.
std::vector<Source> strings_of(StudyReader& s, const std::string& key) {
  std::vector<Source> sources;
  const Node* list = s.tree.find(key);
  if (list == nullptr) return sources;
  const auto is_string = [](const Node& item) { return item.kind == Node::Kind::string; };
  if (list->kind != Node::Kind::array || !std::all_of(list->items.begin(), list->items.end(), is_string)) {
    if (!s.reader.has_failed(key)) s.error(list->position, key, "has to be a list of expressions in quotes");
  } else if (list->items.size() > kMostExpressions) {
    if (!s.reader.has_failed(key)) s.error(list->position, key, "more than " + std::to_string(kMostExpressions));
  } else {
    for (std::size_t i = 0; i < list->items.size(); ++i)
      sources.push_back({list->items[i].text, list->items[i].position, key + "[" + std::to_string(i) + "]", 0});
  }
  return sources;
}

/// Position of the comparison in a constraint: "< 3", "<= 3"; npos when there is not exactly one.
std::size_t comparison(const std::string& text) {
  const std::size_t at = text.find_first_of("<>");
  if (at == std::string::npos) return at;
  return text.find_first_of("<>=", at + (text.compare(at + 1, 1, "=") == 0 ? 2 : 1)) == std::string::npos
             ? at
             : std::string::npos;
}

Source part_of(const Source& whole, std::size_t from, std::size_t to) {
  return {whole.text.substr(from, to - from), whole.position, whole.path, static_cast<int>(from)};
}

struct ConstraintSides {
  Source left, right;
  bool less = true, strict = true;
};

std::optional<ConstraintSides> sides_of(const Source& source) {
  const std::size_t at = comparison(source.text);
  if (at == std::string::npos) return std::nullopt;
  const bool strict = source.text.compare(at + 1, 1, "=") != 0;
  return ConstraintSides{part_of(source, 0, at), part_of(source, at + (strict ? 1 : 2), source.text.size()),
                         source.text[at] == '<', strict};
}

/// The expression of an objective after its first word; null when that is no direction.
std::optional<Source> goal_of(const Source& source) {
  const std::size_t start = source.text.find_first_not_of(" \t");
  if (start == std::string::npos) return std::nullopt;
  const std::size_t end = std::min(source.text.find_first_of(" \t(", start), source.text.size());
  const std::string_view word = std::string_view(source.text).substr(start, end - start);
  if (std::find(kDirections.begin(), kDirections.end(), word) == kDirections.end()) return std::nullopt;
  const std::size_t body = std::min(source.text.find_first_not_of(" \t", end), source.text.size());
  return part_of(source, body, source.text.size());
}

/// "150", not "150 urad" and not 0, which is the same in every unit.
bool is_bare_number(std::string_view text) { return mtf::io::cell_number(text).value_or(0.0) != 0.0; }

void read_constraint(StudyReader& s, const Source& source) {
  const auto sides = sides_of(source);
  if (!sides)
    return s.error_in(source, 0,
                      "has to compare two expressions with one of <, <=, >, >=, such as \"mtf_nyquist > 0.1\"");
  auto left = read_expression(s, sides->left, true);
  auto right = read_expression(s, sides->right, true);
  if (!left || !right) return;
  if (left->dimensions() != right->dimensions())
    return s.error_in(source, 0,
                      "compares " + describe(left->dimensions()) + " with " + describe(right->dimensions()) +
                          "; give both sides one kind of unit");
  for (const auto& [name, number] : {std::pair{&*left, &*right}, std::pair{&*right, &*left}})
    if (const auto slot = name->only_slot(); slot && is_bare_number(mtf::trimmed(number->text())))
      if (const std::string& unit = s.study.unit_of(*slot); unit_scale(unit).si != 1.0)
        return s.error_in(source, 0,
                          "compares " + std::string(mtf::trimmed(name->text())) + ", which is in " + unit + ", with " +
                              std::string(mtf::trimmed(number->text())) +
                              ", which has no unit; write it with its unit, such as 5 " + unit);
  if (left->constant() && right->constant())
    return s.error_in(source, 0, "has no name in it: it holds for every design or for none");
  s.study.constraints.push_back({.text = source.text,
                                 .left = std::move(*left),
                                 .right = std::move(*right),
                                 .less = sides->less,
                                 .strict = sides->strict});
}

void read_objective(StudyReader& s, const Source& source) {
  const auto goal = goal_of(source);
  if (!goal)
    return s.error_in(source, 0,
                      "begins with neither maximize nor minimize; write for example \"maximize niirs_giqe5\"");
  auto expression = read_expression(s, *goal, true);
  if (!expression) return;
  if (expression->constant()) return s.error_in(*goal, 0, "has no name in it: all designs are equal");
  Objective objective{.text = std::string(mtf::trimmed(goal->text)),
                      .maximize = source.text.find("maxim") < static_cast<std::size_t>(goal->column),
                      .expression = std::move(*expression),
                      .unit = {},
                      .si = 1.0};
  if (const auto slot = objective.expression.only_slot()) {
    objective.unit = s.study.unit_of(*slot);
    objective.si = unit_scale(objective.unit).si;
  } else {
    objective.unit = si_unit(objective.expression.dimensions());
  }
  for (const Objective& other : s.study.objectives)
    if (other.text == objective.text) return s.error_in(source, 0, "is an objective already; leave one of them");
  s.study.objectives.push_back(std::move(objective));
}

std::vector<std::string_view> names_of_metrics() {
  std::vector<std::string_view> names{"mtf_at_20_cy_mm"};
  for (const MetricInfo& metric : metric_catalogue()) names.push_back(metric.name);
  return names;
}

/// A name in an expression that nothing has. It may have been meant for a metric, a parameter or one of the study's own
/// numbers; parameters are found by their key alone too.
std::string unknown_name(const StudyReader& s, const std::string& name) {
  std::vector<std::string_view> known = names_of_metrics();
  for (const auto& [own, index] : s.by_name) known.push_back(own);
  for (const auto& [full, target] : s.views.front().targets) {
    known.push_back(full);
    known.push_back(target.key);
  }
  const auto guess = name.size() > 1 && name.size() <= 64 ? mtf::nearest(name, known) : std::nullopt;
  return "the sensor has no parameter of that name, and there is no such metric; " +
         (guess ? "did you mean " + *guess + "?"
                : "mtf config explain shows the parameters, apps/study/README.md the metrics");
}

std::string unknown_metric(const std::string& name) {
  const std::vector<std::string_view> known = names_of_metrics();
  const auto guess = name.size() <= 64 ? mtf::nearest(name, known) : std::nullopt;
  const std::string unknown = "unknown metric \"" + mtf::printable(name, 60) + "\"; ";
  const std::string figure = name.substr(0, name.rfind('.'));
  if (const auto same = find_metric(figure); same && figure != name)
    return unknown + (choose_metric(figure + ".mean") ? "after the dot stands axis, mean or worst"
                      : choose_metric(figure)->row->effort != Effort::geometry
                          ? figure + " is that of the optical axis; write it alone"
                          : figure + " is the same all over the image; write it alone");
  if (guess) return unknown + "did you mean \"" + *guess + "\"?";
  std::string all;
  for (const MetricRow& row : metric_rows()) all += std::string(row.name) + ", ";
  return unknown + "there are " + all + "and mtf_at_20_cy_mm at any frequency in cy_mm, cy_px or cy_mrad";
}

void add_metric(StudyReader& s, const MetricInfo& metric, const std::string& as) {
  s.metric_names.push_back(as);
  s.study.metrics.push_back(metric);
}

}  // namespace

void read_metrics(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "metrics");
  if (table != nullptr) {
    const Section section{s.reader, *table, "metrics", "[metrics]"};
    check_study_keys(section, kMetricsKeys);
    const Node* list = section.find("list");
    if (list != nullptr && list->items.size() > kMostExpressions) {
      section.error("list", "more than " + std::to_string(kMostExpressions));
      list = nullptr;
    }
    if (list != nullptr && list->kind != Node::Kind::array)
      section.error("list", cfg::shown(*list) + " has to be a list of names, such as [\"mtf_nyquist\"]");
    for (const Node& item : list != nullptr ? list->items : std::vector<Node>()) {
      if (item.kind != Node::Kind::string) {
        s.error(item.position, "metrics.list", cfg::shown(item) + " has to be the name of a metric in quotes");
        continue;
      }
      const auto metric = item.text.size() <= 200 ? find_metric(item.text) : std::nullopt;
      if (!metric)
        s.error(item.position, "metrics.list", unknown_metric(item.text));
      else if (std::find(s.metric_names.begin(), s.metric_names.end(), item.text) != s.metric_names.end())
        s.warn(item.position, "metrics.list", item.text + " is listed twice");
      else
        add_metric(s, *metric, item.text);
    }
  }
  if (table == nullptr && s.tree.find("constraints") == nullptr && s.tree.find("objectives") == nullptr)
    s.error({}, "metrics",
            "neither metrics nor objectives are given; write [metrics] with list = [\"mtf_nyquist\"], or objectives");
}

std::vector<Source> goal_sources(StudyReader& s) {
  std::vector<Source> sources;
  for (const Source& constraint : strings_of(s, "constraints"))
    if (const auto sides = sides_of(constraint)) sources.insert(sources.end(), {sides->left, sides->right});
  for (const Source& objective : strings_of(s, "objectives"))
    if (const auto goal = goal_of(objective)) sources.push_back(*goal);
  return sources;
}

void register_names(StudyReader& s, const std::vector<Source>& sources) {
  for (const Source& source : sources)
    for (const NameAt& at : names_in(source.text)) {
      if (s.why.contains(at.name) || at.name.size() > 200) continue;
      if (std::find(s.metric_names.begin(), s.metric_names.end(), at.name) != s.metric_names.end()) continue;
      if (const auto metric = find_metric(at.name)) {
        add_metric(s, *metric, at.name);
        continue;
      }
      if (s.by_name.contains(at.name)) continue;
      std::string problem = "one unknown name of many";
      if (s.why.size() < kMostUnknown) {
        if (parameter_named(s, at.name, problem) >= 0) continue;
        if (at.name != "sensor" && find_place(s.views.front(), at.name).unknown) problem = unknown_name(s, at.name);
      }
      s.why[at.name] = "'" + at.name + "': " + problem;
    }
}

void read_goals(StudyReader& s) {
  for (const Source& constraint : strings_of(s, "constraints")) read_constraint(s, constraint);
  for (const Source& objective : strings_of(s, "objectives")) read_objective(s, objective);
}

void check_gaps(StudyReader& s) {
  std::map<std::string, std::string> gaps;  // by metric: the answer is computed once for each
  for (const char* key : {"constraints", "objectives"})
    for (const Source& source : strings_of(s, key))
      for (const NameAt& at : names_in(source.text)) {
        const auto metric = std::find(s.metric_names.begin(), s.metric_names.end(), at.name);
        if (metric == s.metric_names.end()) continue;
        const auto [gap, fresh] = gaps.try_emplace(at.name);
        if (fresh)
          gap->second = metric_gap(s.study.metrics[static_cast<std::size_t>(metric - s.metric_names.begin())], s.study);
        if (!gap->second.empty())
          s.error_in(source, at.column, "needs " + at.name + ", which no design has: " + gap->second);
      }
}

std::vector<mtf::io::Diagnostic> listed_gaps(const Study& study) {
  std::vector<mtf::io::Diagnostic> gaps;
  const cfg::Tree tree = cfg::read_tree(study.text);
  const Node* table = tree.root.find("metrics");
  const Node* list = table != nullptr ? table->find("list") : nullptr;
  if (list == nullptr) return gaps;
  for (const Node& item : list->items)
    if (const auto metric = find_metric(item.text))
      if (const std::string gap = metric_gap(*metric, study); !gap.empty())
        gaps.push_back({.error = true,
                        .position = item.position,
                        .path = "metrics.list",
                        .text = item.text + " is asked of designs that cannot have it: " + gap +
                                "; add that, or take the metric from the list"});
  return gaps;
}

void check_column_names(StudyReader& s) {
  std::set<std::string> taken{"design"};
  for (const Column& column : file_columns(s.study))
    if (column.role == Column::Role::feasible || column.role == Column::Role::yield ||
        column.role == Column::Role::error || column.role == Column::Role::pareto)
      taken.insert(column.name);
  const std::string problem = " is a column of designs.csv already; take another name";
  for (std::size_t a = 0; a < s.study.axes.size(); ++a)
    if (const std::string& name = s.study.parameters[a].name; s.own.contains(name) && taken.contains(name))
      s.error(s.tree.find("axis")->items[a].find("name")->position, "axis[" + std::to_string(a) + "].name",
              name + problem);
  for (const LinkSource& link : s.links)
    if (link.own && taken.contains(link.target)) s.error(link.target_at, link.source.path, link.target + problem);
}

}  // namespace study
