// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <random>

#include "apps/study/study_reader.h"
#include "mtf/error.h"
#include "tests/apps/study/study_files.h"
#include "tests/expect_error.h"

namespace {

using study_test::Folder;
using study_test::kAxis;
using study_test::kHead;
using study_test::kMetrics;

struct Case {
  std::string text;
  std::vector<std::string> parts;
  std::int64_t lines = 1;  ///< of the message: one an error or warning
};

void expect_errors(const std::vector<Case>& cases) {
  const Folder folder;
  for (const Case& c : cases) {
    SCOPED_TRACE(c.text);
    const std::string lines = folder.lines(c.text);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), c.lines) << lines;
    for (const std::string& part : c.parts) expect_says(lines, {part});
  }
}

std::string axis(const std::string& body) { return kHead + "[[axis]]\n" + body + "\n" + kMetrics; }

TEST(StudyErrors, OfTheHead) {
  expect_errors({
      {"", {"error: schema: missing", "error: metrics: neither metrics", "error: sensor: missing"}, 3},
      {"x = [", {"error: "}},
      {"schema = 2\nsensor = \"camera.toml\"\n" + kAxis + kMetrics, {"study.toml:1:10: error: schema: 2"}},
      {"schema = 1\nsensor = \"none.toml\"\n" + kAxis + kMetrics,
       {"study.toml:2:10: error: sensor: cannot read none.toml"}},
      {"schema = 1\nsensor = 3\n" + kAxis + kMetrics, {"2:10: error: sensor: 3"}},
      {kHead + "tolernce = 1e-3\n" + kAxis + kMetrics, {"3:1: error: tolernce: unknown", "\"tolerance\""}},
      {kHead + "tolerance = 1\n" + kAxis + kMetrics, {"3:13: error: tolerance: 1 is outside [1e-12, 0.1]"}},
      {kHead + "seed = -1\n" + kAxis + kMetrics, {"3:8: error: seed"}},
      {kHead + kAxis + kMetrics + "constraints = []\n", {"8:1: error: metrics.constraints:", "top of the file"}},
      {kHead + kMetrics, {"error: axis: missing; write [[axis]]"}},
      {kHead + "axis = []\n" + kMetrics, {"3:8: error: axis:", "nothing varies"}},
      {kHead + "[axis]\nparameter = \"pitch\"\n" + kMetrics, {"error: axis:", "list of tables", "[[axis]]"}},
      {kHead + kAxis, {"error: metrics: neither metrics"}},
  });
}

TEST(StudyErrors, OfTheSensorAreShownWhereItIsNamed) {
  const Folder folder;
  folder.write("bad.toml", "schema = 1\n[frame]\npitch = 5\n");
  const std::string lines = folder.lines("schema = 1\nsensor = \"bad.toml\"\n" + kAxis + kMetrics);
  expect_says(lines, {"study.toml:2:10: error: sensor:", "bad.toml:3:9: error: frame.pitch:", "5 has no unit"});
  folder.write("nested.toml", kHead + kAxis);
  expect_says(folder.lines("schema = 1\nsensor = \"nested.toml\"\n" + kAxis + kMetrics), {"is a study itself"});
}

