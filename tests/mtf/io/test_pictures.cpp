// SPDX-License-Identifier: Apache-2.0
// PGM, PPM and BMP that cannot be read, and the scale of their values; tests/python/test_bare_numbers.py reads the
// others, against numpy.
#include <gtest/gtest.h>

#include "mtf/error.h"
#include "mtf/io/codecs/encoding.h"
#include "tests/expect_error.h"
#include "tests/mtf/io/io_test_files.h"

namespace {

class Pictures : public testing::Test {
 protected:
  void refused(const std::string& bytes, std::initializer_list<std::string_view> parts) const {
    io_test::write_bytes(path, bytes);
    expect_refused<mtf::RuntimeError>(parts, [&] { mtf::io::read_image(path); });
  }
  const io_test::TempFolder folder;
  const std::string path = folder / "a picture";
};

TEST_F(Pictures, GreyMapsThatCannotBeReadSayWhy) {
  refused("P5 4 3 255\n" + std::string(11, 'x'), {"a picture", "cut off"});
  refused("P5 1048576 1048576 255\n0", {"2^31 pixels"});
  refused("P6 1048576 1024 255\n0", {"3 planes", "cut off"});
  refused("P5 -4 3 255\n" + std::string(12, 'x'), {"no pixels"});
  refused("P5 4 3 70000\n" + std::string(24, 'x'), {"65535"});
  refused("P5 4 3", {"largest value", "P5"});
  refused("P2 2 2 9\n1 2 3   ", {"sample 4 of 4", "missing"});
  refused("P2 2 2 9\n1 2 3 10", {"sample 4", "above"});
  refused("P2 1048576 1024 9\n1", {"cut off"});
  refused("P5 2 2 9\n\1\2\3\n", {"row 1", "above"});
  refused("P4 2 2\nxx", {"none of OpenEXR"});
  io_test::write_bytes(path, "P5 2 1 4095\n" + std::string(6, '\1'));
  const mtf::io::FileInfo info = mtf::io::read_info(path);
  EXPECT_EQ(mtf::io::full_scale(info), 4095.0);
  EXPECT_TRUE(says(info.notes, "2 bytes"));
}

TEST_F(Pictures, BitmapsThatCannotBeReadSayWhy) {
  std::string bmp("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\2\0\0\0\2\0\0\0\1\0\x18\0", 30);
  bmp += std::string(24 + 16, '\0');
  io_test::write_bytes(path, bmp);
  EXPECT_EQ(mtf::io::read_image(path).planes.size(), 3U);
  refused(bmp.substr(0, 69), {"a picture", "cut off"});
  const auto with = [&](std::size_t at, char value) { return std::string(bmp).replace(at, 1, 1, value); };
  refused(with(30, '\1'), {"compression 1", "PNG"});
  refused(with(10, '\x20'), {"byte 32", "headers of 54"});
  refused(with(28, '\4'), {"4 bits a pixel", "PNG"});
  refused(with(21, '\x7f'), {"2^31 pixels"});
  refused(with(21, '\xff'), {"no pixels"});
  refused(with(28, '\b') + std::string(1024, '\7'), {"palette", "PNG"});
}

TEST_F(Pictures, ScalesOfTypes) {
  for (const auto& [type, least, most] : {std::tuple{"int8", -128.0, 127.0},
                                          {"int16", -32768.0, 32767.0},
                                          {"uint32", 0.0, 4294967295.0},
                                          {"int32", -2147483648.0, 2147483647.0}}) {
    mtf::io::FileInfo info;
    info.channels.emplace_back().type = type;
    EXPECT_EQ(mtf::io::full_scale(info), most) << type;
    EXPECT_EQ(mtf::io::least_stored(info), least) << type;
  }
}

}  // namespace
