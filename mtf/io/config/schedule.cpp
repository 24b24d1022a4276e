// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/schedule.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

// The lines of a schedule as text, before their values are read.

/// Errors of a schedule that one message lists.
inline constexpr std::size_t kMostScheduleErrors = 20;

constexpr int kMaxLines = 1'000'000;
constexpr std::size_t kMaxCell = 4096;
constexpr std::string_view kHeader = "the first line has to be frame,parameter,value";

bool is_text(std::string_view line) {
  return std::ranges::all_of(line,
                             [](char c) { return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f); });
}

/// The next line without its end (LF, CRLF or CR), taken off `rest`.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end);
  rest.remove_prefix(rest.starts_with("\r\n") ? 2 : rest.empty() ? 0 : 1);
  return line;
}

/// Cells of a line; a cell in double quotes may hold the separator, and a quote as two. Nothing when a quote is open.
std::optional<std::vector<std::string>> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  for (;;) {
    const std::size_t begin = std::min(line.find_first_not_of(separator == '\t' ? " " : " \t"), line.size());
    std::string cell;
    if (begin < line.size() && line[begin] == '"') {
      std::size_t at = begin + 1;
      for (;; ++at) {
        if (at >= line.size()) return std::nullopt;
        if (line[at] != '"')
          cell += line[at];
        else if (at + 1 < line.size() && line[at + 1] == '"')
          cell += line[at++];
        else
          break;
      }
      line.remove_prefix(at + 1);
      const std::size_t end = std::min(line.find(separator), line.size());
      if (!trimmed(line.substr(0, end)).empty()) return std::nullopt;
      line.remove_prefix(end);
    } else {
      const std::size_t end = std::min(line.find(separator), line.size());
      cell = trimmed(line.substr(0, end));
      line.remove_prefix(end);
    }
    cells.push_back(std::move(cell));
    if (line.empty()) return cells;
    line.remove_prefix(1);
  }
}

struct ScheduleColumns {
  char separator = ',';
  std::array<std::size_t, 3> at{};  ///< of frame, parameter, value
};

/// What is wrong with the header, "" when it is good.
std::string read_header(std::string_view line, ScheduleColumns& columns) {
  constexpr std::array<std::string_view, 3> names{"frame", "parameter", "value"};
  columns.separator = separator_of(line);
  const auto cells = cells_of(line, columns.separator);
  const std::string found = "; found: " + printable(line, 60);
  if (!cells || cells->size() != names.size()) return std::string(kHeader) + found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto cell = std::ranges::find(*cells, names[i]);
    if (cell == cells->end()) return std::string(kHeader) + found;
    columns.at[i] = static_cast<std::size_t>(cell - cells->begin());
  }
  return "";
}

/// What is wrong with a line, "" when it is good.
std::string read_line(std::string_view line, const ScheduleColumns& columns, Setting& setting) {
  const auto cells = cells_of(line, columns.separator);
  if (!cells) return "a quote is open, or text follows a closed one: " + printable(line, 60);
  if (cells->size() != 3)
    return std::to_string(cells->size()) + " values where 3 belong (frame, parameter, value)" +
           (cells->size() > 3 ? "; put a value that holds the separator in double quotes" : "");
  const std::string& number = (*cells)[columns.at[0]];
  const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), setting.frame);
  if (status != std::errc{} || end != number.data() + number.size() || setting.frame < 0 || setting.frame > kLastFrame)
    return "'" + printable(number, 40) + "' is no frame; write a whole number from 0 to " + std::to_string(kLastFrame);
  setting.parameter = (*cells)[columns.at[1]];
  setting.value = (*cells)[columns.at[2]];
  if (setting.parameter.empty()) return "no parameter is named";
  if (setting.value.empty()) return setting.parameter.substr(0, 80) + " is given no value";
  if (setting.parameter.size() > kMaxCell || setting.value.size() > kMaxCell)
    return "a name or value of more than " + std::to_string(kMaxCell) + " characters";
  return "";
}

/// "file:line: error: text"
std::string schedule_error(const std::string& file, int line, const std::string& text) {
  return file + ":" + std::to_string(line) + ": error: " + text;
}

/// Settings in the order of the file. What is wrong with its form goes to `errors` as "file:line: error: ..." lines.
std::vector<Setting> read_settings(std::string_view text, const std::string& file, std::vector<std::string>& errors) {
  std::vector<Setting> settings;
  const auto fail = [&](int line, const std::string& what) { errors.push_back(schedule_error(file, line, what)); };
  text = without_mark(text);
  ScheduleColumns columns;
  bool header = false;
  for (int number = 1; !text.empty() && errors.size() < kMostScheduleErrors; ++number) {
    const std::string_view line = take_line(text);
    if (number > kMaxLines) return fail(number, "more than " + std::to_string(kMaxLines) + " lines"), settings;
    if (!is_text(line)) return fail(number, "no text; " + std::string(kHeader)), settings;
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    if (!header) {
      if (const std::string wrong = read_header(line, columns); !wrong.empty()) return fail(number, wrong), settings;
      header = true;
      continue;
    }
    Setting setting{.frame = 0, .line = number};
    if (const std::string wrong = read_line(line, columns, setting); wrong.empty())
      settings.push_back(std::move(setting));
    else
      fail(number, wrong);
  }
  if (!header) fail(1, "nothing is in it; " + std::string(kHeader));
  if (header && settings.empty() && errors.empty())
    fail(1, "no line sets a parameter; add one such as 10,jitter.rms,8 urad");
  return settings;
}

using cfg::Node;

constexpr std::size_t kMaxScheduleBytes = std::size_t{64} << 20;

