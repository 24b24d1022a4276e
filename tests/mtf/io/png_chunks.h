// SPDX-License-Identifier: Apache-2.0
#pragma once

// Chunks put into a PNG that is there: what editors and cameras write beside the pixels.

#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>
#include <utility>

namespace io_test {

inline std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (const unsigned shift : {24U, 16U, 8U, 0U}) bytes += static_cast<char>(value >> shift & 0xffU);
  return bytes;
}

/// CRC of the PNG specification, annex D, bit by bit.
inline std::uint32_t png_crc(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? 0xedb88320U ^ crc >> 1U : crc >> 1U;
  }
  return ~crc;
}

using PngChunk = std::pair<std::string, std::string>;  // type, data

inline PngChunk srgb_chunk() { return {"sRGB", std::string(1, '\0')}; }
inline PngChunk gamma_chunk(std::uint32_t gamma_e5) { return {"gAMA", big_endian(gamma_e5)}; }
/// The name alone counts; the profile itself is left out.
inline PngChunk profile_chunk(const std::string& name) { return {"iCCP", name + std::string(2, '\0')}; }
inline PngChunk cicp_chunk(char transfer) { return {"cICP", {'\x01', transfer, '\0', '\x01'}}; }

/// Behind the header, where the specification wants those that tell of colour.
inline void add_chunks(const std::string& path, std::initializer_list<PngChunk> chunks) {
  std::ifstream in(path, std::ios::binary);
  std::string png{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::string added;
  for (const auto& [type, data] : chunks)
    added += big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(png_crc(type + data));
  constexpr std::size_t header_end = 8 + 25;
  png.insert(header_end, added);
  std::ofstream(path, std::ios::binary) << png;
}

}  // namespace io_test
