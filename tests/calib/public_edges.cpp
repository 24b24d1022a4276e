// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/public_edges.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "mtf/io/image_io.h"

namespace public_edges {

std::string folder() {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const std::filesystem::path shared = chosen ? chosen : MTFKIT_SOURCE_DIR "/../shared";
  return (shared / "data/edges").string();
}

std::vector<Case> cases() {
  std::ifstream file(folder() + "/truth.json");
  if (!file) return {};
  std::vector<Case> all;
  const auto document = nlohmann::json::parse(file);
  for (const auto& entry : document.at("cases")) {
    const auto& truth = entry.at("truth");
    all.push_back({.file = entry.at("file"),
                   .psf = entry.at("psf"),
                   .encoding = entry.at("encoding"),
                   .angle_deg = entry.at("angle"),
                   .bits = entry.at("bits"),
                   .x = entry.at("edge_x").get<double>() + 0.5,
                   .y = entry.at("edge_y").get<double>() + 0.5,
                   .noise_sigma = entry.at("noise_sigma"),
                   .sagitta_px = entry.value("sagitta_px", 0.0),
                   .mtf50 = truth.at("mtf50"),
                   .frequency = truth.at("freq_cyc_per_px"),
                   .mtf = truth.at("mtf")});
  }
  return all;
}

mtf::Image read(const Case& one) {
  mtf::Image image = mtf::io::read_image(folder() + "/" + one.file).planes.at(0).clone();
  const double full = one.bits > 8 ? 65535.0 : 255.0;
  for (std::int64_t i = 0; i < image.size(); ++i) {
    double v = image.data()[i] / full;
    if (one.encoding == "sRGB") v = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    image.data()[i] = static_cast<float>(v);
  }
  return image;
}

}  // namespace public_edges
