// SPDX-License-Identifier: Apache-2.0

// [[axis]] and [sampling]: what varies, over which values, and how many designs that makes.

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

#include "apps/study/statistics/sampling.h"
#include "apps/study/study.h"
#include "apps/study/study_reader.h"
#include "apps/study/study_shape.h"
#include "mtf/words.h"

namespace study {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Unit of "15 um"; null for a plain number and for what is none.
const mtf::Unit* unit_in(const Node& node) {
  if (node.kind != Node::Kind::string) return nullptr;
  std::string_view text = mtf::trimmed(node.text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status == std::errc::invalid_argument) return nullptr;
  return mtf::find_unit(mtf::trimmed(text.substr(static_cast<std::size_t>(end - text.data()))));
}

/// A number of the study's own has the unit of its first value.
mtf::FieldInfo own_info(const Node* first) {
  mtf::FieldInfo info{.name = "value", .lo = -kInfinity, .hi = kInfinity, .example = "4.0"};
  if (const mtf::Unit* unit = first != nullptr ? unit_in(*first) : nullptr) {
    info.dimension = unit->dimension;
    info.unit = unit->name;
  }
  return info;
}

/// True when a value of the list can only be set in the file: another kind of unit, or a file in place of a number.
bool needs_file(const Place& place, const Node& node) {
  if (node.kind != Node::Kind::string) return node.kind == Node::Kind::array || node.kind == Node::Kind::boolean;
  const mtf::Unit* unit = unit_in(node);
  if (unit == nullptr) return place.file;
  return place.info.dimension == mtf::Dimension::extent &&
         unit->dimension != mtf::find_unit(place.info.unit)->dimension;
}

/// One [[axis]] table becomes an Axis and its Parameter.
struct AxisReader {
  StudyReader& s;
  Section section;
  Axis axis{};
  Parameter parameter{};
  mtf::FieldInfo info{};
  std::optional<Place> place{};
  bool discrete = false, good = true;

  void fail(std::string_view key, const std::string& text) {
    section.error(key, text);
    good = false;
  }

  std::string given() const { return place ? "in the sensor file" : "in the first value"; }

  void identify() {
    const auto own = cfg::read_string(section, "name");
    const auto named = cfg::read_string(section, "parameter");
    if (section.find("name") != nullptr && section.find("parameter") != nullptr)
      return fail("name", "given together with parameter; name is for numbers of the study's own, remove one of them");
    if (own) return identify_own(*own);
    if (!named) {
      if (section.find("name") == nullptr && section.find("parameter") == nullptr)
        fail("parameter", "missing; write for example parameter = \"optics.aperture\"");
      good = false;
      return;
    }
    if (*named == "sensor") {
      discrete = true;
      parameter = {.name = *named, .path = *named, .unit = {}, .scale = {}};
      return;
    }
    const Found found = find_place(s.views.front(), *named);
    if (!found.place) return fail("parameter", found.problem);
    place = found.place;
    discrete = place->kind == Place::Kind::level;
    info = place->info;
    parameter = parameter_of(*named, *place);
    check_taken();
  }

  void identify_own(const std::string& name) {
    if (!is_identifier(name) || name == "sensor")
      return fail("name", "\"" + mtf::printable(name, 60) +
                              "\" is no name that an expression can have: letters, "
                              "digits and _, and none of its functions");
    if (find_metric(name)) return fail("name", name + " is a metric; take another name");
    if (s.own.contains(name)) return fail("name", name + " is the name of another axis already");
    s.own.insert(name);
    const Node* values = section.find("values");
    const Node* first = values == nullptr                                             ? section.find("from")
                        : values->kind == Node::Kind::array && !values->items.empty() ? &values->items[0]
                                                                                      : nullptr;
    info = own_info(first);
    parameter = {.name = name,
                 .path = {},
                 .unit = std::string(info.unit),
                 .scale = unit_scale(info.unit),
                 .lo = info.lo,
                 .hi = info.hi,
                 .lo_open = false,
                 .hi_open = false,
                 .role = Parameter::Role::axis,
                 .base = std::numeric_limits<double>::quiet_NaN()};
    if (const Found found = find_place(s.views.front(), name); found.place)
      s.warn(section.table.position, section.path,
             name + " is a number of the study's own; the sensor has " + found.place->target.path() +
                 " too, which this does not change (parameter = \"" + name + "\" would)");
  }

