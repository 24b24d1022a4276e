// SPDX-License-Identifier: Apache-2.0

// `mtf demo`: a sensor, a scene, its image, the plots, and a check that anybody can follow: the modulation of sine
// targets in the simulated image against the analytic MTF.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "apps/demo/demo_scene.h"
#include "apps/figures/curve_figure.h"
#include "apps/figures/picture.h"
#include "apps/figures/plot.h"
#include "apps/modules/modules.h"
#include "apps/options.h"
#include "apps/simulate/sensor_image.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/statistics.h"
#include "mtf/image.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/config/config.h"
#include "mtf/io/scene.h"
#include "mtf/plan/sensor_plan.h"
#include "mtf/work/stopwatch.h"

namespace apps {
namespace {

// The edge of `mtf demo`: a slanted edge as imaged by the demo's sensor, to measure and to fit.

constexpr std::int64_t kPixels = 128, kSceneMargin = 16, kRatio = 8;
constexpr double kAngle_deg = -5.0, kDark = 2.0, kBright = 8.0;
constexpr float kNoise = 0.03F;  // 200 times less than the contrast
/// Of the scene's blur, in its samples: what lies beyond their Nyquist frequency and aliases below the optics' cutoff
/// is 1e-5 and less.
constexpr double kSigma_samples = 1.0;

mtf::Image step_scene(std::int64_t size) {
  const double a = kAngle_deg * std::numbers::pi / 180.0;
  const double nx = std::cos(a), ny = std::sin(a), middle = 0.5 * static_cast<double>(size);
  mtf::Image scene(size, size);
  for (std::int64_t y = 0; y < size; ++y)
    for (std::int64_t x = 0; x < size; ++x) {
      const double d = nx * (static_cast<double>(x) + 0.5 - middle) + ny * (static_cast<double>(y) + 0.5 - middle);
      const double share = 0.5 * std::erfc(-d / (kSigma_samples * std::numbers::sqrt2));
      scene.at(x, y) = static_cast<float>(kDark + (kBright - kDark) * share);
    }
  return scene;
}

/// Image of an edge whose normal points 5 degrees above +x, 128 x 128 pixels, with a little noise. The scene is a step
/// blurred by a Gaussian that the simulation divides out again, so that its samples alias nothing; the frame's border
/// is cut off, where mirroring bends the edge.
mtf::Image demo_edge(const mtf::io::SensorConfig& sensor, int threads) {
  const std::int64_t size = (kPixels + 2 * kSceneMargin) * kRatio;
  const mtf::Image scene = step_scene(size);
  const double step_um = sensor.system.frame.pitch_x_um / static_cast<double>(kRatio);
  const mtf::SampleGrid grid{size, size, step_um, step_um};

  mtf::io::SceneDefaults blurred = sensor.scene;
  blurred.aperture = mtf::io::Aperture::gaussian;
  blurred.aperture_size.x = {kSigma_samples * step_um, mtf::find_unit("um")};
  mtf::PlanOptions options;
  options.threads = threads;
  options.border = mtf::Border::reflect;
  options.aperture = mtf::io::scene_aperture(blurred, grid);
  options.scene = mtf::summarise(scene.view(), options.border, 0.0);
  const mtf::SensorPlan plan = mtf::compile_sensor(sensor.system, grid, options);
  const mtf::ImageView<const float> view = scene.view();
  const mtf::Image whole = std::move(plan.run(std::span(&view, 1), 0.0, threads).front());

  mtf::Image edge(kPixels, kPixels);
  std::mt19937_64 random(1);
  std::normal_distribution<float> noise(0.0F, kNoise);
  for (std::int64_t y = 0; y < kPixels; ++y)
    for (std::int64_t x = 0; x < kPixels; ++x)
      edge.at(x, y) = whole.at(x + kSceneMargin, y + kSceneMargin) + noise(random);
  return edge;
}

/// The sensor file with its jitter to be fitted, starting from a value that is wrong.
std::string demo_fit_config(const mtf::io::SensorConfig& sensor) {
  mtf::io::SensorConfig start = sensor;
  auto& list = start.system.list(mtf::Stage::presample);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].component.kind() != "jitter") continue;
    for (const mtf::FieldRef<double>& field : list[i].component.fields()) {
      if (field.info->name != "rms") continue;
      mtf::Extent<double>& rms = std::get<mtf::AxisPair<double>*>(field.value)->x;
      rms.value *= 2.0;  // a guess, as of a sensor that nobody has measured
      start.fits.push_back({.path = "presample[" + std::to_string(i) + "].rms",
                            .fit = true,
                            .unit = std::string(rms.unit->name),
                            .min = 0.0,
                            .max = 5.0 * rms.value,
                            .stderr_value = {},
                            .prior = {}});
    }
  }
  return write_config(start);
}

namespace fs = std::filesystem;

constexpr std::int64_t kSize = 1024;
constexpr double kPass = 1e-4;  // the default tolerance: what the plan promises to keep
// Half cycles over the frame of 3.84 mm: 3.9 to 57 cy/mm; Nyquist is 256. No two have the same alias.
const std::vector<int> kTargets{30, 60, 90, 120, 150, 170, 190, 210, 225, 240, 250, 280, 310, 340, 390, 440};

