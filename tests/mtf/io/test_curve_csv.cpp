// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"
#include "tests/expect_error.h"

namespace mtf::io {
namespace {

const std::string kRows = "\n0,1\n10,0.5\n20,0.25\n";

TEST(CurveCsv, UnitsInTheHeader) {
  for (const std::string header :
       {"frequency_cy_mm,mtf", "frequency (cy/mm),MTF", "f_cy_mm,value", "\"freq [cycles/mm]\",m",
        "Spatial frequency (lp/mm),mtf", "frequency_cycles_per_mm , mtf"})
    EXPECT_EQ(parse_curve_csv(header + kRows, "c.csv").unit->name, "cy/mm") << header;
  for (const std::string header : {"frequency_cy_px,mtf", "f (cycles/pixel),mtf", "frequency [c/px],mtf"})
    EXPECT_EQ(parse_curve_csv(header + kRows, "c.csv").unit->name, "cy/px") << header;
  EXPECT_EQ(parse_curve_csv("frequency_cy_mrad,mtf" + kRows, "c.csv").unit->name, "cy/mrad");
}

TEST(CurveCsv, SeparatorsCommentsColumns) {
  const Curve plain = parse_curve_csv("frequency_cy_mm,mtf" + kRows, "c.csv");
  EXPECT_EQ(plain.frequency, (std::vector<double>{0, 10, 20}));
  EXPECT_EQ(plain.value, (std::vector<double>{1, 0.5, 0.25}));
  EXPECT_EQ(plain.source, "c.csv");
  for (const std::string text :
       {"\xEF\xBB\xBF# lens\r\nfrequency_cy_mm;mtf\r\n0;1\r\n\r\n10;0.5\r\n20;0.25",
        "# a\n\nfrequency_cy_mm\tmtf\n0\t1\n10\t5e-1\n20\t+.25\n", "mtf,frequency_cy_mm\n1,0\n0.5,10\n0.25,20\n",
        "field,mtf,frequency_cy_mm\nx,1,0\nx,0.5,10\nx,0.25,20\n"}) {
    const Curve curve = parse_curve_csv(text, "c.csv");
    EXPECT_EQ(curve.frequency, plain.frequency) << text;
    EXPECT_EQ(curve.value, plain.value) << text;
  }
}

void expect_error(const std::string& text, std::initializer_list<std::string_view> parts) {
  SCOPED_TRACE(text.substr(0, 100));
  expect_refused(parts, [&] { parse_curve_csv(text, "c.csv"); });
}

TEST(CurveCsv, Errors) {
  expect_error("", {"c.csv: no header", "frequency_cy_mm,mtf"});
  expect_error("# only\n", {"c.csv: no header"});
  expect_error("0,1\n10,0.5\n", {"c.csv:1:", "header is missing", "frequency_cy_mm,mtf"});
  expect_error("# c\nfrequency,mtf" + kRows, {"c.csv:2:", "no unit", "frequency_cy_mm,mtf"});
  expect_error("frequency_furlong,mtf" + kRows, {"c.csv:1: unknown unit"});
  expect_error("frequency_cy_mm\n0\n", {"c.csv:1: one column only"});
  expect_error("x,mtf" + kRows, {"c.csv:1:", "called frequency"});
  expect_error("frequency_cy_mm,a,b\n0,1,1\n", {"c.csv:1: 3 columns"});
  expect_error("frequency_cy_mm,mtf\n0,1\n10,abc\n", {"c.csv:3: \"abc\"", "finite"});
  expect_error("frequency_cy_mm,mtf\n0,1\n10,nan\n", {"c.csv:3: \"nan\"", "finite"});
  expect_error("frequency_cy_mm,mtf\n0,1\n10,1e400\n", {"c.csv:3: "});
  expect_error("frequency_cy_mm,mtf\n0,1\n10\n", {"c.csv:3: 1 values", "header has 2"});
  expect_error("frequency_cy_mm,mtf\n0,1\n10,0,5\n", {"c.csv:3: 3 values", "decimal point"});
  expect_error("frequency_cy_mm,mtf\n0,1\n# c\n10,0.5\n10,0.4\n", {"c.csv:5: frequency 10 after 10", "increase"});
  expect_error("frequency_cy_mm,mtf\n-1,1\n", {"c.csv:2: negative frequency"});
  expect_error("frequency_cy_mm,mtf\n0,100\n", {"c.csv:2: |MTF| 100 above 1.05", "percent"});
  expect_error("frequency_cy_mm,mtf\n0,1\n", {"c.csv:", "two samples"});
  std::string million = "frequency_cy_mm,mtf\n";
  for (int i = 0; i <= 1'000'000; ++i) million += std::to_string(i) + ",1\n";
  expect_error(million, {"c.csv:1000002:", "million"});
  EXPECT_THROW(read_curve_csv("/dev/zero"), RuntimeError);
  EXPECT_THROW(read_curve_csv(testing::TempDir()), RuntimeError);
  EXPECT_THROW(read_curve_csv("no/such/file.csv"), RuntimeError);
  EXPECT_THROW(read_text_file("/dev/zero", 1000), RuntimeError);
}

// FIPS 180-4 examples as published by NIST.
TEST(Sha256, PublishedExamples) {
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_hex(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace mtf::io
