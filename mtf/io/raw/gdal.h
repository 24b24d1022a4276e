// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface to GDAL, which reads NITF, HDF5 and JPEG 2000. Its library loads a hundred others, so the functions of
// this table are in a module of its own (mtf/work/module.h, CMake target `mtfkit_gdal`), opened when such a file is
// read.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mtf/work/module.h"

namespace mtf::io {

struct GdalBand {
  std::string name;  ///< "" without one
  char kind = 'f';   ///< as NumberType has it
  int bytes = 4;
  double gain = 1.0, offset = 0.0;
  std::optional<double> no_data{};
};

struct GdalImage {
  std::string format;  ///< as GDAL calls it, "National Imagery Transmission Format"
  std::string name;    ///< of the image in a file that has several, "" = the only one
  std::int64_t width = 0, height = 0;
  std::vector<GdalBand> bands{};
  /// x = t0 + t1 column + t2 row, y = t3 + t4 column + t5 row of the outer corner of the first pixel, in the system.
  std::optional<std::array<double, 6>> geotransform{};
  std::string coordinate_system{};  ///< as text, "" = none
  std::shared_ptr<void> dataset{};  ///< one thread at a time
};

/// Functions of the module. They throw RuntimeError naming `path`.
struct Gdal {
  ModuleBuild build;
  /// The images of the file, each of at least one band, with its number among them: that one which is asked for, or
  /// all. Reads no pixels. UsageError where all are too many to be open at a time.
  std::vector<std::pair<int, GdalImage>> (*open)(const std::string& path, std::optional<int> number);
  /// Samples of a band (from 0), `width` a row, as they are stored.
  void (*read)(void* dataset, const std::string& path, int band, std::int64_t x, std::int64_t y, std::int64_t width,
               std::int64_t height, double* out);
};

}  // namespace mtf::io
