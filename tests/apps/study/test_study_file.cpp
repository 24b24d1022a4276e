// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/fit/parameter_site.h"
#include "tests/apps/study/study_files.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using study::Parameter;
using study_test::Folder;
using study_test::kAxis;
using study_test::kHead;
using study_test::kMetrics;

const Parameter& named(const study::Study& study, const std::string& name) {
  const auto found = std::find_if(study.parameters.begin(), study.parameters.end(),
                                  [&](const Parameter& p) { return p.name == name; });
  EXPECT_NE(found, study.parameters.end()) << name;
  return *found;
}

std::vector<double> values_at(const study::Study& study, std::int64_t design) {
  std::vector<double> values(study.axes.size());
  study::design_at(study, design, values);
  return values;
}

TEST(StudyFile, IsToldFromASensor) {
  EXPECT_TRUE(study::is_study(kHead + kAxis));
  EXPECT_TRUE(study::is_study("sensor = \"x.toml\""));
  EXPECT_TRUE(study::is_study("[[axis]]\nname = \"x\""));
  EXPECT_FALSE(study::is_study(study_test::kCamera));
  EXPECT_FALSE(study::is_study(""));
  EXPECT_FALSE(study::is_study("sensor = ["));
}

TEST(StudyFile, TheWholeOfTheExample) {
  const Folder folder;
  const std::string text = R"(schema = 1
name = "aperture against pitch"
sensor = "camera.toml"
tolerance = 1e-5
seed = 7
constraints = ["mtf_nyquist > 0.1", "focal_length <= 40 m", "1 < f_number"]
objectives = ["maximize mtf_nyquist", "minimize aperture ^ 2.5", "minimise  pitch"]
[[axis]]
parameter = "optics.aperture"
values = ["100 mm", "20 cm"]
[[axis]]
parameter = "frame.pitch"
from = "5 um"
to = "0.02 mm"
count = 3
scale = "log"
[[axis]]
name = "f_number"
from = 4.0
to = 12.0
count = 9
[links]
focal_length = "f_number * aperture"
[[as_built]]
parameter = "optics.obscuration"
sd = 0.01
[[as_built]]
parameter = "jitter.rms"
plus_minus = "2 %"
[[as_built]]
parameter = "slow.rms_y"
plus_minus = "200 nm"
[yield]
draws = 100
[metrics]
list = ["gsd"]
[conditions]
range = "500 km"
extinction = 0.2
temperature = "290 K"
)";
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  const study::Study& s = result.study;
  EXPECT_EQ(s.name, "aperture against pitch");
  EXPECT_EQ(s.tolerance, 1e-5);
  EXPECT_EQ(s.seed, 7u);
  EXPECT_EQ(s.designs, 2 * 3 * 9);
  EXPECT_EQ(s.variants, 1);
  ASSERT_EQ(s.axes.size(), 3u);
  EXPECT_EQ(s.axes[0].values, (std::vector{100.0, 200.0}));  // in mm, as the field holds it
  EXPECT_EQ(s.axes[1].to, 20.0);                             // um
  EXPECT_EQ(values_at(s, 0), (std::vector{100.0, 5.0, 4.0}));
  EXPECT_EQ(values_at(s, 1), (std::vector{100.0, 5.0, 5.0}));
  EXPECT_NEAR(values_at(s, 9)[1], 10.0, 1e-14);
  EXPECT_EQ(values_at(s, 53), (std::vector{200.0, 20.0, 12.0}));

  const Parameter& aperture = named(s, "optics.aperture");
  EXPECT_EQ(aperture.path, "optics.aperture");
  EXPECT_EQ(aperture.unit, "mm");
  EXPECT_EQ(aperture.base, 250.0);
  EXPECT_EQ(aperture.role, Parameter::Role::axis);
  const Parameter& own = named(s, "f_number");
  EXPECT_EQ(own.path, "");
  EXPECT_EQ(own.unit, "");
  EXPECT_TRUE(std::isnan(own.base));
  const Parameter& jitter = named(s, "jitter.rms");
  EXPECT_EQ(jitter.path, "presample[2].rms");
  EXPECT_EQ(jitter.unit, "urad");
  EXPECT_EQ(jitter.base, 1.0);
  EXPECT_EQ(jitter.role, Parameter::Role::fixed);

  ASSERT_EQ(s.links.size(), 1u);
  std::vector<double> slots(s.slots(), 0.0);
  slots[0] = 0.2;  // aperture, m
  slots[2] = 8.0;
  EXPECT_DOUBLE_EQ(s.links[0].expression.evaluate<double>(slots), 1.6);
  EXPECT_EQ(s.parameters[static_cast<std::size_t>(s.links[0].parameter)].path, "frame.focal_length");

  ASSERT_EQ(s.as_built.size(), 3u);
  EXPECT_EQ(s.as_built[0].law, study::AsBuilt::Law::normal);
  EXPECT_FALSE(s.as_built[0].relative);
  EXPECT_TRUE(s.as_built[1].relative);
  EXPECT_DOUBLE_EQ(s.as_built[1].spread, 0.02);
  EXPECT_EQ(s.as_built[1].law, study::AsBuilt::Law::uniform);
  EXPECT_DOUBLE_EQ(s.as_built[2].spread, 0.2);  // um
  EXPECT_EQ(s.draws, 100);

  ASSERT_EQ(s.metrics.size(), 2u);
  EXPECT_EQ(s.metrics[0].name, "gsd");
  EXPECT_EQ(s.metrics[1].name, "mtf_nyquist");
  const std::size_t mtf = s.parameters.size() + 1;
  slots.assign(s.slots(), 0.0);
  slots[mtf] = 0.2;
  ASSERT_EQ(s.constraints.size(), 3u);
  EXPECT_EQ(s.constraints[0].left.evaluate<double>(slots), 0.2);
  EXPECT_FALSE(s.constraints[0].less);
  EXPECT_TRUE(s.constraints[0].strict);
  EXPECT_TRUE(s.constraints[1].less);
  EXPECT_FALSE(s.constraints[1].strict);
  EXPECT_EQ(s.constraints[1].right.evaluate<double>(slots), 40.0);
  ASSERT_EQ(s.objectives.size(), 3u);
  EXPECT_TRUE(s.objectives[0].maximize);
  EXPECT_EQ(s.objectives[0].text, "mtf_nyquist");
  EXPECT_FALSE(s.objectives[1].maximize);
  EXPECT_EQ(s.objectives[1].unit, "m^2.5");
  EXPECT_EQ(s.objectives[1].si, 1.0);
  EXPECT_EQ(s.objectives[2].text, "pitch");
  EXPECT_EQ(s.objectives[2].unit, "um");
  EXPECT_DOUBLE_EQ(s.objectives[2].si, 1e-6);
  EXPECT_EQ(s.conditions.range_m, 5e5);
  EXPECT_EQ(s.conditions.extinction_per_km, 0.2);
  EXPECT_EQ(s.conditions.temperature_k, 290.0);
  EXPECT_FALSE(s.conditions.contrast_k);
  EXPECT_TRUE(s.warnings.empty());
}

