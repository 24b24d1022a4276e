// SPDX-License-Identifier: Apache-2.0
// The MTF of the optics and of the detector alone.
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/math/special.h"
#include "mtf/metrics/resolution.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

// exp(-2 pi^2 s^2 f^2) at Nyquist, s in pixels and f = 1/2: in the MTF of the part of which the user says it is.
TEST(Resolution, BlurCountsToThePartThatTheUserSays) {
  const double s = 0.2, blur = std::exp(-0.5 * kPi * kPi * s * s);
  struct {
    SensorPart part;
    double optics, detector;
  } const rows[] = {{SensorPart::unspecified, 1.0, 1.0},
                    {SensorPart::optics, blur, 1.0},
                    {SensorPart::detector, 1.0, blur},
                    {SensorPart::motion, 1.0, 1.0}};
  for (const auto& row : rows) {
    auto component = gaussian(10.0 * s);
    choose(component, "part", static_cast<int>(row.part));
    EXPECT_EQ(component.part(), row.part);
    System<double> system;
    system.frame = {100.0, 10.0, 10.0, 0.0, 0, 0};
    system.add(Stage::presample, component);
    const AxisFigures<double> x = ResolutionMeter<double>(ResolutionNeeds{}).measure(system).x;
    EXPECT_NEAR(x.optics_nyquist, row.optics, 1e-15);
    EXPECT_NEAR(x.detector_nyquist, row.detector, 1e-15);
    EXPECT_NEAR(x.presample_nyquist, blur, 1e-15);
  }
}

}  // namespace
}  // namespace mtf::test
