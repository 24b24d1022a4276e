// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <random>

#include "mtf/error.h"
#include "mtf/io/csv/tape7.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"
#include "tests/replaced.h"

namespace mtf::io {
namespace {

// Numbers and text made up for these tests, in the layout of the format.
const std::string kInput =
    "M F 2    1    1    0    1    1    1    1    1    1    0    0   0.0000.00000\n"
    "    1    0    0    0    0    0  23.00000   0.00000   0.00000   0.00000   0.00000\n"
    "   0.10000   0.10000  90.00000   1.00000   0.00000   0.00000    0        0.00000\n"
    "    2000.0    2020.0      10.0      20.0NW\n";
const std::string kThermalHeader =
    "    FREQ  TOT_TRANS  PTH_THRML  THRML_SCT  SURF_EMIS   SOL_SCAT  SING_SCAT  GRND_RFLT  DRCT_RFLT  TOTAL_RAD  "
    "REF_SOL  SOL@OBS   DEPTH\n";

std::string text(const char* format, double a, double b, double c) {
  std::array<char, 128> line{};
  std::snprintf(line.data(), line.size(), format, a, b, c);
  return line.data();
}

/// IEMSCT 1: the columns of the sun are blank.
std::string thermal_row(double k, double tau, double radiance) {
  return text("%8.2f %10.8f %10.4E", k, tau, radiance) + std::string(11, ' ') +
         text(" %10.4E%33s", 0.0, 0.0, 0.0).substr(0, 11) + std::string(44, ' ') + text(" %10.4E", radiance, 0.0, 0.0) +
         std::string(18, ' ') + "   0.100\n";
}

/// IEMSCT 2: thermal scattering is blank.
std::string solar_row(double k, double tau, double thermal, double scattered) {
  return text("%8.2f %10.8f %10.4E", k, tau, thermal) + std::string(11, ' ') + text(" %10.4E", 0.0, 0, 0) +
         text(" %10.4E %10.4E %10.4E", scattered, 0.5 * scattered, 0.0) + text(" %10.4E %10.4E", 0.0, thermal, 0) +
         " 0.00E+00 0.00E+00   0.100\n";
}

std::string thermal_run() {
  return kInput + kThermalHeader + thermal_row(2000.0, 0.25, 1e-7) + thermal_row(2010.0, 0.5, 2e-7) +
         thermal_row(2020.0, 0.0, 4e-7) + " -9999.\n";
}

std::string solar_run() {
  return kInput + kThermalHeader + solar_row(2000.0, 0.25, 1e-7, 5e-8) + solar_row(2010.0, 0.5, 2e-7, 0.0) + "-9999.\n";
}

const std::string kTransmissionRun = kInput +
                                     "    FREQ COMBIN    H2O   UMIX     O3    -LOG\n"
                                     "    CM-1  TRANS  TRANS  TRANS  TRANS  COMBIN\n"
                                     " 2000.00 0.5000 0.6000 0.8333 1.0000   0.693\n"
                                     " 2005.00 0.1250 0.2500 0.5000 1.0000   2.079\n"
                                     "-9999.\n";
const std::string kSolarRun = kInput +
                              "    FREQ   TRANS     SOL TR  SOLAR\n"
                              "11995.00  0.7237 5.35E-06 7.40E-06                                      3.234E-01\n"
                              "11996.00  0.5385 3.98E-06 7.40E-06                                      6.190E-01\n"
                              " -9999.\n";

TEST(Tape7, thermal_radiance_with_blank_columns) {
  const std::vector<Tape7Run> runs = parse_tape7(thermal_run(), "t.tp7");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].source, "t.tp7:5");
  ASSERT_EQ(runs[0].wavelength_um.size(), 3U);
  EXPECT_EQ(runs[0].wavelength_um, (std::vector<double>{1e4 / 2020, 1e4 / 2010, 5.0}));
  EXPECT_EQ(runs[0].transmission, (std::vector<double>{0.0, 0.5, 0.25}));
  // 1e-7 W/(cm^2 sr cm^-1) at 2000 cm^-1: 1e-3 W/(m^2 sr cm^-1), and 1 um is 400 cm^-1 there.
  EXPECT_NEAR(runs[0].radiance[2], 0.4, 1e-15);
  EXPECT_NEAR(runs[0].radiance[0], 4e-7 * 1e4 * 2020 * 2020 / 1e4, 1e-14);
}

