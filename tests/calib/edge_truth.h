// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slanted edges of known MTF in the shared data: their images, made linear, and their truth in closed form.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "mtf/image.h"
#include "mtf/io/codecs/encoding.h"
#include "mtf/io/image_io.h"
#include "mtf/math/quadrature.h"

namespace calib::test {

/// The folder of the shared test data, empty without it.
inline std::filesystem::path shared_data() {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  std::filesystem::path shared = std::filesystem::path(__FILE__).parent_path() / "../../../shared";
  if (chosen != nullptr) shared = chosen;
  return std::filesystem::is_directory(shared / "data") ? shared / "data" : std::filesystem::path();
}

inline nlohmann::json shared_json(const std::string& name) {
  std::ifstream file(shared_data() / name);
  return nlohmann::json::parse(file);
}

/// First plane as linear values.
inline mtf::Image linear_image(const std::filesystem::path& file, const std::string& encoding = "linear") {
  mtf::io::ImageFile image = mtf::io::read_image(file.string());
  static_cast<void>(
      mtf::io::decode(mtf::io::parse_encoding(encoding), image.planes.front().view(), mtf::io::full_scale(image.info)));
  return std::move(image.planes.front());
}

/// OTF of a pupil with the wavefront error w020 r^2 + w040 r^4, in waves, at the shift s of a pupil of radius 1.
inline double aberrated(double s, double w020, double w040) {
  if (s >= 2.0) return 0.0;
  const mtf::GaussRule& rule = mtf::gauss_legendre(96);
  double sum = 0.0;
  // The overlap is symmetric in x, and even and odd halves of the phase make the sum real.
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double reach = 1.0 - 0.5 * s, x = 0.5 * reach * (rule.node[i] + 1.0);
    const double height = std::sqrt(std::max(0.0, 1.0 - (x + 0.5 * s) * (x + 0.5 * s)));
    for (std::size_t j = 0; j < rule.node.size(); ++j) {
      const double y = height * rule.node[j];
      const double before = (x - 0.5 * s) * (x - 0.5 * s) + y * y, after = (x + 0.5 * s) * (x + 0.5 * s) + y * y;
      const double waves = w020 * (after - before) + w040 * (after * after - before * before);
      sum += rule.weight[i] * rule.weight[j] * reach * height * std::cos(2.0 * std::numbers::pi * waves);
    }
  }
  return sum / std::numbers::pi;
}

/// The MTF along the normal of a case of truth.json.
inline double true_mtf(const nlohmann::json& edge, double f_cy_px) {
  const std::string psf = edge.at("psf");
  if (psf == "gaussian") return std::exp2(-std::pow(f_cy_px / edge.at("mtf50_nominal").get<double>(), 2));
  const double angle = edge.at("angle").get<double>() * std::numbers::pi / 180.0;
  const auto sinc = [](double x) { return x == 0.0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x); };
  const double across = f_cy_px * std::cos(angle), along = f_cy_px * std::sin(angle);
  double value = sinc(across) * sinc(along);
  const double share =
      f_cy_px * edge.at("lambda_um").get<double>() * edge.at("fnum").get<double>() / edge.at("pitch_um").get<double>();
  if (psf == "wavefront-box") {
    value *= aberrated(2.0 * share, edge.at("w020"), edge.at("w040"));
  } else {
    const double x = std::min(share, 1.0);
    value *= 2.0 / std::numbers::pi * (std::acos(x) - x * std::sqrt(1.0 - x * x));
  }
  if (psf == "airy-4dot-olpf") {
    const double turn = 2.0 * std::numbers::pi * edge.at("olpf").get<double>();
    value *= std::cos(turn * across) * std::cos(turn * along);
  }
  return std::abs(value);
}

}  // namespace calib::test
