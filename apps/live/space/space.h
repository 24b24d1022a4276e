// SPDX-License-Identifier: Apache-2.0
#pragma once

// A 3-D scene, as the session sees it: what draws it, the times that it has, where its camera is at the start, what of
// its file the page changes. Builds without scenes have none.

#include <functional>
#include <span>
#include <string>

#include "apps/live/edits.h"
#include "apps/live/frames.h"
#include "apps/live/model.h"
#include "apps/options.h"

namespace apps::live {

struct Space {
  /// Frames of a flight of their own: each keeps what it has seen.
  std::function<DrawScene()> drawer{};
  Viewpoint start{};
  double begin_s = 0.0, end_s = 0.0;  ///< UTC, times that pictures may be of
  /// For the page: the scene's size, what stands for sky and air, the command's words, what does not change here.
  Json facts{};
  /// "elevation_deg", "solar_time_h" of the sun there at a time.
  std::function<Json(double utc_s)> sun{};
  /// The text of the scene file with these edits. Throws UsageError for one that cannot be made.
  std::function<std::string(std::span<const Edit>)> edited{};
  /// The rows of such a text, for the page.
  std::function<Json(const std::string&)> rows{};
  /// The text with a camera there.
  std::function<std::string(const std::string&, const Viewpoint&)> with_camera{};
};

/// "position", "look_at" and "utc_s" of a request; what is missing is that of the start. Whole seconds. Throws
/// UsageError for what is no number, out of range, or a camera that looks at its own position.
Viewpoint viewpoint_of(const Json& request, const Space& space);

// The 3-D scene of the live view: the flight of apps/scene/fly, its clock and camera turned by hand. At rest a frame is
// what `mtf render` and `mtf simulate` give: two samples a pitch, four points each, the light of its own second. While
// something moves it has one sample a pitch and one point a sample, and may have the light of the last time that light
// was made for. Other weather, another engine, other materials are another heat balance (solved_scenes.h).

struct SceneViewOptions {
  std::string scene{};         ///< path
  std::string temperatures{};  ///< folder of `mtf heat`, or a table of facets; "": given in the scene file, or solved
  std::string time{};          ///< of the first picture; "": the first time that temperatures have
  bool no_air = false;
  mtf::DeviceChoice device{};
  std::function<void(const std::string&)> tell{};  ///< hears what is going on, for the page
};

/// Reads the scene, and works out its temperatures where nobody gives them. Throws as load_scene, PictureSource and
/// solved_rows.
Space open_space(const SceneViewOptions& options, const Global& global);

}  // namespace apps::live