TEST(Tape7, the_integral_is_the_same_in_both_units) {
  // A smooth spectrum of fine steps: what it holds per wavenumber it holds per wavelength.
  std::string file = kInput + kThermalHeader;
  double per_wavenumber = 0.0;
  for (int k = 2000; k <= 3000; ++k) {
    const double radiance = 1e-7 * std::exp(-1e-3 * (k - 2000));
    file += thermal_row(k, 0.5, radiance);
    per_wavenumber += (k == 2000 || k == 3000 ? 0.5 : 1.0) * radiance * 1e4;
  }
  const Tape7Run run = parse_tape7(file + "-9999.", "t.tp7").at(0);
  double per_um = 0.0;
  for (std::size_t i = 0; i + 1 < run.radiance.size(); ++i)
    per_um += 0.5 * (run.radiance[i] + run.radiance[i + 1]) * (run.wavelength_um[i + 1] - run.wavelength_um[i]);
  EXPECT_NEAR(per_um, per_wavenumber, 1e-4 * per_wavenumber);
}

TEST(Tape7, scattered_sunlight_belongs_to_the_path) {
  const Tape7Run run = parse_tape7(solar_run(), "t.tp7").at(0);
  EXPECT_NEAR(run.radiance[1], 1.5e-7 * 2000 * 2000, 1e-15);
  EXPECT_NEAR(run.radiance[0], 2e-7 * 2010 * 2010, 1e-15);
}

TEST(Tape7, older_headers_with_blanks_in_names) {
  std::string old = thermal_run();
  for (char& c : old) c = c == '_' ? ' ' : c;
  const Tape7Run run = parse_tape7(old, "t.tp7").at(0), modern = parse_tape7(thermal_run(), "t.tp7").at(0);
  EXPECT_EQ(run.transmission, modern.transmission);
  EXPECT_EQ(run.radiance, modern.radiance);
}

TEST(Tape7, transmission_alone_and_sunlight) {
  const Tape7Run combined = parse_tape7(kTransmissionRun, "t.tp7").at(0);
  EXPECT_EQ(combined.transmission, (std::vector<double>{0.125, 0.5}));
  EXPECT_TRUE(combined.radiance.empty());
  const Tape7Run solar = parse_tape7(kSolarRun, "t.tp7").at(0);
  EXPECT_EQ(solar.transmission, (std::vector<double>{0.5385, 0.7237}));
  EXPECT_TRUE(solar.radiance.empty());
}

TEST(Tape7, several_runs_make_a_table_of_paths) {
  const std::vector<Tape7Run> runs = parse_tape7(thermal_run() + thermal_run(), "t.tp7");
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[1].source, "t.tp7:14");
  const PathColumns path = path_columns(runs, {500.0, 1000.0});
  EXPECT_EQ(path.source, "t.tp7");
  EXPECT_EQ(path.range_m, (std::vector<double>{500.0, 1000.0}));
  EXPECT_EQ(path.transmission[1], runs[1].transmission);
  EXPECT_EQ(path.radiance[0], runs[0].radiance);
  const auto refused = [](const std::vector<Tape7Run>& given, const std::vector<double>& ranges) {
    return message_of<UsageError>([&] { path_columns(given, ranges); });
  };
  expect_says(refused(runs, {500.0}), {"2 runs", "1 ranges"});
  expect_says(refused(runs, {500.0, 400.0}), {"t.tp7:14:", "400 m"});
  expect_says(refused(runs, {std::nan(""), 400.0}), {"nan m"});
  expect_says(refused(parse_tape7(kTransmissionRun, "x"), {1.0}), {"transmission alone"});
  const auto mixed = parse_tape7(thermal_run() + solar_run(), "m.tp7");
  expect_says(refused(mixed, {1.0, 2.0}), {"other wavenumbers than m.tp7:5"});
  expect_says(refused({}, {}), {"no runs"});
}

