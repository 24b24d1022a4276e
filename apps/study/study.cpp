// SPDX-License-Identifier: Apache-2.0
#include "apps/study/study.h"

#include <sys/stat.h>

#include <algorithm>

#include "apps/study/study_reader.h"
#include "mtf/error.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "mtf/words.h"

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

}  // namespace study
