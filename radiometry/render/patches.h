// SPDX-License-Identifier: Apache-2.0
#pragma once

// Patches: sets of sides of one mesh, fronts or backs, of one finish and nearly one temperature. What a side reflects
// of other surfaces is known by patch: each has one radiance, the mean of its sides. Steps of temperature are 1 K, or
// as much more as makes patches few.

#include "radiometry/render/render_scene.h"
#include "radiometry/scene/views.h"

namespace radiometry::render {

struct Patches {
  std::vector<std::uint32_t> patch_of{};  ///< of each side; kNone for the inside of solids
  scene::Receivers sides{};               ///< of each patch
  std::vector<std::uint32_t> finish{};    ///< of each patch
  double step_k = 0.0;

  std::size_t size() const { return finish.size(); }
};

/// At most `most` patches, or one for each finish where these are more. Sides without a temperature belong to none.
Patches patches_by_temperature(const RenderScene& scene, std::size_t most = 300);

/// Whether patches made of other temperatures still do: sides are within `step_k`, or 2 K, of the mean of their patch,
/// nearly all of them.
bool still_alike(const RenderScene& scene, const Patches& patches);

/// The mean temperature of each patch, by area.
std::vector<double> patch_temperatures_k(const RenderScene& scene, const Patches& patches);

}  // namespace radiometry::render
