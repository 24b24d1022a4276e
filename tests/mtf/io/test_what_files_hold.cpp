// SPDX-License-Identifier: Apache-2.0
// What a file holds beside the image that is read, and what it says of its values: each is applied, refused or noted.

#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gtest/gtest.h>
#include <tiffio.h>

#include <cmath>
#include <functional>

#include "io_test_files.h"
#include "jpeg_file.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"
#include "png_chunks.h"
#include "tests/expect_error.h"

namespace {

using io_test::TempFolder;
using mtf::io::FileInfo;
using mtf::io::ImageFile;

/// Values 0, 1, 2 ... row by row.
struct TiffPage {
  int width = 4, height = 3, samples = 1, photometric = PHOTOMETRIC_MINISBLACK;
  std::uint32_t kind = 0;  // NewSubfileType
  std::function<void(TIFF*)> more = [](TIFF*) {};
};

template <class T>
void write_page(TIFF* tiff, const TiffPage& page, int format = SAMPLEFORMAT_UINT) {
  TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, page.kind);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, page.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, page.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(T)));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page.samples);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, page.photometric);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, page.height);
  page.more(tiff);
  std::vector<T> row(static_cast<std::size_t>(page.width * page.samples));
  T next{};
  for (int y = 0; y < page.height; ++y) {
    for (T& value : row) value = next++;
    TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0);
  }
  TIFFWriteDirectory(tiff);
}

/// Tags of GDAL and GeoTIFF, which libtiff does not know.
TIFF* create(const std::string& path) {
  static std::string no_data = "GDALNoData", metadata = "GDALMetadata", scale = "ModelPixelScale";
  static const TIFFFieldInfo fields[] = {
      {42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, no_data.data()},
      {42112, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, metadata.data()},
      {33550, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, scale.data()},
  };
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFMergeFieldInfo(tiff, fields, 3);
  return tiff;
}

class TiffHolds : public testing::Test {
 protected:
  template <class T = std::uint16_t>
  FileInfo read(const TiffPage& page, int format = SAMPLEFORMAT_UINT) {
    TIFF* tiff = create(path);
    write_page<T>(tiff, page, format);
    TIFFClose(tiff);
    file = mtf::io::read_image(path);
    return file.info;
  }
  FileInfo read_with(const std::function<void(TIFF*)>& more) { return read({.more = more}); }
  std::string refusal() const {
    return message_of<mtf::RuntimeError>([&] { static_cast<void>(mtf::io::read_info(path)); });
  }
  void expect_refused(std::initializer_list<const char*> parts) const {
    for (const char* part : parts) EXPECT_TRUE(says(refusal(), part)) << part << ": " << refusal();
  }

  TempFolder folder;
  std::string path = folder / "a.tif";
  ImageFile file;
};

// A DNG as cameras write it: the preview comes first, the mosaic is below it.
TEST_F(TiffHolds, APreviewIsNotTheImage) {
  TIFF* tiff = create(path);
  TiffPage preview{
      .width = 8, .height = 8, .samples = 3, .photometric = PHOTOMETRIC_RGB, .kind = FILETYPE_REDUCEDIMAGE};
  preview.more = [](TIFF* t) {
    const std::uint64_t offset = 0;
    const unsigned char version[] = {1, 4, 0, 0};
    TIFFSetField(t, TIFFTAG_SUBIFD, 1, &offset);
    TIFFSetField(t, TIFFTAG_DNGVERSION, version);
  };
  write_page<std::uint8_t>(tiff, preview);
  write_page<std::uint16_t>(tiff, {.width = 20, .height = 16, .photometric = PHOTOMETRIC_CFA});
  TIFFClose(tiff);
  expect_refused(
      {"a.tif", "8 x 8 pixels", "preview", "20 x 16 pixels", "filter array", "SubIFD", "unprocessed_raw -T"});
}

