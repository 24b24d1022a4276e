// SPDX-License-Identifier: Apache-2.0
#include "apps/live/answers.h"

#include "apps/text/json.h"

namespace apps::live {

std::string error_of(const Answer& answer) {
  const std::optional<Json> json = parsed_json(*answer.body);
  return json && json->contains("error") ? json->at("error").get<std::string>() : "";
}

Answer json_answer(const Json& json, int status) {
  return {.status = status, .body = std::make_shared<const std::string>(json_document(json, -1))};
}

Answer refusal(const std::string& text, int status) {
  const bool of_form = status == 400 || status == 404;
  return json_answer({{"error", text}, {"status", status}}, of_form ? status : 200);
}

void add_pixel_facts(Json& facts, const PixelBytes& pixels) {
  facts["width"] = pixels.width;
  facts["height"] = pixels.height;
  facts["low"] = pixels.low;
  facts["high"] = pixels.high;
  facts["dark"] = pixels.dark;
  facts["bright"] = pixels.bright;
}

Answer pixels_answer(Json facts, const PixelBytes& pixels, const std::string& more) {
  add_pixel_facts(facts, pixels);
  std::string json = json_document(facts, -1);
  json.resize((json.size() + 3) / 4 * 4, ' ');  // the numbers begin at a multiple of their size
  const auto length = static_cast<std::uint32_t>(json.size());
  std::string body;
  body.reserve(4 + json.size() + pixels.bytes.size() + more.size());
  for (int byte = 0; byte < 4; ++byte) body += static_cast<char>((length >> (8 * byte)) & 0xffU);
  body += json;
  body += pixels.bytes;
  body += more;
  return {.type = "application/octet-stream", .body = std::make_shared<const std::string>(std::move(body))};
}

Json left_out_json(const mtf::SensorPlan& plan) {
  Json left = Json::array();
  const auto add = [&](const mtf::PlanReport& report) {
    for (const mtf::Dropped& d : report.dropped) left.push_back({{"what", d.label}, {"bound", d.bound}});
    for (const mtf::Omission& o : report.omitted)
      left.push_back({{"what", o.what}, {"bound", o.bound}, {"saved_ms", o.saved_ms}});
  };
  add(plan.presample.report());
  if (plan.readout) add(plan.readout->report());
  if (plan.post) add(plan.post->report());
  return left;
}

Json scene_facts(const mtf::io::Scene& scene, int every) {
  return {{"full_width", scene.planes.front().width()},
          {"full_height", scene.planes.front().height()},
          {"every", every},
          {"step_x_um", scene.grid.step_x_um},
          {"step_y_um", scene.grid.step_y_um},
          {"quantity", std::string(mtf::io::quantity_name(scene.quantity))},
          {"unit", std::string(mtf::io::quantity_unit(scene.quantity))}};
}

}  // namespace apps::live
