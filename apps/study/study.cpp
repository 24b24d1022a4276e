// SPDX-License-Identifier: Apache-2.0
#include "apps/study/study.h"

#include <sys/stat.h>

#include <algorithm>

#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/study/study_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "mtf/words.h"
#include "radiometry/chain/sensor_settings.h"

namespace study {
namespace {

using mtf::io::Diagnostic;

/// The parts that refer to the sensor, each after those that it needs.
void read_on_sensor(StudyReader& s) {
  read_axes(s);
  read_sampling(s);
  read_links(s);
  read_as_built(s);
  if (!s.axes_good) return;  // names of axes that could not be read would be reported as unknown
  std::vector<Source> sources = goal_sources(s);
  for (const LinkSource& link : s.links) sources.push_back(link.source);
  register_names(s, sources);
  read_link_expressions(s);
  read_goals(s);
  check_conditions(s);
  if (s.study.variants <= kMostVariants) check_levels(s);
}

ReadFile state_of(const std::string& file) {
  ReadFile now{.file = file, .sha256 = {}};
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return now;
  now.bytes = status.st_size;
  now.changed_ns = std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
  return now;
}

/// With the hash of the study. Sensor files themselves are in memory.
void hash_files(Study& study) {
  std::string all = mtf::io::sha256_hex(study.text) + study.base.sha256;
  for (const mtf::io::SensorConfig& sensor : study.sensors) all += sensor.sha256;
  const auto is_sensor = [&](const std::string& file) {
    return file == study.base.file || std::any_of(study.sensors.begin(), study.sensors.end(),
                                                  [&](const auto& sensor) { return sensor.file == file; });
  };
  for (const StudyFile& named : files_of(study)) {
    ReadFile read = state_of(named.file);
    read.sha256 = mtf::io::sha256_file(named.file);
    all += read.sha256;
    if (!is_sensor(named.file)) study.read.push_back(std::move(read));
  }
  study.sha256 = mtf::io::sha256_hex(all);
}

using mtf::io::Position;

__extension__ using Wide = unsigned __int128;

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }  // of a UTF-8 character

/// Place of byte `column` of a string that is on one line; that of the string itself where it spans several.
Position inside_string(const std::string& text, Position at, int column) {
  std::size_t offset = 0;
  for (int line = 1; line < at.line && offset < text.size(); ++line) offset = text.find('\n', offset) + 1;
  for (int i = 1; i < at.column && offset < text.size(); ++i) do
      ++offset;
    while (offset < text.size() && continues(text[offset]));
  if (offset >= text.size() || (text[offset] != '"' && text[offset] != '\'')) return at;
  const char quote = text[offset];
  if (text.compare(offset, 3, std::string(3, quote)) == 0) return at;
  Position place{at.line, at.column + 1};
  ++offset;
  for (int byte = 0; byte < column && offset < text.size() && text[offset] != '\n'; ++byte) {
    std::size_t length = 1;  // in the file
    if (quote == '"' && text[offset] == '\\' && offset + 1 < text.size())
      length = text[offset + 1] == 'u' ? 6 : text[offset + 1] == 'U' ? 10 : 2;
    for (std::size_t i = 0; i < length && offset < text.size(); ++i, ++offset)
      if (!continues(text[offset])) ++place.column;
  }
  return place;
}

constexpr std::size_t kMostSensorErrors = 10;
constexpr std::size_t kMostSensors = 1000;

/// One sensor file, its errors at the place that names it; null when there are any.
std::optional<SensorView> read_sensor(StudyReader& s, const Node& node, const std::string& path) {
  const auto fail = [&](const std::string& text) {
    s.error(node.position, path, text);
    return std::nullopt;
  };
  if (node.kind != Node::Kind::string || node.text.empty() || node.text.find('\0') != std::string::npos)
    return fail(cfg::shown(node) + " is no name of a sensor file; write for example \"camera.toml\"");
  const std::string file = cfg::beside(s.reader.folder, node.text);
  mtf::io::ConfigResult result;
  try {
    const std::string text = mtf::io::read_text_file(file, cfg::kMaxBytes);
    if (is_study(text)) return fail(mtf::printable(node.text) + " is a study itself; name a sensor file");
    result = mtf::io::parse_config(text, file, apps::sensor_schema());
  } catch (const mtf::Error& error) {
    return fail(mtf::printable(error.what(), 600));
  }
  std::size_t errors = 0;
  for (const mtf::io::Diagnostic& diagnostic : result.diagnostics)
    if (diagnostic.error && ++errors <= kMostSensorErrors)
      s.error(node.position, path, mtf::printable(mtf::io::format_diagnostic(diagnostic, file), 800));
  if (errors == 0) {
    if (const auto problem = apps::chain_problem(result.config))
      return fail(mtf::printable(mtf::io::format_diagnostic(*problem, file), 800));
    for (const mtf::io::Diagnostic& warning : apps::chain_warnings(result.config))
      if (!warning.remark) {
        const std::string where = file + ": " + (warning.path.empty() ? "" : warning.path + ": ");
        s.reader.diagnostics.push_back({.error = false,
                                        .position = node.position,
                                        .path = path,
                                        .text = mtf::printable(where + warning.text, 800)});
      }
  }
  if (errors > kMostSensorErrors)
    fail(std::to_string(errors - kMostSensorErrors) + " more errors; see mtf config check " + file);
  return errors > 0 ? std::nullopt : std::optional(view_of(std::move(result.config)));
}

/// The [[axis]] over `sensor`; -1 without one.
int find_sensor_axis(const StudyReader& s) {
  const Node* axes = s.tree.find("axis");
  if (axes == nullptr || axes->kind != Node::Kind::array) return -1;
  for (std::size_t i = 0; i < axes->items.size(); ++i) {
    const Node* parameter = axes->items[i].find("parameter");
    if (parameter != nullptr && parameter->kind == Node::Kind::string && parameter->text == "sensor")
      return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

bool StudyResult::ok() const {
  return std::none_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) { return d.error; });
}

StudyResult parse_study(const std::string& text, const std::string& file) {
  StudyResult result;
  StudyReader s{
      .reader = {
          .folder = cfg::folder_of(file), .schema = {}, .diagnostics = {}, .positions = {}, .failed = {}, .fits = {}}};
  s.study.file = file;
  s.study.text = text;
  cfg::Tree tree = cfg::read_tree(text);
  if (tree.error) {
    result.diagnostics.push_back(*tree.error);
    result.study = std::move(s.study);
    return result;
  }
  s.tree = std::move(tree.root);
  read_settings(s);
  read_metrics(s);
  if (read_sensors(s)) read_on_sensor(s);
  const bool good = std::none_of(s.reader.diagnostics.begin(), s.reader.diagnostics.end(),
                                 [](const Diagnostic& d) { return d.error; });
  if (good) check_gaps(s);
  if (good) check_column_names(s);
  result.diagnostics = std::move(s.reader.diagnostics);
  if (result.ok()) try {
      hash_files(s.study);
    } catch (const mtf::Error& error) {
      result.diagnostics.push_back({.error = true, .position = {}, .path = {}, .text = error.what()});
    }
  cfg::sort_diagnostics(result.diagnostics);
  for (const Diagnostic& diagnostic : result.diagnostics)
    if (!diagnostic.error) s.study.warnings.push_back(diagnostic);
  result.study = std::move(s.study);
  return result;
}

void require_unchanged(const Study& study) {
  for (const ReadFile& was : study.read) {
    const ReadFile now = state_of(was.file);
    if (now.bytes == was.bytes && now.changed_ns == was.changed_ns) continue;
    if (now.changed_ns == 0 || mtf::io::sha256_file(was.file) != was.sha256)
      throw mtf::RuntimeError(mtf::printable(was.file) +
                              ": is not what it was when the study was read; read the study again");
  }
}

bool is_study(const std::string& text) {
  const cfg::Tree tree = cfg::read_tree(text);
  return !tree.error && (tree.root.find("axis") != nullptr || tree.root.find("sensor") != nullptr);
}

std::shared_ptr<const Study> load_study(const std::string& file) {
  const std::string text = mtf::io::read_text_file(file, cfg::kMaxBytes);
  StudyResult result = parse_study(text, file);
  if (const std::string kind = cfg::another_kind(result.diagnostics, text, "sensor"); !kind.empty())
    throw mtf::UsageError(file + ": " + kind + "; a study belongs here");
  cfg::require_no_errors(result.diagnostics, file);
  return std::make_shared<const Study>(std::move(result.study));
}

// What the parts of a study share: sensor files, names, numbers in the unit of their field, places inside of strings.

void StudyReader::error_in(const Source& source, int column, std::string text) {
  error(inside_string(study.text, source.position, source.column + column), source.path, std::move(text));
}

bool read_sensors(StudyReader& s) {
  s.sensor_axis = find_sensor_axis(s);
  const Node* named = s.tree.find("sensor");
  std::vector<SensorView> levels;
  bool good = true;
  if (s.sensor_axis >= 0) {
    const std::string path = "axis[" + std::to_string(s.sensor_axis) + "].values";
    const Node* values = s.tree.find("axis")->items[static_cast<std::size_t>(s.sensor_axis)].find("values");
    if (values != nullptr && values->items.size() > kMostSensors) {
      s.error(values->position, path, "more than " + std::to_string(kMostSensors) + " sensor files");
      return false;
    }
    if (values != nullptr && values->kind == Node::Kind::array)
      for (const Node& node : values->items) {
        auto view = read_sensor(s, node, path);
        good = good && view;
        if (view) levels.push_back(std::move(*view));
      }
  }
  if (named != nullptr) {
    auto base = read_sensor(s, *named, "sensor");
    if (!base) return false;
    s.views.push_back(std::move(*base));
  } else if (!levels.empty()) {
    s.views.push_back(levels.front());
  } else {
    if (good) s.error({}, "sensor", "missing; write sensor = \"camera.toml\", the sensor file that is varied");
    return false;
  }
  for (SensorView& view : levels) {
    s.study.sensors.push_back(view.sensor);
    s.views.push_back(std::move(view));
  }
  s.study.base = s.views.front().sensor;
  return good;
}

Parameter parameter_of(const std::string& name, const Place& place) {
  // A metric of the same name keeps it, in expressions and as a column.
  return {.name = find_metric(name) ? place.target.path() : name,
          .path = place.target.path(),
          .unit = std::string(place.info.unit),
          .scale = unit_scale(place.info.unit),
          .lo = place.info.lo,
          .hi = place.info.hi,
          .lo_open = place.info.lo_open,
          .hi_open = place.info.hi_open,
          .role = Parameter::Role::fixed,
          .base = place.value};
}

int parameter_named(StudyReader& s, const std::string& name, std::string& problem) {
  if (const auto found = s.by_name.find(name); found != s.by_name.end()) return found->second;
  const auto fail = [&](std::string text) {
    problem = std::move(text);
    return -1;
  };
  if (name == "sensor") return fail("the sensor file is no number; it can be an axis");
  const Found found = find_place(s.views.front(), name);
  if (!found.place) return fail(found.problem);
  const std::string path = found.place->target.path();
  for (std::size_t i = 0; i < s.study.parameters.size(); ++i) {
    const Parameter& other = s.study.parameters[i];
    if (other.path == path) return s.by_name[name] = static_cast<int>(i);
    const auto varies = [&](const AsBuilt& built) { return built.parameter == static_cast<int>(i); };
    const auto& as_built = s.study.as_built;
    if (overlap(other.path, path) && (other.role != Parameter::Role::fixed || std::ranges::any_of(as_built, varies)))
      return fail("is a part of " + other.name + ", which the study changes, or the other way round; name " +
                  other.name);
  }
  if (found.place->kind != Place::Kind::number)
    return fail("is " + found.place->what +
                ", no number that follows or varies by itself; an axis with its values "
                "makes it one of a list");
  s.study.parameters.push_back(parameter_of(name, *found.place));
  const int index = static_cast<int>(s.study.parameters.size()) - 1;
  s.by_name.emplace(s.study.parameters.back().name, index);
  return s.by_name[name] = index;
}

std::optional<Expression> read_expression(StudyReader& s, const Source& source, bool metrics) {
  const auto find = [&](std::string_view name) -> std::optional<Symbol> {
    const auto metric = std::find(s.metric_names.begin(), s.metric_names.end(), name);
    if (metric != s.metric_names.end()) {
      if (!metrics) throw ExpressionError{0, std::string(name) + " follows from the design, so no link can read it"};
      const auto i = static_cast<std::size_t>(metric - s.metric_names.begin());
      return Symbol{static_cast<int>(s.study.parameters.size() + i), unit_scale(s.study.metrics[i].unit).dimensions};
    }
    if (const auto why = s.why.find(name); why != s.why.end()) throw ExpressionError{0, why->second};
    const auto found = s.by_name.find(name);
    if (found == s.by_name.end()) return std::nullopt;
    return Symbol{found->second, s.study.parameters[static_cast<std::size_t>(found->second)].scale.dimensions};
  };
  std::vector<std::string> names = s.metric_names;
  for (const auto& [name, index] : s.by_name) names.push_back(name);
  try {
    return Expression::parse(source.text, find, names);
  } catch (const ExpressionError& error) {
    s.error_in(source, error.column, error.text);
    return std::nullopt;
  }
}

std::optional<double> read_held(StudyReader& s, const Node& node, const mtf::FieldInfo& info, const std::string& path,
                                const std::string& given) {
  using enum mtf::Dimension;
  mtf::FieldInfo reading = info;
  // Units of one dimension here may still be of several kinds, which only the frame converts: cy/mm and cy/px.
  const bool several = info.dimension == frequency || info.dimension == extent || info.dimension == cutoff;
  if (several) reading.unit = {};
  auto scalar = cfg::read_plain(s.reader, node, reading, path);
  if (!scalar) return std::nullopt;
  if (several) {
    const mtf::Unit* held = mtf::find_unit(info.unit);
    const bool same = scalar->unit->dimension == held->dimension && held->dimension != frequency;
    if (!same && scalar->unit != held) {
      s.error(node.position, path,
              cfg::shown(node) + " is in " + std::string(scalar->unit->name) + ", but " + given + " it is in " +
                  std::string(info.unit) + "; use one unit");
      return std::nullopt;
    }
    scalar->value = mtf::convert({scalar->value, scalar->unit}, info.unit);
  }
  if (mtf::in_range(info, scalar->value)) return scalar->value;
  s.error(node.position, path, mtf::outside_text(info, scalar->value, info.unit));
  return std::nullopt;
}

std::string exact_product(std::span<const std::int64_t> factors) {
  std::string digits = "1";  // lowest first
  for (const std::int64_t factor : factors) {
    Wide carry = 0;
    for (char& digit : digits) {
      carry += static_cast<Wide>(digit - '0') * static_cast<Wide>(factor);
      digit = static_cast<char>('0' + static_cast<int>(carry % 10));
      carry /= 10;
    }
    for (; carry > 0; carry /= 10) digits += static_cast<char>('0' + static_cast<int>(carry % 10));
  }
  while (digits.size() > 1 && digits.back() == '0') digits.pop_back();  // of a product that is 0
  return {digits.rbegin(), digits.rend()};
}

std::int64_t bounded_product(std::span<const std::int64_t> factors, std::int64_t limit) {
  std::int64_t product = 1;
  for (const std::int64_t factor : factors) {
    if (factor > 0 && product > limit / factor) return limit + 1;
    product *= factor;
  }
  return product;
}

}  // namespace study
