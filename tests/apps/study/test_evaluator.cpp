// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_chain.h"
#include "mtf/metrics/resolution.h"
#include "tests/apps/study/evaluated.h"
#include "tests/apps/study/satellite.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using study_test::Evaluated;
using study_test::evaluated;
using study_test::expect_gradient;
using study_test::Folder;
using study_test::with_metrics;

TEST(Evaluator, GeometryIsByHand) {
  const Folder folder;
  Evaluated e = evaluated(folder, with_metrics(R"("cutoff", "nyquist", "q", "ifov", "gsd", "fov_x", "fov_y")") +
                                      "[conditions]\nrange = \"500 km\"\n");
  e.at(1);  // pitch 8 um, f = 2 m, F/8, 0.5 to 0.7 um
  EXPECT_NEAR(e["cutoff"], 1e3 / (0.5 * 8.0), 1e-9);
  EXPECT_NEAR(e["nyquist"], 62.5, 1e-12);
  EXPECT_NEAR(e["q"], 0.6 * 8.0 / 8.0, 1e-12);
  EXPECT_NEAR(e["ifov"], 4.0, 1e-12);
  EXPECT_NEAR(e["gsd"], 2.0, 1e-12);
  EXPECT_NEAR(e["fov_x"], 2.0 * std::atan(0.5 * 640 * 8e-6 / 2.0) * 180.0 / M_PI, 1e-12);
  EXPECT_NEAR(e["fov_y"], 2.0 * std::atan(0.5 * 512 * 8e-6 / 2.0) * 180.0 / M_PI, 1e-12);
}

// RER of a Gaussian of s pixels is erf(1/(sqrt 8 s)), and so NIIRS is known in closed form (GIQE 5, giqe.h).
TEST(Evaluator, RerAndNiirsOfGaussianSystemsAreClosedForms) {
  for (const double s : {0.3, 0.5, 1.0}) {
    const Folder folder;
    std::string camera = study_test::kCamera;
    camera = camera.substr(0, camera.find("[[presample]]")) +
             "[scene]\nemissivity = 2.1e-6\n[[presample]]\nkind = \"gaussian\"\nsigma = \"" + std::to_string(8.0 * s) +
             " um\"\n";
    folder.write("camera.toml", camera);
    Evaluated e =
        evaluated(folder, with_metrics(R"("rer", "niirs_giqe5", "target_snr", "gsd")", "tolerance = 1e-11\n") +
                              "[conditions]\nrange = \"500 km\"\nsignal_contrast = 0.5\ntemperature = \"5800 K\"\n");
    e.at(1);
    const double rer = std::erf(0.5 / (std::sqrt(2.0) * s)), snr = e["target_snr"], log_rer = std::log10(rer);
    EXPECT_NEAR(e["rer"], rer, 1e-10) << s;
    const double niirs = 9.57 - 3.32 * std::log10(2.0 / 0.0254) + 3.32 * (1.0 - std::exp(-1.9 / snr)) * log_rer -
                         2.0 * std::pow(log_rer, 4) - 1.8 / snr;
    EXPECT_NEAR(e["niirs_giqe5"], niirs, 1e-9) << s;
  }
}

TEST(Evaluator, BudgetsAreThoseOfMtfBudget) {
  const Folder folder;
  Evaluated e =
      evaluated(folder, with_metrics(R"("signal", "temporal_noise", "netd", "snr", "nei", "quantisation_noise")") +
                            "[conditions]\ntemperature = \"400 K\"\n");
  for (const std::int64_t design : {0, 1}) {
    e.at(design);
    std::vector<double> axes(1);
    study::design_at(*e.study, design, axes);
    const mtf::io::SensorConfig config = e.evaluator->sensor_at(axes);
    const apps::LoadedSensor loaded = apps::load_chain(config);
    const auto budget = radiometry::budget_of(config.system, loaded.sensor, 400.0);
    EXPECT_NEAR(e["signal"] / budget.signal.scene_e, 1.0, 1e-13);
    EXPECT_NEAR(e["temporal_noise"] / budget.temporal_e, 1.0, 1e-13);
    EXPECT_NEAR(e["netd"] / (1e3 * budget.netd_k), 1.0, 1e-13);
    EXPECT_NEAR(e["snr"] / budget.snr, 1.0, 1e-13);
    EXPECT_NEAR(e["nei"] / budget.nei_ph, 1.0, 1e-13);
    EXPECT_NEAR(e["quantisation_noise"], 20.0 / std::sqrt(12.0), 1e-12);
  }
}