TEST(StudyErrors, OfAxes) {
  expect_errors({
      {axis(""), {"error: axis[0].parameter: missing"}},
      {axis("parameter = \"pich\"\nvalues = [\"5 um\"]"), {"4:13: error: axis[0].parameter:", "'pich'"}},
      {axis("parameter = \"frame.pich\"\nvalues = [\"5 um\"]"), {"did you mean frame.pitch?"}},
      {axis("parameter = \"pitch\"\nname = \"x\"\nvalues = [\"5 um\"]"),
       {"5:8: error: axis[0].name:", "with parameter"}},
      {axis("parameter = \"pitch\"\nvalus = [\"5 um\"]\nvalues = [\"5 um\"]"), {"did you mean \"values\"?"}},
      {axis("parameter = \"pitch\"\nvalues = []"), {"5:10: error: axis[0].values: an empty list"}},
      {axis("parameter = \"pitch\"\nvalues = 5"), {"5:10: error: axis[0].values: 5", "a list"}},
      {axis("parameter = \"pitch\"\nvalues = [5, \"6 mK\", \"7 um\"]"),
       {"5:11: error: axis[0].values: 5", "no unit", "such as \"15 um\"", "5:14: error: axis[0].values: \"6 mK\""},
       2},
      {axis("parameter = \"pitch\"\nvalues = [\"5 um\", \"6 um\", \"0.005 mm\"]"),
       {"5:27: error: axis[0].values: \"0.005 mm\" is the value \"5 um\" of this list again", "remove one"}},
      {axis("parameter = \"sensor\"\nvalues = [\"camera.toml\", \"camera.toml\"]"),
       {"5:26: error: axis[0].values: \"camera.toml\" is the value \"camera.toml\" of this list again"}},
      {axis("parameter = \"pitch\"\nvalues = [\"5 um\"]\nfrom = \"5 um\""),
       {"6:8: error: axis[0].from:", "with values"}},
      {axis("parameter = \"pitch\"\nvalues = [\"-5 um\", \"2 m\"]"),
       {"5:11: error: axis[0].values: -5 um is outside [1e-06, 1e+06]",
        "5:20: error: axis[0].values: 2e+06 um is outside"},
       2},
      {axis("parameter = \"pitch\"\nfrom = \"5 um\""),
       {"error: axis[0].to: missing", "error: axis[0].count: missing"},
       2},
      {axis("parameter = \"pitch\"\nfrom = \"5 um\"\nto = \"6 um\""), {"error: axis[0].count: missing"}},
      {axis("parameter = \"pitch\"\nfrom = \"5 um\"\nto = \"6 um\"\ncount = 0"),
       {"7:9: error: axis[0].count: 0 has to be"}},
      {axis("parameter = \"pitch\"\nfrom = \"5 um\"\nto = \"6 um\"\ncount = 2.5"),
       {"7:9: error: axis[0].count: 2.5 has to be"}},
      {axis("parameter = \"pitch\"\nfrom = \"5 um\"\nto = \"0.005 mm\"\ncount = 3"),
       {"6:6: error: axis[0].to:", "the same as from"}},
      {axis("parameter = \"pitch\"\nfrom = \"5 um\"\nto = \"6 um\"\ncount = 1"),
       {"7:9: warning: axis[0].count: one point only"}},
      {axis("parameter = \"obscuration\"\nfrom = 0.0\nto = 0.5\ncount = 3\nscale = \"log\""),
       {"5:8: error: axis[0].from:", "above 0", "\"log\""}},
      {axis("parameter = \"obscuration\"\nfrom = 0.1\nto = 1.0\ncount = 3"),
       {"6:6: error: axis[0].to: 1 is outside [0, 1)"}},
      {axis("parameter = \"obscuration\"\nvalues = [\"0.1 um\"]"),
       {"5:11: error: axis[0].values:", "\"0.1 um\"", "plain number"}},
      {axis("parameter = \"adc.bits\"\nfrom = 8\nto = 14\ncount = 3"),
       {"error: axis[0].parameter: adc.bits", "whole number"}},
      {axis("parameter = \"adc.bits\"\nvalues = [8, 99, 10]"),
       {"5:14: error: axis[0].values: adc.bits: 99 is outside [1, 32]"}},
      {axis("parameter = \"f_number\"\nvalues = [2.0]"),
       {
           "does not give it",
       }},
      {axis("parameter = \"optics.f_number\"\nvalues = [2.0]"), {"f_number = 2.0", "[optics]", "aperture"}},
      {axis("parameter = \"dark_current\"\nvalues = [\"5 e-/s\"]"), {"dark_current = \"1e5 e-/s\"", "[detector]"}},
      {axis("parameter = \"noise.row\"\nvalues = [\"5 e-\"]"), {"no [noise]", "with row"}},
      {axis("parameter = \"wavefront.f_number\"\nvalues = [4.0]"), {"name optics.f_number"}},
      {axis("parameter = \"rms\"\nvalues = [\"5 um\"]"), {"several: jitter.rms, slow.rms"}},
      {axis("parameter = \"slow.rms\"\nvalues = [\"5 um\"]"), {"rms_x and rms_y", "name one"}},
      {axis("parameter = \"jitter.rms_x\"\nvalues = [\"5 urad\"]"), {"rms for both axes"}},
      {axis("parameter = \"jitter.rms\"\nfrom = \"1 um\"\nto = \"2 um\"\ncount = 2"),
       {"5:8: error: axis[0].from: \"1 um\"", "urad", "6:6: error: axis[0].to"},
       2},
      {axis("parameter = \"wavefront.zernike[9]\"\nvalues = [0.1]"), {"no such element"}},
      {axis("parameter = \"band.wavelength\"\nvalues = [[\"0.7 um\", \"0.5 um\"]]"),
       {"5:11: error: axis[0].values: band"}},
      {axis("parameter = \"sensor\"\nfrom = 1\nto = 2\ncount = 2"), {"a file", "no range"}},
      {axis("parameter = \"sensor\"\nvalues = [\"none.toml\"]"),
       {"5:11: error: axis[0].values: cannot read none.toml"}},
      {axis("name = \"sqrt\"\nvalues = [1.0]"), {"error: axis[0].name: \"sqrt\""}},
      {axis("name = \"a b\"\nvalues = [1.0]"), {"error: axis[0].name: \"a b\""}},
      {axis("name = \"mtf_nyquist\"\nvalues = [1.0]"), {"mtf_nyquist is a metric"}},
      {axis("name = \"quality\"\nvalues = [\"one\"]"), {"\"one\"", "plain number"}},
      {axis("name = \"quality\"\nvalues = [\"1 um\", \"2 K\"]"), {"5:19: error: axis[0].values: \"2 K\""}},
      {axis("name = \"quality\"\nvalues = [\"1 cy/mm\", \"2 cy/px\"]"), {"cy/px", "cy/mm"}},
  });
}

