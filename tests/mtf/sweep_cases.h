// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random work for plans: systems of 1 to 8 components (a third each: blurs of about a pixel, typical sensors, any kinds
// with any allowed values), sizes with primes, whole and other ratios of pitch and sample, every border rule,
// tolerances of 1e-6 to 1e-1, and scenes that are made or cut from photographs. A case is its seed: the same for every
// machine, whatever the standard library.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mtf/plan/plan.h"

namespace mtf::test {

struct SweepLimits {
  std::int64_t least_side = 16, largest_side = 700;
  bool flat_parts = false;  ///< scenes are uniform but for a box, and half of the boxes touch sides of the image
};

struct SweepCase {
  std::uint64_t seed = 0;
  System<double> system;
  std::vector<Stage> stages;  ///< presample, or the lists on the detector grid
  SampleGrid in, out;
  Border border{};
  double border_value = 0.0;
  double tolerance = 0.0;
  SceneAperture aperture;
  std::string scene_kind;
  Image scene;

  bool is_presample() const { return stages.front() == Stage::presample; }
  /// What a plan is given, besides the scene's spectrum.
  PlanOptions options() const;
  /// compile or compile_post.
  Plan compile_with(const PlanOptions& options) const;
  /// One line: seed, sizes, border, tolerance, scene, components.
  std::string describe() const;
};

struct Photograph {
  std::string name;
  Image image;
};

/// The thermal images and the natural EXR samples of the shared data; empty where these are not there.
std::vector<Photograph> photographs();

/// The case of that seed. With photographs its scene is a part of one of them, mirrored where it is smaller.
SweepCase sweep_case(std::uint64_t seed, const SweepLimits& limits, std::span<const Photograph> photographs);

}  // namespace mtf::test