TEST(Evaluator, ASensorOfADesignSaysTheSame) {
  const Folder folder;
  folder.write("satellite.toml", study_test::satellite(true));
  Evaluated e = evaluated(folder, study_test::satellite_study(64, "1e-8"));
  e.at(17);
  std::vector<double> axes(e.study->axes.size());
  study::design_at(*e.study, 17, axes);
  folder.write("design.toml", mtf::io::write_config(e.evaluator->sensor_at(axes), folder / "design.toml"));
  const auto config = mtf::io::load_config(folder / "design.toml", nullptr, radiometry::sensor_tables());
  mtf::ResolutionNeeds needs;
  needs.axis.edge = true;
  needs.tolerance = 1e-8;
  const auto direct = mtf::ResolutionMeter<double>(needs).measure(config.system);
  EXPECT_NEAR(e["rer"], std::sqrt(direct.x.rer * direct.y.rer), 1e-10);
  EXPECT_NEAR(e["mtf_nyquist"], std::sqrt(direct.x.nyquist * direct.y.nyquist), 1e-12);
  const auto budget = radiometry::budget_of(config.system, apps::load_chain(config).sensor, 5800.0);
  EXPECT_NEAR(e["temporal_noise"] / budget.temporal_e, 1.0, 1e-12);
}

// The camera's jitter is larger along x than along y. The name without an axis is their geometric mean, and the values
// along an axis are those of `mtf curve`.
TEST(Evaluator, TheMtfAtNyquistHasAValueAlongEachAxisAndAMeanOfBoth) {
  const Folder folder;
  const std::string text = with_metrics(R"("mtf_nyquist", "mtf_nyquist_x", "mtf_nyquist_y")", "tolerance = 1e-10\n");
  Evaluated e = evaluated(folder, text);
  e.at(1);
  EXPECT_LT(e["mtf_nyquist_x"], 0.95 * e["mtf_nyquist_y"]);
  EXPECT_NEAR(e["mtf_nyquist"], std::sqrt(e["mtf_nyquist_x"] * e["mtf_nyquist_y"]), 1e-14);
  std::vector<double> axes(e.study->axes.size());
  study::design_at(*e.study, 1, axes);
  folder.write("design.toml", mtf::io::write_config(e.evaluator->sensor_at(axes), folder / "design.toml"));
  const auto config = mtf::io::load_config(folder / "design.toml", nullptr, radiometry::sensor_tables());
  const mtf::System<double> system = apps::with_electron_rate(config.system, apps::load_chain(config));
  for (const auto& [metric, angle] : {std::pair{"mtf_nyquist_x", 0.0}, std::pair{"mtf_nyquist_y", 90.0}}) {
    const apps::Direction direction = apps::make_direction(system.frame, "cy/px", angle);
    const auto h = apps::otf_curves(system, {0.5}, direction).system.otf.front();
    EXPECT_NEAR(e[metric], std::hypot(h.re, h.im), 1e-9) << metric;
  }
  expect_gradient(folder, text, 1, 1e-5);
  for (const auto& [metric, ends] : {std::pair{"mtf_nyquist", "; geometric mean of both axes"},
                                     std::pair{"mtf_nyquist_x", "; along x"}, std::pair{"mtf_nyquist_y", "; along y"}})
    EXPECT_TRUE(study::find_metric(metric)->definition.ends_with(ends)) << metric;
}

TEST(Evaluator, ARowDoesNotDependOnWhatCameBefore) {
  const Folder folder;
  folder.write("satellite.toml", study_test::satellite(false));
  Evaluated e = evaluated(folder, study_test::satellite_study(24, "1e-4"));
  std::vector<std::vector<double>> rows;
  for (int design = 0; design < 24; ++design) {
    e.at(design);
    rows.push_back(e.row);
  }
  for (int design = 23; design >= 0; design -= 5) {
    Evaluated fresh = evaluated(folder, study_test::satellite_study(24, "1e-4"));
    fresh.at(design);
    EXPECT_EQ(fresh.row, rows[static_cast<std::size_t>(design)]) << design;
    e.at(design);
    EXPECT_EQ(e.row, rows[static_cast<std::size_t>(design)]) << design;
  }
}

TEST(Evaluator, DerivativesAreThoseOfTheWholeChain) {
  const Folder folder;
  folder.write("satellite.toml", study_test::satellite(true));
  expect_gradient(folder, study_test::satellite_study(8, "1e-4"), 3, 1e-6);
}

