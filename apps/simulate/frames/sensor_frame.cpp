// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/sensor_frame.h"

#include <utility>

#include "apps/sensor/sensor_place.h"
#include "mtf/survey/bad_pixels.h"

namespace apps {
namespace {

std::vector<mtf::Image> through_chain(Frame& frame, radiometry::ChainState* state, int threads) {
  const SceneInput& input = *frame.input;
  const auto number = static_cast<std::uint32_t>(frame.number);
  const radiometry::OutputStage stage = frame.sensor.chain()->stage;
  frame.counted = at_its_place(frame.sensor.config(), [&] {
    if (frame.kept != nullptr)
      return frame.chain->run(*frame.kept, number, stage, input.border_value, threads, state, frame.noise_rows);
    mtf::Image light =
        frame.own != nullptr ? std::move(frame.own->scene.planes.front()) : input.scene.planes.front().clone();
    return frame.chain->run(std::move(light), number, stage, input.border_value, threads, state);
  });
  std::vector<mtf::Image> images;
  images.push_back(std::move(frame.counted.image));
  return images;
}

std::vector<mtf::Image> filtered(Frame& frame, int threads) {
  const SceneInput& input = *frame.input;
  if (frame.kept != nullptr) return frame.plan->run(*frame.kept, input.border_value, threads);
  if (frame.own != nullptr && !frame.tiles)
    return frame.plan->run(std::move(frame.own->scene.planes), input.border_value, threads);
  std::vector<mtf::ImageView<const float>> planes;
  for (const mtf::Image& plane : input.scene.planes) planes.push_back(plane.view());
  return frame.tiles ? frame.tiles->run(planes, input.border_value, &frame.tally)
                     : frame.plan->run(planes, input.border_value, threads);
}

}  // namespace

std::vector<std::string> warnings_of(const Frame& frame) {
  std::vector<std::string> warnings = frame.input->scene.warnings;
  for (std::string& text : mtf::io::sampling_warnings(frame.sensor.config().system, frame.input->scene.grid))
    warnings.push_back(std::move(text));
  warnings.insert(warnings.end(), frame.input->warnings.begin(), frame.input->warnings.end());
  return warnings;
}

void load_own(Frame& frame, SceneSource source, NanPolicy nan, int threads, RunWatch* watch) {
  const auto input = std::make_shared<SceneInput>(load_input(std::move(source), frame.sensor, nan, threads, watch));
  frame.own = input.get();
  frame.input = input;
}

std::shared_ptr<const radiometry::Chain> chain_of(const SensorRun& sensor, const mtf::SensorPlan& plan, int threads,
                                                  const radiometry::Chain* before, bool keep_shading) {
  if (sensor.is_linear()) return nullptr;
  return at_its_place(sensor.config(), [&] {
    return std::make_shared<const radiometry::Chain>(plan, sensor.system(), sensor.chain()->loaded.sensor,
                                                     radiometry::Origin{}, threads, before, keep_shading);
  });
}

std::vector<mtf::Image> run_planes(Frame& frame, radiometry::ChainState* state, int threads) {
  const SceneInput& input = *frame.input;
  std::vector<mtf::Image> images = frame.chain ? through_chain(frame, state, threads) : filtered(frame, threads);
  for (std::size_t c = 0; c < images.size(); ++c) {
    const mtf::Image& mask = input.masks[c];
    if (mask.size() > 0)
      mtf::propagate_bad_pixels(*frame.plan, mask, frame.plan->options.tolerance, threads, images[c].view());
    if (frame.region) images[c] = cropped(images[c], *frame.region);
    if (mask.size() == 0 && !mtf::all_finite(images[c].view())) refuse_overflow(input.scene.names[c]);
  }
  return images;
}

mtf::io::Metadata metadata_of(const Frame& frame) {
  mtf::io::Metadata metadata =
      frame.sensor.metadata(frame.input->scene, *frame.plan, frame.plan->options.tolerance, frame.number);
  metadata.text["mtf:frame"] = std::to_string(frame.number);
  if (!frame.settings.empty()) metadata.text["mtf:schedule"] = frame.settings;
  return metadata;
}

}  // namespace apps