TEST_F(TiffHolds, TheMosaicOfACameraIsNoGreyImage) {
  TIFF* tiff = create(path);
  write_page<std::uint16_t>(tiff, {.photometric = PHOTOMETRIC_CFA});
  TIFFClose(tiff);
  expect_refused({"colour filter array", "unprocessed_raw -T"});
}

TEST_F(TiffHolds, PagesAreCountedAndPreviewsAndMasksRefused) {
  const auto write = [&](std::initializer_list<TiffPage> pages) {
    TIFF* tiff = create(path);
    for (const TiffPage& page : pages) write_page<std::uint8_t>(tiff, page);
    TIFFClose(tiff);
  };
  const TiffPage full{.width = 16, .height = 12}, small{.width = 8, .height = 6, .kind = FILETYPE_REDUCEDIMAGE};
  write({full, small, full});
  EXPECT_TRUE(says(mtf::io::read_info(path).notes, "page 1 of 3") && says(mtf::io::read_info(path).notes, "16 x 12"));
  write({full, small});
  EXPECT_TRUE(says(mtf::io::read_info(path).notes, "page 1 of 2"));
  write({full});
  EXPECT_TRUE(mtf::io::read_info(path).notes.empty());
  expect_says(message_of([&] { mtf::io::read_image(path, {.channel = {}, .layer = {}, .part = 1}); }),
              {"page 2 of a TIFF of 1 page"});
  write({small, full});
  const ImageFile second = mtf::io::read_image(path, {.channel = {}, .layer = {}, .part = 1});
  EXPECT_EQ(second.info.width, 16);
  EXPECT_TRUE(says(second.info.notes, "page 2 of 2"));
  expect_refused({"8 x 6 pixels", "16 x 12 pixels", "page 2", "tiffcp"});
  write({full, {.width = 16, .height = 12, .kind = FILETYPE_MASK}});
  expect_refused({"page 2", "mask of the pixels", "NaN"});
}

TEST_F(TiffHolds, ImagesBelowAreNoted) {
  TIFF* tiff = create(path);
  TiffPage page;
  page.more = [](TIFF* t) {
    const std::uint64_t offset = 0;
    TIFFSetField(t, TIFFTAG_SUBIFD, 1, &offset);
  };
  write_page<std::uint16_t>(tiff, page);
  write_page<std::uint16_t>(tiff, {.width = 20, .height = 16});
  TIFFClose(tiff);
  EXPECT_TRUE(says(mtf::io::read_info(path).notes, "1 images in SubIFDs") &&
              says(mtf::io::read_info(path).notes, "20 x 16"));
}

TEST_F(TiffHolds, NoDataIsNaN) {
  const auto with = [](const char* text) { return [text](TIFF* tiff) { TIFFSetField(tiff, 42113, text); }; };
  EXPECT_EQ(read({.more = with("7")}).no_data, "7 (GDAL_NODATA)");
  EXPECT_TRUE(says(file.info.notes, "value 7 (GDAL_NODATA)"));
  EXPECT_TRUE(file.integer);
  for (int i = 0; i < 12; ++i)
    if (const float value = file.planes[0].data()[i]; i == 7)
      EXPECT_TRUE(std::isnan(value));
    else
      EXPECT_EQ(value, static_cast<float>(i));
  read<float>({.more = with(" 3.0e0 ")}, SAMPLEFORMAT_IEEEFP);
  EXPECT_TRUE(std::isnan(file.planes[0].data()[3]));
  read({.samples = 3, .photometric = PHOTOMETRIC_RGB, .more = with("0")});  // each band by itself
  EXPECT_TRUE(std::isnan(file.planes[0].data()[0]));
  EXPECT_EQ(file.planes[1].data()[0], 1.0F);
  for (const char* nothing : {"-9999", "nan", "70000"}) {
    read({.more = with(nothing)});
    for (int i = 0; i < 12; ++i) EXPECT_EQ(file.planes[0].data()[i], static_cast<float>(i)) << nothing;
  }
  EXPECT_TRUE(says(read({.more = with("none")}).notes, "\"none\" is no number"));
}

