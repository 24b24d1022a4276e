// SPDX-License-Identifier: Apache-2.0
#pragma once

// What reading whole OpenEXR images and reading windows of them share: opening with every check, what the headers say,
// and bands of pixels.

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfTiledInputPart.h>

#include <cstdint>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/words.h"

namespace mtf::io {

/// A data or display window: the first and the last column and row, both inside.
struct Window {
  std::int64_t x0, y0, x1, y1;
  std::int64_t width() const { return x1 - x0 + 1; }
  std::int64_t height() const { return y1 - y0 + 1; }
};

/// Checks the raw header before the library opens the file: it allocates what a header asks for, and a damaged one may
/// ask for anything. Throws RuntimeError when the header is cut short, an attribute is longer than the file, a window
/// is inverted, the chunk table cannot fit, or the announced pixels (or one tile) are far beyond what the file can hold
/// compressed.
void scan_exr_header(const std::string& path);

/// Runs `action` and turns what the library throws into our errors.
template <class Action>
auto guarded(const std::string& path, Action&& action) {
  try {
    return std::forward<Action>(action)();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw RuntimeError("cannot read " + path + ": out of memory; crop the image or choose one channel");
  } catch (const std::exception& error) {
    std::string why = error.what();
    const auto named = why.find(path + "\". ");  // the library names the file too
    if (named != std::string::npos) why.erase(0, named + path.size() + 3);
    throw RuntimeError("cannot read " + path + ": damaged or incomplete OpenEXR file (" + printable(why) +
                       "); copy or export the file again");
  }
}

/// A float frame buffer over `planes` whose pixel (x0, y0) is the first sample of each plane; of `whole_numbers` the
/// bits are those of uint32.
Imf::FrameBuffer frame_buffer(const std::vector<std::string>& channels, const std::vector<float*>& planes,
                              std::int64_t x0, std::int64_t y0, std::int64_t stride, bool whole_numbers = false);

/// One part opened for pixels, scan lines and tiles by the same call.
class PixelSource {
 public:
  PixelSource(Imf::MultiPartInputFile& file, int part);
  /// Rows that are decoded together; bands start at the first row of the data window.
  std::int64_t band_rows() const { return band_; }
  bool tiled() const { return tiled_.has_value(); }
  void read(const Imf::FrameBuffer& buffer, std::int64_t first, std::int64_t last);

 private:
  std::optional<Imf::InputPart> lines_;
  std::optional<Imf::TiledInputPart> tiled_;
  std::int64_t band_ = 1;
  std::int64_t top_ = 0;
};

/// A file whose header, chosen channels and sizes have passed every check; no pixels are read yet.
struct OpenedExr {
  OpenedExr(const std::string& path, const ReadOptions& options);

  Imf::MultiPartInputFile file;
  ImageFile image;                    ///< without planes
  std::vector<std::string> channels;  ///< full names of those chosen
  int part = 0;
  bool whole_numbers = true;  ///< all of those chosen are uint32
  Window data{}, display{};
};

/// What the headers of an open file say. Windows, shape of pixels and notes are those of `part`, and so are the
/// attributes that it has.
FileInfo describe_exr(const Imf::MultiPartInputFile& file, int part = 0);

}  // namespace mtf::io