TEST(Evaluator, DerivativesGoThroughTablesLinksAndSpectra) {
  const Folder folder;
  std::string camera = study_test::kCamera;
  camera = replaced(camera, "transmission = 0.8",
                    "transmission = 0.8\nemissivity = 0.1\ntemperature = \"290 K\"\nstop_temperature = \"250 K\"");
  camera = replaced(camera, "\"0.5 um\", \"0.7 um\"", "\"8 um\", \"12 um\"");
  camera.replace(camera.find("\"20 e-\"\n[[presample]]"), 7, "\"100 ke-\"");  // else the converter is saturated
  const std::string aberrated = "kind = \"wavefront\"\nzernike = [0.0, 0.0, 0.0, 0.05]";
  camera.replace(camera.find(aberrated), aberrated.size(), "kind = \"diffraction\"\nwavelength = \"10 um\"");
  folder.write("camera.toml", camera + "[path]\ntransmission = 0.7\nradiance = 0.5\n[nonuniformity]\nprnu = 0.001\n");
  expect_gradient(folder, R"(schema = 1
sensor = "camera.toml"
objectives = ["minimize netd * aperture ^ 2"]
[[axis]]
parameter = "optics.aperture"
from = "200 mm"
to = "300 mm"
count = 3
[[axis]]
name = "speed"
from = 3.0
to = 4.0
count = 2
[[axis]]
parameter = "detector.quantum_efficiency"
from = 0.5
to = 0.8
count = 2
[[axis]]
parameter = "optics.temperature"
from = "280 K"
to = "300 K"
count = 2
[[axis]]
parameter = "path.transmission"
from = 0.5
to = 0.9
count = 2
[[axis]]
parameter = "nonuniformity.prnu"
from = 0.001
to = 0.002
count = 2
[links]
focal_length = "speed * aperture"
[metrics]
list = ["signal", "background", "netd", "spatial_netd", "snr", "rer", "mtf50", "gsd", "grd", "strehl"]
[conditions]
range = "5 km"
contrast = "2 K"
)",
                  5, 1e-6);
}

TEST(Evaluator, WhatADesignCannotHaveIsAGapWithItsReason) {
  const Folder folder;
  std::string camera = study_test::kCamera;
  camera.erase(camera.find("[detector]"), camera.find("[[presample]]") - camera.find("[detector]"));
  camera.erase(camera.find("transmission = 0.8\n"), 19);
  folder.write("camera.toml", camera);
  Evaluated e = evaluated(folder, with_metrics(R"("netd", "niirs_giqe5", "gsd", "ttp", "spurious_response", "rer")"));
  e.at(0);
  for (const char* name : {"netd", "niirs_giqe5", "gsd", "ttp", "spurious_response"})
    EXPECT_TRUE(std::isnan(e[name])) << name;
  EXPECT_TRUE(std::isfinite(e["rer"]));
  EXPECT_EQ(e.evaluator->last_problem(), "");
  const auto gaps = e.evaluator->gaps();
  const auto gap = [&](const std::string& name) {
    for (std::size_t c = 0; c < e.columns.size(); ++c)
      if (e.columns[c].name == name) return gaps[c];
    return std::string("?");
  };
  EXPECT_EQ(gap("netd"), "no [detector]");
  EXPECT_EQ(gap("niirs_giqe5"), "no [detector]");
  expect_says(gap("gsd"), {"no [conditions] range, such as range = \"5 km\""});
  expect_says(gap("spurious_response"), {"interpolation or eye", "[[postsample]]"});
  EXPECT_EQ(gap("rer"), "");
}

TEST(Evaluator, AModelThatRefusesLeavesTheOtherMetricsTheirNumbers) {
  const Folder folder;
  Evaluated e = evaluated(folder, with_metrics(R"("mrtd", "netd", "rer")"));
  e.at(0);  // in visible light a kelvin of 300 K gives nothing: no MRTD takes such noise
  EXPECT_TRUE(std::isnan(e["mrtd"]));
  EXPECT_TRUE(std::isfinite(e["netd"]));
  EXPECT_TRUE(std::isfinite(e["rer"]));
  EXPECT_EQ(e.evaluator->last_problem(), "");
  const auto told = e.evaluator->skipped();
  EXPECT_TRUE(std::any_of(told.begin(), told.end(), [](const std::string& sentence) {
    return sentence.find("metrics without a number") != std::string::npos &&
           sentence.find("mrtd.tvh") != std::string::npos;
  }));
}