TEST(StudyFile, NumbersOfOtherTablesAreAxesToo) {
  const Folder folder;
  const std::string text =
      kHead +
      "objectives = [\"minimize detector.read_noise\"]\n[[axis]]\nparameter = \"detector.read_noise\"\n"
      "values = [\"10 e-\", \"0.1 ke-\"]\n[[axis]]\nparameter = \"optics.transmission\"\n"
      "from = 0.5\nto = 0.9\ncount = 3\n[[axis]]\nparameter = \"wavefront.zernike[3]\"\n"
      "values = [0.0, 0.1]\n";
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  EXPECT_EQ(result.study.axes[0].values, (std::vector{10.0, 100.0}));
  EXPECT_EQ(result.study.parameters[0].unit, "e-");
  EXPECT_EQ(result.study.parameters[0].base, 20.0);
  EXPECT_EQ(result.study.parameters[1].base, 0.8);
  EXPECT_EQ(result.study.parameters[2].path, "presample[0].zernike[3]");
  EXPECT_EQ(result.study.parameters[2].base, 0.05);
  EXPECT_EQ(result.study.parameters.size(), 3u);  // read_noise of the objective is the axis
  EXPECT_EQ(result.study.variants, 1);
}

TEST(StudyFile, AMetricKeepsItsNameBesideAParameter) {
  const Folder folder;
  ASSERT_TRUE(study::find_metric("read_noise"));
  const std::string text = kHead +
                           "objectives = [\"minimize read_noise + detector.read_noise\"]\n[[axis]]\n"
                           "parameter = \"read_noise\"\nvalues = [\"10 e-\", \"20 e-\"]\n";
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  ASSERT_EQ(result.study.parameters.size(), 1u);
  EXPECT_EQ(result.study.parameters[0].name, "detector.read_noise");
  ASSERT_EQ(result.study.metrics.size(), 1u);
  EXPECT_EQ(result.study.objectives.at(0).expression.slots(), (std::vector{0, 1}));
}

