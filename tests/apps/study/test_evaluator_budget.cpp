// SPDX-License-Identifier: Apache-2.0

// What a study takes from the budget: spectral responses, the target's contrast, cones, what a correction leaves.

#include "apps/sensor/sensor_chain.h"
#include "apps/study/design/metric_rows.h"
#include "mtf/io/image_io.h"
#include "radiometry/chain/chain.h"
#include "tests/apps/study/evaluated.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using study_test::Evaluated;
using study_test::evaluated;
using study_test::expect_gradient;
using study_test::Folder;

/// A MWIR camera of everything that a budget reads.
std::string mwir_camera(const std::string& efficiency, const std::string& more = "") {
  return R"(schema = 1
[frame]
focal_length = "100 mm"
pitch = "15 um"
integration_time = "2 ms"
format = [64, 48]
[scene]
quantity = "temperature"
emissivity = 0.95
surroundings = "280 K"
[path]
transmission = 0.8
air_temperature = "285 K"
radiance = 0.01
[optics]
f_number = 2.0
transmission = 0.85
emissivity = 0.1
temperature = "293 K"
stop_temperature = "180 K"
[band]
wavelength = ["3.4 um", "4.8 um"]
[detector]
quantum_efficiency = )" +
         efficiency + R"(
full_well = "4 Me-"
dark_current = "1 Me-/s"
read_noise = "150 e-"
[nonuniformity]
prnu = 0.02
dsnu = "500 e-"
[nonlinearity]
a2 = -0.02
[correction]
frames = 8
[adc]
bits = 14
[[presample]]
kind = "diffraction"
[[presample]]
kind = "footprint"
width = "15 um"
)" + more;
}

/// Every metric that reads the budget, of a target of 4 K, with axes that its spectra hang on.
std::string mwir_study() {
  std::string list;
  for (const study::MetricRow& row : study::metric_rows())
    if (row.effort == study::Effort::budget || row.effort == study::Effort::giqe || row.effort == study::Effort::grd ||
        row.effort == study::Effort::bars)
      list += (list.empty() ? "\"" : ", \"") + std::string(row.name) + "\"";
  return R"(schema = 1
sensor = "camera.toml"
[[axis]]
parameter = "optics.f_number"
values = [2.0, 2.5]
[[axis]]
parameter = "optics.stop_temperature"
values = ["180 K", "185 K"]
[[axis]]
parameter = "scene.emissivity"
values = [0.9, 0.95]
[[axis]]
parameter = "nonuniformity.prnu"
values = [0.01, 0.02]
[metrics]
list = [)" +
         list +
         R"(]
[conditions]
temperature = "290 K"
contrast = "4 K"
range = "2 km"
target_size = "3 m"
)";
}

TEST(EvaluatorBudget, AFlatCurveIsItsNumberInEveryMetricAndItsSlopes) {
  const Folder folder;
  folder.write("camera.toml", mwir_camera("0.7"));
  Evaluated number = evaluated(folder, mwir_study());
  folder.write("qe.csv", "wavelength_um,quantum_efficiency\n1,0.7\n4,0.7\n5.5,0.7\n");
  folder.write("camera.toml", mwir_camera("\"qe.csv\""));
  Evaluated curve = evaluated(folder, mwir_study());
  for (const std::int64_t design : {0, 7}) {
    number.at(design);
    curve.at(design);
    for (std::size_t c = 0; c + 1 < number.columns.size(); ++c) {  // the last one estimates an error
      EXPECT_TRUE(std::isfinite(number.row[c])) << number.columns[c].name;
      // Roots of range equations carry what their curves differ by, 1e-15, some hundredfold.
      EXPECT_NEAR(curve.row[c], number.row[c], 1e-12 * std::abs(number.row[c])) << number.columns[c].name;
    }
  }
  std::vector<double> axes(4);
  study::design_at(*number.study, 7, axes);
  const auto a = number.evaluator->gradient_at(axes, 1e-6), b = curve.evaluator->gradient_at(axes, 1e-6);
  for (std::size_t i = 0; i < a.value.size(); ++i)  // spectra by differences over 1e-3 of their number
    EXPECT_NEAR(b.value[i], a.value[i], 1e-9 * std::abs(a.value[i]) + 1e-300) << a.columns[i / 4] << " by " << i % 4;
}

