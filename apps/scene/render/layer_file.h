// SPDX-License-Identifier: Apache-2.0
#pragma once

// The layers that another renderer wrote (OpenEXR), for radiometry/render/layers: which channel is what, which of its
// numbers is which material of the scene file, and temperatures of materials where it has none.
//   depth        of the plane across the optical axis, as Blender's Z, or a range along the ray
//   material     numbers, as Blender's IndexMA: those of a table index,material[,temperature_K]; without one, the
//                materials of the scene file from 0 on, as `mtf render --layer material` writes them
//   temperature  K; or the table's
//   normal       X, Y, Z in axes of the scene; optional
//   sunlit       share that the sun reaches; optional

#include <map>
#include <optional>
#include <string>

#include "apps/scene/scene_file/scene_file.h"
#include "radiometry/render/layers/layer_picture.h"

namespace apps::scene {

struct LayerFile {
  std::string file;
  std::map<std::string, std::string> channels{};  ///< of roles whose name is not the usual one
  std::string materials{};                        ///< path of the table; "" = none
  std::optional<bool> planar{};                   ///< depths, or ranges; as the file is, where nobody says it: ranges
                                                  ///< in pictures of `mtf render`, depths in others
};

/// Words of LayerFile::channels.
inline constexpr std::array<std::string_view, 7> kLayerRoles{"depth",    "material", "temperature", "normal.X",
                                                             "normal.Y", "normal.Z", "sunlit"};

/// Throws UsageError for channels that are not there, with those that are, for tables that do not fit, and numbers that
/// the table does not have; RuntimeError for files that cannot be read.
radiometry::render::SurfaceLayers read_layers(const LayerFile& from, const SceneFile& scene,
                                              const radiometry::render::Camera& camera);

}  // namespace apps::scene
