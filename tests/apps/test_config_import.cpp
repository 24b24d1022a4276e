// SPDX-License-Identifier: Apache-2.0

// `mtf config import`; the readers of the listings are tested in tests/mtf/io/test_designs.cpp.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/apps/command.h"

namespace apps_test {
namespace {

std::string listing(const std::string& field, const std::string& terms) {
  return "Listing of Zernike Fringe Coefficient Data\n\nField : " + field +
         " (deg)\nWavelength : 0.5500 \xC2\xB5m\n\n" + "Z 1 0 : 1\nZ 2 0 : (p) * COS (A)\nZ 3 0 : (p) * SIN (A)\n" +
         terms;
}

TEST(ConfigImport, OneFieldIsABlockOfASensorFile) {
  const Scratch scratch;
  write_file(scratch / "lens.txt", listing("0.0, 7.0", "Z 4 0.25 :\nZ 5 -0.5 :\nZ 6 0.125 :\n"));
  const Result result = scratch.run("mtf config import lens.txt -o lens.toml");
  ASSERT_EQ(result.status, 0) << result.err;
  expect_says(result.err, {"Fringe (unit peak)", "y of the file", "sign of W", "wrote lens.toml"});
  const std::string block = read_file(scratch / "lens.toml");
  expect_says(block, {"# lens.txt: order", "zernike = [0.0, 0.0, 0.0, 0.25, -0.5, -0.125]",
                      "wavelength_reference = \"0.55 um\""});
  scratch.add_sensor();
  write_file(scratch / "s.toml", replaced(read_file(scratch / "sensor.toml"), "kind = \"diffraction\"",
                                          "kind = \"gaussian\"\nsigma = \"1 um\"") +
                                     block);
  const Result check = scratch.run("mtf config check s.toml");
  EXPECT_EQ(check.status, 0) << check.err;
  expect_error(scratch.run("mtf config import lens.txt -o lens.toml"), 2, {"lens.toml", "--force"});
  EXPECT_EQ(scratch.run("mtf config import lens.txt -o lens.toml --force --quiet").err, "");
  expect_error(scratch.run("mtf config import lens.txt --as psf"), 2, {"lens.txt", "Huygens PSF"});
  write_file(scratch / "steep.txt", listing("0.0, 7.0", "Z 4 9.9 :\nZ 5 9.9 :\n"));
  expect_error(scratch.run("mtf config import steep.txt"), 2, {"waves per pupil radius"});
}

TEST(ConfigImport, SeveralFieldsAreATable) {
  const Scratch scratch;
  // Coma and astigmatism of a lens with an axis, for fields along +y of the lens program: there coma lies along y.
  write_file(scratch / "a.txt", listing("0.0, 0.0", "Z 4 0.1 :\n"));
  write_file(scratch / "b.txt", listing("0.0, 7.0", "Z 4 0.2 :\nZ 5 -0.3 :\nZ 6 0 :\nZ 7 0 :\nZ 8 0.4 :\n"));
  const Result table = scratch.run("mtf config import a.txt b.txt");
  ASSERT_EQ(table.status, 0) << table.err;
  // Away from the axis, which is up: x of the component. W = 0.4 (3 rho^2 - 2) y becomes that of x, y^2 - x^2 turns
  // too.
  expect_says(table.out, {"# orientation = \"field\"", "# table = \"zernike.csv\"",
                          "\nr (deg),Z4,Z5,Z7\n0,0.1,0,0\n7,0.2,0.3,0.4\n"});
  EXPECT_FALSE(says(table.err, "warning")) << table.err;
  expect_says(scratch.run("mtf config import a.txt b.txt --field 2").out,
              {"zernike = [0.0, 0.0, 0.0, 0.2, -0.3, 0.0, 0.0, -0.4]"});
  write_file(scratch / "c.txt", listing("5.0, 3.0", "Z 4 0.2 :\nZ 5 0 :\nZ 6 0.1 :\n"));
  const Result all = scratch.run("mtf config import a.txt b.txt c.txt -o table.csv");
  EXPECT_EQ(all.status, 0) << all.err;
  expect_says(read_file(scratch / "table.csv"),
              {"# table = \"table.csv\"",
               "\nx (deg),y (deg),Z4,Z5,Z6,Z8\n0,0,0.1,0,0,0\n0,-7,0.2,-0.3,0,-0.4\n5,-3,0.2,0,-0.1,0\n"});
  write_file(scratch / "b.txt", listing("0.0, 7.0", "Z 4 0.2 :\nZ 5 0 :\nZ 6 0.1 :\n"));
  expect_says(scratch.run("mtf config import a.txt b.txt").err,
              {"warning", "no axis", "0.0408 waves"});  // 0.1 / sqrt(6)
  expect_error(scratch.run("mtf config import b.txt b.txt"), 2, {"rows 1 and 2"});
  expect_error(scratch.run("mtf config import a.txt b.txt --step '2 um'"), 2, {"--step", "leave it out"});
  write_file(scratch / "b.txt", replaced(listing("0.0, 7.0", "Z 4 0.2 :\n"), "0.5500", "0.6500"));
  expect_error(scratch.run("mtf config import a.txt b.txt"), 2, {"wavelengths"});
}

TEST(ConfigImport, PsfThatIsCutOffIsWarnedOf) {
  const Scratch scratch;
  const auto grid = [](double width) {
    std::string text =
        "Listing of FFT PSF Data\n\n0.5500 \xC2\xB5m at 0.0 (deg).\nData spacing is 0.500 \xC2\xB5m.\n"
        "Image grid size: 16 by 16\nCenter point is: row 9, column 8\n\n";
    for (int j = 1; j <= 16; ++j, text += "\n")
      for (int i = 1; i <= 16; ++i)
        text += std::to_string(std::exp(-(std::pow(i - 8, 2) + std::pow(j - 9, 2)) / (2.0 * width * width))) + "\t";
    return text;
  };
  write_file(scratch / "psf.txt", grid(1.5));
  const Result whole = scratch.run("mtf config import psf.txt");
  ASSERT_EQ(whole.status, 0) << whole.err;
  expect_says(whole.out, {"kind = \"psf\"", "step = \"0.5 um\"", "samples = [[0.0,0.0"});
  EXPECT_FALSE(says(whole.err, "warning")) << whole.err;
  write_file(scratch / "psf.txt", grid(2.3));
  expect_says(scratch.run("mtf config import psf.txt").err, {"warning", "beyond them lies"});
  write_file(scratch / "psf.txt", grid(6.0));
  expect_error(scratch.run("mtf config import psf.txt"), 2, {"samples", "further out"});
}

TEST(ConfigImport, MtfAgainstFieldIsOneOfItsRows) {
  const Scratch scratch;
  write_file(scratch / "m.txt", "Polychromatic\n0 1 0.8 0.8 0.6 0.6\n14 1 0.7 0.8 0.4 0.6\n");
  const std::string cuts = "-, tangential (10 cy/mm), sagittal (10 cy/mm), tangential (20 cy/mm), sagittal (20 cy/mm)'",
                    import = "mtf config import m.txt --field 2 --columns ";
  expect_says(scratch.run(import + "'x (deg) = 0, y (deg), " + cuts).out,
              {"axis = \"y\"\npart = \"optics\"\nfile = \"\"\"\nfrequency_cy_mm,mtf\n0,1\n10,0.7\n20,0.4\n",
               "0,1\n10,0.8\n20,0.6\n"});
  expect_error(scratch.run(import + "'y (deg), " + cuts), 2, {"x (deg), y (deg)"});
  expect_error(scratch.run(import + "'x (deg) = 0, y (deg), " + cuts + " --sign minus"), 2, {"--sign", "leave it out"});
  // Against frequency; lines between that are no rows end nothing, and lines are counted as in the file.
  write_file(scratch / "m.txt", "0 1 1\n10 0.7 0.8\nPage 2\n20 0.4 0.6\n*** 0.3 0.5\n");
  const std::string read = "mtf config import m.txt --columns 'frequency (cy/mm), tangential, sagittal'";
  const Result curve = scratch.run(read);
  expect_says(curve.out, {"0,1\n10,0.7\n20,0.4\n"});
  expect_says(curve.err, {"left out: 5"});
  write_file(scratch / "m.txt", "0 1 1\n10 0.7 0.8\n20 0.4 0.6\n50 0.4 0.6\n");
  expect_error(scratch.run(read), 2, {"m.txt:1:"});
}

TEST(ConfigImport, MtfIsTwoCuts) {
  const Scratch scratch;
  const std::string head = "Spatial frequency units are cycles per mm.\n",
                    columns = "Spatial frequency Tangential Sagittal\n";
  write_file(scratch / "m.txt", head + "Field: 0.0, 0.0 (deg)\n" + columns +
                                    "0 1 1\n50 0.6 0.6\n100 0.2 0.2\n150 0 0\n\nField: 0.0, 14.0 (deg)\n" + columns +
                                    "0 1 1\n50 0.5 0.6\n100 0.1 0.2\n150 0 0\n");
  expect_error(scratch.run("mtf config import m.txt"), 2, {"2 fields", "2: (0, -14) deg", "--field"});
  expect_says(scratch.run("mtf config import m.txt --field 1").out,
              {"axis = \"radial\"", "frequency_cy_mm,mtf\n0,1\n50,0.6\n"});
  const Result two = scratch.run("mtf config import m.txt --field 2");
  ASSERT_EQ(two.status, 0) << two.err;
  expect_says(two.out,
              {"axis = \"y\"\npart = \"optics\"\nfile = \"\"\"\nfrequency_cy_mm,mtf\n0,1\n50,0.5\n", "axis = \"x\""});
  expect_says(two.err, {"no phase", "on the diagonals"});
}

// The layout that OpticStudio's analysis of coefficients against field has: a line of the numbers of terms, rows below.
TEST(ConfigImport, CoefficientsAgainstFieldAreATable) {
  const Scratch scratch;
  const std::string rows = "0.0\t0\t0\t0\t0.1\t0\n7.0\t0\t0\t0\t0.2\t-0.3\n", head = "Field:\t 1\t 2\t 3\t 4\t 5\n";
  write_file(
      scratch / "z.txt",
      "Zernike Fringe Coefficients vs. Field\nWavelength : 0.55 \xC2\xB5m\nField units : Degrees\n" + head + rows);
  write_file(scratch / "a.txt", listing("0.0, 0.0", "Z 4 0.1 :\n"));
  write_file(scratch / "b.txt", listing("0.0, 7.0", "Z 4 0.2 :\nZ 5 -0.3 :\n"));
  const auto table = [](const Result& result) { return result.out.substr(result.out.find("\nr (deg)")); };
  const std::string one_by_one = table(scratch.run("mtf config import a.txt b.txt"));
  const Result scan = scratch.run("mtf config import z.txt");
  ASSERT_EQ(scan.status, 0) << scan.err;
  EXPECT_EQ(table(scan), one_by_one);
  write_file(scratch / "bare.txt", "a title of 2 words\n" + rows);
  const std::string columns = " --order fringe --columns 'x (deg) = 0, y (deg), wavelength (um) = 0.55, Z1-Z5 (waves)'";
  EXPECT_EQ(table(scratch.run("mtf config import bare.txt" + columns)), one_by_one);
  write_file(scratch / "bare.txt", "Zernike\n" + head + rows);
  expect_error(scratch.run("mtf config import bare.txt"), 2, {"bare.txt:2:", "unit", "--columns"});
  write_file(scratch / "noll.txt", replaced(read_file(scratch / "z.txt"), "Fringe", "Standard"));
  expect_error(scratch.run("mtf config import z.txt noll.txt"), 2, {"noll.txt", "another order"});
  expect_error(scratch.run("mtf config import z.txt --order noll"), 2, {"z.txt", "Fringe", "leave --order out"});
  expect_error(scratch.run("mtf config import bare.txt --columns 'x (deg), y (deg)'"), 2, {"2 numbers"});
}

TEST(ConfigImport, WhatIsNotReadIsNamed) {
  const Scratch scratch;
  write_file(scratch / "lens.zmx", "VERS 200000\nMODE SEQ\nUNIT MM\n");
  expect_error(scratch.run("mtf config import lens.zmx"), 2,
               {"lens.zmx", "lens files", "Zernike Standard", "FFT or Huygens"});
  write_file(scratch / "lens.zos", std::string("\1\0\2\xFF", 4));
  expect_error(scratch.run("mtf config import lens.zos"), 2, {"lens.zos", "encrypted"});
  write_file(scratch / "empty.txt", "");
  expect_error(scratch.run("mtf config import empty.txt"), 2, {"empty.txt", "read are"});
  EXPECT_EQ(scratch.run("mtf config import missing.txt").status, 1);
}

}  // namespace
}  // namespace apps_test
