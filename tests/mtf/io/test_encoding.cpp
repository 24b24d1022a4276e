// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/encoding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "io_test_files.h"
#include "tests/expect_error.h"

namespace mtf::io {
namespace {

TEST(Encoding, SrgbIsThatOfIec61966) {
  const Encoding srgb = parse_encoding("srgb");
  // 8-bit codes; linear values from the standard's formula in high precision.
  const std::pair<double, double> known[] = {{0, 0.0},
                                             {1, 0.00030352698354883752},
                                             {10, 0.0030352698354883752},
                                             {11, 0.0033465357638991595},
                                             {128, 0.21586050011389926},
                                             {188, 0.50288645803257085},
                                             {255, 1.0}};
  for (const auto& [code, linear] : known)
    EXPECT_NEAR(decode(srgb, code, 255.0), 255.0 * linear, 255.0 * 1e-14) << code;
  EXPECT_NEAR(decode(srgb, 188.0 * 257.0, 65535.0), 65535.0 * 0.50288645803257085, 1e-9);
  EXPECT_NEAR(decode(srgb, 0.04045, 1.0), 0.04045 / 12.92, 1e-15);
}

TEST(Encoding, GammaKeepsEndsAndSigns) {
  const Encoding gamma = parse_encoding("gamma:2.2");
  EXPECT_DOUBLE_EQ(decode(gamma, 65535.0, 65535.0), 65535.0);
  EXPECT_DOUBLE_EQ(decode(gamma, 0.25, 1.0), std::pow(0.25, 2.2));
  EXPECT_DOUBLE_EQ(decode(gamma, -0.25, 1.0), -std::pow(0.25, 2.2));
  EXPECT_EQ(decode(gamma, 0.0, 1.0), 0.0);
  EXPECT_DOUBLE_EQ(decode(parse_encoding("gamma:1"), 77.0, 255.0), 77.0);
  EXPECT_DOUBLE_EQ(decode(parse_encoding("gamma"), 0.25, 1.0), std::pow(0.25, 2.2));
}

TEST(Encoding, TablesAreInterpolated) {
  const Encoding table = parse_oecf("# camera 3\nstored;linear\n0;0\n100;10\n200;10\n300;50\n", "t.csv");
  EXPECT_DOUBLE_EQ(decode(table, 50.0, 255.0), 5.0);
  EXPECT_DOUBLE_EQ(decode(table, 150.0, 255.0), 10.0);
  EXPECT_DOUBLE_EQ(decode(table, 250.0, 255.0), 30.0);
  EXPECT_DOUBLE_EQ(decode(table, 300.0, 255.0), 50.0);
  EXPECT_TRUE(std::isnan(decode(table, 300.5, 255.0)));
  EXPECT_TRUE(std::isnan(decode(table, -1.0, 255.0)));
  EXPECT_TRUE(std::isnan(decode(table, std::numeric_limits<double>::quiet_NaN(), 255.0)));
  const Encoding falling = parse_oecf("0,8\n10,0", "t.csv");
  EXPECT_DOUBLE_EQ(decode(falling, 2.5, 255.0), 6.0);
}

TEST(Encoding, ImagesAreDecodedInPlace) {
  Image image(3, 2);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float stored[] = {0.0F, 128.0F, 255.0F, 400.0F, nan, 5.0F};
  std::copy(std::begin(stored), std::end(stored), image.data());
  const Image same = image.clone();
  EXPECT_EQ(decode(parse_encoding("linear"), image.view(), 255.0), 0);
  EXPECT_EQ(image.at(1, 0), 128.0F);
  EXPECT_EQ(decode(parse_oecf("0,0\n255,510", "t"), image.view(), 255.0), 1);
  EXPECT_EQ(image.at(1, 0), 256.0F);
  EXPECT_TRUE(std::isnan(image.at(0, 1)));
  EXPECT_TRUE(std::isnan(image.at(1, 1)));
  EXPECT_EQ(image.at(2, 1), 10.0F);
}

TEST(Encoding, QuantumIsTheSlopeOfTheCurve) {
  EXPECT_DOUBLE_EQ(quantum_at(parse_encoding("linear"), 100.0, 255.0), 1.0);
  EXPECT_DOUBLE_EQ(quantum_at(parse_encoding("linear"), 0.1, 1.0, 1.0 / 1024), 1.0 / 1024);
  const Encoding srgb = parse_encoding("srgb");
  const double level = decode(srgb, 128.0, 255.0);
  EXPECT_NEAR(quantum_at(srgb, level, 255.0), decode(srgb, 128.5, 255.0) - decode(srgb, 127.5, 255.0), 1e-12);
  EXPECT_NEAR(quantum_at(srgb, 0.0, 255.0), 1.0 / 12.92, 1e-12);
  const Encoding gamma = parse_encoding("gamma:2");
  EXPECT_NEAR(quantum_at(gamma, 255.0 * 0.25, 255.0), 1.0, 1e-12);  // slope 2 v at v = 0.5
  const Encoding table = parse_oecf("0,0\n100,10\n200,10\n300,50", "t");
  EXPECT_NEAR(quantum_at(table, 5.0, 255.0), 0.1, 1e-12);
  EXPECT_NEAR(quantum_at(table, 30.0, 255.0), 0.4, 1e-12);
  EXPECT_NEAR(quantum_at(table, 50.0, 255.0), 0.4, 1e-12);
  EXPECT_NEAR(quantum_at(table, 0.0, 255.0), 0.1, 1e-12);
  EXPECT_NEAR(quantum_at(table, 99.0, 255.0), 0.4, 1e-12);
  const Encoding falling = parse_oecf("0,8\n10,0", "t");
  EXPECT_NEAR(quantum_at(falling, 4.0, 255.0), 0.8, 1e-12);
}

TEST(Encoding, FullScaleComesFromTheFile) {
  const auto scale = [](const char* type, const char* storage) {
    FileInfo info;
    ChannelInfo channel;
    channel.type = type;
    info.channels.push_back(channel);
    info.storage = storage;
    return full_scale(info);
  };
  EXPECT_EQ(scale("uint8", "8-bit"), 255.0);
  EXPECT_EQ(scale("uint8", "4-bit"), 15.0);
  EXPECT_EQ(scale("uint8", "1-bit"), 1.0);
  EXPECT_EQ(scale("uint8", "4-bit palette"), 255.0);
  EXPECT_EQ(scale("uint16", "16-bit interlaced"), 65535.0);
  EXPECT_EQ(scale("uint", "scanline zip"), 4294967295.0);
  EXPECT_EQ(scale("half", "scanline zip"), 1.0);
  EXPECT_EQ(scale("float", "32-bit float"), 1.0);
  EXPECT_EQ(scale("double", ""), 1.0);
  EXPECT_EQ(full_scale({}), 1.0);
}

TEST(Encoding, RefusesWhatItDoesNotKnow) {
  expect_refused({"sRGB", "linear, srgb, gamma (2.2)"}, [] { static_cast<void>(parse_encoding("sRGB")); });
  expect_refused({"linear, srgb"}, [] { static_cast<void>(parse_encoding("")); });
  for (const char* wrong :
       {"gamma:", "gamma:x", "gamma:0", "gamma:-2", "gamma:nan", "gamma:inf", "gamma:2,2", "gamma:11"})
    expect_refused({wrong, "gamma:2.2"}, [&] { static_cast<void>(parse_encoding(wrong)); });
  expect_refused<RuntimeError>({"missing/oecf.csv"}, [] { static_cast<void>(parse_encoding("missing/oecf.csv")); });
  const io_test::TempFolder folder;
  expect_refused<RuntimeError>({"folder"}, [&] { static_cast<void>(parse_encoding(folder / "")); });
  io_test::write_bytes(folder / "empty.csv", "");
  expect_refused<RuntimeError>({"empty"}, [&] { static_cast<void>(parse_encoding(folder / "empty.csv")); });
  io_test::write_bytes(folder / "good.csv", "0,0\n255,1\n");
  EXPECT_EQ(parse_encoding(folder / "good.csv").stored.size(), 2U);
}

TEST(Encoding, TablesNameTheLineThatIsWrong) {
  const auto refused = [](const char* text, std::initializer_list<std::string_view> words) {
    expect_refused(words, [&] { static_cast<void>(parse_oecf(text, "t.csv")); });
  };
  refused("", {"t.csv", "two rows"});
  refused("stored,linear\n0,0\n", {"t.csv", "two rows"});
  refused("0,0\n1\n", {"t.csv:2", "1 columns"});
  refused("0,0\n1,2,3\n", {"t.csv:2", "3 columns"});
  refused("0,0\n1,x\n", {"t.csv:2", "\"x\""});
  refused("0,0\n1,nan\n", {"t.csv:2", "finite"});
  refused("a,b\nc,d\n", {"t.csv:2", "\"c\""});
  refused("0,0\n1,1\n1,2\n", {"t.csv:3", "increase"});
  refused("0,0\n1,1\n# note\n2,0.5\n", {"t.csv:4", "turn back"});
  refused("0,3\n1,3\n2,3\n", {"t.csv", "same"});
}

}  // namespace
}  // namespace mtf::io
