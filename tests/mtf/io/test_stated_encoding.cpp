// SPDX-License-Identifier: Apache-2.0
// What PNG and TIFF say of the curve of their values.

#include "mtf/io/codecs/stated_encoding.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <cmath>

#include "io_test_files.h"
#include "mtf/io/codecs/encoding.h"
#include "mtf/io/image_io.h"
#include "png_chunks.h"

namespace mtf::io {
namespace {

using io_test::TempFolder;

StatedEncoding png_with(std::initializer_list<io_test::PngChunk> chunks) {
  const TempFolder folder;
  const Image image(3, 2);
  write_integer(folder / "a.png", {{"Y", image.view()}}, {}, {});
  io_test::add_chunks(folder / "a.png", chunks);
  const StatedEncoding read = read_image(folder / "a.png").info.encoding;
  EXPECT_EQ(read, read_info(folder / "a.png").encoding);
  return read;
}

TEST(StatedEncoding, PngChunksOneByOne) {
  EXPECT_EQ(png_with({}), StatedEncoding());
  EXPECT_EQ(png_with({io_test::srgb_chunk()}), (StatedEncoding{"srgb", "sRGB chunk"}));
  EXPECT_EQ(png_with({io_test::gamma_chunk(45455)}), (StatedEncoding{"gamma:2.2", "gAMA chunk (0.45455)"}));
  EXPECT_EQ(png_with({io_test::gamma_chunk(55556)}), (StatedEncoding{"gamma:1.8", "gAMA chunk (0.55556)"}));
  EXPECT_EQ(png_with({io_test::gamma_chunk(50000)}), (StatedEncoding{"gamma:2", "gAMA chunk (0.5)"}));
  EXPECT_EQ(png_with({io_test::gamma_chunk(100000)}), (StatedEncoding{"linear", "gAMA chunk (1)"}));
  for (const std::uint32_t senseless : {0U, 1U, 9999U, 1'000'001U, 4'294'967'295U}) {
    const StatedEncoding stated = png_with({io_test::gamma_chunk(senseless)});
    EXPECT_EQ(stated.word, "") << senseless;
    EXPECT_NE(stated.source, "") << senseless;
  }
  EXPECT_EQ(png_with({io_test::profile_chunk("sRGB IEC61966-2.1")}).word, "srgb");
  EXPECT_EQ(png_with({io_test::profile_chunk("Adobe RGB (1998)")}),
            (StatedEncoding{"", "ICC profile \"Adobe RGB (1998)\""}));
  // The primaries of sRGB, another curve.
  EXPECT_EQ(png_with({io_test::profile_chunk("GIMP built-in Linear sRGB")}).word, "");
  EXPECT_EQ(png_with({io_test::cicp_chunk('\x0d')}).word, "srgb");
  EXPECT_EQ(png_with({io_test::cicp_chunk('\x08')}).word, "linear");
  EXPECT_EQ(png_with({io_test::cicp_chunk('\x10')}), (StatedEncoding{"", "cICP chunk (transfer function 16)"}));
}

TEST(StatedEncoding, TheStrongerPngChunkCounts) {
  const auto srgb = io_test::srgb_chunk(), gamma = io_test::gamma_chunk(45455);
  const auto adobe = io_test::profile_chunk("Adobe RGB (1998)"), perceptual = io_test::cicp_chunk('\x10');
  EXPECT_EQ(png_with({srgb, gamma}), (StatedEncoding{"srgb", "sRGB chunk"}));
  EXPECT_EQ(png_with({gamma, srgb}), (StatedEncoding{"srgb", "sRGB chunk"}));
  EXPECT_EQ(png_with({adobe, gamma}),
            (StatedEncoding{"gamma:2.2", "gAMA chunk (0.45455) beside ICC profile \"Adobe RGB (1998)\""}));
  EXPECT_EQ(png_with({io_test::profile_chunk("sRGB built-in"), gamma}).word, "srgb");
  EXPECT_EQ(png_with({srgb, perceptual}).word, "");
}

/// A chunk that breaks the PNG specification says nothing that can be believed.
TEST(StatedEncoding, MalformedPngChunksAreNamedAndNotUsed) {
  const auto malformed = [](const std::string& type, const std::string& fault) {
    return StatedEncoding{"", type + " chunk (malformed: " + fault + "; not used)"};
  };
  EXPECT_EQ(png_with({{"gAMA", "ab"}}), malformed("gAMA", "2 bytes in place of 4"));
  EXPECT_EQ(png_with({{"sRGB", ""}}), malformed("sRGB", "0 bytes in place of 1"));
  EXPECT_EQ(png_with({{"sRGB", "\x09"}}), malformed("sRGB", "rendering intent 9, which is 0 to 3"));
  EXPECT_EQ(png_with({{"cICP", "\x01\x0d"}}), malformed("cICP", "2 bytes in place of 4"));
  EXPECT_EQ(png_with({{"iCCP", "sRGB"}}), malformed("iCCP", "no profile name of 1 to 79 characters"));
  const auto gamma = io_test::gamma_chunk(45455);
  EXPECT_EQ(png_with({gamma, gamma}), malformed("gAMA", "more than one"));
  EXPECT_EQ(png_with({gamma, io_test::gamma_chunk(100000)}), malformed("gAMA", "more than one"));
  EXPECT_EQ(png_with({{"sRGB", "\x09"}, gamma}),
            (StatedEncoding{"gamma:2.2",
                            "gAMA chunk (0.45455) beside sRGB chunk (malformed: rendering intent 9, which is 0 to 3; "
                            "not used)"}));
}

/// The exponent that is named is one that a writer would have stored like this, whatever the value.
TEST(StatedEncoding, EveryGammaComesBack) {
  for (std::uint32_t gamma_e5 = 10'000; gamma_e5 <= 1'000'000; gamma_e5 += 7) {
    const StatedEncoding stated = stated_by_png({.transfer = {}, .profile = {}, .srgb = false, .gamma_e5 = gamma_e5});
    const Encoding encoding = parse_encoding(stated.word);
    const double exponent = encoding.kind == Encoding::Kind::linear ? 1.0 : encoding.gamma;
    ASSERT_NEAR(1e5 / exponent, gamma_e5, 0.5000001) << stated.word;
  }
}

TEST(StatedEncoding, OurOwnFilesSayNothing) {
  const TempFolder folder;
  Image image(4, 3);
  for (std::int64_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<float>(5000 * i);
  for (const char* name : {"a.png", "a.tif"}) {
    write_integer(folder / name, {{"Y", image.view()}}, {}, {});
    const ImageFile read = read_image(folder / name);
    EXPECT_EQ(read.info.encoding, StatedEncoding()) << name;
    for (std::int64_t i = 0; i < image.size(); ++i) EXPECT_EQ(read.planes[0].data()[i], image.data()[i]);
  }
  write_preview_png(folder / "p.png", {{"Y", image.view()}}, 0.0, 65535.0);
  EXPECT_EQ(read_info(folder / "p.png").encoding, StatedEncoding());
  write_annotated_png(folder / "d.png", image.view(), 0.0, 65535.0, {});
  EXPECT_EQ(read_info(folder / "d.png").encoding, StatedEncoding());
}

using Table = std::vector<std::uint16_t>;

template <class Light>
Table table_of(int bits, const Light& light) {
  Table table(std::size_t{1} << static_cast<unsigned>(bits));
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint16_t>(
        std::lround(65535.0 * light(static_cast<double>(i) / static_cast<double>(table.size() - 1))));
  return table;
}

/// A TIFF of 2 x 2 zeros with these tables, one or three, and this profile.
StatedEncoding tiff_with(int bits, std::vector<Table> tables, const std::string& profile) {
  const TempFolder folder;
  const std::string path = folder / "a.tif";
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  const int colours = tables.size() == 3 ? 3 : 1;
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 2);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 2);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, colours);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 2);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, colours == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  if (colours == 3)
    TIFFSetField(tiff, TIFFTAG_TRANSFERFUNCTION, tables[0].data(), tables[1].data(), tables[2].data());
  else if (!tables.empty())
    TIFFSetField(tiff, TIFFTAG_TRANSFERFUNCTION, tables[0].data());
  if (!profile.empty())
    TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(profile.size()), profile.data());
  std::vector<std::uint8_t> row(static_cast<std::size_t>(2 * colours * bits / 8));
  for (std::uint32_t y = 0; y < 2; ++y) TIFFWriteScanline(tiff, row.data(), y, 0);
  TIFFClose(tiff);
  return read_image(path).info.encoding;
}