TEST(StudyFile, OwnNumbersFollowInOrder) {
  const Folder folder;
  // mass needs area, area needs aperture, which is linked itself: written the wrong way round.
  const std::string text =
      kHead +
      "constraints = [\"mass < 90 kg\"]\n[[axis]]\nname = \"speed\"\nvalues = [\"4 km\", \"5000 m\"]\n"
      "[links]\nmass = \"40 kg / (1 m * 1 m) * area\"\narea = \"aperture^2\"\naperture = \"speed / 10000\"\n" +
      kMetrics;
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  const study::Study& s = result.study;
  EXPECT_EQ(s.axes[0].values, (std::vector{4.0, 5.0}));  // in km, the unit of the first
  ASSERT_EQ(s.links.size(), 3u);
  std::vector<double> slots(s.slots());
  slots[0] = s.axes[0].values[1] * s.parameters[0].scale.si;
  for (const study::Link& link : s.links)
    slots[static_cast<std::size_t>(link.parameter)] = link.expression.evaluate<double>(slots);
  EXPECT_DOUBLE_EQ(slots[static_cast<std::size_t>(&named(s, "mass") - s.parameters.data())], 10.0);
  EXPECT_EQ(named(s, "area").unit, "m^2");
  EXPECT_EQ(named(s, "mass").unit, "kg");
  EXPECT_EQ(named(s, "aperture").unit, "mm");
}

TEST(StudyFile, VariantsAreWhatTheSensorFileWouldBe) {
  const Folder folder;
  const std::string text = kHead + "objectives = [\"minimize bits\"]\n" + kAxis + R"([[axis]]
parameter = "bits"
values = [10, 12, 14]
[[axis]]
parameter = "band.wavelength"
values = [["0.5 um", "0.7 um"], ["0.4 um", "0.8 um"]]
[[axis]]
parameter = "jitter.rms"
values = ["1 urad", "3 um"]
[[axis]]
parameter = "frame.format"
values = [[640, 512]]
)";
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  const study::Study& s = result.study;
  EXPECT_EQ(s.variants, 12);
  EXPECT_EQ(s.designs, 24);
  EXPECT_EQ(s.axes[1].values, (std::vector{10.0, 12.0, 14.0}));
  EXPECT_EQ(s.axes[2].levels[1], "[\"0.4 um\", \"0.8 um\"]");
  EXPECT_EQ(s.axes[2].values, (std::vector{0.0, 1.0}));
  EXPECT_EQ(values_at(s, 23), (std::vector{8.0, 2.0, 1.0, 1.0, 0.0}));

  const std::vector<int> levels{0, 2, 1, 1, 0};
  const mtf::io::SensorConfig sensor = study::variant(s, levels);
  EXPECT_EQ(std::get<int>(*find_table(sensor.tables, "adc")->find("bits")), 14);
  EXPECT_EQ(sensor.system.band->lo_um, 0.4);
  EXPECT_EQ(sensor.system.band->hi_um, 0.8);
  mtf::System<double> system = sensor.system;
  EXPECT_EQ(*calib::parameter_site(system, "presample[2].rms").numbers.at(0), 3.0);
  EXPECT_EQ(sensor.system.frame.pitch_x_um, 8.0);  // a numeric axis stays as the file has it
  // The same from a file in which it is written.
  std::string written = study_test::kCamera;
  const auto replace = [&](const std::string& from, const std::string& to) {
    written.replace(written.find(from), from.size(), to);
  };
  replace("bits = 12", "bits = 14");
  replace("\"0.5 um\", \"0.7 um\"", "\"0.4 um\", \"0.8 um\"");
  replace("rms = \"1 urad\"", "rms = \"3 um\"");
  const auto direct = mtf::io::parse_config(written, sensor.file, s.base.schema);
  ASSERT_TRUE(direct.ok());
  EXPECT_EQ(mtf::io::write_config(sensor), mtf::io::write_config(direct.config));
}

