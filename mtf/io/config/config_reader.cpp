// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

#include "mtf/error.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/words.h"

namespace mtf::io::cfg {
namespace {

constexpr std::size_t kMaxDiagnostics = 1000;
// Longer words are never a slip of the finger, and the edit distance is quadratic.
constexpr std::size_t kMaxGuess = 64;

bool is_axis_part(std::string_view path) { return path.ends_with("_x") || path.ends_with("_y"); }

// One value of each type, from the tree into a number, word, list or curve; and a number with what is known of it:
//   rms = { value = "8 urad", fit = true, min = "0 urad", max = "50 urad", prior = { mean, sd }, stderr = "0.1 urad" }
//   read_noise = { value = "0.03 e-", interval = ["0 e-", "0.11 e-"] }

// No quantity, word or file name is longer; messages and guesses stay short and fast.
constexpr std::size_t kMaxText = 1024;

bool is_number(std::string_view text) {
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

std::optional<double> read_bare(Reader& reader, const Node& node, const FieldInfo& info, const std::string& path) {
  const std::string name(info.name);
  if (node.kind == Node::Kind::string) {
    reader.error(node.position, path,
                 is_number(node.text)
                     ? shown(node) + " is a string; write " + name + " = " + node.text + " without quotes"
                     : shown(node) + " where a plain number belongs; write for example " + name + " = " +
                           std::string(info.example.empty() ? "1.0" : info.example));
    return std::nullopt;
  }
  if (!node.is_number()) {
    reader.error(node.position, path, std::string(kind_word(node.kind)) + " where a plain number belongs");
    return std::nullopt;
  }
  if (!std::isfinite(node.number)) {
    reader.error(node.position, path, shown(node) + " is not finite; write an ordinary number");
    return std::nullopt;
  }
  return node.number;
}

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

std::optional<Scalar> read_plain_or_fit(Reader& reader, const Node& node, const FieldInfo& info,
                                        const std::string& path) {
  if (is_over_field(node, info)) return read_over_field(reader, node, info, path);
  return node.kind == Node::Kind::table ? read_fit(reader, node, info, path) : read_plain(reader, node, info, path);
}

}  // namespace

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

void Reader::error(Position position, std::string path, std::string text) {
  failed.insert(path);
  if (is_axis_part(path)) failed.insert(path.substr(0, path.size() - 2));
  if (diagnostics.size() < kMaxDiagnostics)
    diagnostics.push_back({.error = true, .position = position, .path = std::move(path), .text = std::move(text)});
}

void Reader::note(Position position, std::string path, std::string text, bool remark) {
  if (diagnostics.size() < kMaxDiagnostics)
    diagnostics.push_back(
        {.error = false, .position = position, .path = std::move(path), .text = std::move(text), .remark = remark});
}

bool Reader::has_failed(std::string_view path) const {
  for (;;) {
    if (failed.contains(path)) return true;
    const std::size_t dot = path.rfind('.');
    if (dot == std::string_view::npos) return false;
    path = path.substr(0, dot);
  }
}

Position Reader::position_of(std::string path) const {
  while (!path.empty()) {
    for (const std::string& candidate : {path, is_axis_part(path) ? path.substr(0, path.size() - 2) : path})
      if (const auto found = positions.find(candidate); found != positions.end()) return found->second;
    const std::size_t dot = path.rfind('.');
    path = dot == std::string::npos ? "" : path.substr(0, dot);
  }
  return {};
}

void Section::error(std::string_view key, std::string text) const {
  const Node* node = find(key);
  reader.error(node != nullptr ? node->position : table.position, at(key), std::move(text));
}

std::string suggestion(std::string_view word, std::span<const std::string_view> known) {
  std::string text;
  if (word.size() <= kMaxGuess)
    if (const auto guess = nearest(word, known)) text += "; did you mean \"" + *guess + "\"?";
  text += text.empty() ? "; known: " : " (known: ";
  return text + joined(known) + (text.find("(known: ") != std::string::npos ? ")" : "");
}

void check_keys(const Section& section, std::span<const std::string_view> known) {
  for (const Member& member : section.table.members) {
    if (section.reader.diagnostics.size() >= kMaxDiagnostics) return;  // nothing more would be shown
    const std::string path = section.at(printable(member.key, kMaxGuess));
    const auto is = [&](std::string_view key) { return key == member.key; };
    if (std::any_of(known.begin(), known.end(), is)) continue;
    section.reader.error(
        member.position, path,
        "unknown key" + (section.title.empty() ? "" : " in " + section.title) + suggestion(member.key, known));
    // The key that was meant is missing for this reason.
    if (member.key.size() > kMaxGuess) continue;
    if (const auto guess = nearest(std::string_view(member.key), known))
      if (section.find(*guess) == nullptr) section.reader.failed.insert(section.at(*guess));
  }
}

void check_keys(const Section& section, const std::vector<std::string>& known) {
  check_keys(section, std::vector<std::string_view>(known.begin(), known.end()));
}

const Node* find_table(const Section& parent, std::string_view key) {
  const Node* node = parent.find(key);
  if (node == nullptr) return nullptr;
  const std::string path = parent.at(key);
  parent.reader.positions[path] = node->position;
  if (node->kind == Node::Kind::table) return node;
  parent.reader.error(node->position, path,
                      std::string(kind_word(node->kind)) + " where a table belongs; write [" + std::string(key) +
                          "] on a line of its own and its keys below it");
  return nullptr;
}

const Node* find_tables(const Section& parent, std::string_view key) {
  const Node* list = parent.find(key);
  if (list == nullptr) return nullptr;
  parent.reader.positions[parent.at(key)] = list->position;
  const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
  if (list->kind == Node::Kind::array && std::all_of(list->items.begin(), list->items.end(), is_table)) return list;
  parent.error(key, "has to be a list of tables; write [[" + std::string(key) + "]] with double brackets");
  return nullptr;
}

std::string missing_text(const FieldInfo& info) {
  return "missing; write for example " + std::string(info.name) + " = " + std::string(info.example) +
         (info.doc.empty() ? "" : " (" + std::string(info.doc) + ")");
}

std::string lacks_unit_text(const Node& node, const FieldInfo& info) {
  std::string example(info.example);
  if (!example.starts_with('"')) {  // a number of the study's own, whose row has none with a unit
    const bool frequency = info.dimension == Dimension::frequency || info.dimension == Dimension::cutoff;
    example = "\"1 " + std::string(!info.unit.empty() ? info.unit : frequency ? "cy/mm" : "um") + "\"";
  }
  return shown(node) + " has no unit; write it with its unit, such as " + example;
}

std::string folder_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos ? "" : file.substr(0, slash + 1);
}

std::string beside(const std::string& folder, const std::string& name) {
  return name.starts_with('/') ? name : folder + name;
}

std::string Reader::file(const std::string& name) {
  const std::string path = beside(folder, name);
  if (std::find(files.begin(), files.end(), path) == files.end()) files.push_back(path);
  return path;
}

std::string another_kind(const std::vector<Diagnostic>& diagnostics, const std::string& text, std::string_view ours) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kKinds{
      {{"frame", "a sensor file, for it has [frame]"},
       {"mesh", "the file of a 3-D scene, for it has [[mesh]]"},
       {"sensor", "a study, for it names a sensor"}}};
  if (std::none_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& one) { return one.error; })) return {};
  const Node root = read_tree(text).root;
  if (root.find(ours) != nullptr) return {};
  for (const auto& [mark, kind] : kKinds)
    if (root.find(mark) != nullptr) return std::string(kind);
  return {};
}

