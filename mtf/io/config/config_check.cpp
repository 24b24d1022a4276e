// SPDX-License-Identifier: Apache-2.0

// Findings of System::check at their place in the file. What could not be read is replaced by something plausible
// first, so that one bad table does not hide what is wrong in the others, and findings that only repeat a cause are
// left out.

#include "mtf/io/config/config_reader.h"

namespace mtf::io::cfg {
namespace {

bool is_shared(std::string_view where) {
  return where.starts_with("frame.") || where.starts_with("optics.") || where.starts_with("band.");
}

void repair(const Reader& reader, System<double>& system) {
  const auto failed = [&](const char* path) { return reader.has_failed(path); };
  Frame<double>& frame = system.frame;
  if (failed("frame.focal_length")) frame.focal_length_mm = 100.0;
  if (failed("frame.pitch") || failed("frame.pitch_x")) frame.pitch_x_um = 15.0;
  if (failed("frame.pitch") || failed("frame.pitch_y")) frame.pitch_y_um = 15.0;
  if (failed("frame.integration_time")) frame.integration_time_s = 0.01;
  if (failed("frame.format")) frame.columns = frame.rows = 0;
  Optics<double>& optics = system.optics;
  if (failed("optics.f_number") || failed("optics.aperture")) {
    optics.f_number = 2.0;
    optics.aperture_mm.reset();
  }
  if (failed("optics.obscuration")) optics.obscuration.reset();
  if (failed("band.wavelength")) system.band = Band{3.0, 5.0};
  if (failed("optics.wavelength")) optics.wavelength_um.reset();
  if (failed("optics.wavelength") && !system.band) optics.wavelength_um = 4.0;
  if (failed("band.wavelength")) optics.wavelength_um.reset();
}

/// "presample[0].rms" of the lists that were made, to the place in the file.
std::string in_file(std::string where, const Origin& origin) {
  for (const Stage stage : kStages) {
    const std::string start = std::string(stage_name(stage)) + "[";
    const std::size_t end = where.find(']');
    if (!where.starts_with(start) || end == std::string::npos) continue;
    const std::size_t i = std::stoul(where.substr(start.size(), end - start.size()));
    return start + std::to_string(origin[static_cast<std::size_t>(stage)].at(i)) + where.substr(end);
  }
  return where;
}

bool any_failed_below(const Reader& reader, const std::string& table) {
  const auto after = reader.failed.lower_bound(table + ".");
  return after != reader.failed.end() && after->starts_with(table + ".");
}

/// True for a finding that follows from something reported already.
bool is_follow_up(const Reader& reader, const std::string& path, const std::string& text) {
  if (reader.has_failed(path)) return true;
  const std::size_t dot = path.rfind('.');
  const std::string table = path.substr(0, dot);
  if (is_shared(path) || !any_failed_below(reader, table)) return false;
  // The component's fields are incomplete: believe only what concerns a value that is there, or plainly not there.
  const bool present = dot != std::string::npos && reader.positions.contains(path);
  return !present && !text.starts_with("missing");
}

}  // namespace

void check_system(Reader& reader, const System<double>& system, const Origin& origin) {
  System<double> copy = system;
  repair(reader, copy);
  const bool intact = reader.failed.empty();
  std::set<std::pair<std::string, std::string>> seen;
  bool frame_wrong = false;
  const auto report = [&](bool components) {
    for (const auto& finding : copy.check()) {
      if (is_shared(finding.where) == components) continue;
      std::string path = in_file(finding.where, origin);
      const std::string stem = path.substr(0, path.size() < 2 ? 0 : path.size() - 2);
      if ((path.ends_with("_x") || path.ends_with("_y")) && !reader.positions.contains(path) &&
          reader.positions.contains(stem))
        path = stem;
      // What a replaced value gives rise to is no news.
      if (!finding.problem.error && (!intact || frame_wrong)) continue;
      if (seen.contains({path, finding.problem.text}) || is_follow_up(reader, path, finding.problem.text)) continue;
      seen.insert({path, finding.problem.text});
      if (!finding.problem.error) {
        reader.note(reader.position_of(path), path, finding.problem.text, false);
        continue;
      }
      frame_wrong = frame_wrong || !components;
      reader.error(reader.position_of(path), path, finding.problem.text);
    }
  };
  report(false);
  repair(reader, copy);
  report(true);
}

}  // namespace mtf::io::cfg
