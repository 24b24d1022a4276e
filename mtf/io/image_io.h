// SPDX-License-Identifier: Apache-2.0
#pragma once

// Image files in and out. Everything inside the toolkit is linear float32 planes; this header is the only interface to
// files of images; their formats stand in one table (mtf/io/image_formats.h). Values are returned as stored (integers
// as their counts): gain, offset and quantity belong to the sensor configuration, nothing is guessed here.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/image.h"
#include "mtf/io/codecs/drawing.h"
#include "mtf/io/codecs/stated_encoding.h"

namespace mtf::io {

enum class Format { exr, png, tiff, jpeg, envi, fits, pnm, bmp, gdal, camera_raw, flir };

/// Format by the first bytes of a file; nothing where they are those of no image.
std::optional<Format> format_of(std::string_view start);

/// Format by file content for reading (magic bytes). Throws RuntimeError for a missing, empty or foreign file.
Format detect_format(const std::string& path);

/// Format by extension for writing (.exr .png .tif .tiff .hdr .img, any case). Throws UsageError naming the known
/// extensions.
Format format_from_extension(const std::string& path);
/// Whether images of a format that is written are floats, and not whole numbers.
bool holds_floats(Format format);

/// The files of an image that is there or will be written: an ENVI has two.
std::vector<std::string> files_of_image(const std::string& path);

struct ChannelInfo {
  std::string name;   ///< full name as stored, e.g. "ViewLayer.Combined.R"; PNG/TIFF: "Y" or "R","G","B" ("A" last)
  std::string type;   ///< "half", "float", "uint", "uint8", "uint16", "double" (TIFF); "deep half" ... cannot be read
  std::string layer;  ///< part before the last '.', "" when there is none
  int part = 0;       ///< part of a multi-part file, else 0
  std::string part_name;  ///< name of that part, "" when it has none; works as a layer where channels have none
  int x_sampling = 1, y_sampling = 1;
  double wavelength_um = 0.0;  ///< of a band, where the file lists it beside the name; 0 = it does not
};

/// Format and metadata of a file, without reading its pixels.
struct FileInfo {
  Format format{};
  std::string storage;     ///< e.g. "scanline zip", "tiled piz, 3 mip-map levels", "2 parts", "16-bit"
  std::int64_t width = 0;  ///< size of the display window: the size of the image that is read
  std::int64_t height = 0;
  std::array<int, 4> data_window{};  ///< x0, y0, x1, y1 inclusive; equals the display window for PNG and TIFF
  std::array<int, 4> display_window{};
  std::vector<ChannelInfo> channels;              ///< in the file's order
  std::map<std::string, std::string> attributes;  ///< other attributes that can be shown as text
  StatedEncoding encoding;                        ///< curve of the values of PNG, TIFF and JPEG; OpenEXR is linear
  std::vector<std::uint16_t> dct_steps{};         ///< of a JPEG, in counts (mtf/io/codecs/encoding.h)
  double largest = 0.0;   ///< value of a sample where the file states one below that of its type; 0 = it does not
  std::string no_data{};  ///< stored value of pixels that have none and are read as NaN, "0 (GDAL_NODATA)"; "" = none
  double pixel_aspect = 1.0;  ///< width of a pixel over its height, as the file states it; 1 where it states none
  /// What the file holds and is not read, and what else a user has to know of the values: "read as page 1 of 3: ...".
  std::vector<std::string> notes{};
};

/// Stored values that `words` name, "0 (GDAL_NODATA)", are no data: said so, and noted.
void note_no_data(FileInfo& info, const std::string& words);

FileInfo read_info(const std::string& path);

struct ReadOptions {
  /// One full channel name, or its last component within `layer`.
  std::optional<std::string> channel;
  /// All colour (or single) channels of this layer; "" = the channels without a layer.
  std::optional<std::string> layer{};
  /// Part of a multi-part file, from 0; needed only when names repeat. Of a TIFF the page, the first where none is
  /// asked for.
  std::optional<int> part{};
};

/// The chosen planes, each width x height of the *display window*. Data window parts outside are cropped, missing
/// pixels are 0 and counted. Mip-map level 0. Subsampled channels (RY, BY of luminance-chroma files) and deep data are
/// refused with the remedy. Values are float32: EXR uint above 2^24 is rounded. NaN and Inf are passed through.
struct ImageFile {
  std::vector<std::string> names;  ///< as chosen: "Y" | "R","G","B" | full channel name
  std::vector<Image> planes;
  bool integer = false;  ///< stored as integers (PNG, integer TIFF, EXR uint): the config has to give gain and offset
  std::int64_t missing_pixels = 0;  ///< display-window pixels that the data window does not cover
  FileInfo info;
};

/// Reads the channels chosen by `options`. Without a choice: the radiance spectrum where there is one (spectral_exr.h),
/// the only channel, or Y, or R,G,B (alpha is left out), of the channels without a layer or of the only layer; anything
/// else is a UsageError that lists what there is and how to choose. Damaged, incomplete or impossibly large files:
/// RuntimeError, before memory is taken. Limits: 2^31 pixels a plane (PNG, TIFF: 2^30 and 2^20 a side), the memory of
/// the machine, what the file can hold compressed, and for display windows above 2^24 pixels a data window that covers
/// at least 1/256.
ImageFile read_image(const std::string& path, const ReadOptions& options = {});

/// Text and numbers stored with an image. EXR: typed attributes named `mtf:...`; PNG: tEXt; TIFF: ImageDescription.
struct Metadata {
  std::map<std::string, std::string> text;             ///< e.g. {"mtf:units", "W.m^-2.sr^-1"}
  std::map<std::string, std::array<double, 2>> pairs;  ///< e.g. {"mtf:pixelPitch", {15e-6, 15e-6}}
  std::map<std::string, std::vector<float>> lists;     ///< e.g. {"mtf:bandEdges", {3.4, 4.8}}
  std::vector<std::string> history;                    ///< "mtf:history"
};

/// As names and words, for formats that store text.
std::vector<std::pair<std::string, std::string>> words_of(const Metadata& metadata);

struct NamedPlane {
  std::string name;
  ImageView<const float> plane;
};

/// Scanline float32 ZIP EXR, data window = display window = size from (0,0). Appears whole or not at all.
void write_exr(const std::string& path, const std::vector<NamedPlane>& planes, const Metadata& metadata);

/// Fills rows first .. of every plane, as many as the views are high.
using ReadRows = std::function<void(std::int64_t first, std::span<const ImageView<float>> planes)>;

/// Tiled float32 ZIP EXR of an image that need not fit memory, otherwise as write_exr. Rows are asked for in order, a
/// row of tiles at a time; `threads` compress, 0 = all cores.
void write_tiled_exr(const std::string& path, const std::vector<std::string>& names, std::int64_t width,
                     std::int64_t height, const ReadRows& rows, const Metadata& metadata, int threads);

/// OpenEXR or ENVI, by extension, of planes and of rows that are asked for.
void write_floats(const std::string& path, const std::vector<NamedPlane>& planes, const Metadata& metadata);
void write_float_rows(const std::string& path, const std::vector<std::string>& names, std::int64_t width,
                      std::int64_t height, const ReadRows& rows, const Metadata& metadata, int threads);

/// file value = round((value - offset) / gain), clamped to what the bits hold; the clamped pixels are counted.
struct IntegerScaling {
  double gain = 1.0;
  double offset = 0.0;
  int bits = 16;  ///< 8 or 16

  double largest() const { return bits == 8 ? 255.0 : 65535.0; }
};

/// Scaling that maps [min, max] of the planes to 0..65535 (gain 1 for a flat image).
IntegerScaling full_range_scaling(const std::vector<NamedPlane>& planes);

/// PNG or TIFF (by extension) with 1 or 3 planes; `gain` and `offset` are written into the file beside
/// `metadata`. Returns the number of clamped samples. Appears whole or not at all.
std::int64_t write_integer(const std::string& path, const std::vector<NamedPlane>& planes,
                           const IntegerScaling& scaling, const Metadata& metadata);

/// 8-bit grey or RGB preview: values mapped linearly from [low, high] to 0..255, NaN to 0. PNG only.
void write_preview_png(const std::string& path, const std::vector<NamedPlane>& planes, double low, double high);

/// The same in grey, drawn upon. Throws UsageError for pictures above 2^28 pixels.
void write_annotated_png(const std::string& path, ImageView<const float> plane, double low, double high,
                         const Drawing& drawing);

}  // namespace mtf::io
