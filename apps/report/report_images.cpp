// SPDX-License-Identifier: Apache-2.0

// Simulated images of the chosen designs, as `mtf simulate` makes them, of one scene.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "apps/demo/demo_scene.h"
#include "apps/report/base64.h"
#include "apps/report/report_chosen.h"
#include "apps/simulate/simulate.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/io/codecs/codecs.h"
#include "radiometry/light/blackbody.h"

namespace apps {
namespace {

constexpr std::int64_t kPixels = 160;                  // of the design with the smallest pixels, a side
constexpr std::int64_t kSamplesAPixel = 4;             // of the scene
constexpr std::int64_t kMostPixels = 1 << 26;          // of a scene file
constexpr double kTolerance = 2e-3;                    // half a grey value of the picture
constexpr double kSun_k = 5772.0, kSun_sr = 6.794e-5;  // IAU 2015 nominal values; solid angle at 1 au

double ifov_urad(const mtf::Frame<double>& frame, mtf::Axis axis) {
  return frame.pitch_um(axis) / frame.focal_length_mm * 1e3;
}

/// The landscape, normalised: mean 0, standard deviation 1.
mtf::Image landscape() {
  mtf::Image image = demo_landscape(kPixels * kSamplesAPixel);
  const mtf::Statistics s = mtf::statistics(image.view());
  for (float& v : std::span(image.data(), static_cast<std::size_t>(image.size())))
    v = static_cast<float>((static_cast<double>(v) - s.mean) / s.std);
  return image;
}

/// Temperatures about the study's, 5 K rms of 300 K; in sunlight, for bands below 3 um, radiance of reflectances about
/// 0.25 under a sun 45 degrees high.
void give_values(const mtf::io::SensorConfig& config, double temperature_k, mtf::io::Scene& scene) {
  const double middle_um = config.system.context().wavelength_um;
  const double lo = config.system.band ? config.system.band->lo_um : 0.95 * middle_um;
  const double hi = config.system.band ? config.system.band->hi_um : 1.05 * middle_um;
  const bool thermal = lo >= 3.0 || config.scene.quantity == mtf::io::Quantity::temperature;
  scene.quantity = thermal ? mtf::io::Quantity::temperature : mtf::io::Quantity::radiance;
  const double sun = radiometry::band_radiance(radiometry::Flux::watts, lo, hi, kSun_k) * kSun_sr *
                     std::numbers::sqrt2 / 2.0 / std::numbers::pi;
  mtf::Image& plane = scene.planes.front();
  for (float& v : std::span(plane.data(), static_cast<std::size_t>(plane.size()))) {
    const double x = static_cast<double>(v);
    v = static_cast<float>(thermal ? temperature_k * std::max(0.0, 1.0 + x / 60.0)
                                   : sun * std::max(0.02, 0.25 + 0.08 * x));
  }
}

SceneSource built_in(const mtf::io::SensorConfig& config, const mtf::Image& picture, double temperature_k,
                     double sample_urad) {
  const double step_um = sample_urad * config.system.frame.focal_length_mm * 1e-3;
  mtf::io::Scene scene;
  scene.names = {"Y"};
  scene.grid = {picture.width(), picture.height(), step_um, step_um};
  scene.planes.push_back(picture.clone());
  give_values(config, temperature_k, scene);
  return {.image = std::move(scene)};
}

SceneSource from_file(const std::string& path) {
  const mtf::io::FileInfo info = mtf::io::read_info(path);
  if (info.width * info.height > kMostPixels)
    throw mtf::UsageError(path + ": has more than " + std::to_string(kMostPixels) +
                          " pixels; give a part of it as --scene");
  return {.file = path};
}

mtf::Image image_of(mtf::io::SensorConfig config, SceneSource source, int threads, ChosenImage& out) {
  if (source.image) {  // it has no blur of its own, and nothing is known of what lies around it
    config.scene.aperture = mtf::io::Aperture::point;
    config.scene.border = mtf::Border::reflect;
  }
  SimulateResult result = [&] {
    try {
      return simulate(config, clone(source), {.tolerance = kTolerance, .threads = threads});
    } catch (const mtf::UnreachableTolerance&) {  // without one, the least that can be kept is used, with a warning
      return simulate(config, std::move(source), {.threads = threads});
    }
  }();
  out.notes = result.report.warnings;
  if (result.report.chain) out.unit = result.report.unit();
  return std::move(result.images.front().planes.front());
}

/// The middle of the image, no larger than that.
mtf::Image middle(const mtf::Image& image, std::int64_t width, std::int64_t height) {
  const std::int64_t w = std::clamp<std::int64_t>(width, 1, image.width()),
                     h = std::clamp<std::int64_t>(height, 1, image.height());
  mtf::Image part(w, h);
  for (std::int64_t y = 0; y < h; ++y)
    for (std::int64_t x = 0; x < w; ++x)
      part.at(x, y) = image.at(x + (image.width() - w) / 2, y + (image.height() - h) / 2);
  return part;
}

/// Grey values between the quantiles of 0.5 and 99.5 %.
mtf::io::RasterData grey(const mtf::Image& image, ChosenImage& out) {
  std::vector<float> sorted(image.data(), image.data() + image.size());
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double share) {
    return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
  };
  out.low = quantile(0.005);
  out.high = quantile(0.995);
  const double range = out.high > out.low ? out.high - out.low : 1.0;
  mtf::io::RasterData data{image.width(), image.height(), 1, 8, {}, {}};
  data.samples.reserve(sorted.size());
  for (std::int64_t i = 0; i < image.size(); ++i)
    data.samples.push_back(static_cast<std::uint16_t>(
        std::lround(255.0 * std::clamp((static_cast<double>(image.data()[i]) - out.low) / range, 0.0, 1.0))));
  return data;
}

std::string png(const mtf::io::RasterData& data) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  if (!file) throw mtf::RuntimeError("there is no room for temporary files; set TMPDIR to a folder that has some");
  if (mtf::io::codecs().encode_png(fileno(file.get()), data) != 0)
    throw mtf::RuntimeError("a temporary file cannot be written; is the disk full?");
  std::string bytes;
  std::rewind(file.get());
  for (int c = std::fgetc(file.get()); c != EOF; c = std::fgetc(file.get())) bytes += static_cast<char>(c);
  return bytes;
}

}  // namespace