const std::vector<std::string> kFiles{
    "sensor.toml",        "scene.exr",     "sensor.exr",   "preview.png", "mtf.csv",     "targets.exr",
    "targets_sensor.exr", "targets.png",   "edge.exr",     "fit.toml",    "thermal.exr", "camera.toml",
    "camera.exr",         "uncooled.toml", "uncooled.exr", "thermal.png", "mtf.svg",     "mtf.png"};
constexpr std::size_t kFigures = 2;  // the last ones, by gnuplot

mtf::io::Metadata scene_metadata(const mtf::SampleGrid& grid) {
  mtf::io::Metadata m;
  m.text["mtf:quantity"] = mtf::io::quantity_name(mtf::io::Quantity::radiance);
  m.text["mtf:units"] = mtf::io::quantity_unit(mtf::io::Quantity::radiance);
  m.pairs["mtf:pixelPitch"] = {grid.step_x_um / 1e6, grid.step_y_um / 1e6};
  m.history = {"mtf demo: computed scene"};
  return m;
}

std::string size_text(const mtf::Image& image) {
  return std::to_string(image.width()) + " x " + std::to_string(image.height());
}

/// How many samples of the scene a pixel is wide.
int zoom_to(const mtf::Image& scene, const mtf::Image& image) {
  return static_cast<int>(scene.width() / image.width());
}

/// The range of the scene, for both panels, so that the loss of contrast shows.
void write_radiance_picture(const std::string& path, const std::string& what, const mtf::Image& scene,
                            const mtf::Image& sensor) {
  const mtf::Statistics s = mtf::statistics(scene.view());
  const std::string quantity = "radiance [" + std::string(mtf::io::quantity_unit(mtf::io::Quantity::radiance)) + "]";
  const Panel left{what + ", " + size_text(scene) + " samples", scene.view(), 1, s.min, s.max, quantity};
  const Panel right{
      "sensor image, " + size_text(sensor) + " pixels", sensor.view(), zoom_to(scene, sensor), s.min, s.max, quantity};
  write_picture(path, std::array{left, right});
}

/// Temperatures and counts, each between its smallest and largest value.
void write_thermal_picture(const std::string& path, const mtf::Image& scene, const mtf::Image& counts) {
  const mtf::Statistics s = mtf::statistics(scene.view()), c = mtf::statistics(counts.view());
  write_picture(path, std::array{Panel{"scene, " + size_text(scene) + " samples", scene.view(), 1, s.min, s.max,
                                       "temperature [K]"},
                                 Panel{"camera image with noise, " + size_text(counts) + " pixels", counts.view(),
                                       zoom_to(scene, counts), c.min, c.max, "counts"}});
}

struct Target {
  double frequency_cy_mm, measured, analytic;
};

std::vector<Target> measure_targets(const mtf::System<double>& system, const mtf::Image& scene, const mtf::Image& image,
                                    double step_um) {
  std::vector<Target> results;
  for (const int k : kTargets) {
    const double f = k * 1e3 / (2.0 * static_cast<double>(scene.width()) * step_um);
    const double measured = cosine_amplitude(image.view(), k) / cosine_amplitude(scene.view(), k);
    results.push_back({f, measured, system.otf({f, 0.0}).re});
  }
  return results;
}

std::string target_table(const std::vector<Target>& targets, double nyquist, double& worst) {
  TextTable table({"cy/mm", "measured", "analytic", "difference", ""});
  worst = 0.0;
  for (const Target& t : targets) {
    const double difference = t.measured - t.analytic;
    worst = std::max(worst, std::abs(difference));
    table.add({fixed(t.frequency_cy_mm, 2), fixed(t.measured, 6), fixed(t.analytic, 6), significant(difference, 2),
               t.frequency_cy_mm > nyquist ? "beyond Nyquist, read at its alias" : ""});
  }
  return table.aligned({Align::right, Align::right, Align::right, Align::right});
}

struct DemoResult {
  std::string text;
  bool pass = false;
};

