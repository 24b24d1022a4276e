// SPDX-License-Identifier: Apache-2.0
#include "apps/report/report_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>

#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/sha256.h"
#include "mtf/units.h"

namespace apps {
namespace {

namespace fs = std::filesystem;

/// A value of sweep.json with its place, for messages.
class Node {
 public:
  Node(const Json& json, std::string where) : json_(&json), where_(std::move(where)) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw mtf::UsageError(one_line(where_) + ": " + what + "; run `mtf sweep` of this version again");
  }

  bool has(const char* key) const { return json_->is_object() && json_->contains(key) && !(*json_)[key].is_null(); }

  Node at(const char* key) const {
    if (!has(key)) fail(std::string("\"") + key + "\" is missing");
    return {(*json_)[key], where_ + "." + key};
  }

  /// Elements of a list; none when the key is absent.
  std::vector<Node> list(const char* key) const {
    std::vector<Node> nodes;
    if (!has(key)) return nodes;
    const Node node = at(key);
    if (!node.json_->is_array()) node.fail("is not a list");
    for (std::size_t i = 0; i < node.json_->size(); ++i)
      nodes.emplace_back((*node.json_)[i], node.where_ + "[" + std::to_string(i) + "]");
    return nodes;
  }

  std::string text() const {
    if (!json_->is_string()) fail("is not text");
    return json_->get<std::string>();
  }
  std::string text(const char* key) const { return has(key) ? at(key).text() : std::string(); }

  double number() const {
    if (!json_->is_number()) fail("is not a number");
    return json_->get<double>();
  }
  /// NaN when absent or null, which stands for what is not finite.
  double number(const char* key) const {
    return has(key) ? at(key).number() : std::numeric_limits<double>::quiet_NaN();
  }

  std::int64_t count() const {
    const double value = number();
    if (!(value >= 0.0 && value <= 1e15) || value != std::floor(value)) fail("is not a count");
    return static_cast<std::int64_t>(value);
  }
  std::int64_t count(const char* key) const { return has(key) ? at(key).count() : 0; }

  bool yes(const char* key) const {
    if (!has(key)) return false;
    const Node node = at(key);
    if (!node.json_->is_boolean()) node.fail("is neither true nor false");
    return node.json_->get<bool>();
  }

  std::vector<std::string> texts(const char* key) const {
    std::vector<std::string> all;
    for (const Node& node : list(key)) all.push_back(node.text());
    return all;
  }

  /// A number or word as designs.csv writes it.
  std::string cell() const { return json_->is_number() ? mtf::format_double(number()) : text(); }