void simulate_chosen(std::vector<ChosenDesign>& designs, const std::string& scene, double temperature_k,
                     const Global& global) {
  double finest_urad = HUGE_VAL;
  for (const ChosenDesign& design : designs)
    if (design.problem.empty())
      for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y})
        finest_urad = std::min(finest_urad, ifov_urad(design.config.system.frame, axis));
  if (!std::isfinite(finest_urad)) return;
  const mtf::Image picture = scene.empty() ? landscape() : mtf::Image();
  for (ChosenDesign& design : designs) {
    if (!design.problem.empty()) continue;
    try {
      const mtf::io::SensorConfig& config = design.config;
      SceneSource source =
          scene.empty() ? built_in(config, picture, temperature_k, finest_urad / static_cast<double>(kSamplesAPixel))
                        : from_file(scene);
      const mtf::Image whole = image_of(config, std::move(source), global.threads, design.image);
      const auto pixels = [&](mtf::Axis axis) {
        return std::llround(static_cast<double>(kPixels) * finest_urad / ifov_urad(config.system.frame, axis));
      };
      const mtf::Image part = middle(whole, pixels(mtf::Axis::x), pixels(mtf::Axis::y));
      design.image.width = part.width();
      design.image.height = part.height();
      design.image.data_uri = "data:image/png;base64," + base64(png(grey(part, design.image)));
    } catch (const std::exception& error) {
      design.image_gap = one_line(error.what());
    }
  }
}

}  // namespace apps