TEST(StudyErrors, OfAxesTogether) {
  expect_errors({
      {kHead + kAxis + kAxis + kMetrics, {"7:13: error: axis[1].parameter:", "axis 1 (pitch) already"}},
      {kHead + kAxis + "[[axis]]\nparameter = \"frame.pitch_x\"\nvalues = [\"5 um\"]\n" + kMetrics,
       {"error: axis[1].parameter: overlaps", "axis 1 (pitch)"}},
      {kHead + "[[axis]]\nname = \"a\"\nvalues = [1.0]\n[[axis]]\nname = \"a\"\nvalues = [2.0]\n" + kMetrics,
       {"7:8: error: axis[1].name: a", "another axis"}},
      {kHead + kAxis + "[sampling]\nmethod = \"sobl\"\npoints = 3\n" + kMetrics, {"did you mean \"sobol\"?"}},
      {kHead + kAxis + "[sampling]\nmethod = \"sobol\"\n" + kMetrics, {"error: sampling.points: missing"}},
      {kHead + kAxis + "[sampling]\nmethod = \"sobol\"\npoints = 0\n" + kMetrics,
       {"8:10: error: sampling.points: 0", "[1, 1000000000]"}},
      {kHead + kAxis + "[sampling]\nmethod = \"latin_hypercube\"\npoints = 1000000000000\n" + kMetrics,
       {"1000000000000", "whole number"}},
      {kHead + kAxis + "[sampling]\npoints = 5\n" + kMetrics, {"points of its axes"}},
  });
}

std::string grid(const std::vector<std::string>& counts) {
  std::string text = kHead;
  for (std::size_t i = 0; i < counts.size(); ++i)
    text += "[[axis]]\nname = \"a" + std::to_string(i) + "\"\nfrom = 0.0\nto = 1.0\ncount = " + counts[i] + "\n";
  return text + kMetrics;
}

