// SPDX-License-Identifier: Apache-2.0
#include "apps/report/report_sweep.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>

#include "apps/arguments.h"
#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/file_checks.h"
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

// designs.csv.

constexpr std::size_t kMostOfRow = 1 << 20;  // bytes

/// Records of a CSV file (RFC 4180), one at a time: cells may be quoted and hold separators, quotes and line ends.
class Records {
 public:
  explicit Records(const std::string& path) : file_(path, std::ios::binary), path_(path), buffer_(1 << 20) {
    if (!file_) throw mtf::RuntimeError("cannot read " + one_line(path));
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw mtf::UsageError(one_line(path_) + ":" + std::to_string(line_) + ": " + what +
                          "; the file is not the one that the sweep wrote: run `mtf sweep` again");
  }

  /// The cells of the next record, false at the end.
  bool next(std::vector<std::string>& cells) {
    cells.clear();
    line_ = next_line_;
    int c = get();
    if (c < 0) return false;
    std::string cell;
    std::size_t bytes = 0;
    bool quoted = false;
    for (;; c = get()) {
      if (++bytes > kMostOfRow) fail("a row of more than " + std::to_string(kMostOfRow) + " bytes");
      if (c == '\n') ++next_line_;
      if (quoted) {
        if (c < 0) fail("a quote is never closed");
        if (c != '"') {
          cell += static_cast<char>(c);
        } else if (peek() == '"') {
          cell += static_cast<char>(get());
        } else {
          quoted = false;
        }
      } else if (c == '"' && cell.empty()) {
        quoted = true;
      } else if (c == ',' || c == '\n' || c < 0) {
        if (c != ',' && !cell.empty() && cell.back() == '\r') cell.pop_back();
        cells.push_back(std::move(cell));
        cell.clear();
        if (c != ',') break;
      } else {
        cell += static_cast<char>(c);
      }
    }
    if (c < 0) fail("the last row has no end: the file is incomplete");
    return true;
  }

 private:
  bool fill() {
    if (at_ < size_) return true;
    file_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    size_ = static_cast<std::size_t>(file_.gcount());
    at_ = 0;
    return size_ > 0;
  }
  int get() { return fill() ? static_cast<unsigned char>(buffer_[at_++]) : -1; }
  int peek() { return fill() ? static_cast<unsigned char>(buffer_[at_]) : -1; }

  std::ifstream file_;
  std::string path_;
  std::vector<char> buffer_;
  std::size_t at_ = 0, size_ = 0;
  std::int64_t line_ = 0, next_line_ = 1;
};

void check_header(const Records& records, const std::vector<std::string>& cells, const Sweep& sweep) {
  if (cells.size() != sweep.columns.size() + 1)
    records.fail(std::to_string(cells.size()) + " columns where sweep.json has " +
                 std::to_string(sweep.columns.size() + 1));
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (const std::string wanted = i == 0 ? "design" : sweep.columns[i - 1].name; cells[i] != wanted)
      records.fail("column '" + one_line(cells[i]) + "' where sweep.json has '" + one_line(wanted) + "'");
}

/// True for one design in `every`, whatever their order: steps of a fixed length would select single values of a grid's
/// axis or the digits of a Sobol sequence. The mixing of splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
bool is_drawn(std::int64_t design, std::int64_t every) {
  auto h = static_cast<std::uint64_t>(design) + 0x9E3779B97F4A7C15ULL;
  h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
  h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
  return (h ^ (h >> 31)) % static_cast<std::uint64_t>(every) == 0;
}

/// Designs that the report names, in no order.
std::vector<std::int64_t> named_designs(const Sweep& sweep) {
  std::vector<std::int64_t> named;
  for (const SweepBest& best : sweep.best) named.push_back(best.design);
  for (const SweepChosen& chosen : sweep.chosen) named.push_back(chosen.design);
  for (const auto& [design, share] : sweep.best_yield) named.push_back(design);
  if (sweep.nearest) named.push_back(*sweep.nearest);
  if (sweep.slope_design) named.push_back(*sweep.slope_design);
  return named;
}

/// Designs to keep whatever their number, rising; sets `every` and `pareto_every`.
std::vector<std::int64_t> plan_subset(const Sweep& sweep, std::int64_t file_bytes, const TableLimits& limits,
                                      DesignTable& table) {
  const double row_bytes =
      static_cast<double>(file_bytes) / static_cast<double>(std::max<std::int64_t>(sweep.designs, 1));
  const auto room = static_cast<std::int64_t>(
      std::max(2.0, std::min(static_cast<double>(limits.rows), static_cast<double>(limits.bytes) / row_bytes)));
  if (sweep.designs <= room) return {};
  std::vector<std::int64_t> keep = named_designs(sweep);
  const auto front = static_cast<std::int64_t>(sweep.pareto.size());
  table.pareto_every = std::max<std::int64_t>(1, (front + room / 2 - 1) / std::max<std::int64_t>(room / 2, 1));
  for (std::size_t i = 0; i < sweep.pareto.size(); i += static_cast<std::size_t>(table.pareto_every))
    keep.push_back(sweep.pareto[i]);
  std::sort(keep.begin(), keep.end());
  keep.erase(std::unique(keep.begin(), keep.end()), keep.end());
  const std::int64_t rest = std::max<std::int64_t>(1, room - static_cast<std::int64_t>(keep.size()));
  table.every = std::max<std::int64_t>(2, (sweep.designs + rest - 1) / rest);
  return keep;
}

// The chosen designs.

constexpr int kPoints = 97;
constexpr std::size_t kMostText = 256 << 10;

double modulus(const mtf::Complex<double>& value) { return std::hypot(value.re, value.im); }

