// SPDX-License-Identifier: Apache-2.0
#include "apps/demo/demo_thermal.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "apps/simulate/simulate.h"
#include "apps/terminal/text_table.h"
#include "mtf/engines/statistics.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

constexpr const char* kCamera = R"toml(schema = 1
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

constexpr const char* kUncooled = R"toml(schema = 1
name = "uncooled LWIR camera with noise"

[frame]
focal_length = "100 mm"
pitch = "15 um"

[scene]
quantity = "temperature"

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
  std::vector<std::string_view> rows;  ///< of the budget that are shown; none: all
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

  const radiometry::Sensor sensor = load_chain(config).sensor;
  TextTable table({"at 288 K", "value", "", ""});
  for (const radiometry::BudgetRow& row : budget_rows(config.system, sensor, budget_of(config.system, sensor, 288.0))) {
    const bool shown =
        camera.rows.empty() || std::find(camera.rows.begin(), camera.rows.end(), row.name) != camera.rows.end();
    if (shown && row.value != 0.0) table.add({row.name, significant(row.value, 5), row.unit, row.doc});
  }
  std::string text = "\nthermal scene through the whole chain of " + file + ", and its noise budget\n" +
                     table.aligned({Align::left, Align::right});
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

  auto [text, counts] = through({"camera", kCamera, {}}, folder, scene, step_um, threads);
  image = std::move(counts);
  return text + through({"uncooled", kUncooled, {"signal_per_k", "temporal", "largest", "netd", "spatial_netd", "nep"}},
                        folder, scene, step_um, threads)
                    .first;
}

}  // namespace apps
