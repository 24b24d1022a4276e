// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/file_checks.h"

#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "mtf/error.h"
#include "mtf/words.h"
#include "mtf/work/usable_memory.h"

namespace mtf::io {

std::int64_t ordinary_file_size(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    throw RuntimeError("cannot read " + path + ": " + std::generic_category().message(errno) + "; check the path");
  if (S_ISDIR(status.st_mode)) throw RuntimeError("cannot read " + path + ": it is a folder; name a file in it");
  if (!S_ISREG(status.st_mode))
    throw RuntimeError("cannot read " + path +
                       ": it is not an ordinary file, but a pipe or a device; store what it gives in a file first");
  return status.st_size;
}

std::int64_t input_file_size(const std::string& path) {
  const std::int64_t size = ordinary_file_size(path);
  if (size == 0) throw RuntimeError("cannot read " + path + ": the file is empty; copy or export it again");
  return size;
}

void check_plane_pixels(const std::string& path, std::int64_t width, std::int64_t height) {
  if (width <= 0 || height <= 0) throw RuntimeError(path + ": the image has no pixels; export the file again");
  if (static_cast<double>(width) * static_cast<double>(height) > static_cast<double>(max_plane_pixels))
    throw RuntimeError(path + ": an image of " + std::to_string(width) + " x " + std::to_string(height) +
                       " pixels needs " + shown_bytes(static_cast<double>(width) * static_cast<double>(height) * 4.0) +
                       " a plane; the limit is 2^31 pixels a plane: crop the image or cut it into pieces");
}

void check_plane_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t planes) {
  const double pixels = static_cast<double>(width) * static_cast<double>(height);
  const double bytes = pixels * static_cast<double>(planes) * sizeof(float);
  const UsableMemory memory = usable_memory();
  const std::string size = path + ": an image of " + std::to_string(width) + " x " + std::to_string(height) +
                           " pixels needs " + shown_bytes(bytes) + " for " + std::to_string(planes) + " plane(s)";
  check_plane_pixels(path, width, height);
  if (bytes > memory.bytes)
    throw RuntimeError(size + "; " + memory.whose + " " + shown_bytes(memory.bytes) +
                       ": crop it or choose one channel");
}

void check_raster_size(const std::string& path, const std::string& what, std::int64_t width, std::int64_t height) {
  constexpr std::int64_t max_side = 1 << 20;
  if (width <= max_side && height <= max_side && width * height <= max_plane_pixels / 2) return;
  throw RuntimeError(path + ": a " + what + " of " + std::to_string(width) + " x " + std::to_string(height) +
                     " pixels needs " + shown_bytes(static_cast<double>(width) * static_cast<double>(height) * 4) +
                     " a plane; the limit is 2^30 pixels and 2^20 a side: crop it, or store the image as OpenEXR");
}

void check_compression(const std::string& path, double data_bytes, std::int64_t file_bytes, double ratio) {
  if (data_bytes <= static_cast<double>(file_bytes) * ratio) return;
  throw RuntimeError(path + ": damaged or incomplete: its header announces " + shown_bytes(data_bytes) +
                     " of pixels, which a file of " + shown_bytes(static_cast<double>(file_bytes)) +
                     " cannot hold; copy or export the file again");
}

std::string shown_bytes(double bytes) {
  constexpr std::array units{"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  std::size_t unit = 0;
  while (bytes >= 1024 && unit + 1 < units.size()) {
    bytes /= 1024;
    ++unit;
  }
  return (unit == 0 ? fixed(bytes, 0) : significant(bytes, 3)) + " " + units[unit];
}

}  // namespace mtf::io