/// The camera of the tests from 8 um to 12 um, with a well that a surface at 300 K can fill.
std::string thermal_camera() {
  std::string camera = study_test::kCamera;
  camera = replaced(camera, "[\"0.5 um\", \"0.7 um\"]", "[\"8 um\", \"12 um\"]");
  const std::string aberrated = "kind = \"wavefront\"\nzernike = [0.0, 0.0, 0.0, 0.05]";
  camera.replace(camera.find(aberrated), aberrated.size(), "kind = \"diffraction\"\nwavelength = \"10 um\"");
  camera.replace(camera.find("read_noise"), 0, "full_well = \"10 Me-\"\n");
  camera = replaced(camera, "bits = 12", "bits = 20");
  camera.replace(camera.find("electrons_per_count"), camera.npos,
                 "offset = 0\n" + camera.substr(camera.find("[[presample]]")));
  return camera;
}

// The longest time would have the least NETD; at 300 K the well is full then.
TEST(Evaluator, ASaturatedDesignHasNoSensitivityAndSaysWhy) {
  const Folder folder;
  folder.write("camera.toml", thermal_camera());
  Evaluated e = evaluated(folder, study_test::kHead + R"(objectives = ["minimize netd"]
constraints = ["well_fill < 100"]
[[axis]]
parameter = "frame.integration_time"
values = ["0.1 ms", "1 ms", "100 ms"]
[metrics]
list = ["netd", "snr", "nei", "spatial_netd", "target_snr", "temporal_noise", "signal", "read_noise", "rer"]
[conditions]
contrast = "2 K"
)");
  e.at(0);
  ASSERT_LT(e["well_fill"], 1.0);
  EXPECT_TRUE(std::isfinite(e["netd"]));
  EXPECT_EQ(e.evaluator->last_refusal(), "");
  const double signal = e["signal"];
  e.at(2);
  ASSERT_GT(e["well_fill"], 1.0);
  for (const char* name : {"netd", "snr", "nei", "spatial_netd", "target_snr", "temporal_noise"})
    EXPECT_TRUE(std::isnan(e[name])) << name;
  EXPECT_NEAR(e["signal"] / signal, 1000.0, 1e-9);
  EXPECT_EQ(e["read_noise"], 20.0);
  EXPECT_TRUE(std::isfinite(e["rer"]));
  EXPECT_EQ(e.evaluator->last_problem(), "");
  expect_says(e.evaluator->last_refusal(), {"saturated"});
  const study::Gradient gradient = e.evaluator->gradient_at(std::vector{e["frame.integration_time"]});
  EXPECT_TRUE(std::isnan(gradient.objective.front()));
  EXPECT_TRUE(std::isfinite(gradient.margin.front()));
  const auto told = e.evaluator->skipped();
  EXPECT_TRUE(std::any_of(told.begin(), told.end(),
                          [](const std::string& sentence) { return says(sentence, "the first: saturated"); }));
}

// A design whose integration is longer than its frame is no sensor, as a file with these two times is none.
TEST(Evaluator, AnIntegrationLongerThanTheFrameIsNoSensor) {
  const Folder folder;
  folder.write("camera.toml", replaced(thermal_camera(), "integration_time = \"2 ms\"",
                                       "frame_time = \"0.06 ms\"\nintegration_time = \"60 us\""));
  Evaluated e = evaluated(folder, study_test::kHead + R"(objectives = ["minimize netd"]
[[axis]]
parameter = "frame.integration_time"
from = "0.01 ms"
to = "0.09 ms"
count = 3
[metrics]
list = ["netd"]
)");
  for (const int design : {0, 1}) {  // 0.01 ms and 0.05 ms
    e.at(design);
    EXPECT_EQ(e.evaluator->last_problem(), "") << design;
    EXPECT_TRUE(e.evaluator->last_valid()) << e.evaluator->last_refusal();
  }
  e.at(2);
  EXPECT_FALSE(e.evaluator->last_valid());
  EXPECT_TRUE(std::isnan(e["netd"]));
  expect_says(e.evaluator->last_problem(), {"frame.frame_time: 6e-05 s is shorter than frame.integration_time, "});
}

