// SPDX-License-Identifier: Apache-2.0
#pragma once

// Files for the I/O tests: a folder that goes away, the shared data, OpenEXR files written with the library itself.

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/expect_error.h"

namespace io_test {

namespace fs = std::filesystem;

/// A new empty folder, removed with all it holds at the end of the scope.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (fs::temp_directory_path() / "mtfkit_io_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TempFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }

 private:
  fs::path path_;
};

/// The shared test data, empty when they are not there.
inline fs::path shared_data() {
  const char* chosen = std::getenv("MTFKIT_SHARED");
  fs::path shared = fs::path(__FILE__).parent_path() / "../../../../shared";
  if (chosen != nullptr) shared = chosen;
  return fs::is_directory(shared / "data") ? shared / "data" : fs::path();
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// A sample that differs in every pixel and is exact in half precision (below 2048 steps).
inline float sample(std::int64_t x, std::int64_t y) { return static_cast<float>((x * 7 + y * 13) % 2048) * 0.25F; }

/// Samples of a data window, first row first.
inline std::vector<float> samples(const Imath::Box2i& window) {
  std::vector<float> values;
  for (int y = window.min.y; y <= window.max.y; ++y)
    for (int x = window.min.x; x <= window.max.x; ++x) values.push_back(sample(x, y));
  return values;
}

/// A frame buffer slice over samples of `window`.
inline Imf::Slice slice_of(std::vector<float>& values, const Imath::Box2i& window) {
  return Imf::Slice::Make(Imf::FLOAT, values.data(), window);
}

/// A scan-line file with float channels that all hold `sample`.
inline void write_scanline(const std::string& path, Imf::Header header, const std::vector<std::string>& channels) {
  std::vector<float> values = samples(header.dataWindow());
  Imf::FrameBuffer buffer;
  for (const std::string& name : channels) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, slice_of(values, header.dataWindow()));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(header.dataWindow().max.y - header.dataWindow().min.y + 1);
}

}  // namespace io_test