  void check_taken() {
    for (std::size_t i = 0; i < s.study.parameters.size(); ++i) {
      const Parameter& other = s.study.parameters[i];
      if (!overlap(other.path, parameter.path)) continue;
      return fail("parameter", (other.path == parameter.path ? "is" : "overlaps") + std::string(" the axis ") +
                                   std::to_string(i + 1) + " (" + other.name + ") already; leave one of them");
    }
  }

  void read_values() {
    const Node& values = *section.find("values");
    for (const char* key : {"from", "to", "count", "scale"})
      if (section.find(key) != nullptr) fail(key, "given together with values; an axis is a list or a range");
    if (values.kind != Node::Kind::array || values.items.empty())
      return fail("values", values.kind == Node::Kind::array
                                ? "an empty list: no design would be left"
                                : cfg::shown(values) + " has to be a list; write values = [...]");
    if (place && place->kind == Place::Kind::number)
      discrete = std::any_of(values.items.begin(), values.items.end(),
                             [&](const Node& node) { return needs_file(*place, node); });
    if (discrete) return read_levels(values);
    for (const Node& node : values.items) {
      const auto number = read_held(s, node, info, section.at("values"), given());
      good = good && number;
      axis.values.push_back(number.value_or(0.0));
    }
    if (good) require_each_once(values, axis.values);
  }

  /// A value that stands twice would be swept twice. `read`: of the nodes, one for each.
  template <class T>
  void require_each_once(const Node& values, const std::vector<T>& read) {
    std::map<T, std::size_t> first;
    for (std::size_t i = 0; i < read.size(); ++i) {
      const auto [known, is_new] = first.try_emplace(read[i], i);
      if (is_new) continue;
      const Node& same = values.items[known->second];
      s.error(values.items[i].position, section.at("values"),
              cfg::shown(values.items[i]) + " is the value " + cfg::shown(same) +
                  " of this list again; its designs would be swept twice, so remove one of them");
      good = false;
    }
  }

  void read_levels(const Node& values) {
    const auto whole = [](const Node& node) { return node.kind == Node::Kind::integer; };
    const bool numbers = std::all_of(values.items.begin(), values.items.end(), whole);
    for (std::size_t i = 0; i < values.items.size(); ++i) {
      axis.levels.push_back(level_text(values.items[i]));
      axis.values.push_back(numbers ? values.items[i].number : static_cast<double>(i));
    }
    require_each_once(values, axis.levels);
    const auto [lo, hi] = std::minmax_element(axis.values.begin(), axis.values.end());
    parameter.unit = {};
    parameter.scale = {};
    parameter.lo = *lo;
    parameter.hi = *hi;
    parameter.lo_open = parameter.hi_open = false;
    parameter.base = std::numeric_limits<double>::quiet_NaN();
    if (!numbers)
      s.why[parameter.name] =
          parameter.name + " is an axis of words, files or lists here; only numbers can be used in " + "an expression";
  }

  void read_range() {
    if (discrete)
      return fail("parameter", parameter.name + " is " + (place ? place->what : "a file") +
                                   ", which has no range; write values = [...]");
    for (const char* key : {"from", "to"})
      if (section.find(key) == nullptr) fail(key, "missing; an axis has values = [...], or from and to");
    const Node *from = section.find("from"), *to = section.find("to");
    if (!good) return;
    const auto lo = read_held(s, *from, info, section.at("from"), given()),
               hi = read_held(s, *to, info, section.at("to"), given());
    if (const auto scale = cfg::read_word(section, "scale", kScales)) axis.scale = static_cast<Scale>(*scale);
    good = good && lo && hi && !s.reader.has_failed(section.at("scale"));
    if (!good) return;
    axis.from = *lo;
    axis.to = *hi;
    if (axis.scale == Scale::log && !(*lo > 0.0 && *hi > 0.0))
      fail(*lo > 0.0 ? "to" : "from", "has to be above 0 for scale = \"log\"; take \"linear\" or another end");
  }