 private:
  const Json* json_;
  std::string where_;
};

SweepColumn column_of(const Node& node) {
  return {node.at("name").text(), node.text("unit"), node.at("role").text(), node.text("definition"),
          node.text("source"),    node.text("gap"),  node.texts("levels"),   node.count("missing")};
}

void read_results(const Node& root, Sweep& sweep) {
  const auto design = [&](const Node& node) {
    const std::int64_t number = node.count();
    if (number >= sweep.designs) node.fail("is no design: there are " + std::to_string(sweep.designs));
    return number;
  };
  sweep.feasible = root.count("feasible");
  if (root.has("invalid")) {
    sweep.invalid = root.at("invalid").count("designs");
    sweep.no_sensor = root.at("invalid").count("no_sensor");
    if (root.at("invalid").has("cause")) {
      const Node cause = root.at("invalid").at("cause");
      sweep.cause = cause.text("text");
      sweep.of_cause = cause.count("designs");
      sweep.looked_at = cause.count("looked_at");
    }
    for (const Node& node : root.at("invalid").list("not_finite"))
      sweep.not_finite.emplace_back(node.at("text").text(), node.count("designs"));
  }
  if (root.has("nearest")) {
    sweep.nearest = design(root.at("nearest").at("design"));
    sweep.violated = root.at("nearest").texts("violated");
  }
  for (const Node& node : root.list("best")) {
    SweepBest best{node.text("objective"), design(node.at("design")), node.number("value"), {}};
    if (std::none_of(sweep.objectives.begin(), sweep.objectives.end(),
                     [&](const SweepObjective& objective) { return objective.text == best.objective; }))
      node.fail("is the best of no objective");
    if (node.has("limits")) best.limits.emplace();
    for (const Node& limit : node.list("limits")) best.limits->push_back({limit.text("text"), limit.text("state")});
    sweep.best.push_back(std::move(best));
  }
  for (const Node& node : root.list("pareto")) sweep.pareto.push_back(design(node));
  if (!std::ranges::is_sorted(sweep.pareto)) root.at("pareto").fail("the designs are not in rising order");
  sweep.pareto_size = std::max(root.count("pareto_size"), static_cast<std::int64_t>(sweep.pareto.size()));
  for (const Node& node : root.list("chosen"))
    sweep.chosen.push_back({design(node.at("design")), node.text("file"), node.text("why")});
  if (root.has("sensitivities")) {
    const Node node = root.at("sensitivities");
    if (node.has("design")) sweep.slope_design = design(node.at("design"));
    for (const Node& one : node.list("derivatives"))
      sweep.derivatives.push_back(
          {one.at("column").text(), one.at("parameter").text(), one.text("unit"), one.number("value")});
    sweep.samples = node.count("samples");
    for (const Node& one : node.list("indices"))
      sweep.indices.push_back({one.at("column").text(), one.at("parameter").text(), one.number("first"),
                               one.number("first_sd"), one.number("total"), one.number("total_sd"), one.count("used")});
  }
  if (root.has("yield")) {
    sweep.draws = root.at("yield").count("draws");
    for (const Node& node : root.at("yield").list("best"))
      sweep.best_yield.emplace_back(design(node.at("design")), node.number("yield"));
  }
}

void read_run(const Node& root, Sweep& sweep) {
  for (const Node& node : root.list("accuracy"))
    sweep.accuracy.push_back(
        {node.number("tolerance"), node.number("promised"), node.number("realised"), node.number("us_per_design")});
  if (root.has("timing")) {
    const Node node = root.at("timing");
    if (node.has("seconds")) sweep.seconds = node.number("seconds");
    if (node.has("designs_per_second")) sweep.designs_per_second = node.number("designs_per_second");
    sweep.threads = node.count("threads");
    sweep.resumed = node.count("resumed_designs");
  }
  sweep.skipped = root.texts("skipped");
}

Sweep sweep_of(const Node& root) {
  Sweep sweep;
  sweep.version = root.text("version");
  sweep.commit = root.text("commit");
  sweep.date = root.text("date");
  sweep.machine = root.text("machine");
  sweep.name = root.at("study").text("name");
  sweep.study = {root.at("study").at("file").text(), root.at("study").text("sha256")};
  for (const Node& node : root.list("sensors")) sweep.sensors.push_back({node.at("file").text(), node.text("sha256")});
  sweep.designs = root.at("designs").count();
  sweep.evaluated = root.at("evaluated").count();
  sweep.method = root.text("method");
  sweep.seed = root.count("seed");
  sweep.tolerance = root.number("tolerance");
  sweep.worst_error = root.number("worst_error");
  if (root.has("conditions")) {
    const double given = root.at("conditions").number("temperature_k");
    if (given > 0.0 && given <= 1e6) sweep.temperature_k = given;
    sweep.conditions = root.at("conditions").texts("lines");
  }
  for (const Node& node : root.list("columns")) sweep.columns.push_back(column_of(node));
  if (sweep.columns.empty() || sweep.columns.size() > 1000) root.fail("a sweep has 1 to 1000 columns");
  for (const Node& node : root.list("axes")) {
    SweepAxis axis{node.at("column").text(), node.text("scale"), {}};
    if (!sweep.column(axis.column)) node.fail("its column is not among \"columns\"");
    for (const Node& value : node.list("values")) axis.values.push_back(value.cell());
    sweep.axes.push_back(std::move(axis));
  }
  for (const Node& node : root.list("constraints"))
    sweep.constraints.push_back({node.at("text").text(), node.count("met"), node.texts("columns"), node.number("limit"),
                                 node.text("relation")});
  for (const Node& node : root.list("objectives")) {
    sweep.objectives.push_back({node.at("text").text(), node.at("column").text(), node.yes("maximize")});
    if (!sweep.column(sweep.objectives.back().column)) node.fail("its column is not among \"columns\"");
  }
  read_results(root, sweep);
  read_run(root, sweep);
  return sweep;
}

void require_sweep(const fs::path& folder) {
  const std::string shown = one_line(folder.string());
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    throw mtf::UsageError(shown + ": is no folder; name the one that `mtf sweep STUDY -o DIR` wrote");
  if (fs::exists(folder / "sweep.json", ignored)) return;
  if (fs::exists(folder / "parts", ignored))
    throw mtf::UsageError(shown + ": the sweep is not finished; the same `mtf sweep` command continues it");
  throw mtf::UsageError(shown + ": has no sweep.json; name a folder that `mtf sweep STUDY -o DIR` wrote");
}

}  // namespace

std::optional<std::size_t> Sweep::column(const std::string& wanted) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const auto& c) { return c.name == wanted; });
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

Sweep read_sweep(const fs::path& folder) {
  require_sweep(folder);
  const std::string file = (folder / "sweep.json").string();
  const std::string text = mtf::io::read_table_text(file);
  Json json;
  try {
    json = parse_json(text);
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(one_line(file) + ": is no JSON, or incomplete; run `mtf sweep` again (" +
                          one_line(error.what()) + ")");
  }
  const Node root(json, file);
  if (!root.has("kind") || root.at("kind").text() != "sweep")
    throw mtf::UsageError(one_line(file) + ": is not what `mtf sweep` writes; name the folder of a sweep");
  if (root.at("schema").count() != 1)
    throw mtf::UsageError(one_line(file) + ": schema " + std::to_string(root.at("schema").count()) +
                          " is of another version of mtf; this one reads 1");
  Sweep sweep = sweep_of(root);
  if (sweep.evaluated != sweep.designs)
    throw mtf::UsageError(one_line(file) + ": " + std::to_string(sweep.evaluated) + " of " +
                          std::to_string(sweep.designs) +
                          " designs are evaluated; the same `mtf sweep` command continues with the others");
  sweep.folder = folder;
  sweep.sha256 = mtf::io::sha256_hex(text);
  return sweep;
}

}  // namespace apps
