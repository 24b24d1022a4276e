// SPDX-License-Identifier: Apache-2.0
#include "apps/demo/demo_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "apps/budget_table.h"
#include "apps/demo/demo_cooled.toml.h"
#include "apps/demo/demo_uncooled.toml.h"
#include "apps/simulate/simulate.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/image_io.h"
#include "mtf/parallel.h"

namespace apps {
namespace {

constexpr double kPi = std::numbers::pi;

struct Point {
  double x, y;  // 0..1 from the upper left corner
};

bool in_disk(Point p, Point centre, double radius) {
  const double x = p.x - centre.x, y = p.y - centre.y;
  return x * x + y * y < radius * radius;
}
bool in_box(Point p, double x0, double y0, double x1, double y1) {
  return p.x >= x0 && p.x < x1 && p.y >= y0 && p.y < y1;
}
/// Trapezoid with horizontal edges; x0, x1 at the top, x2, x3 at the bottom.
bool in_trapezoid(Point p, double y0, double y1, double x0, double x1, double x2, double x3) {
  if (p.y < y0 || p.y >= y1) return false;
  const double t = (p.y - y0) / (y1 - y0);
  return p.x >= x0 + t * (x2 - x0) && p.x < x1 + t * (x3 - x1);
}

/// std::lerp takes three times as long.
double between(double a, double b, double t) { return a + t * (b - a); }

double lattice(std::int64_t x, std::int64_t y) {
  auto h =
      static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^ static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL;
  h = (h ^ (h >> 31)) * 0xBF58476D1CE4E5B9ULL;
  return static_cast<double>((h ^ (h >> 29)) >> 11) * 0x1.0p-52 - 1.0;
}

// Smooth noise in -1..1 with features of size 1. The corners of the last cell are kept: neighbours mostly share them.
class Noise {
 public:
  double at(double x, double y) {
    const auto i = static_cast<std::int64_t>(x), j = static_cast<std::int64_t>(y);  // x, y >= 0
    const double u = x - static_cast<double>(i), v = y - static_cast<double>(j);
    const double s = u * u * (3.0 - 2.0 * u), t = v * v * (3.0 - 2.0 * v);
    if (i != i_ || j != j_) {
      i_ = i, j_ = j;
      corners_ = {lattice(i, j), lattice(i + 1, j), lattice(i, j + 1), lattice(i + 1, j + 1)};
    }
    return between(between(corners_[0], corners_[1], s), between(corners_[2], corners_[3], s), t);
  }

 private:
  std::int64_t i_ = -1, j_ = -1;
  std::array<double, 4> corners_{};
};

template <int octaves>
class LayeredNoise {
 public:
  double at(double x, double y) {
    double sum = 0.0, weight = 0.5;
    for (Noise& layer : layers_) {
      sum += weight * layer.at(x, y);
      weight *= 0.5, x *= 2.0, y *= 2.0;
    }
    return sum;
  }

 private:
  std::array<Noise, octaves> layers_{};
};

// Heights of the ridge and of the ground's edge.
double ridge_at(double x) { return 0.40 + 0.05 * LayeredNoise<4>().at(3.0 * x, 0.5); }
double ground_at(double x) { return 0.47 + 0.01 * LayeredNoise<3>().at(5.0 * x, 7.5); }

// Sky, a ridge and the ground; `step` is the width over which one fades into the next. Their noise is costly and
// smooth: evaluated once a sample, unlike the edges of everything else.
class Background {
 public:
  double at(Point p, double step, double ridge, double ground) {
    const auto below = [&](double line) { return std::clamp((p.y - line) / step + 0.5, 0.0, 1.0); };
    const double hills = below(ridge), soil = below(ground);
    double l = 0.0;  // what is covered is not worked out
    if (hills < 1.0 && soil < 1.0) l = 2.0 + 1.0 * p.y + 0.3 * sky_.at(4.0 * p.x, 9.0 * p.y);
    if (hills > 0.0 && soil < 1.0) l = std::lerp(l, 3.0 + 0.15 * hills_.at(20.0 * p.x, 30.0 * p.y), hills);
    if (soil > 0.0) l = std::lerp(l, 3.5 + 0.35 * soil_.at(14.0 * p.x / (p.y + 0.2), 26.0 * p.y), soil);
    return l;
  }

