// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "mtf/units.h"
#include "radiometry/performance/sensitivity.h"
#include "radiometry/stages/detector/adc.h"
#include "radiometry/stages/detector/blooming.h"
#include "radiometry/stages/detector/lag.h"
#include "radiometry/stages/detector/microscan.h"
#include "radiometry/stages/detector/nonlinearity.h"
#include "radiometry/stages/detector/shutter.h"
#include "radiometry/stages/noise/blinking.h"
#include "radiometry/stages/noise/fixed_pattern.h"
#include "radiometry/stages/noise/flicker.h"
#include "radiometry/stages/noise/noise_3d.h"
#include "radiometry/stages/optics/distortion.h"
#include "radiometry/stages/optics/focal_plane.h"
#include "radiometry/stages/optics/narcissus.h"
#include "radiometry/stages/optics/veiling_glare.h"
#include "radiometry/stages/optics/vignetting.h"
#include "radiometry/stages/processing/agc.h"
#include "radiometry/stages/processing/measure_correction.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

template <class T>
class Fields : public testing::Test {};

using Types = testing::Types<Adc, AutomaticGain, Blinking, Blooming, Camera<double>, CorrectionSettings, Defects,
                             Distortion, Flicker, Ghost, Lag, Microscan, Narcissus, Noise3d, NoiseTerms<double>,
                             Nonlinearity, OpticalAxis, Pixel<double>, ResetNoise, Shutter, VeilingGlare, Vignetting>;
TYPED_TEST_SUITE(Fields, Types);

TYPED_TEST(Fields, rows_are_whole_and_defaults_in_their_bounds) {
  TypeParam object;
  std::set<std::string_view> names;
  for_each_field(object, [&](const FieldInfo& info, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    EXPECT_FALSE(info.doc.empty()) << info.name;
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    if (info.presence == mtf::Presence::required) {
      EXPECT_FALSE(info.example.empty()) << info.name;
    }
    if (info.dimension != mtf::Dimension::none) {
      const mtf::Unit* unit = mtf::find_unit(info.unit);
      ASSERT_NE(unit, nullptr) << info.name;
      EXPECT_EQ(unit->dimension, info.dimension) << info.name;
      EXPECT_EQ(unit->factor, 1.0) << info.name;
      // An example is a string with a unit of that dimension.
      if (!info.example.empty()) {
        ASSERT_EQ(info.example.front(), '"') << info.name;
        const auto quantity = mtf::parse_quantity(info.example.substr(1, info.example.size() - 2), info.dimension);
        EXPECT_EQ(quantity.unit->dimension, info.dimension) << info.name;
      }
    }
    if constexpr (std::is_enum_v<Value>) {
      const auto all = words(value);
      EXPECT_LT(static_cast<std::size_t>(value), all.size()) << info.name;
      const std::string_view example = info.example.substr(1, info.example.size() - 2);
      EXPECT_NE(std::find(all.begin(), all.end(), example), all.end()) << info.name;
    } else if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      EXPECT_TRUE(info.lo < info.hi) << info.name;
      if (info.presence == mtf::Presence::optional) {
        EXPECT_GE(static_cast<double>(value), info.lo) << info.name;
        EXPECT_LE(static_cast<double>(value), info.hi) << info.name;
      }
    }
  });
  EXPECT_FALSE(names.empty());
}

TEST(Words, stand_in_the_order_of_the_values) {
  EXPECT_EQ(words(Rounding{})[static_cast<int>(Rounding::down)], "down");
  EXPECT_EQ(words(GainMethod{})[static_cast<int>(GainMethod::plateau)], "plateau");
  EXPECT_EQ(words(Polarity{})[static_cast<int>(Polarity::black_hot)], "black_hot");
  EXPECT_EQ(words(NarcissusProfile{})[static_cast<int>(NarcissusProfile::flat_top)], "flat_top");
  EXPECT_EQ(words(ReadoutOrder{})[static_cast<int>(ReadoutOrder::columns)], "columns");
  EXPECT_EQ(words(BloomingDirection{})[static_cast<int>(BloomingDirection::both)], "both");
  EXPECT_EQ(words(ShutterKind{})[static_cast<int>(ShutterKind::rolling)], "rolling");
  EXPECT_EQ(words(MicroscanPattern{})[static_cast<int>(MicroscanPattern::diagonal)], "diagonal");
}

TEST(ResetNoise, is_ktc) {
  // k T C = 1.380649e-23 x 300 x 1e-13 = 4.141947e-34 C^2, its root 2.0351774e-17 C, 127.0257 electrons.
  const ResetNoise reset{.capacitance_f = 1e-13, .temperature_k = 300.0};
  EXPECT_NEAR(reset.rms_e(), 127.0257, 1e-3);
  EXPECT_EQ((ResetNoise{.capacitance_f = 1e-13, .temperature_k = 0.0}.rms_e()), 0.0);
  test::expect_refused({"reset.temperature = -1 K"}, [] { require_valid("reset", ResetNoise{1e-13, -1.0}); });
}

}  // namespace
}  // namespace radiometry
