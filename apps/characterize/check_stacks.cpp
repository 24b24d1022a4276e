// SPDX-License-Identifier: Apache-2.0

// `mtf characterize check`: what stacks of frames can determine, as the headers of their files say.

#include <cmath>
#include <set>

#include "apps/characterize/characterize_options.h"
#include "apps/characterize/find_camera.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "calib/characterize/thermal.h"
#include "mtf/error.h"

namespace apps {

void check_stacks(const StacksFile& file, const std::optional<mtf::io::SensorConfig>& nominal, Format format,
                  int threads) {
  const std::vector<StackShapes> shapes = look_at_stacks(file, nominal, threads);
  const int bits = bits_of(file, nominal);
  const std::string frames = words_of(shapes[0][0]);
  TextTable stacks({"stack", "files", "frames", "exposure", std::string(name_of(file.unit))}),
      numbers({"number", "can be determined"});
  Json json{{"frames", frames}, {"bits", bits}, {"stacks", Json::array()}, {"numbers", Json::array()}};
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const StackEntry& one = file.stacks[i];
    std::int64_t count = 0;
    for (const FrameShape& shape : shapes[i]) count += shape.frames;
    stacks.add({one_line(one.name), std::to_string(one.files.size()), std::to_string(count),
                file.has_times ? significant(1e3 * one.time_s, 6) + " ms" : "-",
                one.step_s > 0.0  ? "steps"
                : one.light > 0.0 ? significant(one.light, 6)
                                  : "dark"});
    json["stacks"].push_back({{"name", one.name}, {"frames", count}, {"light", one.light}, {"time_s", one.time_s}});
  }
  std::set<double> lights, dark_times;
  std::size_t count = 0;
  for (const StackEntry& entry : file.stacks) {
    if (entry.step_s > 0.0) continue;
    ++count;
    lights.insert(entry.light);
    if (!(entry.light > 0.0)) dark_times.insert(entry.time_s);
  }
  std::string few = file.has_blackbodies() ? calib::too_few_radiances(count, lights.size() > 1)
                                           : calib::too_few_levels(lights.size(), file.nonlinearity);
  for (const StackEntry& entry : file.stacks)
    if (few.empty() && file.has_times && !file.has_blackbodies() && entry.light > 0.0 && !(entry.step_s > 0.0))
      few = calib::other_exposure_words(one_line(entry.name), entry.time_s, dark_times);
  const std::string dark = dark_times.empty() ? "no dark stack: give one with light = false" : "";
  const std::string times = file.has_times && dark_times.size() > 1 ? few : "it takes dark stacks of two exposures";
  using Numbers = std::vector<std::pair<const char*, std::string>>;
  const Numbers by_light{{"gain, read noise, offset, rate, crosstalk", few},
                         {"noise of rows and columns", few},
                         {"dark current", times},
                         {"fixed patterns in the dark", few.empty() ? dark : few},
                         {"fixed patterns of the response", few.empty() ? dark : few}};
  const Numbers of_blackbodies{
      {"SiTF, NETD, 3-D noise, offset", few},
      {"whether counts are linear in the radiance", lights.size() > 2 ? "" : "it takes three temperatures"}};
  Numbers all = file.has_blackbodies() ? of_blackbodies : by_light;
  all.emplace_back("lag", count < shapes.size() ? "" : "it takes frames whose light steps, with step = \"20 ms\"");
  for (const auto& [name, why] : all) {
    numbers.add({name, why.empty() ? "yes" : "no: " + why});
    json["numbers"].push_back({{"name", name}, {"possible", why.empty()}, {"why", why}});
  }
  print(format == Format::json ? json_document(json)
                               : stacks.aligned() + "\nframes of " + frames + ", counts from 0 to " +
                                     significant(std::ldexp(1.0, bits) - 1.0, 10) + " in steps of " +
                                     significant(file.step, 6) + "\n\n" + numbers.aligned());
  if (!few.empty()) throw mtf::UsageError(few);  // as the run
}

}  // namespace apps
