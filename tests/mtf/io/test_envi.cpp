// SPDX-License-Identifier: Apache-2.0
// ENVI headers that cannot be read, windows, and images that are written. What numbers are read is a test of Python
// (tests/python/test_bare_numbers.py), against numpy.
#include "mtf/io/raw/envi.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mtf/error.h"
#include "mtf/io/image_windows.h"
#include "mtf/io/scene.h"
#include "mtf/words.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"
#include "tests/replaced.h"

namespace {

using io_test::TempFolder;
using io_test::write_bytes;
using mtf::RuntimeError;
using mtf::UsageError;

const std::string kHeader =
    "ENVI\nsamples = 4\nlines = 3\nbands = 2\nheader offset = 0\ndata type = 2\ninterleave = bsq\nbyte order = 0\n";

class Envi : public testing::Test {
 protected:
  /// The error of a header, beside numbers of 4 x 3 pixels, 2 bands, 2 bytes.
  void expect_header_refused(const std::string& header, std::initializer_list<std::string_view> parts) const {
    write_bytes(hdr, header);
    write_bytes(img, std::string(48, '\1'));
    expect_refused<RuntimeError>(parts, [&] { mtf::io::read_info(hdr); });
    expect_refused<RuntimeError>(parts, [&] { mtf::io::read_image(img); });
  }
  void expect_line_refused(const std::string& line, const std::string& instead,
                           std::initializer_list<std::string_view> parts) const {
    expect_header_refused(replaced(kHeader, line, instead), parts);
  }
  const TempFolder folder;
  const std::string hdr = folder / "an image.hdr", img = folder / "an image.img";
};

TEST_F(Envi, HeadersThatCannotBeReadNameTheKey) {
  for (const std::string key : {"samples", "lines", "bands", "data type", "interleave", "byte order"})
    expect_line_refused(key + " =", "; ", {"an image.hdr", "'" + key + "' is missing", "add it"});
  expect_line_refused("samples = 4", "samples = -4", {"an image.hdr:2", "samples = -4", "whole number"});
  expect_line_refused("lines = 3", "lines = 3.5", {"hdr:3", "lines", "whole number"});
  expect_line_refused("bands = 2", "bands = 99999999999", {"hdr:4", "bands", "whole number"});
  expect_line_refused("lines = 3", "lines = 4", {"48 bytes", "cut off"});
  expect_line_refused("samples = 4", "samples = 1048576", {"cut off"});
  expect_header_refused(replaced(replaced(kHeader, "samples = 4", "samples = 1048576"), "lines = 3", "lines = 1048576"),
                        {"2^31 pixels"});
  expect_line_refused("header offset = 0", "header offset = 1", {"48 bytes", "cut off"});
  expect_line_refused("data type = 2", "data type = 6", {"data type = 6", "complex"});
  expect_line_refused("data type = 2", "data type = 7", {"data type = 7", "1 to 5"});
  expect_line_refused("interleave = bsq", "interleave = bsx", {"interleave", "bil"});
  expect_line_refused("byte order = 0", "byte order = 0\nbyte order = 1", {"hdr:9", "twice"});
  expect_line_refused("byte order = 0", "byte order = 0\nwhat", {"hdr:9", "no line"});
  for (const auto& [line, part] : {std::pair{"band names = {a, b", "never closed"},
                                   {"band names = {a}", "2 bands"},
                                   {"data gain values = {1, x}", "no number"},
                                   {"data gain values = {1, 0}", "gain of 0"},
                                   {"data ignore value = none", "data ignore value"},
                                   {"file compression = 1", "compressed"},
                                   {"major frame offsets = {0, 16}", "major frame offsets"},
                                   {"wavelength = {500, 600}", "'wavelength units' is missing"},
                                   {"wavelength units = Unknown\nwavelength = {500, 600}", "Nanometers"},
                                   {"wavelength units = Nanometers\nwavelength = {500, 0}", "above 0"}})
    expect_header_refused(kHeader + line + "\n", {"an image.hdr", part});
}

TEST_F(Envi, NumbersOfAHeaderAreFoundOrAskedFor) {
  write_bytes(hdr, kHeader);
  expect_refused<RuntimeError>({"an image.hdr", "not beside it", "put them there"}, [&] { mtf::io::read_info(hdr); });
  write_bytes(img, std::string(60, '\1'));
  EXPECT_TRUE(says(mtf::io::read_info(hdr).notes, "12 bytes"));
  write_bytes(folder / "an image.DAT", std::string(48, '\1'));
  expect_refused({"an image.img", "an image.DAT", "name the one"}, [&] { mtf::io::read_info(hdr); });
  EXPECT_EQ(mtf::io::read_info(img).width, 4);
  expect_refused({"band 1", "band 2", "--channel"}, [&] { mtf::io::read_image(img); });
  io_test::fs::remove(hdr);
  expect_refused<RuntimeError>({"none of OpenEXR", "ENVI header"}, [&] { mtf::io::read_info(img); });
}

TEST_F(Envi, WindowsEqualTheWholeImage) {
  std::string bytes;
  for (int i = 0; i < 4 * 3 * 2; ++i) bytes += {static_cast<char>(i * 7), static_cast<char>(i)};
  write_bytes(img, bytes);
  for (const std::string interleave : {"bsq", "bil", "bip"}) {
    write_bytes(hdr, replaced(kHeader, "bsq", interleave));
    for (const std::string band : {"band 1", "band 2"}) {
      const mtf::io::ImageFile whole = mtf::io::read_image(hdr, {.channel = band});
      const mtf::io::ImageWindows windows(img, {.channel = band});
      mtf::Image part(2, 2);
      windows.read(0, 1, 1, part.view());
      for (int i = 0; i < 4; ++i)
        EXPECT_EQ(part.at(i % 2, i / 2), whole.planes[0].at(1 + i % 2, 1 + i / 2)) << interleave << " " << band;
    }
  }
  const mtf::io::ImageWindows windows(img, {.channel = "band 2"});
  io_test::fs::resize_file(img, 40);
  mtf::Image rows(4, 3);
  expect_refused<RuntimeError>({"an image.img", "shorter"}, [&] { windows.read(0, 0, 0, rows.view()); });
}

// What float32 changes is counted a second time here, from the numbers themselves.
TEST_F(Envi, RoundingToFloatIsSaidOrRefused) {
  const auto write = [&](auto base, const std::string& type, const std::string& more) {
    std::vector<decltype(base)> numbers(100 * 100);
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = base + static_cast<decltype(base)>(i * i % 1009);
    write_bytes(img, std::string(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof base));
    write_bytes(hdr, "ENVI\nsamples = 100\nlines = 100\nbands = 1\ninterleave = bsq\nbyte order = 0\ndata type = " +
                         type + "\n" + more);
    double sum = 0.0, squares = 0.0, errors = 0.0;
    for (const auto number : numbers) {
      const auto value = static_cast<double>(number - base);
      sum += value, squares += value * value;
      errors += std::pow(static_cast<double>(number) - static_cast<double>(static_cast<float>(number)), 2);
    }
    return std::sqrt(errors / (squares - sum * sum / 1e4));
  };
  for (const double base : {1e6 + 0.32, 1e5 + 0.123}) {
    const double share = write(base, "5", "");
    EXPECT_EQ(share > 1e-5, base > 5e5);
    const std::vector<std::string> notes = mtf::io::read_image(img).info.notes;
    EXPECT_EQ(says(notes, mtf::significant(100.0 * share, 2) + " % (rms)"), share > 1e-5);
    EXPECT_EQ(notes.size(), share > 1e-5 ? 1U : 0U);
    EXPECT_EQ(mtf::io::ImageWindows(img, {}).file().info.notes, notes);
  }
  const auto refused = [&](const std::string& share) {
    expect_refused<RuntimeError>({"an image", share + " %", "constant"}, [&] { mtf::io::read_image(img); });
    expect_refused<RuntimeError>({share + " %"}, [&] { mtf::io::ImageWindows(img, {}); });
  };
  const double share = write(std::int32_t{1'000'000'000}, "3", "");
  refused(mtf::significant(100.0 * share, 2));
  // An offset of the file comes before the rounding, in the digits of the numbers.
  write(std::int32_t{1'000'000'000}, "3", "data offset values = {-1e9}\n");
  mtf::io::ImageFile file = mtf::io::read_image(img);
  EXPECT_EQ(file.planes[0].at(50, 1), static_cast<float>(150 * 150 % 1009));
  EXPECT_FALSE(says(file.info.notes, "float32"));
  write(std::uint64_t{1} << 60U, "15", "data offset values = {-1152921504606846976}\n");
  EXPECT_EQ(mtf::io::read_image(img).planes[0].at(50, 1), static_cast<float>(150 * 150 % 1009));
  write(1e300, "5", "");
  EXPECT_TRUE(says(mtf::io::read_image(img).info.notes, "10000 values beyond the 3.4e38"));
  write_bytes(img, std::string(100 * 100 * 8, '\x3f'));  // flat, and no float
  EXPECT_TRUE(mtf::io::read_image(img).info.notes.empty());
}

TEST_F(Envi, SpectraNeedTheirUnit) {
  write_bytes(img, std::string(48, '\1'));
  write_bytes(hdr, replaced(kHeader, "data type = 2", "data type = 1") +
                       "wavelength units = um\nwavelength = {4, 3.5}\nmap info = {x, 1, 1, 0, 0, 30, 15}\n");
  mtf::io::SensorConfig sensor;
  sensor.file = "s.toml";
  sensor.scene.sample_x_um = 2.0, sensor.scene.sample_y_um = 1.0;
  sensor.scene.quantity = mtf::io::Quantity::spectral_radiance;
  expect_refused({"gain", "offset", "s.toml"}, [&] { load_scene(sensor, hdr, {}); });
  sensor.scene.gain = 3.0, sensor.scene.offset = 1.0;
  const mtf::io::Scene scene = load_scene(sensor, hdr, {});
  EXPECT_EQ(scene.wavelength_um, (std::vector{3.5, 4.0}));
  EXPECT_EQ(scene.planes[0].at(0, 0), 4.0F);
  sensor.scene.sample_x_um = 1.0;  // pixels are twice as wide as high
  expect_refused({"2 times as wide"}, [&] { load_scene(sensor, hdr, {}); });
}

TEST_F(Envi, AttributesThatAreKeysOfItsOwnAreNotWritten) {
  const mtf::Image plane(2, 2);
  for (const std::string name : {"Samples", "a = b"}) {
    mtf::io::Metadata metadata;
    metadata.text[name] = "1";
    expect_refused({hdr, name, "rename"}, [&] { mtf::io::write_floats(hdr, {{"Y", plane.view()}}, metadata); });
  }
  EXPECT_EQ(folder.entries(), 0U);
}

}  // namespace