  void read_count(Method method) {
    const Node* count = section.find("count");
    if (discrete) return;
    if (count == nullptr) {
      if (method == Method::grid)
        return fail("count", "missing; write count = 11, the points of a grid along this axis");
    } else if (count->kind != Node::Kind::integer || count->integer < 1) {
      return fail("count", cfg::shown(*count) + " has to be a whole number from 1 on");
    }
    const std::int64_t points = count != nullptr ? count->integer : 2;
    axis.count = static_cast<int>(std::min<std::int64_t>(points, std::numeric_limits<int>::max()));
    if (!good) return;
    if (axis.from == axis.to && (points > 1 || method != Method::grid))
      fail("to", "is the same as from: all designs would be equal along this axis; write values = [" +
                     cfg::shown(*section.find("from")) + "]");
    else if (points == 1 && axis.from != axis.to && method == Method::grid)
      s.warn(count->position, section.at("count"), "one point only: from; the rest of the range is not used");
  }

  void read(Method method) {
    check_study_keys(section, kAxisKeys);
    identify();
    if (!good) return;
    if (section.find("values") != nullptr)
      read_values();
    else
      read_range();
    if (section.find("values") == nullptr) read_count(method);
  }
};

std::optional<Method> method_of(StudyReader& s) {
  const Node* table = s.tree.find("sampling");
  const Node* method = table != nullptr ? table->find("method") : nullptr;
  if (method == nullptr || method->text == "grid") return Method::grid;
  if (method->text == "latin_hypercube") return Method::latin_hypercube;
  return method->text == "sobol" ? std::optional(Method::sobol) : std::nullopt;
}

constexpr const char* kFewer =
    "take [sampling] with method = \"latin_hypercube\" or \"sobol\" and points = 4096, or fewer points";

void count_variants(StudyReader& s, mtf::io::Position position) {
  std::vector<std::int64_t> levels;
  for (const Axis& axis : s.study.axes)
    if (axis.discrete()) levels.push_back(axis.points());
  s.study.variants = bounded_product(levels, kMostVariants);
  if (s.study.variants > kMostVariants)
    s.error(position, "axis",
            "the axes of words, files, lists and whole numbers combine to " + exact_product(levels) +
                " sensors, at most " + std::to_string(kMostVariants) + " are read; give fewer values");
}

double between(const Axis& axis, double fraction) {
  if (fraction <= 0.0) return axis.from;
  if (fraction >= 1.0) return axis.to;
  const double value = axis.scale == Scale::log
                           ? std::exp((1.0 - fraction) * std::log(axis.from) + fraction * std::log(axis.to))
                           : axis.from * (1.0 - fraction) + axis.to * fraction;
  return std::clamp(value, std::min(axis.from, axis.to), std::max(axis.from, axis.to));
}

/// Point of a grid; of a discrete axis the index of its level.
double grid_value(const Axis& axis, std::int64_t i) {
  if (axis.discrete()) return static_cast<double>(i);
  if (!axis.values.empty()) return axis.values[static_cast<std::size_t>(i)];
  if (axis.count < 2) return axis.from;
  const double last = axis.count - 1, step = static_cast<double>(i);
  if (axis.scale == Scale::linear && 0.0 < step &&
      step < last) {  // round numbers stay round: 16 mm of 12 to 96 mm, not 15.999999999999998
    const double value = (axis.from * (last - step) + axis.to * step) / last;
    if (std::isfinite(value)) return value;
  }
  return between(axis, step / last);
}

double quantile(const Axis& axis, double u) {
  if (axis.values.empty()) return between(axis, u);
  const auto n = static_cast<std::int64_t>(axis.values.size());
  const auto i = static_cast<std::int64_t>(std::floor(std::clamp(u, 0.0, 1.0) * static_cast<double>(n)));
  return grid_value(axis, std::min(i, n - 1));
}

}  // namespace