TEST_F(TiffHolds, ShapeOfPixels) {
  EXPECT_EQ(read({}).pixel_aspect, 1.0);
  EXPECT_EQ(read_with([](TIFF* tiff) {
              TIFFSetField(tiff, TIFFTAG_XRESOLUTION, 200.0F);
              TIFFSetField(tiff, TIFFTAG_YRESOLUTION, 100.0F);
            }).pixel_aspect,
            0.5);
  EXPECT_EQ(read_with([](TIFF* tiff) {
              const double scale[] = {3.0, 2.0, 0.0};
              TIFFSetField(tiff, 33550, 3, scale);
            }).pixel_aspect,
            1.5);
}

TEST_F(TiffHolds, ScaleAndOffsetOfGdal) {
  const FileInfo info = read_with([](TIFF* tiff) {
    TIFFSetField(tiff, 42112,
                 "<GDALMetadata>\n  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">273.15</Item>\n"
                 "  <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.01</Item>\n</GDALMetadata>\n");
  });
  EXPECT_EQ(info.attributes.at("gain"), "0.01");
  EXPECT_EQ(info.attributes.at("offset"), "273.15");
}

TEST_F(TiffHolds, OtherTags) {
  EXPECT_TRUE(says(read_with([](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_MAXSAMPLEVALUE, 4095); }).notes,
                   "4095 (MaxSampleValue)"));
  EXPECT_TRUE(says(read_with([](TIFF* tiff) {
                     TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, "ImageJ=1.53t\nimages=40\nslices=40\n");
                   }).notes,
                   "1 of the 40"));
  EXPECT_TRUE(says(read({.samples = 4, .photometric = PHOTOMETRIC_RGB}).notes, "further sample"));
  const auto alpha = [](TIFF* tiff) {
    const std::uint16_t kind = EXTRASAMPLE_UNASSALPHA;
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &kind);
  };
  EXPECT_TRUE(says(read({.samples = 4, .photometric = PHOTOMETRIC_RGB, .more = alpha}).notes, "alpha channel"));
  const auto palette = [](TIFF* tiff) {
    std::vector<std::uint16_t> ramp(256);
    for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<std::uint16_t>(257 * i);
    TIFFSetField(tiff, TIFFTAG_COLORMAP, ramp.data(), ramp.data(), ramp.data());
  };
  EXPECT_TRUE(says(read<std::uint8_t>({.photometric = PHOTOMETRIC_PALETTE, .more = palette}).notes, "palette"));
  EXPECT_TRUE(
      says(read<std::uint8_t>({.width = 16,
                               .height = 16,
                               .more = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_JPEG); }})
               .notes,
           "may lose fine structure"));
}

