// SPDX-License-Identifier: Apache-2.0
#include "apps/demo/demo_thermal.h"

#include "apps/budget_table.h"
#include "apps/demo/demo_cooled.toml.h"
#include "apps/demo/demo_uncooled.toml.h"
#include "apps/simulate/simulate.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

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
