// SPDX-License-Identifier: Apache-2.0
#pragma once

// The 3-D scene of the live view: the flight of apps/scene/fly, its clock and camera turned by hand. At rest a frame is
// what `mtf render` and `mtf simulate` give: two samples a pitch, four points each, the light of its own second. While
// something moves it has one sample a pitch and one point a sample, and may have the light of the last time that light
// was made for. Other weather, another engine, other materials are another heat balance (solved_scenes.h).

#include <functional>
#include <string>

#include "apps/live/space/space.h"
#include "apps/options.h"

namespace apps::live {

struct SceneViewOptions {
  std::string scene{};         ///< path
  std::string temperatures{};  ///< folder of `mtf heat`, or a table of facets; "": given in the scene file, or solved
  std::string time{};          ///< of the first picture; "": the first time that temperatures have
  bool no_air = false;
  std::function<void(const std::string&)> tell{};  ///< hears what is going on, for the page
};

/// Reads the scene, and works out its temperatures where nobody gives them. Throws as load_scene, PictureSource and
/// solved_rows.
Space open_space(const SceneViewOptions& options, const Global& global);

/// The text of a scene file whose [camera] is there, without a path; comments and all else stay.
std::string with_camera(const std::string& text, const Viewpoint& from);

}  // namespace apps::live
