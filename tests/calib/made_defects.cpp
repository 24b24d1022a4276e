// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/made_defects.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace made {
namespace {

template <class Change>
void change_all(mtf::Image& image, const Change& change) {
  for (std::int64_t j = 0; j < image.height(); ++j)
    for (std::int64_t i = 0; i < image.width(); ++i) image.at(i, j) = static_cast<float>(change(i, j, image.at(i, j)));
}

}  // namespace

void heat_pixels(mtf::Image& image, double share, double more, std::uint64_t seed) {
  std::mt19937_64 bits(seed ^ 0x9e3779b97f4a7c15U);
  std::uniform_real_distribution<double> uniform;
  change_all(image, [&](std::int64_t, std::int64_t, float value) {
    return static_cast<double>(value) + (uniform(bits) < share ? more : 0.0);
  });
}

void cut_off_below(mtf::Image& image, double floor) {
  change_all(image,
             [&](std::int64_t, std::int64_t, float value) { return std::max(static_cast<double>(value), floor); });
}

void add_second_edge(mtf::Image& image, const Scene& scene, const Step& step, double apart_px, double contrast) {
  change_all(image, [&](std::int64_t i, std::int64_t j, float value) {
    const double d = distance(scene, static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
    return static_cast<double>(value) + contrast * step.at(d - apart_px);
  });
}

void correlate_noise(mtf::Image& image, const Scene& scene, const Step& step, double sd_px) {
  Scene quiet = scene;
  quiet.noise_sd = 0.0;
  image = make(step, quiet);
  const auto reach = static_cast<std::int64_t>(std::ceil(5.0 * sd_px));
  std::vector<double> kernel;
  double squares = 0.0;
  for (std::int64_t k = -reach; k <= reach; ++k) {
    const double x = static_cast<double>(k) / sd_px;
    kernel.push_back(std::exp(-0.5 * x * x));
    squares += kernel.back() * kernel.back();
  }
  for (double& weight : kernel) weight /= std::sqrt(squares);
  const std::int64_t width = image.width() + 2 * reach, height = image.height() + 2 * reach;
  std::mt19937_64 bits(scene.seed ^ 0x5851f42d4c957f2dU);
  std::normal_distribution<double> normal(0.0, scene.noise_sd);
  std::vector<double> white(static_cast<std::size_t>(width * height)), rows(white.size());
  for (double& value : white) value = normal(bits);
  const auto at = [&](std::int64_t i, std::int64_t j) { return static_cast<std::size_t>(j * width + i); };
  for (std::int64_t j = 0; j < height; ++j)
    for (std::int64_t i = 0; i < image.width(); ++i)
      for (std::size_t k = 0; k < kernel.size(); ++k)
        rows[at(i, j)] += kernel[k] * white[at(i + static_cast<std::int64_t>(k), j)];
  change_all(image, [&](std::int64_t i, std::int64_t j, float value) {
    double noise = 0.0;
    for (std::size_t k = 0; k < kernel.size(); ++k) noise += kernel[k] * rows[at(i, j + static_cast<std::int64_t>(k))];
    return static_cast<double>(value) + noise;
  });
}

void round_values(mtf::Image& image, double quantum) {
  change_all(image, [&](std::int64_t, std::int64_t, float value) {
    return quantum * std::round(static_cast<double>(value) / quantum);
  });
}

}  // namespace made
