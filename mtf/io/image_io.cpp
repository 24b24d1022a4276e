// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/image_io.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/codecs/raster.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/exr/exr_read.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_formats.h"
#include "mtf/io/image_windows.h"
#include "mtf/io/plane_checks.h"
#include "mtf/io/raw/camera_raw.h"
#include "mtf/io/raw/envi.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

using std::string_view_literals::operator""sv;

bool starts_as_tiff(std::string_view bytes) {
  return std::ranges::any_of(std::array{"II\x2a\0"sv, "MM\0\x2a"sv, "II\x2b\0"sv, "MM\0\x2b"sv},
                             [&](std::string_view mark) { return bytes.starts_with(mark); });
}

bool starts_as_pnm(std::string_view bytes) {
  return bytes.size() > 2 && bytes[0] == 'P' && "2356"sv.find(bytes[1]) != std::string_view::npos &&
         " \t\r\n"sv.find(bytes[2]) != std::string_view::npos;
}

/// Two letters are too few: the bytes that are 0 and the one plane tell it from bare numbers.
bool starts_as_bmp(std::string_view bytes) {
  return bytes.size() >= 28 && bytes.starts_with("BM") && bytes.substr(6, 4) == "\0\0\0\0"sv &&
         bytes.substr(15, 3) == "\0\0\0"sv && bytes.substr(26, 2) == "\1\0"sv;
}

bool starts_as_gdal(std::string_view bytes) {
  return std::ranges::any_of(
      std::array{"NITF0"sv, "NSIF0"sv, "\x89HDF\r\n\x1a\n"sv, "\0\0\0\x0cjP  \r\n\x87\n"sv, "\xff\x4f\xff\x51"sv},
      [&](std::string_view mark) { return bytes.starts_with(mark); });
}