void read_axes(StudyReader& s) {
  const Node* list = cfg::find_tables(s.root(), "axis");
  const auto stop = [&](mtf::io::Position position, const std::string& text) {
    if (!text.empty()) s.error(position, "axis", text);
    s.axes_good = false;
  };
  if (list == nullptr)
    return stop({}, s.tree.find("axis") != nullptr
                        ? ""
                        : "missing; write [[axis]] with parameter and values for each thing that varies");
  if (list->items.empty())
    return stop(list->position, "no axis: nothing varies; write [[axis]] with parameter and values");
  if (list->items.size() > kMostAxes)
    return stop(list->position, std::to_string(list->items.size()) + " axes, at most " + std::to_string(kMostAxes));
  const Method method = method_of(s).value_or(Method::grid);
  for (std::size_t i = 0; i < list->items.size(); ++i) {
    const std::string path = "axis[" + std::to_string(i) + "]";
    AxisReader axis{.s = s, .section = {s.reader, list->items[i], path, "[[axis]]"}};
    axis.read(method);
    s.axes_good = s.axes_good && axis.good;
    axis.axis.parameter = static_cast<int>(i);
    axis.parameter.role = Parameter::Role::axis;
    if (!axis.parameter.name.empty()) s.by_name.try_emplace(axis.parameter.name, static_cast<int>(i));
    s.study.axes.push_back(std::move(axis.axis));
    s.study.parameters.push_back(std::move(axis.parameter));
  }
}

void read_sampling(StudyReader& s) {
  const Section root = s.root();
  const Node* table = cfg::find_table(root, "sampling");
  const Node* points = nullptr;
  mtf::io::Position position = s.reader.positions["axis"];
  if (table != nullptr) {
    const Section section{s.reader, *table, "sampling", "[sampling]"};
    check_study_keys(section, kSamplingKeys);
    if (const auto word = cfg::read_word(section, "method", kMethods))
      s.study.method = static_cast<Method>(*word);
    else if (section.find("method") != nullptr)
      return;
    points = section.find("points");
    position = table->position;
    if (s.study.method == Method::grid && points != nullptr)
      section.error("points",
                    "a grid has the points of its axes; write method = \"latin_hypercube\" or \"sobol\", or "
                    "remove it");
    if (s.study.method != Method::grid && points == nullptr)
      return section.error("points", "missing; write for example points = 4096");
    if (s.study.method != Method::grid &&
        (points->kind != Node::Kind::integer || points->integer < 1 || points->integer > kMostDesigns))
      return section.error(
          "points", cfg::shown(*points) + " has to be a whole number in [1, " + std::to_string(kMostDesigns) + "]");
  }
  if (!s.axes_good) return;
  if (s.study.method == Method::grid) {
    std::vector<std::int64_t> counts;
    for (std::size_t i = 0; i < s.study.axes.size(); ++i) {
      const Node* count = s.tree.find("axis")->items[i].find("count");
      counts.push_back(s.study.axes[i].values.empty() ? count->integer : s.study.axes[i].points());
    }
    s.study.designs = bounded_product(counts, kMostDesigns);
    if (s.study.designs > kMostDesigns)
      s.error(position, "axis",
              "the grid has " + exact_product(counts) + " designs, at most " + std::to_string(kMostDesigns) +
                  " are computed; " + kFewer);
  } else {
    s.study.designs = points->integer;
    if (s.study.method == Method::sobol) s.study.sobol = sobol_axes(s.study.axes.size());
  }
  count_variants(s, s.reader.positions["axis"]);
}

// From the number of a design to the values of its axes.

void design_at(const Study& study, std::int64_t design, std::span<double> axis_values) {
  assert(axis_values.size() == study.axes.size() && design >= 0 && design < study.designs);
  const auto i = static_cast<std::uint64_t>(design), n = static_cast<std::uint64_t>(study.designs);
  if (study.method == Method::grid) {
    for (std::size_t a = study.axes.size(); a-- > 0;) {
      const Axis& axis = study.axes[a];
      const std::int64_t points = axis.points();
      axis_values[a] = grid_value(axis, design % points);
      design /= points;
    }
    return;
  }
  for (std::size_t a = 0; a < study.axes.size(); ++a) {
    const auto number = static_cast<std::uint32_t>(a);
    const double u = study.method == Method::sobol ? sobol(study.sobol[a], i, number, study.seed)
                                                   : latin_hypercube(i, n, number, study.seed);
    axis_values[a] = quantile(study.axes[a], u);
  }
}

void design_at_quantiles(const Study& study, std::span<const double> unit, std::span<double> axis_values) {
  assert(unit.size() == study.axes.size() && axis_values.size() == study.axes.size());
  for (std::size_t a = 0; a < study.axes.size(); ++a) axis_values[a] = quantile(study.axes[a], unit[a]);
}

}  // namespace study