void sort_diagnostics(std::vector<Diagnostic>& diagnostics) {
  std::stable_sort(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::tuple(!a.error, a.position.line, a.position.column) <
           std::tuple(!b.error, b.position.line, b.position.column);
  });
}

void require_no_errors(const std::vector<Diagnostic>& diagnostics, const std::string& file) {
  std::string errors;
  for (const Diagnostic& diagnostic : diagnostics)
    if (diagnostic.error) errors += (errors.empty() ? "" : "\n") + format_diagnostic(diagnostic, file);
  if (!errors.empty()) throw UsageError(errors);
}

std::optional<Scalar> read_plain(Reader& reader, const Node& node, const FieldInfo& info, const std::string& path) {
  reader.positions[path] = node.position;
  if (info.dimension == Dimension::none) {
    const auto value = read_bare(reader, node, info, path);
    return value ? std::optional(Scalar{*value, nullptr}) : std::nullopt;
  }
  const auto fail = [&](const std::string& text) {
    reader.error(node.position, path, text);
    return std::nullopt;
  };
  if (node.is_number()) return fail(lacks_unit_text(node, info));
  const std::string expected(describe(info.dimension));
  if (node.kind != Node::Kind::string)
    return fail(std::string(kind_word(node.kind)) + " where a number with unit belongs; expected " + expected);
  if (node.text.size() > kMaxText) return fail("a text of this length is no number with unit; expected " + expected);
  try {
    const mtf::Quantity quantity = parse_quantity(node.text, info.dimension);
    if (info.unit.empty()) return Scalar{quantity.value, quantity.unit};
    const Scalar scalar{convert(quantity, info.unit), find_unit(info.unit)};
    if (!std::isfinite(scalar.value)) return fail(shown(node) + ": number out of range; expected " + expected);
    return scalar;
  } catch (const UsageError& error) {
    return fail(printable(error.what(), 400));
  }
}

