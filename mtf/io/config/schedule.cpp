// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/schedule.h"

#include <algorithm>
#include <map>

#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/config/schedule_csv.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using cfg::Node;

constexpr std::size_t kMaxScheduleBytes = std::size_t{64} << 20;

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (std::size_t i = 0; i < std::min(lines.size(), kMostScheduleErrors); ++i) text += (i > 0 ? "\n" : "") + lines[i];
  return text;
}

}  // namespace

struct ScheduledSensor::State {
  SensorConfig sensor;
  Schedule schedule;
  Node root;
  cfg::Targets targets;
  std::size_t next = 0;                              ///< first setting that is not in force yet
  std::map<std::string, Setting, std::less<>> last;  ///< in force, by path

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
                                           .targets = cfg::targets_of(sensor),
                                           .last = {}})) {}
ScheduledSensor::~ScheduledSensor() = default;
ScheduledSensor::ScheduledSensor(ScheduledSensor&&) noexcept = default;
ScheduledSensor& ScheduledSensor::operator=(ScheduledSensor&&) noexcept = default;

const SensorConfig& ScheduledSensor::sensor() const { return state_->sensor; }

std::string ScheduledSensor::in_force() const {
  std::string text;
  for (const auto& [path, setting] : state_->last)
    text += (text.empty() ? "" : "; ") + setting.parameter + " = " + setting.value;
  return text;
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
  if (!errors.empty()) throw UsageError(joined(errors));
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
  if (!errors.empty()) throw UsageError(joined(errors));
  s.sensor = std::move(result.config);
  return true;
}

Schedule parse_schedule(std::string_view text, const std::string& file, const SensorConfig& sensor) {
  std::vector<std::string> errors;
  Schedule schedule{.file = file, .sha256 = sha256_hex(std::string(text)), .settings = {}};
  schedule.settings = read_settings(text, file, errors);
  std::stable_sort(schedule.settings.begin(), schedule.settings.end(),
                   [](const Setting& a, const Setting& b) { return a.frame < b.frame; });
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
  if (!errors.empty()) throw UsageError(joined(errors));
  ScheduledSensor check(sensor, schedule);
  for (const Setting& setting : schedule.settings) {
    if (!check.advance(setting.frame)) continue;
    for (const std::string& named : check.sensor().files)
      if (std::find(schedule.files.begin(), schedule.files.end(), named) == schedule.files.end())
        schedule.files.push_back(named);
  }
  return schedule;
}

Schedule read_schedule(const std::string& path, const SensorConfig& sensor) {
  return parse_schedule(read_text_file(path, kMaxScheduleBytes), path, sensor);
}

}  // namespace mtf::io
