// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a scene comes from: a file, or planes in memory. Either becomes a mtf::io::Scene: planes of physical values on
// a sample grid that is given at the focal plane.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "mtf/io/scene.h"

namespace apps {

struct SceneSource {
  std::string
      file{};  ///< an image (mtf/io/image_formats.h), frame.%04d.exr for a sequence; with `image` its name in messages
  mtf::io::ReadOptions read{};                         ///< channels of the file
  std::shared_ptr<const mtf::io::ImageFile> stored{};  ///< what is in `file`, where it has been read already
  /// A scene in memory: `planes` of one size and of `quantity` in its unit (mtf::io::quantity_unit; gain, offset and
  /// encoding of [scene] are for files). What is left out is filled in: `names`, the size of `grid`, and its steps in
  /// um, which are those of [scene] where they are 0.
  std::optional<mtf::io::Scene> image{};
  /// Planes beside `image`, by the names that [scene] emissivity_channel (0 to 1) and depth_channel (m) give.
  std::map<std::string, mtf::Image> beside{};
  /// Acts on the scene, in the quantity that the sensor filters, before everything of the sensor; it may change the
  /// planes and with them the size of the grid. For whole images of sensors without [distortion].
  std::function<void(mtf::io::Scene&)> filter{};
};

/// What is known of a scene, without its planes.
mtf::io::Scene facts_of(const mtf::io::Scene& scene);

/// The same once more, its planes copied.
mtf::io::ImageFile copy_of(const mtf::io::ImageFile& file);
SceneSource clone(const SceneSource& source);

/// A scene in memory gets a name for messages where it has none.
void complete_name(SceneSource& source);

/// The scene, taken out of `source`. Throws as mtf::io::load_scene, and UsageError
/// for a scene in memory without planes, with planes of several sizes, or whose sample spacing nobody gives.
mtf::io::Scene take_scene(const mtf::io::SensorConfig& sensor, SceneSource& source);

/// The plane of that name beside the scene. Throws UsageError where there is none.
mtf::Image plane_beside(const SceneSource& source, const std::string& name);

}  // namespace apps