std::optional<Scalar> read_scalar(const Section& section, const FieldInfo& info, std::string_view key) {
  const Node* node = section.find(key);
  if (node == nullptr) return std::nullopt;
  return read_plain_or_fit(section.reader, *node, info, section.at(key));
}

std::optional<double> read_number(const Section& section, const FieldInfo& info, std::string_view key) {
  const Node* node = section.find(key);
  if (node == nullptr) return std::nullopt;
  const auto scalar = read_plain(section.reader, *node, info, section.at(key));
  if (!scalar) return std::nullopt;
  if (in_range(info, scalar->value)) return scalar->value;
  section.error(key, outside_text(info, scalar->value, info.unit));
  return std::nullopt;
}

bool read_axis_pair(const Section& section, const FieldInfo& info, AxisPair<double>& pair, bool fittable) {
  const std::string name(info.name), name_x = name + "_x", name_y = name + "_y";
  const auto read = [&](const std::string& key, Extent<double>& extent) {
    const Node* node = section.find(key);
    const auto scalar =
        fittable ? read_scalar(section, info, key) : read_plain(section.reader, *node, info, section.at(key));
    if (!scalar) return false;
    extent = {scalar->value, scalar->unit};
    return true;
  };
  const bool both = section.find(name) != nullptr, x = section.find(name_x) != nullptr,
             y = section.find(name_y) != nullptr;
  if (both && (x || y)) {
    section.error(x ? name_x : name_y, "given together with " + name + "; remove one of them");
    return false;
  }
  if (both) {
    pair.split = false;
    return read(name, pair.x);
  }
  if (x != y) {
    section.error(x ? name_x : name_y, "given without " + (x ? name_y : name_x) + "; give both, or only " + name);
    return false;
  }
  if (!x) return false;
  section.reader.positions[section.at(name)] = section.find(name_x)->position;
  Extent<double> along_x, along_y;
  const bool read_x = read(name_x, along_x), read_y = read(name_y, along_y);
  if (!read_x || !read_y) return false;
  pair = {along_x, along_y, true};
  return true;
}

std::optional<std::string> read_string(const Section& section, std::string_view key) {
  const Node* node = section.find(key);
  if (node == nullptr) return std::nullopt;
  section.reader.positions[section.at(key)] = node->position;
  if (node->kind != Node::Kind::string) {
    section.error(key, std::string(kind_word(node->kind)) + " where a text in quotes belongs");
    return std::nullopt;
  }
  if (node->text.size() <= kMaxText) return node->text;
  section.error(key, "longer than " + std::to_string(kMaxText) + " characters");
  return std::nullopt;
}

std::optional<int> read_word(const Section& section, std::string_view key, std::span<const std::string_view> names) {
  const auto word = read_string(section, key);
  if (!word) return std::nullopt;
  const auto found = std::find(names.begin(), names.end(), *word);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  section.error(key, "unknown word \"" + printable(*word, 60) + "\"" + suggestion(*word, names));
  return std::nullopt;
}

