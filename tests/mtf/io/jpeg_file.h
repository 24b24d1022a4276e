// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes baseline JPEG files with quantisation steps of one's own (ITU-T T.81). The Huffman codes have one length each,
// 4 bits for DC and 8 for AC: larger files than others, and just as valid.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "mtf/image.h"

namespace io_test {

using JpegSteps = std::array<int, 64>;  ///< row-major

/// Table K.1 of T.81 at a quality of 1 to 100, as the Independent JPEG Group scales it.
inline JpegSteps jpeg_steps(int quality) {
  JpegSteps steps{16, 11,  10,  16, 24, 40, 51, 61, 12,  12,  14,  19,  26, 58, 60, 55,  14,  13,  16,  24, 40, 57,
                  69, 56,  14,  17, 22, 29, 51, 87, 80,  62,  18,  22,  37, 56, 68, 109, 103, 77,  24,  35, 55, 64,
                  81, 104, 113, 92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98,  112, 100, 103, 99};
  const int scale = quality < 50 ? 5000 / quality : 200 - 2 * quality;
  for (int& step : steps) step = std::clamp((step * scale + 50) / 100, 1, 255);
  return steps;
}

class JpegWriter {
 public:
  /// Stored values 0 to 255. `colour`: with two chroma planes of half the resolution, all grey. `segments`: written
  /// before the frame.
  static std::string make(mtf::ImageView<const float> image, const JpegSteps& steps, bool colour = false,
                          const std::string& segments = "") {
    JpegWriter writer(steps);
    const auto component = [](char name, char sampling) { return std::string{name, sampling, '\0'}; };
    std::string table(1, '\0');
    for (const int at : writer.zigzag_) table += static_cast<char>(steps[static_cast<std::size_t>(at)]);
    std::string frame = "\x08" + two(image.height) + two(image.width) + (colour ? '\x03' : '\x01');
    frame += component(1, colour ? '\x22' : '\x11');
    std::string scan = (colour ? "\x03" : "\x01") + std::string{'\x01', '\0'};
    for (char name = 2; colour && name <= 3; ++name) {
      frame += component(name, '\x11');
      scan += std::string{name, '\0'};
    }
    std::string file = "\xff\xd8" + segments + segment(0xdb, table) + segment(0xc0, frame) + writer.huffman_tables() +
                       segment(0xda, scan + std::string{'\0', '\x3f', '\0'});
    const std::int64_t unit = colour ? 16 : 8;
    for (std::int64_t y = 0; y < image.height; y += unit)
      for (std::int64_t x = 0; x < image.width; x += unit) {
        for (std::int64_t v = y; v < y + unit; v += 8)
          for (std::int64_t u = x; u < x + unit; u += 8) writer.add_block(image, u, v);
        for (int chroma = 0; colour && chroma < 2; ++chroma) writer.add_bits(0, 4), writer.add_bits(0, 8);
      }
    writer.add_bits(0x7f, 7);  // fills the last byte
    return file + writer.data_ + "\xff\xd9";
  }
  static std::string segment(int marker, const std::string& data) {
    return std::string{'\xff', static_cast<char>(marker)} + two(static_cast<std::int64_t>(data.size()) + 2) + data;
  }

 private:
  explicit JpegWriter(const JpegSteps& steps) : steps_(steps) {
    std::size_t k = 0;
    for (int sum = 0; sum <= 14; ++sum)
      for (int i = 0; i <= sum; ++i) {
        const int row = sum % 2 == 0 ? sum - i : i, column = sum - row;
        if (row < 8 && column < 8) zigzag_[k++] = 8 * row + column;
      }
    ac_ = {0x00, 0xf0};
    for (int run = 0; run < 16; ++run)
      for (int size = 1; size <= 10; ++size) ac_.push_back(run << 4 | size);
  }
  static std::string two(std::int64_t value) {
    return {static_cast<char>(value >> 8 & 0xff), static_cast<char>(value & 0xff)};
  }
  std::string huffman_tables() const {
    std::string dc(17, '\0'), ac(17, '\0');
    dc[4] = 12;
    for (char size = 0; size < 12; ++size) dc += size;
    ac[0] = 0x10;
    ac[8] = static_cast<char>(ac_.size());
    for (const int symbol : ac_) ac += static_cast<char>(symbol);
    return segment(0xc4, dc) + segment(0xc4, ac);
  }
  void add_bits(unsigned value, int count) {
    for (int bit = count - 1; bit >= 0; --bit) {
      byte_ = byte_ << 1U | (value >> static_cast<unsigned>(bit) & 1U);
      if (++bits_ < 8) continue;
      data_ += static_cast<char>(byte_ & 0xffU);
      if ((byte_ & 0xffU) == 0xffU) data_ += '\0';
      byte_ = 0;
      bits_ = 0;
    }
  }
  static int size_of(int value) {
    int size = 0;
    for (int rest = std::abs(value); rest > 0; rest /= 2) ++size;
    return size;
  }
  void add_value(int value, int size) {
    add_bits(static_cast<unsigned>(value < 0 ? value + (1 << size) - 1 : value), size);
  }
  void add_ac(int symbol) {
    add_bits(static_cast<unsigned>(std::find(ac_.begin(), ac_.end(), symbol) - ac_.begin()), 8);
  }
  void add_block(mtf::ImageView<const float> image, std::int64_t x, std::int64_t y) {
    static const auto cosine = [] {
      std::array<std::array<double, 8>, 8> table{};
      for (std::size_t u = 0; u < 8; ++u)
        for (std::size_t i = 0; i < 8; ++i)
          table[u][i] = (u == 0 ? std::sqrt(0.125) : 0.5) * std::cos((2.0 * static_cast<double>(i) + 1.0) *
                                                                     static_cast<double>(u) * std::numbers::pi / 16.0);
      return table;
    }();
    std::array<int, 64> coefficient{};
    for (std::size_t v = 0; v < 8; ++v)
      for (std::size_t u = 0; u < 8; ++u) {
        double sum = 0.0;
        for (std::size_t j = 0; j < 8; ++j)
          for (std::size_t i = 0; i < 8; ++i)
            sum += cosine[v][j] * cosine[u][i] *
                   (std::round(image.at(std::min(x + static_cast<std::int64_t>(i), image.width - 1),
                                        std::min(y + static_cast<std::int64_t>(j), image.height - 1))) -
                    128.0);
        coefficient[8 * v + u] = static_cast<int>(std::lround(sum / steps_[8 * v + u]));
      }
    const int difference = coefficient[0] - last_;
    last_ = coefficient[0];
    add_bits(static_cast<unsigned>(size_of(difference)), 4);
    add_value(difference, size_of(difference));
    int run = 0;
    for (std::size_t k = 1; k < 64; ++k) {
      const int value = coefficient[static_cast<std::size_t>(zigzag_[k])];
      if (value == 0) {
        ++run;
        continue;
      }
      for (; run > 15; run -= 16) add_ac(0xf0);
      add_ac(run << 4 | size_of(value));
      add_value(value, size_of(value));
      run = 0;
    }
    if (run > 0) add_ac(0x00);
  }

  JpegSteps steps_;
  std::array<int, 64> zigzag_{};
  std::vector<int> ac_;
  std::string data_;
  unsigned byte_ = 0;
  int bits_ = 0, last_ = 0;
};

inline void write_jpeg(const std::string& path, mtf::ImageView<const float> image, const JpegSteps& steps,
                       bool colour = false, const std::string& segments = "") {
  std::ofstream(path, std::ios::binary) << JpegWriter::make(image, steps, colour, segments);
}

}  // namespace io_test
