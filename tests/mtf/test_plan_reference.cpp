// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/plan/plan.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/reference.h"

namespace mtf::test {
namespace {

struct Case {
  std::int64_t width, height;
  double ratio_x, ratio_y;
  Border border;
  int system;
};

System<double> system_of(int index) {
  System<double> s;
  s.frame = {100.0, 15.0, 12.0, 0.01, 0, 0};
  s.optics.f_number = 2.0;
  s.optics.wavelength_um = 4.0;
  s.add(Stage::presample, Component<double>::make("diffraction"));
  if (index == 1) s.add(Stage::presample, rc(40.0, 0));
  if (index == 2) s.add(Stage::presample, motion(20.0, 30.0));
  if (index == 3) s.add(Stage::presample, rc(30.0, 1)), s.add(Stage::presample, footprint(12.0));
  if (index == 4) s.add(Stage::presample, footprint(15.0)), s.add(Stage::presample, jitter(2.0));
  if (index == 5)
    s.add(Stage::presample, rc(30.0, 1)), s.add(Stage::presample, rc(60.0, 0)),
        s.add(Stage::presample, motion(9.0, 45.0));
  return s;
}

class PlanReference : public testing::TestWithParam<Case> {};

TEST_P(PlanReference, realised_error_is_below_the_promise) {
  const Case c = GetParam();
  const System<double> system = system_of(c.system);
  const SampleGrid in{c.width, c.height, 15.0 / c.ratio_x, 12.0 / c.ratio_y};
  const SampleGrid out = detector_grid(system, in);
  const Image scene = random_image(c.width, c.height, 7, 10.0, 3.0);
  const double border_value = 8.5;
  PlanOptions options;
  options.border = c.border;
  options.tolerance = 1e-4;
  options.scene = summarise(scene.view(), c.border, border_value);
  const Plan plan = compile(system, in, out, options);
  Image image(out.width, out.height);
  plan.run(scene.view(), image.view(), border_value, 1);
  const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), c.border, border_value);
  double squares = 0.0;
  for (std::int64_t i = 0; i < image.size(); ++i)
    squares += std::pow(image.data()[i] - expected[static_cast<std::size_t>(i)], 2);
  const double std = options.scene ? options.scene->std : 1.0;
  const double rms = std::sqrt(squares / static_cast<double>(image.size())) / std;
  EXPECT_LE(rms, plan.report().predicted.total()) << plan.explain();
  EXPECT_LE(plan.report().predicted.total(), options.tolerance);
  RecordProperty("rms", std::to_string(rms));
}

std::vector<Case> cases() {
  std::vector<Case> list;
  for (const Border border : {Border::reflect, Border::replicate, Border::constant, Border::periodic})
    for (int system = 0; system < 6; ++system) {
      list.push_back({24, 16, 1.0, 1.0, border, system});
      list.push_back({24, 20, 2.0, 4.0, border, system});
      list.push_back({37, 31, 3.7, M_PI, border, system});
      list.push_back({17, 23, 3.7, 2.5, border, system});
      list.push_back({1, 29, 1.0, 2.0, border, system});
      list.push_back({13, 1, 1.3, 0.9, border, system});
      list.push_back({44, 40, 2.0, 2.0, border, system});
    }
  return list;
}
INSTANTIATE_TEST_SUITE_P(sizes_ratios_borders, PlanReference, testing::ValuesIn(cases()));

}  // namespace
}  // namespace mtf::test
