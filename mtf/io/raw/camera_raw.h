// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface to LibRaw, which reads DNG and the files of cameras' makers as what the sensor gave: one count a pixel
// under a mosaic of colour filters, not demosaiced, black not subtracted, white balance and gamma not applied; what a
// camera compressed by a curve is linear again. In a module of its own (mtf/work/module.h, CMake target
// `mtfkit_libraw`), opened when such a file is read.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mtf/work/module.h"

namespace mtf::io {

struct CameraRaw {
  std::string camera;                  ///< "Nikon D810"
  std::string pattern;                 ///< colours of the first two rows of two pixels, "rggb"
  std::int64_t width = 0, height = 0;  ///< of the area that is exposed; masked margins are left out
  std::array<double, 4> black{};       ///< of those four pixels, in counts
  double white = 0.0;                  ///< full scale, in counts
  double pixel_aspect = 1.0;           ///< width over height
  double exposure_s = 0.0, iso = 0.0;  ///< 0 = not stated
  bool turned = false;                 ///< shown in another orientation than stored
};

/// Functions of the module. They throw RuntimeError naming `path`.
struct LibRawCodec {
  ModuleBuild build;
  CameraRaw (*header)(const std::string& path);
  /// Counts of the exposed area, row after row.
  std::vector<std::uint16_t> (*counts)(const std::string& path);
};

/// Whether the name ends as those of such files: their first bytes are often those of TIFF.
bool is_camera_raw(const std::string& path);

}  // namespace mtf::io
