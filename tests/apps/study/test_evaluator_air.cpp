// SPDX-License-Identifier: Apache-2.0

// Studies that change the air: a design is the sensor file that says the same, and derivatives go through the light.

#include <gtest/gtest.h>

#include "apps/sensor/sensor_chain.h"
#include "mtf/metrics/resolution.h"
#include "tests/apps/study/evaluated.h"

namespace {

using study_test::Evaluated;
using study_test::evaluated;
using study_test::expect_gradient;
using study_test::Folder;

/// 3 to 5 um at f/4: a diffraction MTF at Nyquist that changes with the wavelengths that get through.
std::string camera(const std::string& more = "") {
  return R"(schema = 1
name = "camera"
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "10 ms"
[scene]
quantity = "temperature"
[optics]
f_number = 4.0
transmission = 0.85
[band]
wavelength = ["3 um", "5 um"]
[[presample]]
kind = "diffraction"
[detector]
quantum_efficiency = 0.75
full_well = "10 Me-"
read_noise = "500 e-"
[atmosphere]
model = "mid_latitude_summer"
haze = "rural"
visibility = "15 km"
relative_humidity = 0.6
temperature = "294 K"
)" + more;
}

std::string axis(const std::string& parameter, const std::string& values) {
  return "[[axis]]\nparameter = \"" + parameter + "\"\nvalues = [" + values + "]\n";
}

std::string study_of(const std::string& axes, const std::string& metrics = R"("mtf_nyquist", "netd", "target_snr")") {
  return "schema = 1\nname = \"air\"\nsensor = \"camera.toml\"\ntolerance = 1e-8\n" + axes + "[metrics]\nlist = [" +
         metrics + "]\n[conditions]\ntemperature = \"294 K\"\ncontrast = \"2 K\"\n";
}

/// The metrics of the sensor file that the design stands for.
void expect_file_of(const Folder& folder, Evaluated& e, std::int64_t design) {
  e.at(design);
  ASSERT_EQ(e.evaluator->last_problem(), "") << design;
  std::vector<double> axes(e.study->axes.size());
  study::design_at(*e.study, design, axes);
  folder.write("design.toml", mtf::io::write_config(e.evaluator->sensor_at(axes), folder / "design.toml"));
  const auto config = apps::read_sensor_file(folder / "design.toml");
  const apps::LoadedSensor loaded = apps::load_chain(config);
  const mtf::System<double> system = apps::with_electron_rate(config.system, loaded);
  mtf::ResolutionNeeds needs;
  needs.tolerance = 1e-9;
  const auto direct = mtf::ResolutionMeter<double>(needs).measure(system);
  EXPECT_NEAR(e["mtf_nyquist"], std::sqrt(direct.x.nyquist * direct.y.nyquist), 1e-8) << design;
  EXPECT_NEAR(e["netd"], 1e3 * radiometry::budget_of(system, loaded.sensor, 294.0).netd_k, 1e-9 * e["netd"]) << design;
  EXPECT_TRUE(std::isfinite(e["error"])) << design;
}

TEST(EvaluatorAir, ADesignIsTheSensorFileThatSaysTheSame) {
  const Folder folder;
  folder.write("camera.toml", camera("range = \"10 m\"\n"));
  Evaluated e = evaluated(folder, study_of(axis("atmosphere.range", R"("10 m", "10 km")") +
                                           axis("atmosphere.visibility", R"("5 km", "23 km")")));
  e.at(0);
  const double near = e["mtf_nyquist"];
  e.at(2);
  EXPECT_GT(std::abs(e["mtf_nyquist"] / near - 1.0), 0.005);  // the weights of the file's air would show nothing of it
  for (std::int64_t design = 3; design >= 0; --design) expect_file_of(folder, e, design);
}

