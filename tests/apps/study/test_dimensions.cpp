// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "apps/study/design/metric_list.h"
#include "apps/study/dimensions.h"
#include "mtf/error.h"

namespace study {
namespace {

TEST(Dimensions, UnitsHaveTheirScaleAndPowers) {
  struct Case {
    const char* unit;
    double si;
    const char* dimensions;
  };
  // Factors of the SI; angles in rad, charges in electrons.
  for (const Case& c : {Case{"", 1.0, ""},
                        Case{"um", 1e-6, "m"},
                        Case{"nm", 1e-9, "m"},
                        Case{"km", 1e3, "m"},
                        Case{"in", 0.0254, "m"},
                        Case{"mrad", 1e-3, ""},
                        Case{"deg", 0.017453292519943295, ""},
                        Case{"px", 1.0, ""},
                        Case{"cy/mm", 1e3, "m^-1"},
                        Case{"cy/mrad", 1e3, ""},
                        Case{"cy/px", 1.0, ""},
                        Case{"kHz", 1e3, "s^-1"},
                        Case{"ms", 1e-3, "s"},
                        Case{"mm/s", 1e-3, "m s^-1"},
                        Case{"urad/s", 1e-6, "s^-1"},
                        Case{"mK", 1e-3, "K"},
                        Case{"ke-", 1e3, "e-"},
                        Case{"e-/s", 1.0, "s^-1 e-"},
                        Case{"cd/m^2", 1.0, "m^-2 cd"},
                        Case{"%", 0.01, ""},
                        Case{"W", 1.0, "m^2 s^-3 kg"},
                        Case{"W/m^2", 1.0, "s^-3 kg"},
                        Case{"m s^-1", 1.0, "m s^-1"},
                        Case{"W Hz^-1", 1.0, "m^2 s^-2 kg"}}) {
    const UnitScale scale = unit_scale(c.unit);
    EXPECT_NEAR(scale.si, c.si, 4e-16 * c.si) << c.unit;
    EXPECT_EQ(si_unit(scale.dimensions), c.dimensions) << c.unit;
    EXPECT_EQ(unit_scale(si_unit(scale.dimensions)).dimensions, scale.dimensions) << c.unit;
  }
}

TEST(Dimensions, CapacitanceTimesVoltageIsCharge) {
  // 1 F x 1 V = 1 C = 1 / 1.602176634e-19 electrons, and 1 V = 1 J / C.
  const UnitScale farad = unit_scale("F"), joule = unit_scale("J"), electron = unit_scale("e-");
  const auto volt = product(joule.dimensions, electron.dimensions, -1);
  ASSERT_TRUE(volt);
  EXPECT_EQ(product(farad.dimensions, *volt), electron.dimensions);
  EXPECT_NEAR(farad.si * 1.602176634e-19 * 1.602176634e-19, 1.0, 1e-15);
}

TEST(Dimensions, PowersThatAreNotWholeAddUp) {
  const Dimensions metre{.metre = 1};
  const auto third = power(metre, 1.0 / 3.0), cost = power(metre, 2.7);
  ASSERT_TRUE(third && cost);
  EXPECT_EQ(power(*third, 3.0), metre);
  EXPECT_EQ(si_unit(*cost), "m^2.7");
  EXPECT_EQ(unit_scale("m^2.7").dimensions, *cost);
  Dimensions sum;
  for (int i = 0; i < 10; ++i) sum = *product(sum, *power(metre, 0.1));
  EXPECT_EQ(sum, metre);
  EXPECT_FALSE(power(metre, std::exp(1.0)));
  EXPECT_FALSE(power(metre, 101.0));
  EXPECT_FALSE(power(metre, std::nan("")));
  EXPECT_EQ(power(Dimensions{}, std::nan("")), Dimensions{});
}

TEST(Dimensions, UnknownUnitsAreRefused) {
  for (const char* unit : {"metre", "um/", "/s", "um^x", "um^0.123456789", "m^1000", "\xff", "m^^2"})
    EXPECT_THROW(unit_scale(unit), mtf::UsageError) << unit;
}

TEST(Dimensions, TheLongestUnitIsTaken) {
  EXPECT_EQ(unit_length("m/s"), 3u);
  EXPECT_EQ(unit_length("m/speed"), 1u);
  EXPECT_EQ(unit_length("mm / pitch"), 2u);
  EXPECT_EQ(unit_length("e- + 3"), 2u);
  EXPECT_EQ(unit_length("% of"), 1u);
  EXPECT_EQ(unit_length("um_x"), 0u);
  EXPECT_EQ(unit_length(""), 0u);
}

TEST(Dimensions, EveryMetricHasAUnitThatExpressionsKnow) {
  ASSERT_FALSE(metric_catalogue().empty());
  for (const MetricInfo& metric : metric_catalogue()) EXPECT_NO_THROW(unit_scale(metric.unit)) << metric.name;
}

}  // namespace
}  // namespace study