constexpr std::array kFormats{
    ImageFormat{.format = Format::exr,
                .name = "OpenEXR",
                .known_by = "first bytes",
                .numbers = "half, float, uint32",
                .endings = {".exr"},
                .written = "float",
                .applied = "windows, layers, parts, levels, spectra, attributes mtf:*",
                .noted = "views, environment maps, compression with a loss, colour spaces",
                .refused = "deep and subsampled channels",
                .starts = [](std::string_view bytes) { return bytes.starts_with("\x76\x2f\x31\x01"sv); }},
    ImageFormat{.format = Format::png,
                .name = "PNG",
                .known_by = "first bytes",
                .numbers = "1 to 16 bits",
                .endings = {".png"},
                .written = "8 or 16 bits",
                .applied = "curve (cICP, iCCP, sRGB, gAMA) by [scene] encoding, tRNS of grey, pHYs, interlace",
                .noted = "palette, alpha, sBIT, animation, orientation",
                .refused = "unknown critical chunks",
                .starts = [](std::string_view bytes) { return bytes.starts_with("\x89PNG\r\n\x1a\n"sv); }},
    ImageFormat{
        .format = Format::tiff,
        .name = "TIFF",
        .known_by = "first bytes",
        .numbers = "8, 12 and 16 bits, signed of 8 and 16, float, double",
        .endings = {".tif", ".tiff"},
        .written = "8 or 16 bits",
        .applied = "TransferFunction by [scene] encoding, GDAL_NODATA, pages (--page N), resolution, tiles, BigTIFF",
        .noted = "further pages, palette, alpha, ICC profiles, MaxSampleValue",
        .refused = "whole numbers of 1 and 32 bits, complex; mosaics, CMYK, YCbCr; Orientation",
        .starts = starts_as_tiff},
    ImageFormat{.format = Format::jpeg,
                .name = "JPEG",
                .known_by = "first bytes",
                .numbers = "luminance, 8 bits; counts of FLIR and DJI",
                .applied = "curve sRGB by [scene] encoding, densities; raw counts as channel counts",
                .noted = "orientation, further images, unknown segments, which may be raw counts",
                .refused = "12 bits, lossless, RGB, CMYK",
                .starts = [](std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"sv); }},
    ImageFormat{.format = Format::envi,
                .name = "ENVI",
                .known_by = "ENVI in NAME.hdr, itself or beside",
                .numbers = "types 1 to 5, 12 to 15; bsq, bil, bip",
                .endings = {".hdr", ".img"},
                .written = "float",
                .applied = "header offset, data gain and offset values, data ignore value, wavelength, pixel sizes",
                .noted = "reflectance scales, bbl, classes, bytes behind the numbers",
                .refused = "complex, compressed, frame offsets, wavelength without units",
                .starts = [](std::string_view bytes) { return bytes.starts_with("ENVI"sv); },
                .raw = open_envi},
    ImageFormat{.format = Format::fits,
                .name = "FITS",
                .known_by = "SIMPLE = at the start",
                .numbers = "BITPIX 8, 16, 32, 64, -32, -64",
                .applied = "BZERO, BSCALE, BLANK, ROWORDER (bottom row first without it), extensions as parts",
                .noted = "tables and compressed images beside others",
                .refused = "compressed images, no image of two axes",
                .starts = [](std::string_view bytes) { return bytes.starts_with("SIMPLE  ="sv); },
                .raw = open_fits},
    ImageFormat{.format = Format::pnm,
                .name = "PGM, PPM",
                .known_by = "P2, P3, P5 or P6 and a blank",
                .numbers = "8 and 16 bits",
                .applied = "largest value as full scale",
                .noted = "bytes behind the image",
                .refused = "bitmaps (P1, P4), PAM, PFM",
                .starts = starts_as_pnm,
                .raw = open_pnm},
    ImageFormat{.format = Format::bmp,
                .name = "BMP",
                .known_by = "BM and its header",
                .numbers = "8 bits grey, 24 and 32 bits",
                .applied = "direction of rows, curve sRGB by [scene] encoding, resolution",
                .noted = "",
                .refused = "palettes of colours, 1, 4 and 16 bits, run lengths",
                .starts = starts_as_bmp,
                .raw = open_bmp},
    ImageFormat{
        .format = Format::flir,
        .name = "FLIR",
        .known_by = "FFF or AFF and a 0; in a JPEG its channel counts",
        .numbers = "16 bits, also as PNG or JPEG-LS",
        .applied = "order of bytes, frames of SEQ and CSQ as parts, camera_counts, emissivity, reflected, air, window",
        .noted = "constants that are missing, frames without counts, bytes behind the last one",
        .refused = "JPEG-LS (CSQ) without CharLS",
        .starts = [](std::string_view bytes) { return bytes.starts_with("FFF\0"sv) || bytes.starts_with("AFF\0"sv); },
        .raw = open_flir},
    ImageFormat{.format = Format::gdal,
                .name = "GDAL",
                .known_by = "NITF, HDF5 or JPEG 2000",
                .numbers = "all real numbers",
                .applied = "images as parts, scale and offset, no-data values, sizes of pixels",
                .noted = "geotransform and coordinate system, as text",
                .refused = "complex numbers, palettes",
                .starts = starts_as_gdal,
                .raw = open_gdal},
    ImageFormat{.format = Format::camera_raw,
                .name = "DNG, raw",
                .known_by = "endings .dng, .nef, .cr2, ...",
                .numbers = "mosaics up to 16 bits",
                .applied = "the maker's compression, masked margins, white level as full scale",
                .noted = "mosaic, black level, exposure, orientation",
                .refused = "demosaiced and X-Trans files, floats",
                .starts = [](std::string_view) { return false; },  // by their names
                .raw = open_camera_raw}};

/// By content and, of bare numbers, by the header beside them.
std::optional<Format> format_at(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw RuntimeError("cannot read " + path + ": it cannot be opened; check its permissions");
  if (is_camera_raw(path)) return Format::camera_raw;
  std::array<char, 32> start{};
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  if (const auto format = format_of({start.data(), static_cast<std::size_t>(file.gcount())})) return format;
  return envi_header_of(path).empty() ? std::nullopt : std::optional(Format::envi);
}

}  // namespace

std::span<const ImageFormat> image_formats() { return kFormats; }

const ImageFormat& row_of(Format format) { return *std::ranges::find(kFormats, format, &ImageFormat::format); }

std::optional<Format> format_of(std::string_view start) {
  const auto* row = std::ranges::find_if(kFormats, [&](const ImageFormat& f) { return f.starts(start); });
  return row == kFormats.end() ? std::nullopt : std::optional(row->format);
}

Format detect_format(const std::string& path) {
  const std::int64_t size = input_file_size(path);
  if (const auto format = format_at(path)) return *format;
  throw RuntimeError("cannot read " + path + ": its content (" + shown_bytes(static_cast<double>(size)) +
                     ") is none of " + joined(kFormats, [](const ImageFormat& row) { return std::string(row.name); }) +
                     "; convert the image to one of them, or describe bare numbers by an ENVI header beside them");
}

Format format_from_extension(const std::string& path) {
  const std::string name = lower_case(path.substr(path.rfind('/') + 1));
  std::vector<std::string_view> endings;
  for (const ImageFormat& row : kFormats)
    for (const std::string_view ending : row.endings)
      if (!ending.empty() && name.ends_with(ending))
        return row.format;
      else if (!ending.empty())
        endings.push_back(ending);
  throw UsageError("cannot tell the image format of " + path + "; end the name in " +
                   joined(std::span<const std::string_view>(endings)));
}

bool holds_floats(Format format) { return row_of(format).written == "float"; }

std::vector<std::string> files_of_image(const std::string& path) {
  std::error_code error;
  const bool is_there = std::filesystem::is_regular_file(path, error);
  if (is_there && format_at(path) == Format::envi) return envi_files_of(path);
  const bool pair = lower_case(path).ends_with(".hdr") || lower_case(path).ends_with(".img");
  return pair ? envi_files(path) : std::vector{path};
}

void write_floats(const std::string& path, const std::vector<NamedPlane>& planes, const Metadata& metadata) {
  if (format_from_extension(path) == Format::exr) return write_exr(path, planes, metadata);
  check_planes(path, planes);
  std::vector<std::string> names;
  for (const NamedPlane& plane : planes) names.push_back(plane.name);
  const auto rows = [&](std::int64_t first, std::span<const ImageView<float>> to) {
    for (std::size_t c = 0; c < planes.size(); ++c)
      for (std::int64_t y = 0; y < to[c].height; ++y)
        std::copy_n(planes[c].plane.row(first + y), to[c].width, to[c].row(y));
  };
  write_envi(path, names, planes.front().plane.width, planes.front().plane.height, rows, metadata);
}

void write_float_rows(const std::string& path, const std::vector<std::string>& names, std::int64_t width,
                      std::int64_t height, const ReadRows& rows, const Metadata& metadata, int threads) {
  if (format_from_extension(path) == Format::exr)
    write_tiled_exr(path, names, width, height, rows, metadata, threads);
  else
    write_envi(path, names, width, height, rows, metadata);
}

ImageWindows::ImageWindows(const std::string& path, const ReadOptions& options) {
  const ImageFormat& row = row_of(detect_format(path));
  if (!row.in_pieces())
    throw UsageError(path + ": " + std::string(row.name) + " cannot be read in pieces; convert it to OpenEXR or ENVI");
  if (row.raw == nullptr) {
    exr_ = std::make_unique<ExrWindows>(path, options);
  } else {
    raw_ = std::make_unique<RawWindows>(path, row.raw, options);
    raw_->note_rounding();
  }
}

FileInfo read_info(const std::string& path) { return read_info_of(path, std::nullopt); }

FileInfo read_info_of(const std::string& path, std::optional<int> part) {
  const ImageFormat& row = row_of(detect_format(path));
  if (row.format == Format::exr) return read_exr_info(path);
  if (row.raw != nullptr) return read_raw_info(path, row.raw, part);
  return part && row.format == Format::tiff ? read_raster_info(path, row.format, *part)
                                            : read_raster_info(path, row.format);
}

ImageFile read_image(const std::string& path, const ReadOptions& options) {
  const ImageFormat& row = row_of(detect_format(path));
  if (row.format == Format::exr) return read_exr(path, options);
  return row.raw != nullptr ? read_raw(path, row.raw, options) : read_raster(path, row.format, options);
}

void note_no_data(FileInfo& info, const std::string& words) {
  info.no_data = words;
  info.notes.push_back("pixels of the value " + words + " are no data and read as NaN");
}

std::vector<std::pair<std::string, std::string>> words_of(const Metadata& metadata) {
  std::vector<std::pair<std::string, std::string>> text(metadata.text.begin(), metadata.text.end());
  for (const auto& [name, pair] : metadata.pairs)
    text.emplace_back(name, number_text(pair[0]) + " " + number_text(pair[1]));
  for (const auto& [name, list] : metadata.lists) text.emplace_back(name, joined(list, number_text<float>, " "));
  if (!metadata.history.empty()) text.emplace_back("mtf:history", joined(metadata.history, "\n"));
  return text;
}

}  // namespace mtf::io