 private:
  LayeredNoise<5> sky_, hills_;
  LayeredNoise<7> soil_;
};

// Cold track, warm hull, hot engine deck and exhaust: the four regions of a vehicle in the literature's examples.
void vehicle(Point p, double& l) {
  if (in_trapezoid(p, 0.645, 0.70, 0.33, 0.69, 0.36, 0.66)) l = 3.9;
  if (in_box(p, 0.36, 0.655, 0.66, 0.70)) {
    const Point wheel{0.385 + 0.05 * std::floor((p.x - 0.36) / 0.05), 0.677};
    if (in_disk(p, wheel, 0.021)) l = in_disk(p, wheel, 0.009) ? 3.7 : 4.9;
  }
  if (in_trapezoid(p, 0.60, 0.65, 0.35, 0.67, 0.32, 0.70)) l = 4.3;
  if (in_box(p, 0.59, 0.602, 0.665, 0.628)) l = 5.5 + 0.4 * std::sin(300.0 * p.x);
  if (in_disk(p, {0.688, 0.622}, 0.012)) l = 6.0;
  if (in_trapezoid(p, 0.548, 0.60, 0.44, 0.55, 0.42, 0.58)) l = 4.1;
  if (in_box(p, 0.235, 0.566, 0.44, 0.574)) l = 4.0;
}

void targets(Point p, double& l) {
  if (in_box(p, 0.04, 0.76, 0.38, 0.96)) l = 3.4;  // board with bars of 2, 1.5, 1 and 0.75 pixels of a 256-pixel frame
  if (in_box(p, 0.06, 0.79, 0.38, 0.93)) {
    constexpr std::array<double, 4> widths{4.0 / 512, 3.0 / 512, 2.0 / 512, 1.5 / 512};
    double left = 0.06;
    for (const double width : widths) {
      const double bars = (p.x - left) / width;
      if (bars >= 0.0 && bars < 7.0 && static_cast<int>(bars) % 2 == 0) l = 5.4;
      left += 9.0 * width + 0.02;
    }
  }
  const Point centre{0.80, 0.82};
  if (in_disk(p, centre, 0.135))
    l = in_disk(p, centre, 0.004) || std::sin(18.0 * std::atan2(p.y - centre.y, p.x - centre.x)) > 0.0 ? 5.4 : 3.4;
}

double objects(Point p, double l) {
  if (in_box(p, 0.23, 0.54, 0.71, 0.71)) vehicle(p, l);
  if (p.y > 0.68) targets(p, l);
  if (p.y > 0.25) return l;
  for (const Point star : {Point{0.21, 0.13}, Point{0.62, 0.08}, Point{0.84, 0.22}})
    if (in_disk(p, star, 0.0016)) l = 6.0;
  return l;
}

/// False where no part of an object is within that square: there the background alone is seen.
bool may_hold_object(Point corner, double step) {
  const auto meets = [&](double x0, double y0, double x1, double y1) {
    return corner.x + step > x0 && corner.x < x1 && corner.y + step > y0 && corner.y < y1;
  };
  return meets(0.23, 0.54, 0.71, 0.71) || meets(0.04, 0.76, 0.38, 0.96) || meets(0.66, 0.68, 0.94, 0.96) ||
         meets(0.20, 0.12, 0.22, 0.14) || meets(0.61, 0.07, 0.63, 0.09) || meets(0.83, 0.21, 0.85, 0.23);
}

struct Camera {
  const char* stem;  ///< of its file and its image
  std::string_view text;
};

/// Writes the file of a camera and its image of the scene; returns both lines of the summary and the image.
std::pair<std::string, mtf::Image> through(const Camera& camera, const std::filesystem::path& folder,
                                           const mtf::Image& temperatures, double step_um, int threads) {
  const std::string file = std::string(camera.stem) + ".toml", out = std::string(camera.stem) + ".exr";
  mtf::io::write_text_file((folder / file).string(), camera.text);
  const mtf::io::SensorConfig config = read_sensor_file((folder / file).string());
  mtf::io::Scene scene;
  scene.names = {"Y"};
  scene.grid = {temperatures.width(), temperatures.height(), step_um, step_um};
  scene.quantity = mtf::io::Quantity::temperature;
  scene.planes.push_back(temperatures.clone());
  SimulateResult result =
      simulate(config, {.file = (folder / "thermal.exr").string(), .image = std::move(scene)}, {.threads = threads});
  SimulatedImage& simulated = result.images.front();
  mtf::Image image = std::move(simulated.planes.front());
  mtf::io::write_exr((folder / out).string(), {{"Y", image.view()}}, simulated.metadata);

  const BudgetTable budget = budget_table(config, load_chain(config), 288.0);
  std::string text = "\nthermal scene through the whole chain of " + file + ", and its noise budget at 288 K\n" +
                     budget_text(budget, budget.rows);
  if (result.report.chain->held.any()) text += out + " is " + words(result.report.chain->held) + "\n";
  return {std::move(text), std::move(image)};
}

}  // namespace

mtf::Image demo_landscape(std::int64_t size) {
  constexpr int kFine = 4;
  mtf::Image image(size, size);
  const double step = 1.0 / static_cast<double>(size);
  std::vector<double> ridge, ground;
  for (std::int64_t x = 0; x < size; ++x) {
    const double middle = static_cast<double>(x) * step + 0.5 * step;
    ridge.push_back(ridge_at(middle));
    ground.push_back(ground_at(middle));
  }
  mtf::parallel_for(size, 16, 0, [&](std::int64_t begin, std::int64_t end) {
    Background background;
    for (std::int64_t y = begin; y < end; ++y)
      for (std::int64_t x = 0; x < size; ++x) {
        const Point corner{static_cast<double>(x) * step, static_cast<double>(y) * step};
        const auto column = static_cast<std::size_t>(x);
        const double around =
            background.at({corner.x + 0.5 * step, corner.y + 0.5 * step}, step, ridge[column], ground[column]);
        if (!may_hold_object(corner, step)) {
          image.at(x, y) = static_cast<float>(around);
          continue;
        }
        double sum = 0.0;
        for (int j = 0; j < kFine; ++j)
          for (int i = 0; i < kFine; ++i)
            sum += objects({corner.x + (i + 0.5) / kFine * step, corner.y + (j + 0.5) / kFine * step}, around);
        image.at(x, y) = static_cast<float>(sum / (kFine * kFine));
      }
  });
  return image;
}

mtf::Image demo_sine_targets(std::int64_t size, const std::vector<int>& half_cycles, double mean, double amplitude) {
  mtf::Image image(size, size);
  const auto strips = static_cast<std::int64_t>(half_cycles.size());
  for (std::int64_t y = 0; y < size; ++y) {
    const int k = half_cycles[static_cast<std::size_t>(y * strips / size)];
    for (std::int64_t x = 0; x < size; ++x)
      image.at(x, y) = static_cast<float>(
          mean + amplitude * std::cos(kPi * k * (static_cast<double>(x) + 0.5) / static_cast<double>(size)));
  }
  return image;
}

double cosine_amplitude(mtf::ImageView<const float> image, int half_cycles) {
  double sum = 0.0;
  for (std::int64_t x = 0; x < image.width; ++x) {
    double column = 0.0;
    for (std::int64_t y = 0; y < image.height; ++y) column += static_cast<double>(image.at(x, y));
    sum += column * std::cos(kPi * half_cycles * (static_cast<double>(x) + 0.5) / static_cast<double>(image.width));
  }
  return 2.0 * sum / (static_cast<double>(image.width) * static_cast<double>(image.height));
}

std::string_view demo_camera() { return mtf::embedded::demo_cooled_toml; }

mtf::Image demo_temperatures(const mtf::Image& landscape) {
  // So little contrast, as before sunrise, that the camera's noise is seen and nothing fills the wells.
  constexpr double kMean_k = 288.0, kContrast_k = 0.5;
  const mtf::Statistics s = mtf::statistics(landscape.view());
  mtf::Image scene = landscape.clone();
  for (float& v : std::span(scene.data(), static_cast<std::size_t>(scene.size())))
    v = static_cast<float>(kMean_k + kContrast_k * (static_cast<double>(v) - s.mean) / s.std);
  return scene;
}

std::string demo_thermal(const std::filesystem::path& folder, const mtf::Image& landscape, double step_um, int threads,
                         mtf::Image& scene, mtf::Image& image) {
  scene = demo_temperatures(landscape);
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  metadata.text["mtf:units"] = "K";
  metadata.pairs["mtf:pixelPitch"] = {step_um / 1e6, step_um / 1e6};
  mtf::io::write_exr((folder / "thermal.exr").string(), {{"Y", scene.view()}}, metadata);

  auto [text, counts] = through({"camera", mtf::embedded::demo_cooled_toml}, folder, scene, step_um, threads);
  image = std::move(counts);
  return text + through({"uncooled", mtf::embedded::demo_uncooled_toml}, folder, scene, step_um, threads).first;
}

}  // namespace apps
