// SPDX-License-Identifier: Apache-2.0
// FITS files that cannot be read; tests/python/test_bare_numbers.py reads the others, against numpy.
#include <gtest/gtest.h>

#include "mtf/error.h"
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

TEST(Fits, FilesThatCannotBeReadSayWhy) {
  const io_test::TempFolder folder;
  const std::string path = folder / "a.fits";
  const auto refused = [&](const std::string& bytes, std::initializer_list<std::string_view> parts) {
    io_test::write_bytes(path, bytes);
    expect_refused<mtf::RuntimeError>(parts, [&] { mtf::io::read_info(path); });
    expect_refused<mtf::RuntimeError>(parts, [&] { mtf::io::read_image(path); });
  };
  const std::string data(2880, '\0');
  const auto image = [](const std::string& bits, const std::string& columns, const std::string& rows) {
    return Cards{{"SIMPLE", "T"}, {"BITPIX", bits}, {"NAXIS", "2"}, {"NAXIS1", columns}, {"NAXIS2", rows}};
  };
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

}  // namespace
