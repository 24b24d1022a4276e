// SPDX-License-Identifier: Apache-2.0
#pragma once

// An image file in memory, as the class Image of the package holds it.

#include <memory>
#include <string>

#include "mtf/io/image_io.h"
#include "mtf/io/scene.h"

namespace apps::python {

struct ImageHandle {
  std::string path;
  std::shared_ptr<const mtf::io::ImageFile> file;
};

/// The scene that load_scene makes of the file, from its planes in memory.
mtf::io::Scene scene_of(const mtf::io::SensorConfig& sensor, const ImageHandle& image);

}  // namespace apps::python
