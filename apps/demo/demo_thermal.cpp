// SPDX-License-Identifier: Apache-2.0
#include "apps/demo/demo_thermal.h"

#include "apps/budget_table.h"
#include "apps/simulate/simulate.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

constexpr const char* kCamera = R"toml(schema = 2
name = "MWIR camera with noise"

[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "2 ms"

[scene]
quantity = "temperature"        # K; or radiance, photon_radiance, spectral_radiance, counts of a thermal camera
emissivity = 0.95
surroundings = "280 K"          # what the rest reflects

[path]
transmission = 0.8              # or a CSV of the wavelength, or table = a CSV over range and wavelength, or a tape7
air_temperature = "285 K"       # what it takes it also emits

[optics]
f_number = 2.0
transmission = 0.85
emissivity = 0.1
temperature = "293 K"
stop_temperature = "77 K"

[band]
wavelength = ["3.4 um", "4.8 um"]

[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "15 um"
[[presample]]
kind = "jitter"
rms = "2 um"

[vignetting]                    # cos^4 of the field angle

[detector]
quantum_efficiency = 0.75
full_well = "2 Me-"
dark_current = "1 Me-/s"
read_noise = "150 e-"

[nonuniformity]
prnu = 0.02
dsnu = "500 e-"

[defects]
dead_fraction = 0.0005

[noise]                         # shot and read noise, new in every frame
seed = 1
column = "60 e-"

[adc]
bits = 14

[correction]                    # two points, from flat frames with their own noise
frames = 8
)toml";

constexpr const char* kUncooled = R"toml(schema = 2
name = "uncooled LWIR camera with noise"

[frame]
focal_length = "100 mm"
pitch = "15 um"
frame_time = "20 ms"

[scene]
quantity = "temperature"

[atmosphere]                    # a model of the air: its light and its loss, at any range
model = "mid_latitude_summer"
range = "1 km"

[optics]
f_number = 1.0
transmission = 0.9
emissivity = 0.1
temperature = "293 K"
stop_temperature = "293 K"      # the housing is seen around the lens

[band]
wavelength = ["8 um", "13 um"]

[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "15 um"

[detector]
kind = "thermal"                # microbolometers, stated as data sheets do
absorptance = 0.8
responsivity = 1e5              # V/W of incident power
shutter_temperature = "293 K"   # offsets are taken from it
netd = "50 mK"
netd_f_number = 1.0
netd_transmission = 1.0
netd_temperature = "300 K"

[nonuniformity]
dsnu = "0.2 uV"

[noise]
seed = 1
column = "0.1 uV"

[adc]
bits = 14
volts_per_count = "0.1 uV"
offset = 4000
)toml";

struct Camera {
  const char* stem;  ///< of its file and its image
  const char* text;
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

std::string_view demo_camera() { return kCamera; }

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

  auto [text, counts] = through({"camera", kCamera}, folder, scene, step_um, threads);
  image = std::move(counts);
  return text + through({"uncooled", kUncooled}, folder, scene, step_um, threads).first;
}

}  // namespace apps