TEST(EvaluatorBudget, DerivativesGoThroughContrastCorrectionAndTheCurveOfTheDetector) {
  const Folder folder;
  folder.write("qe.csv", "wavelength_um,quantum_efficiency\n3,0.5\n4,0.8\n5,0.3\n");
  std::string camera = mwir_camera("\"qe.csv\"");
  camera = replaced(camera, "f_number = 2.0", "f_number = 2.0\ncone = \"sine\"\nstop_band = \"response\"");
  folder.write("camera.toml", camera);
  std::string study = mwir_study();
  const std::size_t list = study.find("list = ");
  study.replace(
      list, study.find('\n', list) - list,
      "list = [\"nei\", \"target_snr\", \"prnu_noise\", \"correction_noise\", \"spatial_netd\", \"background\"]");
  expect_gradient(folder, study, 6, 1e-6);
}

// A target of 4 K by the electrons of two budgets, at a surface without a path of its own radiance or with one.
TEST(EvaluatorBudget, TheTargetIsTheDifferenceOfTwoBudgets) {
  const Folder folder;
  folder.write("camera.toml", mwir_camera("0.7"));
  Evaluated e = evaluated(folder, mwir_study());
  e.at(0);
  std::vector<double> axes(4);
  study::design_at(*e.study, 0, axes);
  const mtf::io::SensorConfig config = e.evaluator->sensor_at(axes);
  const apps::LoadedSensor loaded = apps::load_chain(config);
  const auto background = radiometry::budget_of(config.system, loaded.sensor, 290.0);
  const auto target = radiometry::budget_of(config.system, loaded.sensor, 294.0);
  // As the response of a2 = -0.02 shows it, in charge: (R(target) - R(background)) / R'(background).
  const auto response = [](double charge_e) { return charge_e * (1.0 - 0.02 * charge_e / 4e6); };
  const double scene_e = background.signal.total_e(),
               seen_e = (response(target.signal.total_e()) - response(scene_e)) / (1.0 - 0.04 * scene_e / 4e6),
               snr = seen_e / background.temporal_e;
  EXPECT_NEAR(e["target_snr"] / snr, 1.0, 1e-12);
  EXPECT_GT(snr, 1.05 * 4.0 * background.signal_per_k / background.temporal_e);  // Planck's law is bent there
  for (const auto& [name, value] : {std::pair{"background", background.signal.path_e + background.signal.optics_e +
                                                                background.signal.stop_e + background.signal.dark_e},
                                    {"prnu_noise", background.prnu_e},
                                    {"correction_noise", background.correction_e},
                                    {"spatial_noise", background.spatial_e},
                                    {"nei", background.nei_ph}})
    EXPECT_NEAR(e[name] / value, 1.0, 1e-13) << name;
}

