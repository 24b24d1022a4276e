// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <set>

#include "mtf/units.h"
#include "radiometry/chain/sensor_settings.h"
#include "radiometry/performance/sensitivity.h"
#include "tests/expect_error.h"

namespace radiometry {
namespace {

template <class T>
void expect_whole_rows(std::string_view type) {
  SCOPED_TRACE(std::string(type));
  T object;
  std::set<std::string_view> names;
  for_each_field(object, [&](const FieldInfo& info, const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    EXPECT_FALSE(info.doc.empty()) << info.name;
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    // The constants of a camera that wrote counts stand in its files.
    if (info.presence == mtf::Presence::required && !std::is_same_v<T, CountCamera>) {
      EXPECT_FALSE(info.example.empty()) << info.name;
    }
    if (info.dimension != mtf::Dimension::none) {
      const mtf::Unit* unit = mtf::find_unit(info.unit);
      ASSERT_NE(unit, nullptr) << info.name;
      const bool difference = info.dimension == mtf::Dimension::temperature_difference;  // in the same units
      const mtf::Dimension dimension = difference ? mtf::Dimension::temperature : info.dimension;
      EXPECT_EQ(unit->dimension, dimension) << info.name;
      // The air has metres and degrees where the optics have um and urad.
      if (dimension != mtf::Dimension::length && dimension != mtf::Dimension::angle) {
        EXPECT_EQ(unit->factor, 1.0) << info.name;
      }
      // An example is a string with a unit of that dimension.
      if (!info.example.empty()) {
        ASSERT_EQ(info.example.front(), '"') << info.name;
        const auto quantity = mtf::parse_quantity(info.example.substr(1, info.example.size() - 2), info.dimension);
        EXPECT_EQ(quantity.unit->dimension, dimension) << info.name;
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

TEST(Fields, rows_are_whole_and_defaults_in_their_bounds) {
  for_each_table([]<class T>(const SensorTable<T>& table) { expect_whole_rows<T>(table.name); });
  expect_whole_rows<ThermalSettings>("thermal detector");
  expect_whole_rows<Adc>("Adc");
  expect_whole_rows<Camera<double>>("Camera");
  expect_whole_rows<NoiseTerms<double>>("NoiseTerms");
  expect_whole_rows<Pixel<double>>("Pixel");
  expect_whole_rows<ResetNoise>("ResetNoise");
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
  expect_refused({"reset.temperature = -1 K"}, [] { require_valid("reset", ResetNoise{1e-13, -1.0}); });
}

}  // namespace
}  // namespace radiometry