std::optional<int> read_whole(const Section& section, const FieldInfo& info) {
  const Node* node = section.find(info.name);
  if (node == nullptr) return std::nullopt;
  section.reader.positions[section.at(info.name)] = node->position;
  if (node->kind != Node::Kind::integer) {
    section.error(info.name, (node->kind == Node::Kind::real ? shown(*node) : std::string(kind_word(node->kind))) +
                                 " where a whole number belongs; write for example " + std::string(info.name) + " = " +
                                 std::string(info.example));
    return std::nullopt;
  }
  if (in_range(info, node->number)) return static_cast<int>(node->integer);
  section.error(info.name, shown(*node) + " is outside " + range_text(info, ""));
  return std::nullopt;
}

std::optional<Taps<double>> read_taps(const Section& section, std::string_view key) {
  const Node* node = section.find(key);
  if (node == nullptr) return std::nullopt;
  Reader& reader = section.reader;
  const std::string path = section.at(key);
  reader.positions[path] = node->position;
  const auto is_row = [](const Node& item) { return item.kind == Node::Kind::array; };
  if (node->kind != Node::Kind::array || !std::all_of(node->items.begin(), node->items.end(), is_row)) {
    section.error(key, "has to be a list of rows, each a list of plain numbers, such as [[1.0, 2.0, 1.0]]");
    return std::nullopt;
  }
  Taps<double> taps;
  bool good = true;
  for (const Node& row : node->items) {
    taps.emplace_back();
    for (const Node& item : row.items) {
      const auto value = read_bare(reader, item, {.name = "tap", .example = "0.25"}, path);
      good = good && value;
      taps.back().push_back(value.value_or(0.0));
    }
  }
  return good ? std::optional(std::move(taps)) : std::nullopt;
}

std::optional<Coefficients<double>> read_coefficients(const Section& section, const FieldInfo& info) {
  const Node* node = section.find(info.name);
  if (node == nullptr) return std::nullopt;
  const std::string path = section.at(info.name);
  section.reader.positions[path] = node->position;
  if (node->kind != Node::Kind::array) {
    section.error(info.name, std::string(kind_word(node->kind)) + " where a list of plain numbers belongs; write for " +
                                 "example " + std::string(info.name) + " = " + std::string(info.example));
    return std::nullopt;
  }
  Coefficients<double> list;
  bool good = true;
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const FieldInfo element{.name = info.name, .lo = info.lo, .hi = info.hi, .example = "0.25"};
    const auto value = read_plain_or_fit(section.reader, node->items[i], element, path + "[" + std::to_string(i) + "]");
    good = good && value;
    list.push_back(value ? value->value : 0.0);
  }
  return good ? std::optional(std::move(list)) : std::nullopt;
}

std::optional<Encoding> read_encoding(const Section& section, std::string_view key) {
  const auto word = read_string(section, key);
  if (!word) return std::nullopt;
  try {
    Encoding encoding = parse_encoding(*word, section.reader.folder);
    if (encoding.kind == Encoding::Kind::table) section.reader.file(*word);
    return encoding;
  } catch (const Error& error) {
    section.error(key, printable(error.what(), 600));
    return std::nullopt;
  }
}

std::shared_ptr<const Curve> read_curve(const Section& section, std::string_view key) {
  const Node* node = section.find(key);
  const bool lines = node != nullptr && node->kind == Node::Kind::string && node->text.find('\n') != std::string::npos;
  const auto name = lines ? std::optional(node->text) : read_string(section, key);
  if (!name) return nullptr;
  const auto fail = [&](const std::string& text) {
    section.error(key, printable(text, 600));
    return nullptr;
  };
  if (name->empty() || name->find('\0') != std::string::npos) return fail("no file name");
  try {
    if (!lines) return std::make_shared<const Curve>(read_curve_csv(section.reader.file(*name)));
    section.reader.positions[section.at(key)] = node->position;
    Curve curve = parse_curve_csv(*name, "text");
    curve.source.clear();
    return std::make_shared<const Curve>(std::move(curve));
  } catch (const Error& error) {
    return fail(error.what());
  }
}

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

}  // namespace mtf::io::cfg