// The aerosol and the turbulence of the path take its length and its scattering from the same table.
TEST(EvaluatorAir, ComponentsOfThePathFollow) {
  const Folder folder;
  folder.write("camera.toml", camera("range = \"1 km\"\n[[presample]]\nkind = \"aerosol\"\n"
                                     "[[presample]]\nkind = \"turbulence\"\ncn2 = 1e-14\n"));
  Evaluated e = evaluated(folder, study_of(axis("atmosphere.range", R"("500 m", "4 km")") +
                                           axis("atmosphere.visibility", R"("5 km", "23 km")")));
  for (std::int64_t design = 0; design < 4; ++design) expect_file_of(folder, e, design);
  e.at(3);
  const double clear = e["mtf_nyquist"];
  e.at(2);
  EXPECT_LT(e["mtf_nyquist"], 0.9 * clear);
  for (const std::int64_t design : {0, 3})
    expect_gradient(
        folder,
        study_of(axis("atmosphere.range", R"("500 m", "4 km")") + axis("atmosphere.visibility", R"("5 km", "23 km")")),
        design, 1e-5);
}

TEST(EvaluatorAir, DerivativesGoThroughTheLight) {
  const Folder folder;
  folder.write("camera.toml", camera("range = \"3 km\"\n"));
  expect_gradient(folder,
                  study_of(axis("atmosphere.range", R"("3 km")") + axis("atmosphere.relative_humidity", "0.6") +
                           axis("atmosphere.visibility", R"("15 km")") + axis("atmosphere.temperature", R"("290 K")")),
                  0, 1e-5);
}

// At the ends of what is allowed a difference looks to one side: straight down, saturated, and as near as the altitudes
// are apart.
TEST(EvaluatorAir, DerivativesAtTheEndsOfRanges) {
  const Folder folder;
  const auto slopes = [&](const std::string& more, const std::string& axes) {
    folder.write("camera.toml", camera(more));
    Evaluated e = evaluated(folder, study_of(axes, R"("mtf_nyquist", "netd")"));
    std::vector<double> at(e.study->axes.size());
    study::design_at(*e.study, 0, at);
    return e.evaluator->gradient_at(at).value;
  };
  const std::string down = "sensor_altitude = \"3 km\"\ntarget_altitude = \"0 m\"\n";
  const auto vertical = slopes(down + "zenith_angle = \"180 deg\"\n", axis("atmosphere.zenith_angle", R"("180 deg")"));
  const auto tilted = slopes(down + "zenith_angle = \"170 deg\"\n", axis("atmosphere.zenith_angle", R"("170 deg")"));
  EXPECT_LT(std::abs(vertical[1]), 1e-3 * std::abs(tilted[1]));  // symmetric about straight down
  EXPECT_NE(tilted[1], 0.0);
  for (const double slope : slopes("range = \"2 km\"\n", axis("atmosphere.relative_humidity", "1.0")))
    EXPECT_TRUE(std::isfinite(slope));
  for (const double slope : slopes(down + "range = \"3 km\"\n", axis("atmosphere.range", R"("3 km")")))
    EXPECT_TRUE(std::isfinite(slope));
  for (const double slope : slopes("range = \"0 m\"\n", axis("atmosphere.range", R"("0 m")")))
    EXPECT_TRUE(std::isfinite(slope));
}

// What a design is does not depend on the design before it, whose light may be kept.
TEST(EvaluatorAir, ARowDoesNotDependOnWhatCameBefore) {
  const Folder folder;
  folder.write("camera.toml", camera("range = \"1 km\"\n"));
  const std::string text =
      study_of(axis("atmosphere.range", R"("1 km", "7 km")") + axis("optics.f_number", "2.0, 4.0"));
  Evaluated e = evaluated(folder, text);
  std::vector<std::vector<double>> rows;
  for (std::int64_t design = 0; design < 4; ++design) {
    e.at(design);
    rows.push_back(e.row);
  }
  for (std::int64_t design = 3; design >= 0; --design) {
    Evaluated fresh = evaluated(folder, text);
    fresh.at(design);
    EXPECT_EQ(fresh.row, rows[static_cast<std::size_t>(design)]) << design;
    e.at(design);
    EXPECT_EQ(e.row, rows[static_cast<std::size_t>(design)]) << design;
  }
}

}  // namespace
