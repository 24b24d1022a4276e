// SPDX-License-Identifier: Apache-2.0
#include "apps/simulate/frames/frame.h"

#include "apps/simulate/sensor_image.h"
#include "apps/simulate/simulate_parts.h"
#include "mtf/survey/bad_pixels.h"

namespace apps {
namespace {

std::vector<mtf::Image> filtered(Frame& frame, radiometry::ChainState* state, int threads) {
  const SceneInput& input = *frame.input;
  if (frame.chain) {
    const auto number = static_cast<std::uint32_t>(frame.number);
    const radiometry::OutputStage stage = frame.radiometric->stage;
    frame.counted =
        frame.kept != nullptr
            ? frame.chain->run(*frame.kept, number, stage, input.border_value, threads, state, frame.noise_rows)
            : frame.chain->run(input.scene.planes.front().clone(), number, stage, input.border_value, threads, state);
    std::vector<mtf::Image> images;
    images.push_back(std::move(frame.counted.image));
    return images;
  }
  if (frame.kept != nullptr) return frame.plan->run(*frame.kept, input.border_value, threads);
  std::vector<mtf::ImageView<const float>> planes;
  for (const mtf::Image& plane : input.scene.planes) planes.push_back(plane.view());
  return frame.plan->run(planes, input.border_value, threads);
}

}  // namespace

std::vector<mtf::Image> run_planes(Frame& frame, radiometry::ChainState* state, int threads) {
  const SceneInput& input = *frame.input;
  std::vector<mtf::Image> images = filtered(frame, state, threads);
  for (std::size_t c = 0; c < input.masks.size(); ++c)
    if (input.masks[c].size() > 0)
      mtf::propagate_bad_pixels(*frame.plan, input.masks[c], frame.plan->options.tolerance, threads, images[c].view());
    else if (!mtf::all_finite(images[c].view()))
      refuse_overflow(input.scene.names[c]);
  return images;
}

mtf::io::Metadata metadata_of(const Frame& frame) {
  mtf::io::Metadata metadata =
      provenance(*frame.sensor, frame.input->scene, *frame.plan, frame.plan->options.tolerance);
  metadata.text["mtf:frame"] = std::to_string(frame.number);
  if (!frame.settings.empty()) metadata.text["mtf:schedule"] = frame.settings;
  if (frame.radiometric) add_chain(metadata, *frame.radiometric, static_cast<std::uint32_t>(frame.number));
  return metadata;
}

}  // namespace apps