ChosenCurve curve_of(const OtfColumn& column) {
  ChosenCurve curve{column.label, column.stage, column.doc, {}, 0.0};
  // The last frequency is Nyquist's own.
  for (std::size_t i = 0; i + 1 < column.otf.size(); ++i) curve.mtf.push_back(modulus(column.otf[i]));
  curve.at_nyquist = modulus(column.otf.back());
  return curve;
}

void add_curves(ChosenDesign& design, const mtf::System<double>& system) {
  const KeyFigures figures = key_figures(system, {});
  design.nyquist_cy_mm = figures.nyquist;
  std::vector<double> frequency = evenly_spaced(0.0, figures.last_frequency(), kPoints);
  design.frequency_cy_mm = frequency;
  frequency.push_back(figures.nyquist);
  const OtfCurves values = otf_curves(system, std::move(frequency));
  for (const OtfColumn& column : values.components) design.components.push_back(curve_of(column));
  design.system = curve_of(values.system);
}

void add_budget(ChosenDesign& design, double temperature_k) {
  try {
    const LoadedSensor loaded = load_chain(design.config);
    const radiometry::Budget<double> budget = budget_of(design.config.system, loaded.sensor, temperature_k);
    design.budget = budget_rows(design.config.system, loaded.sensor, budget);
    design.saturation = words(budget.saturation);
  } catch (const std::exception& error) {
    design.budget_gap = one_line(error.what());
  }
}

void load(const Sweep& sweep, ChosenDesign& design) {
  std::string problem;
  design.text = text_of(sweep, design.chosen.file, problem);
  if (!problem.empty()) throw mtf::RuntimeError(problem);
  const std::string path = (sweep.folder / design.chosen.file).string();
  mtf::io::ConfigResult parsed = mtf::io::parse_config(design.text, path, sensor_schema());
  for (const mtf::io::Diagnostic& diagnostic : parsed.diagnostics)
    if (diagnostic.error) throw mtf::UsageError(mtf::io::format_diagnostic(diagnostic, design.chosen.file));
  design.config = std::move(parsed.config);
  design.name = design.config.system.name;
  const bool chain = has_chain(design.config);
  const mtf::System<double>& system = design.config.system;
  add_curves(design, chain && system.band ? with_electron_rate(system, load_chain(design.config)) : system);
  if (chain)
    add_budget(design, sweep.temperature_k);
  else
    design.budget_gap = "its sensor file has no [detector], without which there is neither light nor noise";
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

std::optional<std::size_t> DesignTable::row(std::int64_t wanted) const {
  const auto found = std::lower_bound(design.begin(), design.end(), wanted);
  if (found == design.end() || *found != wanted) return std::nullopt;
  return static_cast<std::size_t>(found - design.begin());
}

DesignTable read_designs(const Sweep& sweep, const TableLimits& limits) {
  const std::string path = (sweep.folder / "designs.csv").string();
  const std::int64_t bytes = mtf::io::input_file_size(path);
  DesignTable table;
  const std::vector<std::int64_t> keep = plan_subset(sweep, bytes, limits, table);
  Records records(path);
  std::vector<std::string> cells;
  if (!records.next(cells)) records.fail("the file is empty");
  check_header(records, cells, sweep);
  std::vector<std::int64_t> missing(sweep.columns.size(), 0);
  std::int64_t count = 0;
  for (auto kept = keep.begin(); records.next(cells); ++count) {
    if (cells.size() != sweep.columns.size() + 1)
      records.fail(std::to_string(cells.size()) + " cells where the header has " +
                   std::to_string(sweep.columns.size() + 1));
    if (count == sweep.designs) records.fail("more designs than the " + std::to_string(count) + " of sweep.json");
    if (cells.front() != std::to_string(count))
      records.fail("design '" + one_line(cells.front()) + "' where " + std::to_string(count) + " follows");
    for (std::size_t i = 0; i < missing.size(); ++i) missing[i] += cells[i + 1].empty();
    const bool wanted = kept != keep.end() && *kept == count;
    if (wanted) ++kept;
    if (!wanted && !is_drawn(count, table.every)) continue;
    table.design.push_back(count);
    table.cells.emplace_back(std::make_move_iterator(cells.begin() + 1), std::make_move_iterator(cells.end()));
  }
  if (count != sweep.designs)
    records.fail(std::to_string(count) + " designs where sweep.json has " + std::to_string(sweep.designs));
  for (std::size_t i = 0; i < missing.size(); ++i)
    if (missing[i] != sweep.columns[i].missing)
      records.fail("column '" + one_line(sweep.columns[i].name) + "' has " + std::to_string(missing[i]) +
                   " empty cells where sweep.json has " + std::to_string(sweep.columns[i].missing));
  table.sha256 = mtf::io::sha256_file(path);
  return table;
}

std::string text_of(const Sweep& sweep, const std::string& file, std::string& problem) {
  const std::filesystem::path path = file;
  const bool inside = !file.empty() && path.is_relative() &&
                      std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
  if (!inside) {
    problem = one_line(file) + ": is not a file of the sweep's folder";
    return {};
  }
  try {
    return mtf::io::read_table_text((sweep.folder / path).string(), kMostText);
  } catch (const std::exception& error) {
    problem = one_line(error.what());
    return {};
  }
}

std::vector<ChosenDesign> load_chosen(const Sweep& sweep) {
  constexpr std::size_t kMost = 16;  // a sweep chooses about ten
  std::vector<ChosenDesign> designs;
  for (const SweepChosen& chosen : sweep.chosen) {
    if (designs.size() == kMost) break;
    ChosenDesign& design = designs.emplace_back();
    design.chosen = chosen;
    try {
      load(sweep, design);
    } catch (const std::exception& error) {
      design.problem = one_line(error.what());
      design.budget_gap = design.image_gap = design.problem;
    }
  }
  return designs;
}

}  // namespace apps
