// SPDX-License-Identifier: Apache-2.0
#pragma once

// Answers of the live view: JSON, or facts and pixels. Pixels follow their facts: four bytes with the length of the
// JSON, the JSON, the numbers of PixelBytes; of a 3-D scene those of the radiance after those of the image.

#include <memory>
#include <string>

#include "apps/live/frames.h"
#include "apps/live/model.h"

namespace apps::live {

struct Answer {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
};

/// The message of an answer that is an error, "" of others.
std::string error_of(const Answer& answer);

Answer json_answer(const Json& json, int status = 200);
/// What cannot be done with a request that is allowed: an ordinary answer, as browsers put others on their console.
Answer refusal(const std::string& text, int status = 422);

/// Facts and pixels in one body; `more` follows.
Answer pixels_answer(Json facts, const PixelBytes& pixels, const std::string& more = "");
/// The size and the ends of pixels, among their facts.
void add_pixel_facts(Json& facts, const PixelBytes& pixels);
/// Of a scene of which every `every`-th sample is sent.
Json scene_facts(const mtf::io::Scene& scene, int every);
/// What the plan does not compute, with bounds.
Json left_out_json(const mtf::SensorPlan& plan);

}  // namespace apps::live