DemoResult make_demo(const DemoOptions& options, OutputSet& outputs, const Global& global) {
  const mtf::io::SensorConfig config = mtf::io::parse_config(mtf::io::starter_config(), "sensor.toml").config;
  const mtf::System<double>& system = config.system;
  const mtf::SampleGrid grid{kSize, kSize, config.scene.sample_x_um.value(), config.scene.sample_y_um.value()};
  const mtf::Image landscape = demo_landscape(kSize);
  const mtf::Image targets = demo_sine_targets(kSize, kTargets, 4.0, 1.0);

  mtf::PlanOptions plan_options;
  plan_options.tolerance = options.tolerance.value_or(plan_options.tolerance);
  plan_options.border = config.scene.border;
  plan_options.threads = global.threads;
  // As `mtf simulate` does it: each scene has its own plan, from its own contrast and spectrum.
  const auto plan_for = [&](const mtf::Image& image) {
    mtf::PlanOptions own = plan_options;
    own.scene = mtf::summarise(image.view(), own.border, 0.0);
    own.spectrum = mtf::scene_spectrum(image.view(), own.border, global.threads);
    return mtf::compile_sensor(system, grid, own);
  };
  const mtf::SensorPlan plan = plan_for(landscape), targets_plan = plan_for(targets);

  const fs::path folder = options.out;
  const auto path = [&](const char* name) { return outputs.in(name); };
  mtf::io::write_text_file(path("sensor.toml"), mtf::io::starter_config());
  mtf::io::write_exr(path("scene.exr"), {{"Y", landscape.view()}}, scene_metadata(grid));
  mtf::io::write_exr(path("targets.exr"), {{"Y", targets.view()}}, scene_metadata(grid));
  const mtf::Stopwatch watch;
  std::vector<mtf::Image> images;
  for (const auto& [image_plan, image] : {std::pair{&plan, &landscape}, std::pair{&targets_plan, &targets}}) {
    const mtf::ImageView<const float> view = image->view();
    images.push_back(std::move(image_plan->run(std::span(&view, 1), 0.0, global.threads).front()));
  }
  const double elapsed_ms = watch.ms();

  mtf::io::Scene scene;
  scene.quantity = mtf::io::Quantity::radiance;
  const mtf::io::Metadata metadata = provenance(config, scene, plan, plan_options.tolerance);
  mtf::io::write_exr(path("sensor.exr"), {{"Y", images[0].view()}}, metadata);
  mtf::io::write_exr(path("targets_sensor.exr"), {{"Y", images[1].view()}},
                     provenance(config, scene, targets_plan, plan_options.tolerance));
  const mtf::Image edge = demo_edge(config, global.threads);
  mtf::io::write_exr(path("edge.exr"), {{"Y", edge.view()}}, scene_metadata(plan.out()));
  mtf::io::write_text_file(path("fit.toml"), demo_fit_config(config));
  write_radiance_picture(path("preview.png"), "scene", landscape, images[0]);
  write_radiance_picture(path("targets.png"), "sine targets", targets, images[1]);
  mtf::Image temperatures, counts;
  const std::string thermal =
      demo_thermal(outputs.in(""), landscape, grid.step_x_um, global.threads, temperatures, counts);
  write_thermal_picture(path("thermal.png"), temperatures, counts);

  std::vector<double> frequency;
  for (int i = 0; i <= 130; ++i) frequency.push_back(i);
  const OtfCurves curves = otf_curves(system, frequency);
  const Figure figure = curve_figure(curves);
  const std::vector<Target> results = measure_targets(system, targets, images[1], grid.step_x_um);
  mtf::io::write_text_file(path("mtf.csv"), figure_csv(figure));
  const bool drawn = draw_figure(path("mtf.svg"), figure) && draw_figure(path("mtf.png"), figure);
  if (!drawn)
    note(global,
         "note: gnuplot is not installed; mtf.csv has the curves, the figures mtf.svg and mtf.png are left out");

  double worst = 0.0;
  std::string text = "sensor    " + one_line(system.name) + "\n" + curve_footer(system, curves);
  text += "image     " + std::to_string(kSize) + "x" + std::to_string(kSize) + " samples -> " +
          std::to_string(plan.out().width) + "x" + std::to_string(plan.out().height) + " pixels, two scenes in " +
          fixed(elapsed_ms, 1) + " ms\n";
  text += "\nsine targets in the simulated image against the analytic system MTF\n";
  text += target_table(results, curves.figures.nyquist, worst);
  const double allowed = std::max(kPass, plan_options.tolerance);
  const bool pass = worst <= allowed;
  text += std::string(pass ? "PASS" : "FAIL") + "  largest difference " + significant(worst, 2) + ", allowed " +
          significant(allowed, 2) + "\n" + thermal + "\nwritten to " + one_line(folder.string()) + "/:";
  for (std::size_t i = 0; i < kFiles.size() - (drawn ? 0 : kFigures); ++i) text += std::string(" ") + kFiles[i];
  const auto place = [&](const char* name) { return (folder / name).string(); };
  text += "\nnext: edit " + one_line(place("sensor.toml")) + ", then  mtf simulate " +
          shell_word(place("sensor.toml")) + " " + shell_word(place("scene.exr")) + " -o out.exr\n";
  if (has_live_module())
    text += "      or  mtf live " + shell_word(place("camera.toml")) + " " + shell_word(place("thermal.exr")) +
            "  to turn every parameter in the browser\n";
#ifdef MTFKIT_HAVE_CALIB
  text += "      or  mtf measure " + shell_word(place("edge.exr")) + "  and  mtf fit " + shell_word(place("fit.toml")) +
          " " + shell_word(place("edge.exr")) + " -o fitted.toml\n";
#endif
  return {std::move(text), pass};
}

}  // namespace

int run_demo(const DemoOptions& options, const Global& global) {
  OutputSet outputs({.folder = options.out, .force = options.force, .names = kFiles});
  const DemoResult result = make_demo(options, outputs, global);
  outputs.commit();
  print(result.text);
  return result.pass ? 0 : 3;
}

}  // namespace apps
