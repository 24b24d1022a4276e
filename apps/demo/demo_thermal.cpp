// SPDX-License-Identifier: Apache-2.0
#include "apps/demo/demo_thermal.h"

#include <cmath>

#include "apps/simulate/simulate.h"
#include "apps/terminal/text_table.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/image_io.h"
#include "mtf/survey/statistics.h"

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

}  // namespace

std::string demo_thermal(const std::filesystem::path& folder, const mtf::Image& landscape, double step_um, int threads,
                         mtf::Image& scene, mtf::Image& image) {
  const auto path = [&](const char* name) { return (folder / name).string(); };
  mtf::io::write_text_file(path("camera.toml"), kCamera);
  const mtf::io::SensorConfig config = read_sensor_file(path("camera.toml"));

  // So little contrast, as before sunrise, that the camera's noise is seen and nothing fills the wells.
  constexpr double kMean_k = 288.0, kContrast_k = 0.5;
  const mtf::Statistics s = mtf::statistics(landscape.view());
  mtf::io::Scene thermal;
  thermal.names = {"Y"};
  thermal.grid = {landscape.width(), landscape.height(), step_um, step_um};
  thermal.quantity = mtf::io::Quantity::temperature;
  thermal.planes.push_back(landscape.clone());
  for (float& v : std::span(thermal.planes[0].data(), static_cast<std::size_t>(landscape.size())))
    v = static_cast<float>(kMean_k + kContrast_k * (static_cast<double>(v) - s.mean) / s.std);
  scene = thermal.planes[0].clone();
  mtf::io::Metadata metadata;
  metadata.text["mtf:quantity"] = "temperature";
  metadata.text["mtf:units"] = "K";
  metadata.pairs["mtf:pixelPitch"] = {step_um / 1e6, step_um / 1e6};
  mtf::io::write_exr(path("thermal.exr"), {{"Y", scene.view()}}, metadata);

  SimulateResult result =
      simulate(config, {.file = path("thermal.exr"), .image = std::move(thermal)}, {.threads = threads});
  SimulatedImage& simulated = result.images.front();
  image = std::move(simulated.planes.front());
  mtf::io::write_exr(path("camera.exr"), {{"Y", image.view()}}, simulated.metadata);

  const radiometry::Budget<double> budget = budget_of(config.system, load_chain(config).sensor, kMean_k);
  TextTable table({"at 288 K", "value", "", ""});
  for (const radiometry::BudgetRow& row : rows(budget))
    if (row.value != 0.0) table.add({row.name, significant(row.value, 5), row.unit, row.doc});
  return "\nthermal scene through the whole chain of camera.toml, and its noise budget\n" +
         table.aligned({Align::left, Align::right}) +
         (result.report.chain->held.any() ? "camera.exr is " + words(result.report.chain->held) + "\n" : "");
}

}  // namespace apps
