// SPDX-License-Identifier: Apache-2.0
#include "tests/mtf/sweep_cases.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "mtf/engines/statistics.h"
#include "mtf/io/image_io.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/random_systems.h"

namespace mtf::test {
namespace {

namespace fs = std::filesystem;

constexpr double kPi = std::numbers::pi;

bool is_prime(std::int64_t n) {
  for (std::int64_t p = 2; p * p <= n; ++p)
    if (n % p == 0) return false;
  return n > 1;
}

// A pupil whose OTF costs microseconds a frequency.
bool has_quadrature(const System<double>& system) {
  for (const auto& list : system.stages)
    for (const Entry<double>& entry : list)
      if (entry.component.is_slow()) return true;
  return false;
}

// One or two blurs of about a pixel: what kernels of a few samples can do.
System<double> compact_system(Random& random) {
  System<double> system;
  system.frame = {100.0, 15.0, random.below(3) == 0 ? 12.0 : 15.0, 0.01, 0, 0};
  system.optics.f_number = random.decades(1.0, 6.0);
  system.optics.wavelength_um = 4.0;
  for (int wanted = 1 + random.below(3); wanted > 0; --wanted) switch (random.below(5)) {
      case 0:
        system.add(Stage::presample, gaussian(random.decades(0.5, 15.0)));
        break;
      case 1:
        system.add(Stage::presample, footprint(random.uniform(5.0, 15.0)));
        break;
      case 2:
        system.add(Stage::presample, jitter(random.decades(0.2, 10.0)));
        break;
      case 3:
        system.add(Stage::presample, motion(random.decades(0.5, 30.0), 15.0 * random.below(24)));
        break;
      default: {
        const auto optics = Component<double>::make("diffraction");
        System<double> larger = system;
        larger.add(Stage::presample, optics);
        if (has_no_errors(larger)) system = std::move(larger);
      }
    }
  return system;
}

// Any kinds, as examples of the component tables have them (typical) or with any allowed value.
System<double> any_system(Random& random, std::span<const Stage> stages, bool typical) {
  const auto draw = [&]() -> const Case& {
    for (;;) {
      const Case& found = draw_case(random);
      if (found.typical || !typical) return found;
    }
  };
  System<double> system = draw().system;
  for (auto& list : system.stages) list.clear();
  const auto try_to_add = [&](const Component<double>& component, Stage stage) {
    if (!component.stages().allows(stage)) return 0;
    System<double> larger = system;
    larger.add(stage, component);
    if (!has_no_errors(larger)) return 0;
    system = std::move(larger);
    return 1;
  };
  int wanted = 1 + std::min(random.below(8), random.below(8));
  if (typical && stages.front() == Stage::presample) {
    system.frame = {100.0, 15.0, random.below(3) == 0 ? 12.0 : 15.0, 0.01, 0, 0};
    system.optics.f_number = random.decades(1.2, 12.0);
    wanted -= try_to_add(Component<double>::make("diffraction"), Stage::presample);
    wanted -= try_to_add(footprint(random.uniform(10.0, 15.0)), Stage::presample);
  }
  for (int tries = 0; wanted > 0 && tries < 100; ++tries) {
    const Stage stage = stages[static_cast<std::size_t>(random.below(static_cast<int>(stages.size())))];
    wanted -= try_to_add(only_component(draw().system), stage);
  }
  if (random.below(6) == 0 && !has_quadrature(system)) {
    const double middle = random.decades(0.5, 12.0), half = 0.5 * middle * random.uniform(0.02, 0.4);
    System<double> wide = system;
    wide.optics.wavelength_um.reset();
    wide.band = Band{middle - half, middle + half};
    if (has_no_errors(wide)) system = std::move(wide);
  }
  return system;
}

System<double> draw_system(Random& random, std::span<const Stage> stages) {
  const int family = random.below(3);
  if (family == 0 && stages.front() == Stage::presample) return compact_system(random);
  return any_system(random, stages, family == 1);
}

// The exact OTF of every frequency of the canvas is what a reference costs.
std::int64_t affordable_side(const System<double>& system, std::int64_t largest) {
  if (has_quadrature(system)) return std::min<std::int64_t>(largest, 48);
  return system.band ? std::min<std::int64_t>(largest, 96) : largest;
}

std::int64_t draw_side(Random& random, std::int64_t least, std::int64_t largest) {
  const auto any =
      static_cast<std::int64_t>(random.decades(static_cast<double>(least), 1.0 + static_cast<double>(largest)));
  std::int64_t n = std::min(any, largest);
  switch (random.below(4)) {
    case 0:
      while (!is_prime(n)) --n;
      return std::max(n, least);
    case 1:  // as cameras have them
      return std::max(least, n / 16 * 16);
    default:
      return n;
  }
}

double draw_ratio(Random& random) {
  constexpr std::array whole{1.0, 1.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  if (random.below(4) == 0) return random.uniform(1.0, 6.0);
  return whole[static_cast<std::size_t>(random.below(static_cast<int>(whole.size())))];
}

template <class F>
Image image_of(const SampleGrid& grid, const F& value) {
  Image image(grid.width, grid.height);
  for (std::int64_t y = 0; y < grid.height; ++y)
    for (std::int64_t x = 0; x < grid.width; ++x)
      image.at(x, y) = static_cast<float>(value(static_cast<double>(x), static_cast<double>(y)));
  return image;
}

double normal(Random& random) {
  return std::sqrt(-2.0 * std::log(random.uniform(1e-300, 1.0))) * std::cos(2.0 * kPi * random.uniform(0.0, 1.0));
}

// Waves whose amplitude falls with their frequency: slow contrast on top of fast, as landscapes have it.
Image clouds(Random& random, const SampleGrid& grid) {
  struct Wave {
    double amplitude, fx, fy, phase;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 24; ++i) {
    const double f = random.decades(0.5, 0.4 * static_cast<double>(std::min(grid.width, grid.height)));
    const double angle = random.uniform(0.0, 2.0 * kPi);
    waves.push_back({1.0 / f, f * std::cos(angle), f * std::sin(angle), random.uniform(0.0, 2.0 * kPi)});
  }
  return image_of(grid, [&](double x, double y) {
    double sum = 0.0;
    for (const Wave& w : waves)
      sum += w.amplitude *
             std::cos(2.0 * kPi *
                          (w.fx * x / static_cast<double>(grid.width) + w.fy * y / static_cast<double>(grid.height)) +
                      w.phase);
    return sum;
  });
}

Image made_scene(Random& random, const SampleGrid& grid, std::string& kind) {
  constexpr std::array names{"noise", "edges", "points", "clouds", "slope with a bright border"};
  const double mean = random.below(3) == 0 ? random.decades(1.0, 1e4) : 0.0;
  const auto w = static_cast<double>(grid.width), h = static_cast<double>(grid.height);
  const int which = random.below(static_cast<int>(names.size()));
  kind = names[static_cast<std::size_t>(which)];
  switch (which) {
    case 0:
      return image_of(grid, [&](double, double) { return mean + normal(random); });
    case 1: {  // two half-planes, sharp or a few samples wide
      std::array<double, 4> c{};
      for (double& value : c) value = random.uniform(-1.0, 1.0);
      const double width = random.below(2) == 0 ? 1e-9 : random.decades(0.3, 10.0);
      const double step = random.decades(0.1, 10.0);
      const auto side = [&](double a, double b, double x, double y) {
        return std::clamp(((a * (x - 0.45 * w) + b * (y - 0.55 * h)) / std::hypot(a, b)) / width, -0.5, 0.5);
      };
      return image_of(
          grid, [&](double x, double y) { return mean + step * side(c[0], c[1], x, y) + side(c[2], c[3], x, y); });
    }
    case 2: {
      Image image = image_of(grid, [&](double, double) { return mean; });
      for (int i = 1 + random.below(20); i > 0; --i)
        image.at(static_cast<std::int64_t>(random.uniform(0.0, w)),
                 static_cast<std::int64_t>(random.uniform(0.0, h))) += static_cast<float>(random.decades(0.1, 10.0));
      return image;
    }
    case 3: {
      Image image = clouds(random, grid);
      for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] += static_cast<float>(mean);
      return image;
    }
    default: {  // what is rare in the image and repeated by its border
      const double a = random.uniform(-1.0, 1.0), b = random.uniform(-1.0, 1.0);
      return image_of(grid, [&](double x, double y) { return mean + a * x / w + b * y / h + (x == 0.0 ? 3.0 : 0.0); });
    }
  }
}

Image part_of(const Image& whole, Random& random, const SampleGrid& grid) {
  const auto offset = [&](std::int64_t all, std::int64_t part) {
    return all > part ? static_cast<std::int64_t>(random.uniform(0.0, static_cast<double>(all - part))) : 0;
  };
  const std::int64_t x0 = offset(whole.width(), grid.width), y0 = offset(whole.height(), grid.height);
  Image image(grid.width, grid.height);
  for (std::int64_t y = 0; y < grid.height; ++y)
    for (std::int64_t x = 0; x < grid.width; ++x)
      image.at(x, y) = whole.at(border_source(Border::reflect, x0 + x, whole.width()),
                                border_source(Border::reflect, y0 + y, whole.height()));
  return image;
}

// One level, near the mean or far from it, outside of a box.
void flatten_around_box(Random& random, Image& scene) {
  const Statistics s = statistics(scene.view());
  const auto level =
      static_cast<float>(s.mean + (random.below(2) == 0 ? 0.0 : 3.0 * s.std * random.uniform(-1.0, 1.0)));
  const auto range = [&](std::int64_t n) {
    const auto from = random.below(2) == 0 ? 0 : static_cast<std::int64_t>(random.uniform(0.0, static_cast<double>(n)));
    const auto count = static_cast<std::int64_t>(random.uniform(1.0, static_cast<double>(n - from) + 1.0));
    return std::pair{from, random.below(3) == 0 ? n : std::min(n, from + count)};
  };
  const auto [left, right] = range(scene.width());
  const auto [top, bottom] = range(scene.height());
  for (std::int64_t y = 0; y < scene.height(); ++y)
    for (std::int64_t x = 0; x < scene.width(); ++x)
      if (x < left || x >= right || y < top || y >= bottom) scene.at(x, y) = level;
}

fs::path shared_data() {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  const fs::path shared = chosen != nullptr ? fs::path(chosen) : fs::path(MTFKIT_SOURCE_DIR) / "../shared";
  return fs::is_directory(shared / "data") ? shared / "data" : fs::path();
}

}  // namespace

std::vector<Photograph> photographs() {
  constexpr std::array names{"thermal/moving_mercedes.png", "thermal/ducks.png",         "thermal/windmill.png",
                             "thermal/solar_halo.png",      "thermal/floor_heating.png", "thermal/water_pipe.png",
                             "thermal/tower.png",           "thermal/moving_car.png",    "exr_samples/Garden.exr"};
  std::vector<Photograph> found;
  const fs::path data = shared_data();
  if (data.empty()) return found;
  for (const char* name : names) found.push_back({name, std::move(io::read_image(data / name).planes.front())});
  return found;
}

SweepCase sweep_case(std::uint64_t seed, const SweepLimits& limits, std::span<const Photograph> photographs) {
  Random random(0x5eed'0000'0000u + seed);
  SweepCase c;
  c.seed = seed;
  c.stages = {Stage::presample};
  if (random.below(8) == 0) c.stages = {Stage::readout, Stage::postsample};
  c.system = draw_system(random, c.stages);
  Frame<double>& frame = c.system.frame;
  const std::int64_t largest = affordable_side(c.system, limits.largest_side);
  const double ratio_x = c.is_presample() ? draw_ratio(random) : 1.0;
  const double ratio_y = random.below(3) == 0 && c.is_presample() ? draw_ratio(random) : ratio_x;
  const auto side = [&](double ratio) {
    const std::int64_t n = draw_side(random, limits.least_side, largest);
    const auto whole = static_cast<std::int64_t>(ratio);  // most scenes are made for their detector
    const std::int64_t multiple = std::max(n / whole, (limits.least_side + whole - 1) / whole) * whole;
    return static_cast<double>(whole) == ratio && random.below(4) != 0 ? multiple : n;
  };
  const std::int64_t width = side(ratio_x);
  const std::int64_t height = random.below(4) == 0 ? width : side(ratio_y);
  c.in = {width, height, frame.pitch_x_um / ratio_x, frame.pitch_y_um / ratio_y};
  if (random.below(8) == 0) frame.columns = 1 + random.below(64), frame.rows = 1 + random.below(64);
  c.out = c.is_presample() ? detector_grid(c.system, c.in) : c.in;
  c.border = static_cast<Border>(random.below(4));
  c.tolerance = random.decades(1e-6, 1e-1);
  if (c.is_presample() && random.below(10) == 0) {
    c.aperture.kind = SceneAperture::Kind::box;
    const auto sample = [](double step_um) { return Extent<double>{step_um, find_unit("um")}; };
    c.aperture.size = {sample(c.in.step_x_um), sample(c.in.step_y_um), true};
  }
  if (photographs.empty()) {
    c.scene = made_scene(random, c.in, c.scene_kind);
  } else {
    const Photograph& whole = photographs[random.bits() % photographs.size()];
    c.scene_kind = whole.name;
    c.scene = part_of(whole.image, random, c.in);
  }
  if (limits.flat_parts) {
    flatten_around_box(random, c.scene);
    c.scene_kind += " in a flat scene";
  }
  const Statistics s = statistics(c.scene.view());
  c.border_value = s.mean + (random.below(3) == 0 ? 20.0 * s.std * random.uniform(-1.0, 1.0) : 0.0);
  return c;
}

PlanOptions SweepCase::options() const {
  PlanOptions options;
  options.border = border;
  options.tolerance = tolerance;
  options.aperture = aperture;
  options.scene = summarise(scene.view(), border, border_value);
  options.threads = 1;
  return options;
}

Plan SweepCase::compile_with(const PlanOptions& options) const {
  return is_presample() ? compile(system, in, out, options) : compile_post(system, in, stages, options);
}

std::string SweepCase::describe() const {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), "seed %llu: %lldx%lld -> %lldx%lld, ratio %.4g x %.4g, %s, tolerance %.3g, ",
                static_cast<unsigned long long>(seed), static_cast<long long>(in.width),
                static_cast<long long>(in.height), static_cast<long long>(out.width),
                static_cast<long long>(out.height), out.step_x_um / in.step_x_um, out.step_y_um / in.step_y_um,
                kBorderNames[static_cast<std::size_t>(border)].data(), tolerance);
  std::string line = text.data() + scene_kind + (aperture.kind == SceneAperture::Kind::point ? "" : ", box aperture");
  line += system.band ? ", band:" : ":";
  for (const Stage stage : stages)
    for (const Entry<double>& entry : system.list(stage)) line += " " + entry.label;
  return line;
}

}  // namespace mtf::test