// 12 bits of 60 e- end at 245730 e-, below them lies the scene, above them the target; the well holds 4 Me-.
TEST(EvaluatorBudget, ATargetThatTheConverterHoldsHasNoNumber) {
  const Folder folder;
  std::string camera = replaced(mwir_camera("0.7"), "bits = 14", "bits = 12\nelectrons_per_count = \"60 e-\"");
  camera = replaced(camera, "[correction]\nframes = 8\n", "");
  folder.write("camera.toml", camera);
  const std::string study =
      "schema = 1\nsensor = \"camera.toml\"\n[[axis]]\nparameter = \"frame.integration_time\"\nvalues = [\"0.3 ms\"]\n"
      "[metrics]\nlist = [\"target_snr\", \"niirs_giqe5\", \"netd\", \"dynamic_range\", \"signal\", \"background\"]\n"
      "[conditions]\ntemperature = \"290 K\"\nrange = \"2 km\"\n";
  Evaluated e = evaluated(folder, study + "contrast = \"4 K\"\n");
  e.at(0);
  EXPECT_TRUE(std::isfinite(e["target_snr"]));
  EXPECT_TRUE(std::isfinite(e["niirs_giqe5"]));
  const double room = 245730.0 - e["signal"] - e["background"];
  for (const std::string& contrast : {std::string("contrast = \"300 K\"\n"),
                                      "signal_contrast = " + mtf::format_double(1.1 * room / e["signal"]) + "\n"}) {
    Evaluated held = evaluated(folder, study + contrast);
    held.at(0);
    EXPECT_TRUE(std::isnan(held["target_snr"])) << contrast;
    EXPECT_TRUE(std::isnan(held["niirs_giqe5"])) << contrast;
    EXPECT_TRUE(std::isfinite(held["netd"])) << contrast;
    std::string told;
    for (const std::string& sentence : held.evaluator->skipped()) told += sentence;
    expect_says(told, {"target of [conditions] is saturated", "largest count of [adc]"});
  }
  const std::size_t path = camera.find("[path]");  // along a range a plain transmission cannot be followed
  folder.write("camera.toml", camera.erase(path, camera.find("[optics]") - path));
  Evaluated range =
      evaluated(folder, replaced(study, "\"target_snr\", \"niirs_giqe5\", ", "\"johnson_range_detect\", ") +
                            "contrast = \"300 K\"\ntarget_size = \"3 m\"\n");
  range.at(0);
  expect_says(range.evaluator->last_caution(), {"target of [conditions]", "largest count of [adc]", "ranges"});
}

// cos^4 alone changes over the image here, and takes light of scene and path: bars are seen worst in the corners, by
//   sqrt((v s^2 + r^2)/(s^2 + r^2))/v,   s their shot noise, r all other noise on the axis, v what is left of the
//   light.
TEST(EvaluatorBudget, VignettingTakesLightFromPlacesOfTheImage) {
  const Folder folder;
  std::string camera = mwir_camera("0.7");
  const std::size_t spatial = camera.find("[nonuniformity]");
  camera.replace(spatial, camera.find("[adc]") - spatial, "[vignetting]\ncos4 = true\n");
  folder.write("camera.toml", replaced(camera, "focal_length = \"100 mm\"", "focal_length = \"1 mm\""));
  const std::string study =
      "schema = 1\nsensor = \"camera.toml\"\n[[axis]]\nparameter = \"frame.focal_length\"\n"
      "values = [\"1 mm\", \"1.5 mm\"]\n[[axis]]\nparameter = \"optics.f_number\"\nvalues = [2.0]\n"
      "[metrics]\nlist = [\"mrtd\", \"mrtd.worst\", \"mrtd.mean\", \"scene_shot_noise\", \"temporal_noise\"]\n"
      "[conditions]\ntemperature = \"290 K\"\n";
  Evaluated e = evaluated(folder, study);
  for (const std::int64_t design : {0, 1}) {
    e.at(design);
    const double focal_um = design == 0 ? 1000.0 : 1500.0, shot = std::pow(e["scene_shot_noise"], 2),
                 all = std::pow(e["temporal_noise"], 2);
    double mean = 0.0, worst = 0.0;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        const double light = std::pow(std::cos(std::atan(15.0 * std::hypot(x - 31.5, y - 23.5) / focal_um)), 4),
                     ratio = std::sqrt((light * shot + all - shot) / all) / light;
        worst = std::max(worst, ratio);
        // Between the outermost centres, by the trapezoidal rule.
        mean += ratio * (x % 63 == 0 ? 0.5 : 1.0) * (y % 47 == 0 ? 0.5 : 1.0) / (63.0 * 47.0);
      }
    EXPECT_GT(worst, 1.1);
    EXPECT_NEAR(e["mrtd.worst"] / e["mrtd"], worst, 1e-5);  // rounding to counts is no sum of squares
    EXPECT_NEAR(e["mrtd.mean"] / e["mrtd"], mean, mean * (e["error"] + 1e-4));  // of 25 places, and that rule
  }
  expect_gradient(folder, study, 0, 1e-5);
}