// Where the mean meets the full well a NETD would be 17 % too good: refused there, with a caution close to it.
TEST(Evaluator, AMeanAtTheFullWellIsSaturatedAndOneCloseToItIsSaid) {
  const Folder folder;
  folder.write("camera.toml", thermal_camera());
  Evaluated e = evaluated(folder, study_test::kHead + R"(objectives = ["minimize netd"]
constraints = ["well_fill < 100"]
[[axis]]
parameter = "frame.integration_time"
from = "0.01 ms"
to = "10 ms"
count = 3
[metrics]
list = ["netd"]
)");
  e.at(0);
  const double full_ms = e["frame.integration_time"] / e["well_fill"];
  const auto at_fill = [&](double fill) { e.evaluator->evaluate_at(std::vector{fill * full_ms}, e.row); };
  at_fill(1.0);
  EXPECT_TRUE(std::isnan(e["netd"])) << e["well_fill"];
  EXPECT_FALSE(e.evaluator->last_valid());
  expect_says(e.evaluator->last_refusal(), {"saturated"});
  EXPECT_EQ(e.evaluator->last_caution(), "");
  at_fill(0.9999);
  EXPECT_TRUE(std::isfinite(e["netd"]));
  expect_says(e.evaluator->last_caution(), {"near saturation"});
  at_fill(0.5);
  EXPECT_EQ(e.evaluator->last_caution(), "");
}

TEST(Evaluator, DesignsThatNoSensorCanBeHaveAReasonAndNoNumbers) {
  const Folder folder;
  Evaluated e = evaluated(folder, R"(schema = 1
sensor = "camera.toml"
constraints = ["rer > 0"]
[[axis]]
name = "share"
values = [0.5, 1.5, -1.0]
[links]
"optics.obscuration" = "share"
[metrics]
list = ["rer"]
)");
  e.at(0);
  EXPECT_EQ(e.evaluator->last_problem(), "");
  EXPECT_EQ(e["feasible"], 1.0);
  for (const int design : {1, 2}) {
    e.at(design);
    expect_says(e.evaluator->last_problem(), {"optics.obscuration"});
    EXPECT_TRUE(std::isnan(e["rer"]));
    EXPECT_EQ(e["feasible"], 0.0);
    EXPECT_EQ(e["optics.obscuration"], design == 1 ? 1.5 : -1.0);  // what was asked for is told
  }
  e.at(0);
  EXPECT_EQ(e["feasible"], 1.0);
}

TEST(Evaluator, AsBuiltShiftsCountOnTopOfTheDesign) {
  const Folder folder;
  const std::string text =
      study_test::kHead + study_test::kAxis +
      "[metrics]\nlist = [\"rer_x\"]\n[[as_built]]\nparameter = \"jitter.rms\"\nsd = \"0.1 urad\"\n"
      "[yield]\ndraws = 10\n";
  Evaluated e = evaluated(folder, "constraints = [\"rer_x > 0.1\"]\n" + text);
  const std::vector<double> axes{8.0};
  std::vector<double> nominal(e.columns.size()), shifted(e.columns.size()), again(e.columns.size());
  e.evaluator->evaluate_at(axes, nominal);
  const std::vector<double> shift{1.0};
  e.evaluator->evaluate_at(axes, shifted, shift);
  e.evaluator->evaluate_at(axes, again);
  EXPECT_LT(shifted[1], nominal[1]);
  EXPECT_EQ(again[1], nominal[1]);
  // 1 urad of jitter and 1 more is 2: as a sensor file with that says.
  std::string camera = study_test::kCamera;
  camera = replaced(camera, "rms = \"1 urad\"", "rms = \"2 urad\"");
  folder.write("camera.toml", camera);
  Evaluated two = evaluated(folder, text);
  two.evaluator->evaluate_at(axes, nominal);
  EXPECT_NEAR(shifted[1], nominal[1], 1e-12);
}

TEST(Evaluator, DiscreteAxesMakeSensorsOfTheirOwn) {
  const Folder folder;
  std::string other = study_test::kCamera;
  other = replaced(other, "pitch = \"8 um\"", "pitch = \"4 um\"");
  folder.write("other.toml", other);
  Evaluated e = evaluated(
      folder,
      "schema = 1\n[[axis]]\nparameter = \"sensor\"\nvalues = [\"camera.toml\", \"other.toml\"]\n"
      "[[axis]]\nparameter = \"band.wavelength\"\nvalues = [[\"0.5 um\", \"0.7 um\"], [\"0.8 um\", \"0.9 um\"]]\n"
      "[metrics]\nlist = [\"nyquist\", \"cutoff\"]\n");
  ASSERT_EQ(e.study->designs, 4);
  const double nyquist[] = {62.5, 62.5, 125.0, 125.0}, cutoff[] = {250.0, 156.25, 250.0, 156.25};
  for (int design = 0; design < 4; ++design) {
    e.at(design);
    EXPECT_NEAR(e["nyquist"], nyquist[design], 1e-9);
    EXPECT_NEAR(e["cutoff"], cutoff[design], 1e-9);
  }
}

}  // namespace