TEST(StudyErrors, TooManyDesignsAreRefusedWithTheirCount) {
  const Folder folder;
  const std::string million = "1000000";
  EXPECT_TRUE(folder.parse(grid({million, "1000"})).ok());
  EXPECT_EQ(folder.parse(grid({million, "1000"})).study.designs, 1'000'000'000);
  const std::string more = folder.lines(grid({million, million}));
  expect_says(more, {"1000000000000 designs", "latin_hypercube"});
  const std::string huge = folder.lines(grid(std::vector<std::string>(50, million)));
  expect_says(huge, {" 1" + std::string(300, '0') + " designs"});
  const std::string one = folder.lines(grid({"9223372036854775807", "9223372036854775807"}));
  expect_says(one, {"85070591730234615847396907784232501249 designs"});  // (2^63 - 1)^2
}

TEST(StudyErrors, TooManyVariantsAreRefusedWithTheirCount) {
  const Folder folder;
  std::string bits = "[1";
  for (int i = 2; i <= 32; ++i) bits += ", " + std::to_string(i);
  std::string seeds = "[0";
  for (int i = 1; i < 400; ++i) seeds += ", " + std::to_string(i);
  folder.write("camera.toml", std::string(study_test::kCamera) + "[noise]\nseed = 1\n");
  const std::string text = kHead + "[[axis]]\nparameter = \"bits\"\nvalues = " + bits +
                           "]\n[[axis]]\nparameter = \"noise.seed\"\nvalues = " + seeds + "]\n" + kMetrics;
  const std::string lines = folder.lines(text);
  expect_says(lines, {"12800 sensors", "10000"});
}

TEST(StudyErrors, OfLinks) {
  const std::string number = "[[axis]]\nname = \"n\"\nvalues = [1.0]\n";
  const auto links = [&](const std::string& body) { return kHead + kAxis + number + kMetrics + "[links]\n" + body; };
  expect_errors({
      {links("focal_length = \"n * 1 m\"\n"), {}, 0},
      {links("focal_lenght = \"n * 1 m\"\n"), {"12:1: error: links.focal_lenght:", "no parameter"}},
      {links("focal_length = 3\n"), {"12:16: error: links.focal_length: 3", "quotes"}},
      {links("focal_length = \"n * m\"\n"), {"12:21: error: links.focal_length: 'm'", "no parameter"}},
      {links("focal_length = \"n * 1 s\"\n"), {"12:17: error: links.focal_length:", "focal_length is m", "is s"}},
      {links("focal_length = \"(n + 1 m)\"\n"), {"12:18: error: links.focal_length: cannot add"}},
      {links("pitch = \"n * 1 um\"\n"), {"12:1: error: links.pitch:", "axis"}},
      {links("frame.pitch_x = \"n * 1 um\"\n"), {"error: links.frame.pitch_x:", "axis"}},
      {links("focal_length = \"n * 1 m\"\nframe.focal_length = \"2 m\"\n"), {"is linked twice (focal_length)"}},
      {links("bits = \"n\"\n"), {"bits:", "whole number"}},
      {links("focal_length = \"mtf_nyquist * 1 m\"\n"),
       {"12:17: error: links.focal_length: mtf_nyquist", "from the design"}},
      {links("focal_length = \"focal_length * 2\"\n"), {"12:1: error: links.focal_length:", "from itself; name"}},
      {links("focal_length = \"8 * aperture\"\naperture = \"0.1 * slow.rms_x * obscuration\"\nobscuration = "
             "\"focal_length / (1 m)\"\n"),
       {"error: links.focal_length:", "from itself:", "focal_length -> aperture ->",
        "aperture -> obscuration -> focal_length"}},
      {links("focal_length = \"pitch_x * 1000\"\n"), {"'pitch_x'", "part of pitch"}},
  });
}

TEST(StudyErrors, OfVariationAsBuilt) {
  const auto built = [&](const std::string& body) {
    return kHead + "constraints = [\"mtf_nyquist > 0.1\"]\n" + kAxis + "[[as_built]]\n" + body;
  };
  expect_errors({
      {built("parameter = \"obscuration\"\nsd = 0.01\n"), {}, 0},
      {built("sd = 0.01\n"), {"error: as_built[0].parameter: missing"}},
      {built("parameter = \"obscuration\"\n"), {"error: as_built[0].sd: missing"}},
      {built("parameter = \"obscuration\"\nsd = 0.01\nplus_minus = 0.1\n"), {"plus_minus:", "with sd"}},
      {built("parameter = \"obscuration\"\nsd = 0.0\n"), {"9:6: error: as_built[0].sd: 0.0", "above 0"}},
      {built("parameter = \"obscuration\"\nsd = \"1 um\"\n"), {"plain number"}},
      {built("parameter = \"focal_length\"\nsd = 3\n"), {"3 has no unit"}},
      {built("parameter = \"bits\"\nsd = 3\n"), {"as_built[0].parameter:", "whole number"}},
      {built("parameter = \"obscuration\"\nsd = 0.01\n[[as_built]]\nparameter = \"optics.obscuration\"\nsd = 0.1\n"),
       {"11:13: error: as_built[1].parameter: varies in another"}},
      {built("parameter = \"obscuration\"\nsd = 0.01\n[yield]\ndraws = 0\n"), {"error: yield.draws: 0 is outside"}},
      {kHead + kAxis + kMetrics + "[[as_built]]\nparameter = \"pitch\"\nsd = \"2 %\"\n",
       {"warning: as_built: without constraints"}},
      {kHead + kAxis + kMetrics + "[yield]\ndraws = 5\n", {"warning: yield: nothing varies"}},
  });
}

TEST(StudyErrors, OfGoals) {
  const auto goals = [&](const std::string& body) { return kHead + body + "\n" + kAxis + kMetrics; };
  expect_errors({
      {goals("constraints = [\"mtf_nyquist > 0.1\", \"pitch <= 10 um\"]"), {}, 0},
      {goals("constraints = \"mtf_nyquist > 0.1\""), {"3:15: error: constraints:", "a list"}},
      {goals("constraints = [\"mtf_nyquist\"]"), {"error: constraints[0]:", "compare two expressions"}},
      {goals("constraints = [\"0.1 < mtf_nyquist < 0.5\"]"), {"error: constraints[0]:", "compare two expressions"}},
      {goals("constraints = [\"mtf_nyquist == 0.1\"]"), {"error: constraints[0]:", "compare two expressions"}},
      {goals("constraints = [\"mtf_nyqist > 0.1\"]"),
       {"3:17: error: constraints[0]: 'mtf_nyqist':", "did you mean mtf_nyquist?"}},
      {goals("objectives = [\"minimize mtf_nyquist_z\"]"), {"did you mean mtf_nyquist_x?"}},
      {goals("objectives = [\"minimize 2 * nidt\"]"), {"3:29: error: objectives[0]: 'nidt':", "did you mean netd?"}},
      {goals("objectives = [\"minimize mtf_at_35_cymm\"]"), {"did you mean mtf_at_20_cy_mm?"}},
      {goals("objectives = [\"minimize pich\"]"), {"did you mean pitch?"}},
      {goals("objectives = [\"minimize jiter.rms\"]"), {"did you mean jitter.rms?"}},
      {goals("objectives = [\"minimize bandwidth_of_everything\"]"), {"mtf config explain shows the parameters"}},
      {goals("constraints = [\"mtf_nyquist > \"]"), {"3:31: error: constraints[0]: empty"}},
      {goals("constraints = [\"mtf_nyquist > 1 um\"]"), {"3:17: error: constraints[0]:", "number with m"}},
      {goals("constraints = [\"2 > 1\"]"), {"no name in it"}},
      {goals("constraints = [\"ifov < 150\"]"),
       {"3:17: error: constraints[0]:", "ifov", "150, which has no unit", "such as 5 urad"}},
      {goals("constraints = [\"5 < fov_x\"]"),
       {"3:17: error: constraints[0]:", "5, which has no unit", "such as 5 deg"}},
      {goals("constraints = [\"ifov < 150 urad\", \"q > 0.5\", \"ifov > 0\"]"), {}, 0},
      {goals("constraints = [\"mtf_nyquist < 1/0\"]"), {"3:31: error: constraints[0]: '1/0'", "finite"}},
      {goals("constraints = [\"pitch * sqrt(-1) > 1 um\"]"), {"3:25: error: constraints[0]: 'sqrt(-1)' is no finite"}},
      {goals("objectives = [\"maximize mtf_nyquist + (1e300 m) / (1e-300 m)\"]"),
       {"error: objectives[0]:", "'(1e300 m) / (1e-300", "finite"}},
      {goals("constraints = [\"bits > 1\"]"), {"3:17: error: constraints[0]: 'bits'", "whole number"}},
      {goals("constraints = [\"sensor > 1\"]"), {"3:17: error: constraints[0]: 'sensor'", "no number"}},
      {goals("objectives = [\"mtf_nyquist\"]"), {"3:16: error: objectives[0]:", "maximize nor minimize"}},
      {goals("objectives = [\"maximize \"]"), {"error: objectives[0]: empty"}},
      {goals("objectives = [\"maximize mtf_nyquist + pitch\"]"), {"3:25: error: objectives[0]: cannot add"}},
      {goals("objectives = [\"minimize 3\"]"), {"no name in it"}},
      {goals("objectives = [\"minimize pitch\", \"maximize pitch\"]"), {"is an objective already"}},
      {goals("constraints = ['\xC2\xB5 > 1', \"\\\"x\\\" + pich > 2\"]"),
       {"3:17: error: constraints[0]: expected a number", "3:26: error: constraints[1]: expected a number"},
       2},
      {goals("constraints = [\"\\u0031 + pich > 2\"]"), {"3:26: error: constraints[0]: 'pich'"}},
      {goals("constraints = [\"\"\"\n1 + pich > 2\"\"\"]"), {"3:16: error: constraints[0]: 'pich'"}},
      {kHead + kAxis + "[metrics]\nlist = [\"mtf_nyqist\", 3]\n",
       {"7:9: error: metrics.list:", "\"mtf_nyqist\"", "\"mtf_nyquist\"", "7:23: error: metrics.list: 3 has to be"},
       2},
      {kHead + kAxis + "[metrics]\nlist = [\"sharpness\"]\n", {"\"sharpness\"", "cutoff, nyquist,"}},
      {kHead + kAxis + "[metrics]\nlist = [\"mtf_nyquist\", \"mtf_nyquist\"]\n",
       {"warning: metrics.list: mtf_nyquist is listed twice"}},
      {kHead + kAxis + kMetrics + "[conditions]\nrange = 5\ncontrst = \"2 K\"\n",
       {"9:9: error: conditions.range: 5 has no unit", "10:1: error: conditions.contrst: unknown key"},
       2},
  });
}

TEST(StudyErrors, AllInOnePass) {
  const Folder folder;
  const std::string lines = folder.lines(kHead + "tolerance = 5.0\nconstraints = [\"mtf_nyquist > 0.1 um\"]\n" + kAxis +
                                         "[links]\nfocal_length = \"2 *\"\n[metrics]\nlist = [\"nird\"]\n");
  for (const std::string place : {"3:13", "4:17", "9:20", "11:9"})
    expect_says(lines, {"study.toml:" + place + ": error: "});
}

TEST(StudyErrors, LoadThrowsThemAll) {
  const Folder folder;
  folder.write("study.toml", kHead + "tolerance = 5.0\nseed = 1.5\n" + kAxis + kMetrics);
  try {
    study::load_study(folder / "study.toml");
    FAIL();
  } catch (const mtf::UsageError& error) {
    EXPECT_TRUE(says(error.what(), "study.toml:3:13: error: ")) << error.what();
    EXPECT_TRUE(says(error.what(), "study.toml:4:8: error: ")) << error.what();
  }
  EXPECT_THROW(study::load_study(folder / "none.toml"), mtf::RuntimeError);
}

TEST(StudyErrors, DamagedFilesGiveErrorsNotCrashes) {
  const Folder folder;
  const std::string good =
      kHead + "constraints = [\"mtf_nyquist > 0.1\"]\nobjectives = [\"minimize aperture^2.5\"]\n" + kAxis +
      "[[axis]]\nname = \"n\"\nfrom = 1.0\nto = 2.0\ncount = 3\n[links]\nfocal_length = \"n * aperture\"\n"
      "[[as_built]]\nparameter = \"jitter.rms\"\nsd = \"2 %\"\n" +
      kMetrics;
  ASSERT_TRUE(folder.parse(good).ok()) << folder.lines(good);
  std::mt19937 random(5);
  int still_good = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 2; ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text.erase(at, 1 + random() % 8);
          break;
        case 1:
          text.insert(at, 1, "=[]\"{}.,#\n0-eu"[random() % 14]);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 30));
      }
    }
    still_good += folder.parse(text).ok();
  }
  EXPECT_GT(still_good, 10);  // not all of them end at the first syntax error
}