TEST(StudyFile, CombinationsThatNoSensorCanBeAreRefused) {
  const Folder folder;
  // A kernel that is right for one sensor: the other gives a number that belongs to its own.
  const std::string zoom = "[[postsample]]\nkind = \"interpolation\"\nkernel = \"cubic\"\n";
  folder.write("plain.toml", study_test::kCamera + zoom);
  folder.write("sharp.toml", study_test::kCamera + zoom + "a = -0.6\n");
  const std::string text =
      "schema = 1\n[[axis]]\nparameter = \"sensor\"\nvalues = [\"plain.toml\", \"sharp.toml\"]\n"
      "[[axis]]\nparameter = \"interpolation.kernel\"\nvalues = [\"linear\", \"cubic\"]\n" +
      kMetrics;
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  EXPECT_NO_THROW(study::variant(result.study, std::vector{0, 0}));
  EXPECT_NO_THROW(study::variant(result.study, std::vector{1, 1}));
  expect_refused(
      {"sharp.toml with", "sensor = sharp.toml", "interpolation.kernel = linear", "postsample[0].a: belongs to kernel"},
      [&] {
        study::variant(result.study, std::vector{1, 0});
      });
}

TEST(StudyFile, AxesOverSensors) {
  const Folder folder;
  std::string other = study_test::kCamera;
  other = replaced(other, "8 um", "9 um");
  folder.write("other.toml", other);
  const std::string axis = "[[axis]]\nparameter = \"sensor\"\nvalues = [\"camera.toml\", \"other.toml\"]\n";
  const std::string bits = "[[axis]]\nparameter = \"bits\"\nvalues = [10, 12]\n";
  const std::string jitter = "[[axis]]\nparameter = \"jitter.rms\"\nvalues = [\"1 urad\", \"2 urad\"]\n";
  const std::string text = "schema = 1\nobjectives = [\"minimize pitch\"]\n" + axis + bits + jitter;
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  EXPECT_EQ(result.study.sensors.size(), 2u);
  const std::string own = "[[axis]]\nname = \"lens\"\nvalues = [\"100 mm\", \"200 mm\"]\n";
  const std::string linked = "schema = 1\n" + axis + own + "[links]\nfocal_length = \"8 * lens\"\n" + kMetrics;
  EXPECT_TRUE(folder.parse(linked).ok()) << folder.lines(linked);  // a number of the study's own is in no sensor
  EXPECT_EQ(result.study.base.file, folder / "camera.toml");
  EXPECT_EQ(result.study.variants, 4);
  const auto sensor = study::variant(result.study, std::vector{1, 0, 0});
  EXPECT_EQ(sensor.file, folder / "other.toml");
  EXPECT_EQ(sensor.system.frame.pitch_x_um, 9.0);
  EXPECT_EQ(std::get<int>(*find_table(sensor.tables, "adc")->find("bits")), 10);

  // What is varied has to be in both, in the same place and unit.
  other.replace(other.find("\"1 urad\""), 8, "\"1 um\"");
  folder.write("other.toml", other);
  expect_says(folder.lines(text), {"jitter.rms", "urad in camera.toml", "um in other.toml"});
  other = study_test::kCamera;
  other.insert(other.find("[[presample]]"), "[[presample]]\nkind = \"gaussian\"\nsigma = \"1 um\"\n");
  folder.write("other.toml", other);
  expect_says(folder.lines(text), {"jitter.rms", "presample[2].rms in camera.toml", "presample[3].rms in other.toml"});
  other = study_test::kCamera;
  other = replaced(other, "pitch = \"8 um\"", "pitch_x = \"8 um\"\npitch_y = \"9 um\"");
  folder.write("other.toml", other);
  expect_says(folder.lines(text), {"gives pitch_x and pitch_y"});
}