/// As many as are shown, where there are any.
void require_none(std::vector<std::string> errors) {
  errors.resize(std::min(errors.size(), kMostScheduleErrors));
  if (!errors.empty()) throw UsageError(joined(errors, "\n"));
}

}  // namespace

struct ScheduledSensor::State {
  SensorConfig sensor;
  Schedule schedule;
  Node root;
  cfg::Targets targets;
  std::size_t next = 0;                                ///< first setting that is not in force yet
  std::map<std::string, Setting, std::less<>> last{};  ///< in force, by path

  /// The line that a finding about `path` comes from: the latest that set this value, a part of it, or something in
  /// its table; otherwise the latest of all.
  const Setting& cause(const std::string& path) const {
    const auto concerns = [&](const std::string& key) {
      return key == path || key == path + "_x" || key == path + "_y" || key.starts_with(path + "[") ||
             key.starts_with(path + ".") || path.starts_with(key + "[");
    };
    const Setting* found = nullptr;
    for (const auto& [key, setting] : last)
      if (concerns(key) && (found == nullptr || setting.frame > found->frame)) found = &setting;
    return found != nullptr ? *found : schedule.settings[next - 1];
  }
};

ScheduledSensor::ScheduledSensor(const SensorConfig& sensor, Schedule schedule)
    : state_(std::make_unique<State>(State{.sensor = sensor,
                                           .schedule = std::move(schedule),
                                           .root = cfg::read_tree(sensor.text).root,
                                           .targets = cfg::targets_of(sensor)})) {}
ScheduledSensor::~ScheduledSensor() = default;
ScheduledSensor::ScheduledSensor(ScheduledSensor&&) noexcept = default;
ScheduledSensor& ScheduledSensor::operator=(ScheduledSensor&&) noexcept = default;

const SensorConfig& ScheduledSensor::sensor() const { return state_->sensor; }

std::string ScheduledSensor::in_force() const {
  const auto said = [](const auto& last) { return last.second.parameter + " = " + last.second.value; };
  return joined(state_->last, said, "; ");
}

bool ScheduledSensor::advance(std::int64_t frame) {
  State& s = *state_;
  const std::string& file = s.schedule.file;
  std::vector<std::string> errors;
  bool changed = false;
  for (; s.next < s.schedule.settings.size() && s.schedule.settings[s.next].frame <= frame; ++s.next) {
    const Setting& setting = s.schedule.settings[s.next];
    const auto target = cfg::find_target(s.targets, setting.parameter);
    if (!target) {
      errors.push_back(schedule_error(file, setting.line, cfg::unknown_parameter(s.targets, setting.parameter)));
      continue;
    }
    if (const std::string wrong = cfg::put(s.root, *target, cfg::node_of(setting.value, setting.line)); !wrong.empty())
      errors.push_back(schedule_error(file, setting.line, printable(setting.parameter, 80) + ": " + wrong));
    const std::string path = target->path();
    std::erase_if(s.last, [&](const auto& item) {  // axes and elements that this value replaces
      return item.first == path + "_x" || item.first == path + "_y" || item.first.starts_with(path + "[");
    });
    s.last.insert_or_assign(path, setting);
    changed = true;
  }
  require_none(errors);
  if (!changed) return false;

  ConfigResult result;
  result.config.file = s.sensor.file;
  result.config.text = s.sensor.text;
  result.config.schema = s.sensor.schema;
  result.config.sha256 = s.sensor.sha256;
  cfg::interpret(s.root, result);
  for (const Diagnostic& diagnostic : result.diagnostics) {
    if (!diagnostic.error) continue;
    const Setting& cause = s.cause(diagnostic.path);
    errors.push_back(schedule_error(file, cause.line,
                                    printable(cause.parameter, 80) + " = " + printable(cause.value, 80) + " at frame " +
                                        std::to_string(cause.frame) + ": " + diagnostic.text));
  }
  require_none(errors);
  s.sensor = std::move(result.config);
  return true;
}

Schedule parse_schedule(std::string_view text, const std::string& file, const SensorConfig& sensor) {
  std::vector<std::string> errors;
  Schedule schedule{.file = file, .sha256 = sha256_hex(std::string(text))};
  schedule.settings = read_settings(text, file, errors);
  std::ranges::stable_sort(schedule.settings, [](const Setting& a, const Setting& b) { return a.frame < b.frame; });
  const auto targets = cfg::targets_of(sensor);
  std::map<std::pair<std::int64_t, std::string>, int> seen;
  for (const Setting& setting : schedule.settings) {
    if (errors.size() >= kMostScheduleErrors) break;
    const auto target = cfg::find_target(targets, setting.parameter);
    if (!target) {
      errors.push_back(schedule_error(file, setting.line, cfg::unknown_parameter(targets, setting.parameter)));
      continue;
    }
    const auto [first, fresh] = seen.try_emplace({setting.frame, target->path()}, setting.line);
    if (fresh) continue;
    errors.push_back(schedule_error(file, setting.line,
                                    printable(setting.parameter, 80) + " is set at frame " +
                                        std::to_string(setting.frame) + " by line " + std::to_string(first->second) +
                                        " already; leave one"));
  }
  require_none(errors);
  ScheduledSensor check(sensor, schedule);
  for (const Setting& setting : schedule.settings) {
    if (!check.advance(setting.frame)) continue;
    for (const std::string& named : check.sensor().files)
      if (std::ranges::find(schedule.files, named) == schedule.files.end()) schedule.files.push_back(named);
  }
  return schedule;
}

Schedule read_schedule(const std::string& path, const SensorConfig& sensor) {
  return parse_schedule(read_text_file(path, kMaxScheduleBytes), path, sensor);
}

}  // namespace mtf::io
