// SPDX-License-Identifier: Apache-2.0
#pragma once

// The slow second route to every image of the engine, and scenes of noise.

#include <random>

#include "apps/check/reference_image.h"

namespace mtf::test {

using apps::check::Otf;
using apps::check::otf_of;
using apps::check::reference_image;

inline Image random_image(std::int64_t width, std::int64_t height, unsigned seed, double mean = 0.0, double std = 1.0) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(mean, std);
  Image image(width, height);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(normal(generator));
  return image;
}

}  // namespace mtf::test