TEST(Tape7, numbers_as_fortran_writes_them) {
  std::string file = thermal_run();
  const auto with = [&](const std::string& number) {
    std::string changed = file;
    return replaced(changed, "1.0000E-07", number);
  };
  EXPECT_NEAR(parse_tape7(with("1.0000-107"), "t").at(0).radiance[2], 1e-107 * 4e6, 1e-115);
  EXPECT_EQ(parse_tape7(with("1.0000-400"), "t").at(0).radiance[2], 0.0);
  EXPECT_EQ(parse_tape7(with("1.000E-400"), "t").at(0).radiance[2], 0.0);
  EXPECT_NEAR(parse_tape7(with("       .25"), "t").at(0).radiance[2], 0.25 * 4e6, 1e-9);
  for (const char* bad :
       {"**********", "       NaN", "       inf", "1.0000E--7", "1.0000+400", "  -1.0E-07", "        -7"})
    EXPECT_THROW(parse_tape7(with(bad), "t"), UsageError) << bad;
}

TEST(Tape7, errors_name_the_line) {
  const auto expect = [](const std::string& file, std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] { parse_tape7(file, "t.tp7"); });
  };
  expect("", {"t.tp7:", "no line with FREQ"});
  expect(kInput, {"t.tp7:", "no line with FREQ", "4 lines"});
  expect(kInput + kThermalHeader, {"t.tp7:5:", "cut short"});
  expect(kInput + kThermalHeader + thermal_row(2000, 0.5, 0.0), {"t.tp7:6:", "cut short"});
  expect(kInput + kThermalHeader + "-9999.\n", {"t.tp7:6:", "without rows"});
  expect(kInput + "  FREQ  BANANAS\n", {"t.tp7:5:", "FREQ", "BANANAS"});
  expect(kInput + "  FREQ LOS  TOT_TRANS  PTH_THRML SOL_SCAT\n", {"t.tp7:5:", "several lines of sight"});
  expect(kInput + "  FREQ COMBIN\n 2000.00 0.5\n", {"t.tp7:6:", "second line"});
  expect(kInput + kThermalHeader + "garbage\n", {"t.tp7:6: column FREQ", "\"garbage\""});
  expect(kInput + kThermalHeader + " 2000.00\n", {"t.tp7:6: column TOT TRANS", "characters 9 to 19"});
  expect(kInput + kThermalHeader + thermal_row(2000, 1.5, 0.0), {"t.tp7:6: TOT TRANS is 1.5"});
  expect(kInput + kThermalHeader + thermal_row(2000, 0.5, 0.0) + thermal_row(1990, 0.5, 0.0),
         {"t.tp7:7: wavenumber 1990 after 2000"});
  expect(kInput + kThermalHeader + thermal_row(0, 0.5, 0.0), {"t.tp7:6: a wavenumber of 0"});
  expect(std::string(5000, 'x'), {"t.tp7:1:", "5000 characters"});
  EXPECT_THROW(read_tape7("no/such/tape7"), RuntimeError);
  EXPECT_THROW(read_tape7("/dev/zero"), RuntimeError);
}

TEST(Tape7, every_prefix_has_an_answer_or_one_error) {
  for (const std::string& file : {thermal_run() + solar_run(), kTransmissionRun, kSolarRun})
    for (std::size_t length = 0; length <= file.size(); ++length) {
      const std::string what = message_of<UsageError>([&] { parse_tape7(file.substr(0, length), "t.tp7"); });
      EXPECT_TRUE(what.empty() || what.starts_with("t.tp7:")) << what;
    }
}

TEST(Tape7, random_damage_has_an_answer_or_one_error) {
  std::mt19937 random(5);
  const std::string whole = thermal_run() + kTransmissionRun;
  for (int i = 0; i < 5000; ++i) {
    std::string file = whole;
    for (int n = 0; n < 3; ++n) file[random() % file.size()] = static_cast<char>(random() % 256);
    const std::string what = message_of<UsageError>([&] { parse_tape7(file, "t.tp7"); });
    EXPECT_TRUE(what.empty() || what.starts_with("t.tp7:")) << what;
  }
}

TEST(Tape7, a_million_lines) {
  std::string file = kInput + kThermalHeader;
  for (int k = 1; k <= 1'000'000; ++k) {
    std::array<char, 40> line{};
    std::snprintf(line.data(), line.size(), "%8d 0.50000000 1.0000E-07\n", k);
    file += line.data();
  }
  EXPECT_EQ(parse_tape7(file + "-9999.\n", "t.tp7").at(0).radiance.size(), 1'000'000U);
}

}  // namespace
}  // namespace mtf::io
