// SPDX-License-Identifier: Apache-2.0

// `mtf range SENSOR`: how far a sensor detects, recognises and identifies a target.

#include <array>

#include "apps/config_command.h"
#include "apps/range/range_options.h"
#include "apps/range/range_report.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"

namespace apps {
namespace {

/// A target that others know by name.
struct StandardTarget {
  std::string_view name;
  double size_m, contrast_k;
};
/// "nato": STANAG 4347 (1995), 2.3 m x 2.3 m, 2 K above its background.
constexpr std::array kTargets{std::pair{std::string_view("nato"), StandardTarget{"nato", 2.3, 2.0}}};

/// Keys of [conditions] in a message, as the options that they are here.
std::string in_options(std::string text) {
  const auto replace = [&](const std::string& key, const std::string& option) {
    for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + option.size()))
      text.replace(at, key.size(), option);
  };
  const radiometry::Conditions keys;
  radiometry::for_each_field(keys, [&](const radiometry::FieldInfo& info, const auto&) {
    const std::string key(info.name);
    replace("[conditions] " + key, option_of(key));
    if (key.find('_') != std::string::npos) replace(key, option_of(key));
  });
  return text;
}

radiometry::Conditions conditions_of(const RangeOptions& options) {
  radiometry::Conditions conditions;
  if (!options.target.empty()) {
    const StandardTarget& target = choice("--target", options.target, kTargets);
    conditions.target_size_m = target.size_m;
    conditions.contrast_k = target.contrast_k;
  }
  set_keys(conditions, options.given);
  if (conditions.contrast_k == 0.0)
    throw mtf::UsageError(
        "--contrast: a target as warm as its background shows nothing, at no range; give the "
        "difference, such as --contrast '2 K'");
  if (conditions.contrast_k && *conditions.contrast_k < 0.0)
    throw mtf::UsageError(
        "--contrast: give the size of the difference, above 0; the models are the same for targets "
        "that are colder than their background");
  try {
    radiometry::require_valid("", conditions);
  } catch (const mtf::UsageError& wrong) {
    std::string text = "\n" + std::string(wrong.what());  // each line begins with "." and its key
    for (std::size_t at = text.find("\n."); at != std::string::npos; at = text.find("\n.", at + 1))
      text.replace(at + 1, 1, "[conditions] ");
    throw mtf::UsageError(in_options(text.substr(1)));
  }
  if (!conditions.contrast_k)
    throw mtf::UsageError("no contrast of the target; give --contrast '2 K', or --target nato");
  if (!conditions.target_size_m)
    throw mtf::UsageError(
        "no size of the target; give --target-size '2.3 m', the square root of its area, or --target "
        "nato");
  if (conditions.magnification && (conditions.display_height_m || conditions.viewing_distance_m))
    throw mtf::UsageError("--magnification: given together with a display, from which it follows; remove one of them");
  if (conditions.display_height_m.has_value() != conditions.viewing_distance_m.has_value())
    throw mtf::UsageError(conditions.display_height_m ? "--display-height: needs --viewing-distance beside it"
                                                      : "--viewing-distance: needs --display-height beside it");
  return conditions;
}

study::Acquisition acquired(const mtf::io::SensorConfig& config, const radiometry::Conditions& conditions,
                            const std::vector<double>& range_m) {
  try {
    study::Acquisition found = study::acquisition(config, conditions, range_m);
    for (study::TaskRange& task : found.tasks) task.reason = in_options(task.reason);
    return found;
  } catch (const mtf::UsageError& refused) {
    throw mtf::UsageError(placed(config, in_options(refused.what())));
  }
}

/// Five steps for each of the table, so that curves look like curves.
std::vector<double> between(const std::vector<double>& range_m) {
  constexpr int kSteps = 5;
  std::vector<double> fine;
  for (std::size_t r = 0; r + 1 < range_m.size(); ++r)
    for (int k = 0; k < kSteps; ++k) fine.push_back(range_m[r] + (range_m[r + 1] - range_m[r]) * k / kSteps);
  if (!range_m.empty()) fine.push_back(range_m.back());
  return fine;
}

}  // namespace

int run_range(const RangeOptions& options, const Global& global) {
  const radiometry::Conditions conditions = conditions_of(options);
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  std::vector<std::string> files{options.out};
  for (std::string& file : figure_files(options.plot)) files.push_back(std::move(file));
  OutputSet outputs({.files = files, .inputs = files_of(config)});
  const study::Acquisition found = acquired(config, conditions, options.range_m);
  if (!options.range_m.empty() && found.range_m.empty())
    throw mtf::UsageError(
        "--ranges: " + (found.cautions.empty() ? std::string("none can be") : found.cautions.front()) +
        "; ask for ranges on this side");
  if (!options.plot.empty()) {
    const std::string title = config.system.name.empty() ? config.file : config.system.name;
    const study::Acquisition fine =
        options.range_m.empty() ? acquired(config, conditions, between(found.range_m)) : found;
    const bool drawn = write_figure(outputs.at(options.plot), range_figure(fine, one_line(title)));
    note(global, figure_note(options.plot, drawn));
  }
  if (options.format != Format::table)
    for (const std::string& caution : found.cautions) note(global, "caution: " + one_line(caution));
  if (options.format == Format::csv)
    for (const std::string& line : found.lines) note(global, "note: " + one_line(line));
  outputs.commit(options.out, options.format == Format::csv    ? range_csv(found)
                              : options.format == Format::json ? range_json(found, conditions, config)
                                                               : range_table(found, conditions));
  return 0;
}

}  // namespace apps
