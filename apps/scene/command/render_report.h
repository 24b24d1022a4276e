// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `mtf render` prints of the pictures that it made.

#include <string>
#include <vector>

#include "apps/scene/command/render_options.h"
#include "apps/scene/render/sensor_picture.h"
#include "apps/text/json.h"

namespace apps {

/// A frame of one band for each sensor, and the attributes of their files.
struct RenderOutputs {
  const scene::PictureScene& scene;
  const std::vector<scene::PictureSensor>& sensors;
  const radiometry::render::RenderedFrame& frame;
  const std::vector<mtf::io::Metadata>& metadata;
};

Json render_json(const RenderOutputs& made, const std::vector<std::string>& outputs);

/// What was made, and the commands that come next.
std::string render_summary(const RenderCommandOptions& options, const RenderOutputs& made,
                           const std::vector<std::string>& outputs);

}  // namespace apps
