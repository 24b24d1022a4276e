// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/render_report.h"

#include <filesystem>

#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/statistics.h"
#include "radiometry/weather/instant.h"

namespace apps {

namespace fs = std::filesystem;

Json render_json(const RenderOutputs& made, const std::vector<std::string>& outputs) {
  const auto& [scene, sensors, frame, metadata] = made;
  Json json;
  for (const auto& [name, text] : metadata.front().text) json["attributes"][name] = text;
  for (const auto& [name, text] : scene.closures) json["closures"][name] = text;
  json["divided_samples"] = frame.divided;
  json["shadow_rays"] = frame.shadow_rays;
  json["visible_sides"] = frame.sides;
  json["promised_error"] = frame.promised.front();
  for (std::size_t b = 0; b < outputs.size(); ++b)
    json["pictures"].push_back({{"file", outputs[b]},
                                {"sensor", metadata[b].text.at("mtf:sensor")},
                                {"quantity", metadata[b].text.at("mtf:quantity")},
                                {"promised_error", frame.promised[b]}});
  if (frame.view_rays > 0) {
    json["view_rays"] = frame.view_rays;
    for (std::size_t b = 0; b < outputs.size(); ++b) json["pictures"][b]["reflected_error_K"] = frame.reflected_k[b];
  }
  json["timing_ms"] = Json::object();
  for (const auto& times : {scene.timing_ms, frame.timing_ms})
    for (const auto& [name, ms] : times) {
      Json& time = json["timing_ms"][name];
      time = (time.is_null() ? 0.0 : time.get<double>()) + ms;
    }
  return json;
}

std::string render_summary(const RenderCommandOptions& options, const RenderOutputs& made,
                           const std::vector<std::string>& outputs) {
  const auto& [scene, sensors, frame, metadata] = made;
  TextTable table({"what", "value"});
  const mtf::Image& first = frame.radiance.front();
  table.add({"samples", std::to_string(first.width()) + " x " + std::to_string(first.height())});
  table.add({"time", radiometry::heat::instant_text(scene.utc_s)});
  const bool one = sensors.size() == 1;
  std::string written, next;
  for (std::size_t b = 0; b < sensors.size(); ++b) {
    const auto& text = metadata[b].text;
    const mtf::Statistics s = mtf::statistics(frame.radiance[b].view());
    const std::string of = one ? "" : one_line(fs::path(options.sensors[b]).stem().string()) + ": ";
    table.add({of + text.at("mtf:quantity") + " [" + text.at("mtf:units") + "]",
               significant(s.min, 4) + " to " + significant(s.max, 4) + ", mean " + significant(s.mean, 4)});
    table.add({of + "error of tables", "at most " + significant(frame.promised[b], 2) + ", relative"});
    if (frame.view_rays > 0)
      table.add({of + "error of reflected light", significant(1e3 * frame.reflected_k[b], 2) + " mK rms at 300 K, by " +
                                                      std::to_string(frame.view_rays) + " rays a side"});
    const scene::FinestDetail finest = scene::finest_detail(sensors[b], options.sampling.samples_per_pitch);
    table.add({of + "finest detail of samples", significant(finest.frequency_cy_mm, 3) +
                                                    " cy/mm, where the sensor's MTF is " + significant(finest.mtf, 2)});
    written += (b == 0 ? "written to " : " ") + outputs[b];
    const std::string image = one ? "image" : fs::path(outputs[b]).replace_extension().string() + "_image";
    next += "next: mtf simulate " + shell_word(options.sensors[b]) + " " + shell_word(outputs[b]) + " -o " +
            shell_word(image + ".exr") + (scene.scene.air && sensors[b].has_path ? " --without-path" : "") + "\n";
  }
  if (frame.sides > 0)
    table.add({"visible sides",
               std::to_string(frame.sides) + "; " + std::to_string(frame.divided) + " samples show more than one"});
  if (frame.shadow_rays > 0) table.add({"shadow rays", std::to_string(frame.shadow_rays)});
  for (const auto& [name, words] : scene.closures) table.add({name, words});
  using enum Align;
  return table.aligned({left, left}) + written + (options.picture.empty() ? "" : " " + options.picture) + "\n" + next;
}

}  // namespace apps
