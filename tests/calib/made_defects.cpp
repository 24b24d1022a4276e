// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/made_defects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace made {
namespace {

template <class Change>
void change_all(mtf::Image& image, const Change& change) {
  for (std::int64_t j = 0; j < image.height(); ++j)
    for (std::int64_t i = 0; i < image.width(); ++i) image.at(i, j) = static_cast<float>(change(i, j, image.at(i, j)));
}

mtf::Image quiet_image(Scene scene, const Step& step) {
  scene.noise_sd = 0.0;
  return make(step, scene);
}

mtf::Image white_noise(const Scene& scene) {
  mtf::Image noise(scene.width, scene.height);
  std::mt19937_64 bits(scene.seed ^ 0x5851f42d4c957f2dU);
  std::normal_distribution<double> normal(0.0, scene.noise_sd);
  change_all(noise, [&](std::int64_t, std::int64_t, float) { return normal(bits); });
  return noise;
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
  image = quiet_image(scene, step);
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

void interpolate_noise(mtf::Image& image, const Scene& scene, const Step& step) {
  const mtf::Image noise = white_noise(scene);
  image = quiet_image(scene, step);
  change_all(image, [&](std::int64_t i, std::int64_t j, float value) {
    const auto at = [&](std::int64_t x, std::int64_t y) {  // mirrored at the border
      x = x < 0 ? 1 : x < image.width() ? x : image.width() - 2;
      y = y < 0 ? 1 : y < image.height() ? y : image.height() - 2;
      return static_cast<double>(noise.at(x, y));
    };
    const double mean = 0.25 * (at(i - 1, j) + at(i + 1, j) + at(i, j - 1) + at(i, j + 1));
    return static_cast<double>(value) + ((i + j) % 2 == 0 ? at(i, j) : mean);
  });
}

void compress_noise(mtf::Image& image, const Scene& scene, const Step& step) {
  constexpr std::int64_t kBlock = 8;
  mtf::Image noise = white_noise(scene);
  const auto cosine = [](std::int64_t u, std::int64_t i) {
    return std::sqrt((u == 0 ? 1.0 : 2.0) / kBlock) *
           std::cos(std::numbers::pi * static_cast<double>(u) * (static_cast<double>(i) + 0.5) / kBlock);
  };
  for (std::int64_t top = 0; top + kBlock <= image.height(); top += kBlock)
    for (std::int64_t left = 0; left + kBlock <= image.width(); left += kBlock) {
      std::array<double, kBlock * kBlock> block{};
      for (std::int64_t v = 0; v < kBlock; ++v)
        for (std::int64_t u = 0; u < kBlock; ++u) {
          double sum = 0.0;
          for (std::int64_t j = 0; j < kBlock; ++j)
            for (std::int64_t i = 0; i < kBlock; ++i)
              sum += cosine(u, i) * cosine(v, j) * static_cast<double>(noise.at(left + i, top + j));
          const double quantum = 0.5 * scene.noise_sd * static_cast<double>(1 + u + v);
          const double kept = quantum * std::round(sum / quantum);
          for (std::int64_t j = 0; j < kBlock; ++j)
            for (std::int64_t i = 0; i < kBlock; ++i)
              block[static_cast<std::size_t>(j * kBlock + i)] += cosine(u, i) * cosine(v, j) * kept;
        }
      for (std::int64_t j = 0; j < kBlock; ++j)
        for (std::int64_t i = 0; i < kBlock; ++i)
          noise.at(left + i, top + j) = static_cast<float>(block[static_cast<std::size_t>(j * kBlock + i)]);
    }
  image = quiet_image(scene, step);
  change_all(image, [&](std::int64_t i, std::int64_t j, float value) { return value + noise.at(i, j); });
}

}  // namespace made
