// SPDX-License-Identifier: Apache-2.0

// What `mtf range` takes.

#include <algorithm>

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/range/range_options.h"
#include "mtf/error.h"
#include "mtf/units.h"
#include "radiometry/performance/conditions.h"

namespace apps {
namespace {

/// Keys of [conditions] that are about other figures.
bool is_of_ranges(std::string_view key) { return key != "range" && key != "elevation" && key != "signal_contrast"; }

/// "1:10:10 km" or "1,2,5 km", in m.
std::vector<double> lengths(const std::string& option, const std::string& text) {
  const std::size_t end = text.find_last_not_of("abcdefghijklmnopqrstuvwxyz") + 1;
  try {
    std::vector<double> values = frequency_list(option, text.substr(0, text.find_last_not_of(' ', end - 1) + 1));
    const double unit_m = mtf::convert(mtf::parse_quantity("1" + text.substr(end), mtf::Dimension::length), "m");
    for (double& value : values) {
      value *= unit_m;
      if (!(value > 0.0)) throw mtf::UsageError(option + ": ranges are above 0");
    }
    constexpr std::size_t kMost = 10000;
    if (values.size() > kMost)
      throw mtf::UsageError(option + ": more than " + std::to_string(kMost) + " ranges; each takes a millisecond");
    if (!std::is_sorted(values.begin(), values.end())) throw mtf::UsageError(option + ": ranges rise");
    return values;
  } catch (const mtf::UsageError& wrong) {
    const std::string what = wrong.what();
    throw mtf::UsageError((what.starts_with(option) ? "" : option + ": ") + what +
                          "; write START:STOP:COUNT or a list, and a unit, such as '1:10:10 km'");
  }
}

}  // namespace

Command range_command() {
  const auto shared = std::make_shared<RangeOptions>();
  RangeOptions& options = *shared;
  Command app{
      "range", "how far a sensor detects, recognises and identifies a target",
      "Ranges and probability against range by TTP (NVThermIP) and by Johnson's criteria (MRTD of FLIR92), each with\n"
      "its error. Target and contrast have to be given; TTP needs what the observer looks at too: --display-height "
      "and\n"
      "--viewing-distance, or --magnification. The air is that of the sensor file ([atmosphere], or path.table), up "
      "to\n"
      "each range, or --extinction. Numbers that the sensor file states as { value, stderr } give each range a\n"
      "standard deviation. --target nato is the target of STANAG 4347: 2.3 m x 2.3 m, 2 K.",
      "  mtf range sensor.toml --target nato --magnification 5\n"
      "  mtf range sensor.toml --contrast '1 K' --target-size '3 m' --extinction 0.2 --format csv -o range.csv"};
  add_file(app, "sensor", "sensor file (TOML)", options.sensor);
  add_word(app, "--target", "NAME", "standard target, whose size and contrast other options replace: nato",
           [&](const std::string& text) { options.target = choice("--target", text, kStandardTargets); })
      .candidates = one_of(kStandardTargets);
  add_keys(app, radiometry::Conditions{}, options.given, is_of_ranges);
  add_word(app, "--ranges", "LIST",
           "of the probabilities, such as '1:10:10 km' (START:STOP:COUNT) or '1,2,5 km'; default: round lengths "
           "that show all tasks",
           [&](const std::string& text) { options.range_m = lengths("--ranges", text); });
  add_text(app, "--plot", "FILE", "figure of probability against range: a .svg, .pdf or .png file", options.plot);
  add_format(app, "table (default), csv (probabilities) or json (all)", options.format);
  add_text(app, "-o,--out", "FILE", "write the result here instead of standard output", options.out);
  app.run = [shared](const Global& global) { return run_range(*shared, global); };
  return app;
}

}  // namespace apps
