// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/io/csv/spectrum_csv.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"

namespace mtf::io {
namespace {

using Numbers = std::vector<double>;

void expect_near(const Numbers& found, const Numbers& exact) {
  ASSERT_EQ(found.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_NEAR(found[i], exact[i], 1e-14 * std::abs(exact[i])) << i;
}

TEST(SpectrumCsv, units_of_the_wavelength) {
  for (const std::string text :
       {"wavelength_um,qe\n3.2,0.1\n4,0.2\n5,0.3\n", "wavelength (nm),qe\n3200,0.1\n4000,0.2\n5000,0.3\n",
        "lambda_m;qe\n3.2e-6;0.1\n4e-6;0.2\n5e-6;0.3\n", "Wavelength [\xC2\xB5m]\tqe\n3.2\t0.1\n4\t0.2\n5\t0.3\n",
        "qe,\"wavenumber (cm^-1)\"\n0.3,2000\n0.2,2500\n0.1,3125\n", "wavenumber (1/cm),qe\n2000,0.3\n2500,.2\n3125,.1",
        "wavenumber_cm-1,qe\n2500,0.2\n2000,0.3\n3125,0.1\n",
        "\xEF\xBB\xBF# sheet\r\n\r\nwavelength_um,qe (%)\r\n# rows\r\n5,30\r\n3.2,10\r\n4,20\r\n"}) {
    const SpectrumColumns curve = parse_spectrum_csv(text, "c.csv", {"qe"});
    expect_near(curve.wavelength_um, {3.2, 4.0, 5.0});
    ASSERT_EQ(curve.columns.size(), 1U);
    expect_near(curve.columns[0], {0.1, 0.2, 0.3});
    EXPECT_EQ(curve.source, "c.csv");
  }
  expect_near(parse_spectrum_csv("frequency_thz,qe\n299.792458,1\n", "c.csv", {"qe"}).wavelength_um, {1.0});
}

TEST(SpectrumCsv, columns_by_name) {
  const std::string text = "note,wavelength_um,transmission,Emissivity\nrain,4,0.5,0.9\n,3,0.25,0.8\n";
  const SpectrumColumns both = parse_spectrum_csv(text, "c.csv", {"emissivity", "transmission"});
  EXPECT_EQ(both.wavelength_um, (Numbers{3, 4}));
  EXPECT_EQ(both.columns[0], (Numbers{0.8, 0.9}));
  EXPECT_EQ(both.columns[1], (Numbers{0.25, 0.5}));
  EXPECT_EQ(parse_spectrum_csv("wavelength_um,anything\n4,0.5\n", "c.csv", {"qe"}).columns[0], (Numbers{0.5}));
}

TEST(SpectrumCsv, densities_become_watts_per_um) {
  const auto value = [](const std::string& unit) {
    return parse_spectrum_csv("wavelength_um,radiance " + unit + "\n4,3\n", "c.csv", {"radiance"}).columns[0].at(0);
  };
  EXPECT_EQ(value("(W/m^2/sr/um)"), 3.0);
  EXPECT_EQ(value("[W m^-2 sr^-1 um^-1]"), 3.0);
  EXPECT_EQ(value("(W/m^2/sr/nm)"), 3000.0);
  EXPECT_EQ(value("(uW/cm^2/sr/nm)"), 30.0);
  EXPECT_EQ(value("(W/cm2/sr/um)"), 3e4);
  EXPECT_NEAR(value("(W/cm^2/sr/cm^-1)"), 3e4 * 2500.0 * 2500.0 / 1e4, 1e-4);  // dk = k^2 / 1e4 dlambda
  EXPECT_EQ(spectral_column("radiance_w_m2_sr_um").name, "radiance");
  EXPECT_FALSE(spectral_column("radiance_furlong").density);
}

void expect_error(const std::string& text, std::initializer_list<std::string_view> parts) {
  SCOPED_TRACE(text);
  expect_refused(parts, [&] { parse_spectrum_csv(text, "c.csv", {"qe"}); });
}

TEST(SpectrumCsv, errors_name_the_line) {
  expect_error("", {"c.csv: no header", "wavelength_um,quantum_efficiency"});
  expect_error("3,0.5\n", {"c.csv:1:", "header is missing"});
  expect_error("wavelength,qe\n3,0.5\n", {"c.csv:1: \"wavelength\"", "no unit", "wavelength_nm"});
  expect_error("wavelength_furlong,qe\n3,0.5\n", {"c.csv:1: \"wavelength_furlong\"", "no unit"});
  expect_error("x,qe\n3,0.5\n", {"c.csv:1:", "called wavelength"});
  expect_error("wavelength_um,lambda_um\n3,0.5\n", {"c.csv:1: more than", "wavelengths"});
  expect_error("wavelength_um,a,b\n3,1,1\n", {"c.csv:1: no", "called qe", "wavelength_um, a, b"});
  expect_error("wavelength_um,qe,QE\n3,1,1\n", {"c.csv:1: more than", "called qe"});
  expect_error("wavelength_um\n3\n", {"c.csv:1: one column only"});
  expect_error("# a\nwavelength_um,qe\n3,x\n", {"c.csv:3: \"x\"", "finite"});
  expect_error("wavelength_um,qe\n3,inf\n", {"c.csv:2: \"inf\""});
  expect_error("wavelength_um,qe\n3,1\n4\n", {"c.csv:3: 1 values", "header has 2"});
  expect_error("wavelength_um,qe\n0,1\n", {"c.csv:2: wavelength 0;", "above 0"});
  expect_error("wavenumber_cm-1,qe\n-5,1\n", {"c.csv:2: wavenumber -5"});
  expect_error("wavelength_um,qe\n3,-0.1\n", {"c.csv:2: qe -0.1;", "0 or above"});
  expect_error("wavelength_um,qe\n4,1\n3,1\n4,0.5\n", {"c.csv:4: wavelength 4", "twice"});
  expect_error("wavelength_um,qe\n", {"c.csv:", "no rows"});
  EXPECT_THROW(read_spectrum_csv("/dev/zero", {"qe"}), RuntimeError);
  EXPECT_THROW(read_spectrum_csv("no/such.csv", {"qe"}), RuntimeError);
}

const std::string kPath =
    "# made up\nrange_km,wavelength_um,transmission,radiance_w_m2_sr_um\n2,4,0.25,0.2\n1,3,0.8,0.01\n1,4,0.5,0.1\n"
    "2,3,0.6,0.02\n";

TEST(PathCsv, one_curve_per_range) {
  const PathColumns path = parse_path_csv(kPath, "p.csv");
  EXPECT_EQ(path.range_m, (Numbers{1000, 2000}));
  EXPECT_EQ(path.wavelength_um, (Numbers{3, 4}));
  EXPECT_EQ(path.transmission, (std::vector<Numbers>{{0.8, 0.5}, {0.6, 0.25}}));
  EXPECT_EQ(path.radiance, (std::vector<Numbers>{{0.01, 0.1}, {0.02, 0.2}}));
}

TEST(PathCsv, errors_name_the_line) {
  const std::string header = "range_m,wavelength_um,transmission,radiance_w_m2_sr_um\n";
  const auto expect = [&](const std::string& text, std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] { parse_path_csv(text, "p.csv"); });
  };
  expect("range,wavelength_um,transmission,radiance_w_m2_sr_um\n1,4,1,0\n", {"p.csv:1: no", "called range_m or"});
  expect("range_m,wavelength_um,transmission,radiance\n1,4,1,0\n", {"p.csv:1: \"radiance\"", "no unit"});
  expect("range_m,wavelength_um,transmission\n1,4,1\n", {"p.csv:1: no", "called radiance"});
  expect(header + "0,4,1,0\n", {"p.csv:2: a range of 0 m"});
  expect(header + "1,4,80,0\n", {"p.csv:2: a transmission of 80"});
  expect(header + "1,4,0.8,-1\n", {"p.csv:2: radiance -1"});
  expect(header + "1,4,0.8,1\n1,4,0.8,1\n", {"p.csv:3:", "twice", "range of 1 m"});
  expect(header + "1,4,0.8,1\n2,5,0.8,1\n", {"p.csv:3:", "range of 2 m", "other wavelengths"});
  expect(header + "1,4,0.8,1\n1,5,0.8,1\n2,4,0.8,1\n", {"p.csv:4:", "range of 2 m", "other wavelengths (1)"});
}

TEST(PathCsv, every_prefix_has_an_answer_or_one_error) {
  int answers = 0, errors = 0;
  for (std::size_t length = 0; length <= kPath.size(); ++length) {
    try {
      parse_path_csv(kPath.substr(0, length), "p.csv");
      ++answers;
    } catch (const UsageError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("p.csv:")) << error.what();
      ++errors;
    }
  }
  EXPECT_GT(answers, 0);
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace mtf::io