TEST(StudyErrors, HugeFilesTakeTimeInProportion) {
  const Folder folder;
  const auto repeated = [](const std::string& text, std::size_t bytes) {
    std::string all;
    for (int i = 0; all.size() < bytes; ++i) {
      std::string copy = text;
      for (std::size_t at = 0; (at = copy.find('#', at)) != std::string::npos;) copy.replace(at, 1, std::to_string(i));
      all += copy;
    }
    return all;
  };
  const std::string axis = kHead + kAxis + kMetrics;
  const auto texts = [&](std::size_t part) {
    const std::size_t size = 900'000 / part;
    return std::vector<std::string>{
        kHead + "constraints = [\"" + repeated("x# + ", size) + "1 > 2\"]\n" + kAxis,
        kHead + "constraints = [" + repeated("\"x# > 2\", ", 12'000 / part) + "]\n" + kAxis,
        axis + "[links]\n" + repeated("a# = \"1 1 1 1 1 1 1 1 1 1 1 1 a#\"\n", size),
        axis + "[links]\n" + repeated("a# = \"1 1 1 1 1 1 1 1 1 1 1 1 b#\"\n", 35'000 / part),
        kHead + kAxis + "[metrics]\nlist = [" + repeated("\"metric_#\", ", size) + "]\n",
        kHead + kMetrics + "[[axis]]\nparameter = \"bits\"\nvalues = [" + repeated("1#, ", size) + "]\n",
        kHead + kMetrics + "[[axis]]\nparameter = \"sensor\"\nvalues = [" + repeated("\"camera.toml\", ", size) + "]\n",
        axis + repeated("[[as_built]]\nparameter = \"x#\"\nsd = 1.0\n", size),
        kHead + kMetrics + repeated("[[axis]]\nname = \"x#\"\nvalues = [1.0]\n", size)};
  };
  const auto processor_s = [&](const std::string& text) {
    const std::clock_t start = std::clock();
    EXPECT_FALSE(folder.parse(text).ok()) << text.substr(0, 200);
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  const std::vector<std::string> whole = texts(1), quarter = texts(4);
  // Four times the text takes four times as long, or a little more; a quadratic reader takes sixteen times as long.
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_LT(processor_s(whole[i]), 0.5 + 8.0 * processor_s(quarter[i])) << whole[i].substr(0, 200);
}

TEST(StudyErrors, ProductsAreExact) {
  const std::vector<std::int64_t> primes{999'999'937, 999'999'929, 3, 9'223'372'036'854'775'783};
  // By Python's integers.
  EXPECT_EQ(study::exact_product(primes), "27670112402768892301809497788236232077");
  EXPECT_EQ(study::bounded_product(primes, 1'000'000'000), 1'000'000'001);
  EXPECT_EQ(study::bounded_product(std::vector<std::int64_t>{1000, 1000}, 1'000'000), 1'000'000);
  EXPECT_EQ(study::exact_product({}), "1");
}

}  // namespace
