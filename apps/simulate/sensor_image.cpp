// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/sensor_image.h"

#include <algorithm>

#include "mtf/version.h"

namespace apps {

using namespace mtf::io;  // NOLINT: this file is about image files only

Metadata provenance(const SensorConfig& config, const Scene& scene, const mtf::SensorPlan& plan, double tolerance) {
  const mtf::Frame<double>& frame = config.system.frame;
  Metadata m;
  m.text["mtf:quantity"] = quantity_name(scene.quantity);
  m.text["mtf:units"] = quantity_unit(scene.quantity);
  // Filtered light is still weighted by what it was weighted by, has its air, and was seen there and then.
  for (const char* name :
       {"mtf:quantity", "mtf:response", "mtf:path", "mtf:time", "mtf:cameraPosition", "mtf:cameraAhead"})
    if (const auto found = scene.info.attributes.find(name);
        found != scene.info.attributes.end() &&
        (name != std::string_view("mtf:quantity") || found->second.starts_with("weighted_")))
      m.text[name] = found->second;
  m.text["mtf:configSha256"] = config.sha256;
  m.text["mtf:sensor"] = config.system.name;
  m.text["mtf:version"] = std::string(mtf::version) + " " + mtf::git_commit;
  m.text["mtf:tolerance"] = mtf::format_double(tolerance);
  m.text["mtf:predictedError"] = mtf::format_double(plan.predicted_error);
  m.pairs["mtf:pixelPitch"] = {frame.pitch_x_um / 1e6, frame.pitch_y_um / 1e6};
  m.pairs["mtf:ifov"] = {frame.pitch_x_um * 1e-3 / frame.focal_length_mm,
                         frame.pitch_y_um * 1e-3 / frame.focal_length_mm};
  if (config.system.band)
    m.lists["mtf:bandEdges"] = {static_cast<float>(config.system.band->lo_um),
                                static_cast<float>(config.system.band->hi_um)};
  if (const auto before = scene.info.attributes.find("mtf:history"); before != scene.info.attributes.end())
    m.history.push_back(before->second);
  m.history.push_back("mtf simulate: presample OTF, sampling at the pitch" +
                      std::string(plan.post ? ", readout and postsample filters" : ""));
  return m;
}

std::vector<std::string> output_names(const std::vector<std::string>& names) {
  if (names.size() == 1) return {"Y"};
  const auto last = [](const std::string& name) { return name.substr(name.rfind('.') + 1); };
  if (names.size() == 3) {
    std::vector<std::string> colours;
    for (const std::string& name : names) colours.push_back(last(name));
    std::vector<std::string> sorted = colours;
    std::sort(sorted.begin(), sorted.end());
    if (sorted == std::vector<std::string>{"B", "G", "R"}) return colours;
  }
  return names;
}

Written write_sensor_image(const std::string& path, const std::vector<std::string>& names,
                           const std::vector<mtf::Image>& planes, const Metadata& metadata, const IntegerRange& range) {
  std::vector<NamedPlane> named;
  for (std::size_t i = 0; i < planes.size(); ++i) named.push_back({names[i], planes[i].view()});
  if (holds_floats(format_from_extension(path))) {
    write_floats(path, named, metadata);
    return {};
  }
  Written written;
  written.scaling = full_range_scaling(named);
  if (range.ends) {
    const auto& [low, high] = *range.ends;
    written.scaling = IntegerScaling{.offset = low, .bits = range.bits};
    written.scaling->gain = (high - low) / written.scaling->largest();
  }
  written.clamped = write_integer(path, named, *written.scaling, metadata);
  return written;
}

}  // namespace apps