TEST(StudyFile, FilesAreBesideTheStudy) {
  const Folder folder;
  folder.write("sensors/camera.toml", study_test::kCamera);
  folder.write("qe.csv", "wavelength_um,value\n0.4,0.5\n0.9,0.7\n");
  const std::string text =
      "schema = 1\nsensor = \"sensors/camera.toml\"\n[[axis]]\nparameter = \"quantum_efficiency\"\n"
      "values = [0.5, \"qe.csv\"]\n" +
      kMetrics;
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  EXPECT_EQ(result.study.axes[0].levels, (std::vector<std::string>{"0.5", "qe.csv"}));
  const auto value = [&](int level) {
    const auto sensor = study::variant(result.study, std::vector{level});
    return *find_table(sensor.tables, "detector")->find("quantum_efficiency");
  };
  // A file that cannot be read is told at its place, before any design.
  std::string missing = text;
  missing = replaced(missing, "qe.csv", "no.csv");
  expect_says(folder.lines(missing), {"study.toml:5:16: error: axis[0].values:", "detector.quantum_efficiency: "});
  EXPECT_EQ(std::get<double>(value(0)), 0.5);
  EXPECT_EQ(std::get<std::string>(value(1)), folder / "qe.csv");
}

TEST(StudyFile, SamplesNeedNoCounts) {
  const Folder folder;
  const std::string text =
      kHead + "seed = 3\n[[axis]]\nparameter = \"pitch\"\nfrom = \"5 um\"\nto = \"10 um\"\n" +
      "[[axis]]\nparameter = \"bits\"\nvalues = [8, 10, 12]\n[sampling]\nmethod = \"latin_hypercube\"\npoints = 30\n" +
      kMetrics;
  const study::StudyResult result = folder.parse(text);
  ASSERT_TRUE(result.ok()) << folder.lines(text);
  EXPECT_EQ(result.study.designs, 30);
  std::vector<int> strata(30), levels(3);
  for (std::int64_t i = 0; i < 30; ++i) {
    const auto values = values_at(result.study, i);
    ++strata.at(static_cast<std::size_t>((values[0] - 5.0) / 5.0 * 30.0));
    ++levels.at(static_cast<std::size_t>(values[1]));
  }
  EXPECT_EQ(std::count(strata.begin(), strata.end(), 1), 30);
  EXPECT_EQ(levels, (std::vector{10, 10, 10}));
  std::string sobol = text;
  sobol = replaced(sobol, "latin_hypercube", "sobol");
  const study::StudyResult second = folder.parse(sobol);
  ASSERT_TRUE(second.ok()) << folder.lines(sobol);
  EXPECT_EQ(second.study.sobol.size(), 2u);
  EXPECT_NE(values_at(second.study, 0), values_at(result.study, 0));
}

TEST(StudyFile, TheHashIsOfAllThatItReads) {
  const Folder folder;
  const std::string text = kHead + kAxis + kMetrics;
  const std::string first = folder.parse(text).study.sha256;
  EXPECT_EQ(first.size(), 64u);
  EXPECT_EQ(folder.parse(text).study.sha256, first);
  EXPECT_NE(folder.parse(text + "# more\n").study.sha256, first);
  folder.write("camera.toml", std::string(study_test::kCamera) + "# more\n");
  EXPECT_NE(folder.parse(text).study.sha256, first);
}

TEST(StudyFile, OwnNumbersThatHideASensorsAreTold) {
  const Folder folder;
  const std::string lines = folder.lines(kHead + "[[axis]]\nname = \"obscuration\"\nvalues = [0.1]\n" + kMetrics);
  expect_says(lines, {"warning: axis[0]:", "study's own", "optics.obscuration"});
}

}  // namespace
