// SPDX-License-Identifier: Apache-2.0
#pragma once

// A 3-D scene, as the session sees it: what draws it, the times that it has, where its camera is at the start, what of
// its file the page changes. Builds without scenes have none (space_view.h makes it).

#include <functional>
#include <span>
#include <string>

#include "apps/live/edits.h"
#include "apps/live/frames.h"
#include "apps/live/model.h"

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

}  // namespace apps::live