/// The parts of a profile that hold its name; ICC.1:2001-04 6.5.17, ICC.1:2022 10.15.
std::string profile_of(const std::string& name, bool version4) {
  using io_test::big_endian;
  const auto u32 = [](std::size_t value) { return big_endian(static_cast<std::uint32_t>(value)); };
  std::string tag = (version4 ? "mluc" : "desc") + u32(0);
  if (version4) {
    tag += u32(1) + u32(12) + "enUS" + u32(2 * name.size()) + u32(28);
    for (const char c : name) tag += std::string(1, '\0') + c;
  } else {
    tag += u32(name.size() + 1) + name + '\0';
  }
  return std::string(128, '\0') + u32(1) + "desc" + u32(144) + u32(tag.size()) + tag;
}

TEST(StatedEncoding, TiffTablesAndProfiles) {
  const auto srgb = [](double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); };
  const auto power = [](double g) { return [g](double v) { return std::pow(v, g); }; };
  for (const int bits : {8, 16}) {
    EXPECT_EQ(tiff_with(bits, {}, ""), StatedEncoding());
    EXPECT_EQ(tiff_with(bits, {table_of(bits, srgb)}, ""), (StatedEncoding{"srgb", "TransferFunction tag"}));
    EXPECT_EQ(tiff_with(bits, {table_of(bits, power(2.2))}, "").word, "gamma:2.2");
    EXPECT_EQ(tiff_with(bits, {table_of(bits, power(0.5))}, "").word, "gamma:0.5");
    EXPECT_EQ(tiff_with(bits, {table_of(bits, power(1.0))}, "").word, "linear");
    const auto odd = [](double v) { return v < 0.5 ? 0.2 * v : 1.8 * v - 0.8; };
    EXPECT_EQ(tiff_with(bits, {table_of(bits, odd)}, ""), (StatedEncoding{"", "TransferFunction tag"}));
    EXPECT_EQ(tiff_with(bits, {Table(std::size_t{1} << static_cast<unsigned>(bits), 0)}, "").word, "");
    const Table red = table_of(bits, srgb), blue = table_of(bits, power(2.2));
    EXPECT_EQ(tiff_with(bits, {red, red, red}, "").word, "srgb");
    EXPECT_EQ(tiff_with(bits, {red, red, blue}, "").word, "");
  }
  for (const bool version4 : {false, true}) {
    EXPECT_EQ(tiff_with(8, {}, profile_of("sRGB IEC61966-2.1", version4)).word, "srgb");
    EXPECT_EQ(tiff_with(8, {}, profile_of("Adobe RGB (1998)", version4)),
              (StatedEncoding{"", "ICC profile \"Adobe RGB (1998)\""}));
  }
  EXPECT_EQ(tiff_with(8, {}, "no profile at all"), (StatedEncoding{"", "ICC profile"}));
}

/// Offsets and lengths in a damaged profile lead nowhere.
TEST(StatedEncoding, DamagedProfilesHaveNoName) {
  const auto name_of = [](const std::string& bytes) {
    return icc_name({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
  };
  for (const bool version4 : {false, true}) {
    const std::string whole = profile_of("sRGB", version4);
    EXPECT_EQ(name_of(whole), "sRGB");
    for (std::size_t length = 0; length < whole.size(); ++length) static_cast<void>(name_of(whole.substr(0, length)));
    for (std::size_t at = 128; at < whole.size(); ++at)
      for (const char value : {'\0', '\x7f', '\xff'}) {
        std::string changed = whole;
        changed[at] = value;
        static_cast<void>(name_of(changed));
      }
  }
}

}  // namespace
}  // namespace mtf::io
