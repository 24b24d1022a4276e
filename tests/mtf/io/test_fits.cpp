// SPDX-License-Identifier: Apache-2.0
// FITS files that cannot be read; tests/python/test_bare_numbers.py reads the others, against numpy.
#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/io/designs/psf_fits.h"
#include "mtf/io/image_io.h"
#include "mtf/io/raw/raw_image.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"

namespace {

using Cards = std::vector<std::pair<std::string, std::string>>;

std::string header_of(const Cards& cards) {
  std::string text;
  const auto add = [&](std::string card) { text += card + std::string(80 - card.size(), ' '); };
  for (const auto& [key, value] : cards) add(key + std::string(8 - key.size(), ' ') + "= " + value);
  add("END");
  text.resize((text.size() + 2879) / 2880 * 2880, ' ');
  return text;
}

Cards image(const std::string& bits, const std::string& columns, const std::string& rows) {
  return {{"SIMPLE", "T"}, {"BITPIX", bits}, {"NAXIS", "2"}, {"NAXIS1", columns}, {"NAXIS2", rows}};
}

TEST(Fits, FilesThatCannotBeReadSayWhy) {
  const io_test::TempFolder folder;
  const std::string path = folder / "a.fits";
  const auto refused = [&](const std::string& bytes, std::initializer_list<std::string_view> parts) {
    io_test::write_bytes(path, bytes);
    expect_refused<mtf::RuntimeError>(parts, [&] { mtf::io::read_info(path); });
    expect_refused<mtf::RuntimeError>(parts, [&] { mtf::io::read_image(path); });
  };
  const std::string data(2880, '\0');
  io_test::write_bytes(path, header_of(image("16", "36", "40")) + data);
  EXPECT_EQ(mtf::io::read_info(path).height, 40);
  refused(header_of(image("16", "36", "40")) + data.substr(1), {"a.fits", "unit 0", "5759", "cut off"});
  refused(header_of(image("16", "1048576", "1048576")) + data, {"a.fits", "cut off"});
  refused(header_of(image("16", "1e15", "1e15")) + data, {"announces", "EiB"});
  refused(header_of(image("16", "-36", "40")) + data, {"NAXIS1 = -36", "whole number"});
  refused(header_of(image("12", "36", "40")) + data, {"BITPIX = 12", "-32"});
  refused(header_of(image("16", "36", "x")) + data, {"NAXIS2 = x", "no number"});
  Cards scaled = image("16", "36", "40");
  scaled.emplace_back("BSCALE", "0.0");
  refused(header_of(scaled) + data, {"BSCALE = 0"});
  refused(header_of({{"SIMPLE", "T"}, {"BITPIX", "16"}}) + data, {"NAXIS is missing"});
  refused(header_of({{"SIMPLE", "T"}, {"BITPIX", "16"}, {"NAXIS", "0"}}), {"no image"});
  refused(header_of(image("16", "36", "40")).substr(0, 300), {"no END"});
  refused(std::string("SIMPLE  =") + std::string(5751, ' '), {"no END"});
  Cards table{
      {"XTENSION", "'BINTABLE'"}, {"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", "8"}, {"NAXIS2", "1"}, {"ZIMAGE", "T"}};
  const std::string empty = header_of({{"SIMPLE", "T"}, {"BITPIX", "16"}, {"NAXIS", "0"}});
  refused(empty + header_of(table) + data, {"compressed", "funpack"});
  io_test::write_bytes(path, header_of(image("16", "36", "40")) + data + header_of(table) + data);
  EXPECT_TRUE(says(mtf::io::read_info(path).notes, "1 compressed image"));
  Cards cube = image("8", "1", "1");
  cube[2].second = "3";
  cube.emplace_back("NAXIS3", "65536");
  const std::string planes((65536 + 2879) / 2880 * 2880, '\1');
  io_test::write_bytes(path, header_of(cube) + planes);
  EXPECT_EQ(mtf::io::read_image(path, {.channel = "plane 65536"}).planes.front().at(0, 0), 1.0F);
  Cards more = image("8", "1", "1");
  more[0] = {"XTENSION", "'IMAGE'"};
  refused(header_of(cube) + planes + header_of(more) + data, {"unit 1", "more than the 65536 planes"});
  cube.back().second = "65537";
  refused(header_of(cube) + planes, {"65537 planes", "cut the cube"});
  // A part is described by itself.
  Cards second = image("-32", "6", "5");
  second[0] = {"XTENSION", "'IMAGE'"};
  io_test::write_bytes(path, header_of(image("16", "36", "40")) + data + header_of(second) + data);
  const mtf::io::FileInfo info = mtf::io::read_raw_info(path, mtf::io::open_fits, 1);
  EXPECT_EQ(info.width, 6);
  EXPECT_EQ(info.channels.size(), 2U);
  EXPECT_EQ(mtf::io::read_info(path).width, 36);
  // PSFEx on other bases than pixels has a second column, of their coefficients.
  Cards psf = table;
  psf[3].second = "24";
  psf[5] = {"TTYPE1", "'PSF_MASK'"};
  for (const auto& card : Cards{{"TFORM1", "'4E'"},
                                {"TTYPE2", "'PSF_COEFFS'"},
                                {"TFORM2", "'2E'"},
                                {"PSFNAXIS", "2"},
                                {"PSFAXIS1", "2"},
                                {"PSFAXIS2", "2"}})
    psf.push_back(card);
  io_test::write_bytes(path, empty + header_of(psf) + data);
  EXPECT_EQ(mtf::io::read_image(path).planes.front().size(), 4);
  psf[3].second = "12";
  refused(empty + header_of(psf) + data, {"TFORM1 = 4E", "do not fit"});
}

// Headers as STPSF writes them: with use_detsampled_psf OVERSAMP is 1 and DET_SAMP stays at 4.
TEST(Fits, PointSpreadsOfStpsf) {
  const io_test::TempFolder folder;
  const std::string path = folder / "a.fits", light(2880, '\1');
  Cards grid = image("8", "3", "3"), single = grid, distorted = grid, cube = image("8", "1", "1");
  for (const auto& [key, value] : Cards{{"OVERSAMP", "1"}, {"DET_SAMP", "4"}, {"DET_YX0", "'(1, 2)'"}})
    grid.emplace_back(key, value);
  const auto read = [&](const std::string& bytes, std::array<int, 2> detector = {4, 4}) {
    io_test::write_bytes(path, bytes);
    return mtf::io::read_psf_fits(path, {.detector = detector});
  };
  const mtf::io::PsfFits sampled = read(header_of(grid) + light);
  EXPECT_EQ(sampled.step, "1 px");
  EXPECT_EQ(sampled.planes.at(0).place->text(), "(2.5, 2.5) px");
  expect_refused({"(2.5, 0.5) px", "--detector 2x2"}, [&] { read(header_of(grid) + light, {2, 2}); });
  single.emplace_back("EXTNAME", "'DET_SAMP'");
  distorted[0] = {"XTENSION", "'IMAGE'"};
  distorted.insert(distorted.end(), {{"EXTNAME", "'DET_DIST'"}, {"PIXELSCL", "0.5"}});
  const mtf::io::PsfFits binned = read(header_of(single) + light + header_of(distorted) + light);
  EXPECT_EQ(binned.step, "0.5 arcsec");
  EXPECT_TRUE(says(binned.remarks.notes, "in DET_DIST"));
  EXPECT_TRUE(says(binned.remarks.warnings, "footprint"));
  cube.insert(cube.end(), {{"NAXIS3", "101"}, {"PIXELSCL", "1"}, {"WVLN0100", "2E-6"}});
  cube[2].second = "3";
  EXPECT_EQ(read(header_of(cube) + light).planes.at(100).label, "2 um");
  cube[5].second = "4097";
  expect_refused({"4097 planes", "4096"}, [&] { read(header_of(cube) + light + light); });
  expect_refused({"300 samples", "257"}, [&] { read(header_of(image("8", "300", "1")) + light); });
}

// The centre of an even number of samples is the one behind the middle, from the lower left corner on.
TEST(Fits, PointSpreadsOfPsfex) {
  const io_test::TempFolder folder;
  const std::string path = folder / "a.psf";
  Cards cards{{"XTENSION", "'BINTABLE'"}, {"BITPIX", "8"},     {"NAXIS", "2"},
              {"NAXIS1", "64"},           {"NAXIS2", "1"},     {"EXTNAME", "'PSF_DATA'"},
              {"TTYPE1", "'PSF_MASK'"},   {"TFORM1", "'16E'"}, {"PSFNAXIS", "3"},
              {"PSFAXIS1", "4"},          {"PSFAXIS2", "4"},   {"PSFAXIS3", "1"}};
  std::string data(2880, '\0');
  data.replace(4 * (2 * 4 + 2), 2, "\x3F\x80");  // 1.0 at column 2, row 2
  const std::string empty = header_of({{"SIMPLE", "T"}, {"BITPIX", "8"}, {"NAXIS", "0"}});
  for (const bool y_up : {true, false}) {
    io_test::write_bytes(path, empty + header_of(cards) + data);
    const mtf::io::PsfFits psf = mtf::io::read_psf_fits(path, {.y_up = y_up});
    EXPECT_EQ(psf.planes.at(0).samples.at(2, 2), 1.0F) << y_up;
    EXPECT_FALSE(says(psf.remarks.notes, "half a step"));
  }
  cards.insert(cards.end(), {{"POLNAXIS", "2"}, {"POLNGRP", "1"}, {"POLDEG1", "0"}, {"POLNAME1", "'X_WORLD'"}});
  io_test::write_bytes(path, empty + header_of(cards) + data);
  expect_refused({"POLNAME1 = X_WORLD", "X_IMAGE"}, [&] { mtf::io::read_psf_fits(path, {}); });
}

}  // namespace