// Colours of 16 bits belong into a palette; some writers fill in their upper half alone, or write those of 8 bits.
TEST_F(TiffHolds, AnyPalette) {
  for (const int factor : {257, 256, 1}) {
    const auto palette = [&](TIFF* tiff) {
      std::vector<std::uint16_t> falling(256), dark(256, 0);
      for (int i = 0; i < 256; ++i)
        falling[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(factor * (255 - i));
      TIFFSetField(tiff, TIFFTAG_COLORMAP, falling.data(), dark.data(), falling.data());
    };
    read<std::uint8_t>({.photometric = PHOTOMETRIC_PALETTE, .more = palette});
    ASSERT_EQ(file.names, (std::vector<std::string>{"R", "G", "B"}));
    for (int i = 0; i < 12; ++i) {
      EXPECT_EQ(file.planes[0].data()[i], 255.0F - float(i)) << factor;
      EXPECT_EQ(file.planes[1].data()[i], 0.0F);
      EXPECT_EQ(file.planes[2].data()[i], 255.0F - float(i));
    }
  }
}

class PngHolds : public testing::Test {
 protected:
  ImageFile read(std::initializer_list<io_test::PngChunk> chunks, int bits = 16) {
    mtf::Image image(4, 1);
    for (int i = 0; i < 4; ++i) image.data()[i] = static_cast<float>(50 * i);
    mtf::io::write_integer(folder / "a.png", {{"Y", image.view()}}, {.bits = bits}, {});
    io_test::add_chunks(folder / "a.png", chunks);
    return mtf::io::read_image(folder / "a.png");
  }
  TempFolder folder;
};

TEST_F(PngHolds, ATransparentGreyIsNoData) {
  for (const int bits : {8, 16}) {
    const ImageFile file = read({{"tRNS", std::string("\0\x64", 2)}}, bits);
    EXPECT_EQ(file.info.no_data, "100 (tRNS)");
    EXPECT_EQ(file.planes[0].data()[1], 50.0F);
    EXPECT_TRUE(std::isnan(file.planes[0].data()[2]));
    EXPECT_EQ(file.planes[0].data()[3], 150.0F);
  }
}

TEST_F(PngHolds, ShapeOfPixelsAndNotes) {
  const auto density = [](std::uint32_t x, std::uint32_t y) {
    return io_test::PngChunk{"pHYs", io_test::big_endian(x) + io_test::big_endian(y) + '\1'};
  };
  EXPECT_EQ(read({density(2000, 4000)}).info.pixel_aspect, 2.0);
  EXPECT_EQ(read({density(2835, 2834)}).info.pixel_aspect, 1.0);  // rounding
  EXPECT_TRUE(says(read({{"sBIT", "\x0c"}}).info.notes, "12 bits of each"));
  EXPECT_TRUE(says(read({{"acTL", io_test::big_endian(5) + io_test::big_endian(0)}}).info.notes, "5 images of"));
  const std::string exif("II*\0\x08\0\0\0\1\0\x12\x01\3\0\1\0\0\0\6\0\0\0\0\0\0\0", 26);
  EXPECT_TRUE(says(read({{"eXIf", exif}}).info.notes, "Exif 6"));
  EXPECT_TRUE(read({}).info.notes.empty());
}

class JpegHolds : public testing::Test {
 protected:
  FileInfo read(const std::string& segments, const std::string& behind = "") {
    mtf::Image image(16, 8);
    std::fill(image.data(), image.data() + image.size(), 100.0F);
    const std::string bytes = io_test::JpegWriter::make(image.view(), io_test::jpeg_steps(90), false, segments);
    io_test::write_bytes(folder / "a.jpg", bytes + behind);
    return mtf::io::read_image(folder / "a.jpg").info;
  }
  static std::string segment(int marker, const std::string& data) { return io_test::JpegWriter::segment(marker, data); }
  TempFolder folder;
};

TEST_F(JpegHolds, ShapeOfPixels) {
  EXPECT_EQ(read(segment(0xe0, std::string("JFIF\0\1\2\0\0\1\0\2\0\0", 14))).pixel_aspect, 2.0);
  EXPECT_EQ(read(segment(0xe0, std::string("JFIF\0\1\2\1\0\x48\0\x48\0\0", 14))).pixel_aspect, 1.0);
}

TEST_F(JpegHolds, OrientationRawCountsAndFurtherImages) {
  const std::string tiff("MM\0*\0\0\0\x08\0\1\x01\x12\0\3\0\0\0\1\0\3\0\0\0\0\0\0", 26);
  EXPECT_TRUE(says(read(segment(0xe1, std::string("Exif\0\0", 6) + tiff)).notes, "Exif 3"));
  const FileInfo flir =
      read(segment(0xe1, std::string("FLIR\0\1\0\1FFF", 11)) + segment(0xe1, std::string("FLIR\0\1\1\1", 8)));
  EXPECT_TRUE(says(flir.notes, "counts of a thermal camera"));
  EXPECT_EQ(flir.notes.size(), 1U);
  const std::string index("II*\0\x08\0\0\0\1\0\x01\xb0\4\0\1\0\0\0\3\0\0\0\0\0\0\0", 26);
  EXPECT_TRUE(says(read(segment(0xe2, std::string("MPF\0", 4) + index)).notes, "of 3 images (MPF)"));
  EXPECT_TRUE(
      says(read(segment(0xe3, std::string(50, 'r')) + segment(0xe3, std::string(40, 'r'))).notes, "90 bytes in"));
  EXPECT_TRUE(says(read("", "another image").notes, "13 bytes after"));
  EXPECT_TRUE(read("", std::string(64, '\0')).notes.empty());
}

class ExrHolds : public testing::Test {
 protected:
  FileInfo read(const Imf::Header& header, const std::vector<std::string>& channels = {"Y"}) {
    io_test::write_scanline(path, header, channels);
    return mtf::io::read_image(path).info;
  }
  TempFolder folder;
  std::string path = folder / "a.exr";
};

TEST_F(ExrHolds, ShapeOfPixelsAndNotes) {
  Imf::Header header(8, 4);
  EXPECT_TRUE(read(header).notes.empty());
  header.pixelAspectRatio() = 2.0F;
  EXPECT_EQ(read(header).pixel_aspect, 2.0);
  header.insert("oiio:ColorSpace", Imf::StringAttribute("sRGB"));
  EXPECT_TRUE(says(read(header).notes, "oiio:ColorSpace is sRGB"));
  header.insert("oiio:ColorSpace", Imf::StringAttribute("Linear"));
  EXPECT_TRUE(read(header).notes.empty());
  Imf::addMultiView(header, {"left", "right"});
  EXPECT_TRUE(says(read(header, {"Y", "right.Y"}).notes, "views left,right"));
  Imf::addEnvmap(header, Imf::ENVMAP_LATLONG);
  Imf::addWhiteLuminance(header, 80.0F);
  EXPECT_TRUE(says(read(header).notes, "envmap"));
  EXPECT_TRUE(says(read(header).notes, "80 cd/m2"));
}

TEST_F(ExrHolds, CompressionWithALoss) {
  Imf::Header header(8, 4);
  for (const auto& [compression, loses] : {std::pair{Imf::DWAA_COMPRESSION, true},
                                           {Imf::PXR24_COMPRESSION, true},
                                           {Imf::B44_COMPRESSION, false},  // of float it keeps all
                                           {Imf::PIZ_COMPRESSION, false}}) {
    header.compression() = compression;
    EXPECT_EQ(says(read(header).notes, "compressed with a loss"), loses) << compression;
  }
}

// The attributes of another part are not those of the image that is read.
TEST_F(ExrHolds, AttributesOfThePartThatIsRead) {
  std::vector<Imf::Header> headers;
  for (const char* name : {"counts", "kelvin"}) {
    Imf::Header& header = headers.emplace_back(4, 3);
    header.setName(name);
    header.setType(Imf::SCANLINEIMAGE);
    header.insert("mtf:quantity", Imf::StringAttribute(name));
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
  }
  headers[0].insert("owner", Imf::StringAttribute("somebody"));
  {
    Imf::MultiPartOutputFile out(path.c_str(), headers.data(), 2);
    for (int part = 0; part < 2; ++part) {
      std::vector<float> values = io_test::samples(headers[0].dataWindow());
      Imf::FrameBuffer buffer;
      buffer.insert("Y", io_test::slice_of(values, headers[0].dataWindow()));
      Imf::OutputPart output(out, part);
      output.setFrameBuffer(buffer);
      output.writePixels(3);
    }
  }
  const FileInfo info = mtf::io::read_image(path, {.channel = {}, .layer = {}, .part = 1}).info;
  EXPECT_EQ(info.attributes.at("mtf:quantity"), "kelvin");
  EXPECT_EQ(info.attributes.at("owner"), "somebody");
}

}  // namespace