TEST(EvaluatorBudget, AConeThatNoLensHasIsADesignThatCannotBe) {
  const Folder folder;
  std::string camera = mwir_camera("0.7");
  camera = replaced(camera, "f_number = 2.0", "f_number = 2.0\ncone = \"sine\"");
  folder.write("camera.toml", camera);
  Evaluated e = evaluated(folder,
                          "schema = 1\nsensor = \"camera.toml\"\n[[axis]]\nparameter = \"optics.f_number\"\n"
                          "values = [0.45, 2.0]\n[metrics]\nlist = [\"netd\"]\n");
  e.at(0);
  EXPECT_TRUE(std::isnan(e["netd"]));
  expect_says(e.evaluator->last_problem(), {"0.5 or above"});
  e.at(1);
  EXPECT_TRUE(std::isfinite(e["netd"]));
}

TEST(EvaluatorBudget, SpatialNoiseWithoutFlatFramesHasNoNumberAndAReason) {
  const Folder folder;
  std::string camera = mwir_camera("0.7");
  camera = replaced(camera, "frames = 8", "low = 0.001");
  folder.write("camera.toml", camera);
  Evaluated e = evaluated(folder,
                          "schema = 1\nsensor = \"camera.toml\"\n[[axis]]\nparameter = \"optics.f_number\"\n"
                          "values = [2.0]\n[metrics]\nlist = [\"netd\", \"spatial_netd\"]\n");
  e.at(0);
  EXPECT_TRUE(std::isfinite(e["netd"]));
  EXPECT_TRUE(std::isnan(e["spatial_netd"]));
  std::string told;
  for (const std::string& sentence : e.evaluator->skipped()) told += sentence;
  expect_says(told, {"flat frame at 0.001"});
}

// Frames take the map in place of the number, so that its designs would all be one camera.
TEST(EvaluatorBudget, ANumberThatAMapReplacesIsNoAxis) {
  const Folder folder;
  mtf::Image map(640, 512);
  std::fill_n(map.data(), map.size(), 1.0F);
  mtf::io::write_exr(folder / "gain.exr", {{"Y", map.view()}}, {});
  const std::string camera = std::string(study_test::kCamera) + "[nonuniformity]\nprnu = 0.01\ndsnu = \"20 e-\"\n";
  const auto lines = [&](const std::string& maps, const std::string& study) {
    folder.write("camera.toml", camera + maps);
    return folder.lines(study_test::kHead + study + study_test::kMetrics);
  };
  const std::string prnu = "[[axis]]\nparameter = \"prnu\"\nvalues = [0.01, 0.02]\n";
  const std::string dsnu = "[[axis]]\nparameter = \"nonuniformity.dsnu\"\nvalues = [\"10 e-\"]\n";
  const std::string gain = "responsivity = \"gain.exr\"\n", offset = "offset = \"gain.exr\"\n";
  EXPECT_EQ(lines("", prnu + dsnu), "");
  EXPECT_EQ(lines(gain, dsnu), "") << "the map of the responsivity leaves dsnu as it is";
  std::string told = lines(gain, prnu);
  expect_says(told,
              {"study.toml:4:13: error: axis[0].parameter", "gain.exr", "in place of prnu", "remove responsivity"});
  told = lines(offset, dsnu);
  expect_says(told, {"in place of dsnu"});
  told = lines(gain, study_test::kAxis + std::string("[[as_built]]\nparameter = \"prnu\"\nsd = 0.001\n"));
  expect_says(told, {"in place of prnu"});
  told = lines("", prnu + "[[axis]]\nparameter = \"nonuniformity.responsivity\"\nvalues = [\"gain.exr\"]\n");
  expect_says(told, {"overlaps", "axis 1 (prnu)"});
  folder.write("mapped.toml", camera + gain);
  told = lines("", prnu + "[[axis]]\nparameter = \"sensor\"\nvalues = [\"camera.toml\", \"mapped.toml\"]\n");
  expect_says(told, {"mapped.toml:", "the map"});
}

}  // namespace
