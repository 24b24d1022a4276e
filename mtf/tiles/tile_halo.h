// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far around a tile the scene has to be known.

#include <array>
#include <optional>

#include "mtf/plan/plan.h"

namespace mtf {

struct HaloRequest {
  SampleGrid in, out;        ///< scene and detector of the whole image
  double norm = 1.0;         ///< norm of the canvas relative to std, those of the tiles' own canvases added
  double budget = 0.0;       ///< rms error relative to std that both axes together may make
  std::int64_t longest = 0;  ///< halos beyond this are of no use
  ScaleSplit split = {};     ///< the part of the OTF that the tiles do
};

struct TileHalo {
  std::array<std::int64_t, 2> samples{};  ///< x, y
  double bound = 0.0;                     ///< rms error relative to std
};

/// The smallest halo whose missing tails keep the budget (Young's bound, as choose_canvas in mtf/plan/padding.h): along
/// each axis the kernel of nine sections of the OTF is summed from outside. Nothing when a longer one than `longest`
/// would be needed.
std::optional<TileHalo> find_halo(const System<double>& system, std::span<const Stage> stages,
                                  const PlanOptions& options, const HaloRequest& request);

}  // namespace mtf
