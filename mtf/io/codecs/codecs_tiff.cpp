// SPDX-License-Identifier: Apache-2.0

#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mtf/error.h"
#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"

namespace mtf::io::module {
namespace {

// What a TIFF says beside the size and the type of its samples (TIFF 6.0; Adobe DNG 1.7; GeoTIFF; tags of GDAL): which
// of its images is the first, which pixels are no data, how values are meant. Only sources of the module include this.

/// One image of the file.
struct TiffImage {
  std::uint32_t kind = 0;  ///< NewSubfileType
  std::uint32_t width = 0, height = 0;
  int photometric = 0;
};

/// The images beside the first: those of the chain of directories, and those in SubIFDs of the first one.
struct TiffOthers {
  std::vector<TiffImage> pages, below;
};

inline constexpr int kLinearRaw = 34892;  ///< photometric interpretation of DNG
inline constexpr const char* kRawRemedy =
    "it is a camera's raw file: write the raw values as a TIFF, as `unprocessed_raw -T` of LibRaw does, and read that";

constexpr std::uint32_t kGdalMetadata = 42112, kGdalNoData = 42113, kPixelScale = 33550;
constexpr std::uint32_t kDepthMap = 8;  // NewSubfileType of DNG
constexpr std::uint32_t kNotMain = FILETYPE_REDUCEDIMAGE | FILETYPE_MASK | kDepthMap;

/// Values of a tag that libtiff does not know, or learns from GDAL where that is in the same process, as in Python:
/// each counts them its own way.
template <class T>
std::span<const T> values_of(TIFF* tiff, std::uint32_t tag, TIFFDataType type) {
  const TIFFField* const field = TIFFFindField(tiff, tag, TIFF_ANY);
  if (field == nullptr || TIFFFieldDataType(field) != type) return {};
  const T* values = nullptr;
  std::uint32_t count = 0;
  std::uint16_t short_count = 0;
  if (TIFFFieldPassCount(field) == 0) {
    if (type != TIFF_ASCII || TIFFGetField(tiff, tag, &values) != 1 || values == nullptr) return {};
    return {values, std::strlen(reinterpret_cast<const char*>(values))};
  }
  const bool found = TIFFFieldReadCount(field) == TIFF_VARIABLE2 ? TIFFGetField(tiff, tag, &count, &values) == 1
                                                                 : TIFFGetField(tiff, tag, &short_count, &values) == 1;
  if (!found || values == nullptr) return {};
  return {values, std::max<std::size_t>(count, short_count)};
}

std::string text_of(TIFF* tiff, std::uint32_t tag) {
  const std::span<const char> text = values_of<char>(tiff, tag, TIFF_ASCII);
  return {text.begin(), std::find(text.begin(), text.end(), '\0')};
}

TiffImage image_of(TIFF* tiff) {
  TiffImage image;
  std::uint16_t photometric = 0xffff;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &image.kind);
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &image.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &image.height);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  image.photometric = photometric;
  return image;
}

std::string size_text(const TiffImage& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels";
}

const TiffImage* largest(const std::vector<TiffImage>& images) {
  const auto pixels = [](const TiffImage& image) {
    return (image.kind & kNotMain) != 0 ? 0.0 : static_cast<double>(image.width) * image.height;
  };
  const auto found = std::max_element(images.begin(), images.end(),
                                      [&](const TiffImage& a, const TiffImage& b) { return pixels(a) < pixels(b); });
  return found == images.end() || pixels(*found) == 0.0 ? nullptr : &*found;
}

/// The first item of GDAL's XML with this role: <Item name="SCALE" sample="0" role="scale">0.01</Item>.
std::string item_of(std::string_view xml, std::string_view role) {
  const std::size_t at = xml.find("role=\"" + std::string(role) + "\"");
  const std::size_t begin = at == std::string_view::npos ? at : xml.find('>', at);
  if (begin == std::string_view::npos) return "";
  const std::string_view value = xml.substr(begin + 1, xml.find('<', begin) - begin - 1);
  return std::string(value.substr(0, 40));
}

/// Width of a pixel over its height, from the scale on the ground or else from the resolution.
double aspect_of(TIFF* tiff) {
  float x = 0.0F, y = 0.0F;
  if (const auto scale = values_of<double>(tiff, kPixelScale, TIFF_DOUBLE); scale.size() >= 2)
    return scale[0] > 0.0 && scale[1] > 0.0 ? scale[0] / scale[1] : 1.0;
  const bool both =
      TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &x) == 1 && TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &y) == 1;
  return both && x > 0.0F && y > 0.0F ? static_cast<double>(y) / x : 1.0;
}

void read_no_data(TIFF* tiff, RasterHeader& header) {
  const std::string text = text_of(tiff, kGdalNoData);
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string::npos) return;
  const char* const end = text.data() + text.find_last_not_of(' ') + 1;
  double value = 0.0;
  const auto [after, error] = std::from_chars(text.data() + begin, end, value);
  constexpr double kMost = std::numeric_limits<float>::max();
  if (error == std::errc() && after == end)  // the usual one of double pixels is infinite in single precision, as they
    header.no_data = {static_cast<float>(std::abs(value) > kMost ? std::copysign(HUGE_VAL, value) : value),
                      text + " (GDAL_NODATA)"};
  else
    header.notes.push_back("its GDAL_NODATA \"" + printable(text, 40) + "\" is no number and not applied");
}

void note_further_images(const TiffOthers& others, RasterHeader& header) {
  const auto add = [&](std::string text, const std::vector<TiffImage>& images) {
    const TiffImage* const most = largest(images);
    text += most != nullptr ? ", of up to " + size_text(*most) + "," : "";
    header.notes.push_back(text + " are not read");
  };
  const std::size_t pages = others.pages.size() + 1;
  if (pages > 1)
    add("read as page " + std::to_string(header.page + 1) + " of " + std::to_string(pages) +
            (pages >= 1000 ? " or more" : "") + " (--page N reads another): the others",
        others.pages);
  if (!others.below.empty()) add("its " + std::to_string(others.below.size()) + " images in SubIFDs", others.below);
  // ImageJ writes stacks above 4 GiB behind a single directory.
  const auto images = header.attributes.find("images");
  if (pages == 1 && header.attributes.contains("ImageJ") && images != header.attributes.end() && images->second != "1")
    header.notes.push_back("read as image 1 of the " + printable(images->second, 20) +
                           " that ImageJ keeps in it: the others are not read");
}

/// "a colour filter array".
std::string photometric_name(int photometric) {
  for (const auto& [value, name] : {std::pair{PHOTOMETRIC_MINISWHITE, "values where the least is white"},
                                    {PHOTOMETRIC_MINISBLACK, "grey values"},
                                    {PHOTOMETRIC_RGB, "colours"},
                                    {PHOTOMETRIC_PALETTE, "a palette"},
                                    {PHOTOMETRIC_MASK, "a mask"},
                                    {PHOTOMETRIC_SEPARATED, "inks (CMYK)"},
                                    {PHOTOMETRIC_YCBCR, "luminance and chroma (YCbCr)"},
                                    {PHOTOMETRIC_CIELAB, "CIE L*a*b* values"},
                                    {PHOTOMETRIC_CFA, "a colour filter array"},
                                    {kLinearRaw, "the linear raw of a camera"}})
    if (photometric == value) return name;
  return photometric == 0xffff ? "no word on what its values are"
                               : "photometric interpretation " + std::to_string(photometric);
}

/// Leaves the handle at that page, from 0.
TiffOthers other_images(const std::string& path, TIFF* tiff, int page) {
  constexpr std::size_t most = 999;  // a damaged chain may be long; where it is circular, libtiff stops
  TiffOthers others;
  std::uint16_t count = 0;
  const std::uint64_t* offsets = nullptr;
  std::vector<std::uint64_t> below;
  if (page == 0 && TIFFGetField(tiff, TIFFTAG_SUBIFD, &count, &offsets) == 1 && offsets != nullptr)
    below.assign(offsets, offsets + std::min<std::size_t>(count, most));
  others.pages.push_back(image_of(tiff));
  while (others.pages.size() <= most && TIFFReadDirectory(tiff) == 1) others.pages.push_back(image_of(tiff));
  if (page > static_cast<int>(most) && others.pages.size() > most)
    throw RuntimeError(path + ": page " + std::to_string(page + 1) + ": only the first " + std::to_string(most + 1) +
                       " pages of a TIFF are read");
  if (page < 0 || page >= std::ssize(others.pages))
    throw RuntimeError(path + ": page " + std::to_string(page + 1) + " of a TIFF of " +
                       plural(std::ssize(others.pages), "page") + "; pages count from 1");
  others.pages.erase(others.pages.begin() + page);
  for (const std::uint64_t offset : below)
    if (TIFFSetSubDirectory(tiff, offset) == 1) others.below.push_back(image_of(tiff));
  TIFFSetDirectory(tiff, static_cast<tdir_t>(page));
  return others;
}

/// Throws RuntimeError, with what the file holds and how it is got at, when the first image is a preview of another one
/// or a mask, and when another image is a mask of the first.
void require_main_image(const std::string& path, TIFF* tiff, const TiffOthers& others) {
  const TiffImage first = image_of(tiff);
  const auto refuse_mask = [&](const TiffImage& other, const std::string& name) {
    if ((other.kind & FILETYPE_MASK) != 0 && (first.kind & kNotMain) == 0)
      throw RuntimeError(path + ": " + name +
                         " is a mask of the pixels that hold data, which is not applied; write the pixels without data "
                         "as NaN, or with a value that GDAL_NODATA names, and leave the mask out");
  };
  for (std::size_t i = 0; i < others.pages.size(); ++i)
    refuse_mask(others.pages[i], "its page " + std::to_string(i + 2));
  for (const TiffImage& below : others.below) refuse_mask(below, "an image in its SubIFDs");
  if ((first.kind & kNotMain) == 0) return;
  const TiffImage *const page = largest(others.pages), *const below = largest(others.below);
  const bool in_page = page != nullptr && (below == nullptr || page->width > below->width);
  const TiffImage* const main = in_page ? page : below;
  std::string text =
      path + ": the first image of this TIFF, " + size_text(first) + ", is " +
      ((first.kind & FILETYPE_REDUCEDIMAGE) != 0 ? "a preview or a smaller copy" : "a mask or depth map") +
      " of another one (NewSubfileType " + std::to_string(first.kind) + ")";
  if (main != nullptr)
    text += "; that one has " + size_text(*main) + " of " + photometric_name(main->photometric) + " in " +
            (in_page ? "page " + std::to_string(page - others.pages.data() + 2) : "a SubIFD") + ", which is not read";
  const unsigned char* version = nullptr;
  const bool raw = TIFFGetField(tiff, TIFFTAG_DNGVERSION, &version) == 1 ||
                   (main != nullptr && (main->photometric == PHOTOMETRIC_CFA || main->photometric == kLinearRaw));
  throw RuntimeError(text + "; " +
                     (raw       ? std::string(kRawRemedy)
                      : in_page ? "write that page as a file of its own, as `tiffcp FILE,NUMBER OUT` does with numbers "
                                  "from 0"
                                : "export the image that is wanted as a TIFF of its own"));
}

/// No data, the shape of pixels and notes.
void read_tags(TIFF* tiff, const TiffOthers& others, RasterHeader& header) {
  note_further_images(others, header);
  read_no_data(tiff, header);
  header.pixel_aspect = aspect_of(tiff);
  const std::string metadata = text_of(tiff, kGdalMetadata);
  for (const auto& [role, name] : {std::pair{"scale", "gain"}, {"offset", "offset"}})
    if (const std::string value = item_of(metadata, role); !value.empty()) header.attributes.emplace(name, value);

  std::uint16_t compression = COMPRESSION_NONE, photometric = 0, extra_count = 0, most = 0;
  const std::uint16_t* extra = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_COMPRESSION, &compression) == 1 &&
      (compression == COMPRESSION_JPEG || compression == COMPRESSION_JP2000 || compression == COMPRESSION_LERC ||
       compression == COMPRESSION_WEBP))
    header.notes.push_back("compressed in a way that may lose fine structure and noise (JPEG or another of its kind)");
  if (TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric) == 1 && photometric == PHOTOMETRIC_PALETTE)
    header.notes.push_back("its values are colours of a palette, not measured ones");
  if (TIFFGetField(tiff, TIFFTAG_EXTRASAMPLES, &extra_count, &extra) != 1) extra_count = 0;
  if (header.alpha)
    header.notes.push_back(
        extra_count == 0 || extra[0] == EXTRASAMPLE_UNSPECIFIED ? "a further sample of each pixel is not read"
        : extra[0] == EXTRASAMPLE_ASSOCALPHA ? "its alpha channel is not read: its values are multiplied by it already"
                                             : "its alpha channel is not applied");
  const double scale = header.largest > 0.0 ? header.largest : header.type == "uint8" ? 255.0 : 65535.0;
  if (TIFFGetField(tiff, TIFFTAG_MAXSAMPLEVALUE, &most) == 1 && (header.type == "uint8" || header.type == "uint16") &&
      most < scale)
    header.notes.push_back("its largest possible value is " + std::to_string(most) +
                           " (MaxSampleValue): where it clips there, --saturation says so");
}

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffHandle = std::unique_ptr<TIFF, CloseTiff>;

[[noreturn]] void damaged(const std::string& path, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": damaged or incomplete TIFF file (" + why +
                     "); copy or export the file again");
}

[[noreturn]] void unsupported(const std::string& path, const std::string& what) {
  throw RuntimeError(
      path + ": TIFF with " + what +
      " is not read; convert it to whole numbers of 8, 12 or 16 bits or float, grey (min is black) or RGB");
}

template <class T>
T field(TIFF* tiff, std::uint32_t tag, T missing) {
  T value = missing;
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : missing;
}

std::string sample_type(const std::string& path, int bits, int format) {
  if (format == SAMPLEFORMAT_UINT && bits == 8) return "uint8";
  if (format == SAMPLEFORMAT_UINT && (bits == 12 || bits == 16)) return "uint16";
  if (format == SAMPLEFORMAT_INT && (bits == 8 || bits == 16)) return bits == 8 ? "int8" : "int16";
  if (format == SAMPLEFORMAT_IEEEFP && bits == 32) return "float";
  if (format == SAMPLEFORMAT_IEEEFP && bits == 64) return "double";
  const std::string kind = format == SAMPLEFORMAT_INT      ? "signed "
                           : format == SAMPLEFORMAT_IEEEFP ? "floating-point "
                           : format == SAMPLEFORMAT_UINT   ? ""
                                                           : "undefined or complex ";
  unsupported(path, kind + std::to_string(bits) + "-bit samples");
}

int colours_of(const std::string& path, int samples, int photometric, bool& alpha) {
  if (photometric == PHOTOMETRIC_MINISBLACK && (samples == 1 || samples == 2)) {
    alpha = samples == 2;
    return 1;
  }
  if (photometric == PHOTOMETRIC_RGB && (samples == 3 || samples == 4)) {
    alpha = samples == 4;
    return 3;
  }
  if (photometric == PHOTOMETRIC_PALETTE && samples == 1) return 3;
  const std::string what =
      photometric_name(photometric) + (samples == 1 ? "" : " in " + std::to_string(samples) + " samples a pixel");
  if (photometric == PHOTOMETRIC_CFA || photometric == kLinearRaw)
    throw RuntimeError(path + ": TIFF with " + what + " is not read; " + kRawRemedy);
  unsupported(path, what);
}

// A file that is cut short is refused before it is decoded.
void check_pieces(const std::string& path, TIFF* tiff, std::int64_t file_bytes) {
  const std::uint32_t count = TIFFIsTiled(tiff) ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
  if (count == 0 || static_cast<std::int64_t>(count) > file_bytes) damaged(path, "its pixels are missing");
  for (std::uint32_t i = 0; i < count; ++i) {
    int error = 0;
    const std::uint64_t offset = TIFFGetStrileOffsetWithErr(tiff, i, &error);
    const std::uint64_t bytes = error == 0 ? TIFFGetStrileByteCountWithErr(tiff, i, &error) : 0;
    const auto size = static_cast<std::uint64_t>(file_bytes);
    if (error != 0 || offset == 0 || bytes == 0 || offset > size || bytes > size - offset)
      damaged(path, "piece " + std::to_string(i) + " of " + std::to_string(count) + " of its pixels is missing");
  }
}

// "key=value" lines become attributes; any other description is kept whole.
void read_description(TIFF* tiff, RasterHeader& header) {
  const char* raw = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &raw) != 1 || raw == nullptr) return;
  const std::string text = raw;
  std::map<std::string, std::string> found;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const std::size_t equals = text.find('=', start);
    if (equals == start || equals >= end) {
      header.attributes["ImageDescription"] = text;
      return;
    }
    std::string& value = found[text.substr(start, equals - start)];
    append_word(value, std::string_view(text).substr(equals + 1, end - equals - 1), '\n');
    start = end + 1;
  }
  header.attributes = found;
}

StatedEncoding read_encoding(TIFF* tiff, int bits, bool integer) {
  std::array<std::uint16_t*, 3> raw{};
  std::vector<std::span<const std::uint16_t>> tables;
  if (integer && TIFFGetField(tiff, TIFFTAG_TRANSFERFUNCTION, &raw[0], &raw[1], &raw[2]) == 1)
    for (const std::uint16_t* table : raw)  // libtiff sets the first only where there is one colour
      if (table != nullptr) tables.emplace_back(table, std::size_t{1} << static_cast<unsigned>(bits));
  std::uint32_t size = 0;
  const unsigned char* profile = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_ICCPROFILE, &size, &profile) != 1 || profile == nullptr) size = 0;
  return stated_by_tiff(tables, {profile, size});
}

/// Red, green and blue of each value of 8 bits; none where the image has no palette. Some writers state colours of 8
/// bits where 16 belong.
using Palette = std::vector<std::array<unsigned char, 3>>;

Palette read_palette(TIFF* tiff, int bits) {
  std::array<std::uint16_t*, 3> maps{};
  if (field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, 0xffff) != PHOTOMETRIC_PALETTE || bits != 8 ||
      TIFFGetField(tiff, TIFFTAG_COLORMAP, &maps[0], &maps[1], &maps[2]) != 1)
    return {};
  Palette palette(256);
  const bool bytes = std::all_of(maps.begin(), maps.end(), [](const std::uint16_t* map) {
    return std::all_of(map, map + 256, [](std::uint16_t value) { return value < 256; });
  });
  for (std::size_t i = 0; i < palette.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      palette[i][c] = static_cast<unsigned char>(bytes ? maps[c][i] : maps[c][i] >> 8U);
  return palette;
}

std::vector<unsigned char> coloured(const std::vector<unsigned char>& values, const Palette& palette) {
  std::vector<unsigned char> colours;
  colours.reserve(3 * values.size());
  for (const unsigned char value : values) colours.insert(colours.end(), palette[value].begin(), palette[value].end());
  return colours;
}

/// Numbers of 12 bits, two in three bytes, rows of whole bytes.
std::vector<std::uint16_t> unpacked(const std::vector<unsigned char>& piece, std::size_t row_samples,
                                    std::size_t rows) {
  std::vector<std::uint16_t> wide;
  wide.reserve(row_samples * rows);
  const std::size_t row_bytes = (12 * row_samples + 7) / 8;
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t i = 0; i < row_samples; ++i) {
      const unsigned char* const at = piece.data() + y * row_bytes + 3 * (i / 2);
      wide.push_back(static_cast<std::uint16_t>(i % 2 == 0 ? at[0] << 4 | at[1] >> 4 : (at[1] & 15) << 8 | at[2]));
    }
  return wide;
}

struct Output {
  int descriptor = -1;
  int error = 0;
};

tmsize_t write_bytes(thandle_t handle, void* bytes, tmsize_t size) {
  auto& output = *static_cast<Output*>(handle);
  if (output.error == 0) output.error = write_all(output.descriptor, bytes, static_cast<std::size_t>(size));
  return output.error == 0 ? size : 0;
}

tmsize_t read_bytes(thandle_t handle, void* bytes, tmsize_t size) {
  return ::read(static_cast<Output*>(handle)->descriptor, bytes, static_cast<std::size_t>(size));
}

toff_t seek_bytes(thandle_t handle, toff_t position, int whence) {
  return static_cast<toff_t>(::lseek(static_cast<Output*>(handle)->descriptor, static_cast<off_t>(position), whence));
}

toff_t file_size(thandle_t handle) {
  struct stat status {};
  return ::fstat(static_cast<Output*>(handle)->descriptor, &status) == 0 ? static_cast<toff_t>(status.st_size) : 0;
}

int keep_open(thandle_t) { return 0; }

// Eight-bit samples side by side at the start of the row.
void pack_bytes(std::vector<std::uint16_t>& row) {
  std::vector<unsigned char> bytes(row.begin(), row.end());
  std::memcpy(row.data(), bytes.data(), bytes.size());
}

bool write_image(TIFF* tiff, const RasterData& data, const std::string& description) {
  const auto bits = static_cast<unsigned>(data.bits);
  bool ok = TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(data.width)) == 1 &&
            TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(data.height)) == 1 &&
            TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits) == 1 &&
            TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, static_cast<unsigned>(data.colours)) == 1 &&
            TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT) == 1 &&
            TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == 1 &&
            TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE) == 1 &&
            TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, data.colours == 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK) == 1;
  if (ok && !description.empty()) ok = TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, description.c_str()) == 1;
  if (ok) ok = TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0)) == 1;
  std::vector<std::uint16_t> row(static_cast<std::size_t>(data.width * data.colours));  // libtiff may change it
  for (std::int64_t y = 0; ok && y < data.height; ++y) {
    const auto from = data.samples.begin() + y * static_cast<std::int64_t>(row.size());
    std::copy(from, from + static_cast<std::int64_t>(row.size()), row.begin());
    if (data.bits == 8) pack_bytes(row);
    ok = TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0) == 1;
  }
  return ok && TIFFFlush(tiff) == 1;
}

}  // namespace

void silence_tiff() {
  TIFFSetErrorHandler(nullptr);
  TIFFSetWarningHandler(nullptr);
  TIFFSetErrorHandlerExt(nullptr);
  TIFFSetWarningHandlerExt(nullptr);
}

RasterHeader tiff_header(const std::string& path, std::int64_t file_bytes, int page) {
  silence_tiff();
  const TiffHandle handle(TIFFOpen(path.c_str(), "rm"));  // m: no memory map, a file that shrinks must not kill us
  TIFF* tiff = handle.get();
  if (tiff == nullptr) damaged(path, "its directory cannot be read");

  RasterHeader header;
  const TiffOthers others = other_images(path, tiff, page);
  if (TIFFCurrentDirectory(tiff) != static_cast<tdir_t>(page)) damaged(path, "its directory cannot be read twice");
  if (page == 0) require_main_image(path, tiff, others);
  header.page = page;
  header.width = field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0);
  header.height = field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0);
  const int bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  const int samples = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  if (header.width == 0 || header.height == 0) damaged(path, "the image has no pixels");
  header.type = sample_type(path, bits, field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT));
  header.colours = colours_of(path, samples, field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, 0xffff), header.alpha);
  if (samples > 1 && field<std::uint16_t>(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) != PLANARCONFIG_CONTIG)
    unsupported(path, "colours in separate planes");
  if (field<std::uint16_t>(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) != ORIENTATION_TOPLEFT)
    unsupported(path, "a rotated or mirrored orientation");
  check_raster_size(path, "TIFF", header.width, header.height);
  check_compression(path, static_cast<double>(header.width * header.height) * samples * bits / 8, file_bytes, 2048);
  if (TIFFIsTiled(tiff) != 0) {
    const double tile = static_cast<double>(field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH, 0)) *
                        field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH, 0) * samples * bits / 8;
    constexpr double harmless_bytes = 64.0 * 1024 * 1024;
    if (tile > harmless_bytes) check_compression(path, tile, file_bytes, 2048);
  }
  check_pieces(path, tiff, file_bytes);
  read_description(tiff, header);
  const bool integer = header.type != "float" && header.type != "double", is_signed = header.type.starts_with("int");
  if (bits == 12) header.largest = 4095.0;
  header.encoding = read_encoding(tiff, bits, integer && !is_signed);
  header.storage = std::to_string(bits) +
                   (is_signed ? "-bit signed"
                    : integer ? "-bit"
                              : "-bit float") +
                   (TIFFIsTiled(tiff) != 0 ? " tiled" : "");
  read_tags(tiff, others, header);
  return header;
}

// Strips lie as tiles of the width of the image. A piece that cannot be decoded is an error: some would fill in zeros.
std::vector<Image> decode_tiff(const std::string& path, RasterHeader& header) {
  silence_tiff();
  const TiffHandle handle(TIFFOpen(path.c_str(), "rm"));
  TIFF* tiff = handle.get();
  if (tiff == nullptr || TIFFSetDirectory(tiff, static_cast<tdir_t>(header.page)) != 1)
    damaged(path, "its directory cannot be read");
  const bool tiled = TIFFIsTiled(tiff) != 0;
  const auto width = field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0);
  const auto rows = field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0);
  const int bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  const int samples = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  const Palette palette = read_palette(tiff, bits);
  if (width != header.width || rows != header.height ||
      sample_type(path, bits, field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT)) != header.type ||
      (palette.empty() ? samples : 3) < header.colours)
    undecodable(path, "TIFF", "pixels do not match the header");
  const auto across = tiled ? field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH, 0) : width;
  const auto down = tiled ? field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH, 0)
                          : std::min(field<std::uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP, rows), rows);
  const tmsize_t size = tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
  const std::int64_t row_bytes = (static_cast<std::int64_t>(across) * samples * bits + 7) / 8;
  if (across == 0 || down == 0 || size < row_bytes * down) damaged(path, "its pieces have no size");
  std::vector<Image> planes = empty_planes(header);
  std::vector<Rounding> rounding(planes.size());
  std::vector<unsigned char> piece(static_cast<std::size_t>(size));
  const std::uint32_t a_row = (width - 1) / across + 1, count = a_row * ((rows - 1) / down + 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t x = i % a_row * across, y = i / a_row * down;
    const std::uint32_t high = tiled ? down : std::min(down, rows - y);
    const tmsize_t read =
        tiled ? TIFFReadEncodedTile(tiff, i, piece.data(), size) : TIFFReadEncodedStrip(tiff, i, piece.data(), size);
    if (read < row_bytes * high)
      damaged(path, "piece " + std::to_string(i) + " of " + std::to_string(count) + " of its pixels cannot be decoded");
    if (bits == 12) {
      const auto row_samples = std::size_t{across} * static_cast<std::size_t>(samples);
      const std::vector<std::uint16_t> wide = unpacked(piece, row_samples, high);
      place({wide.data(), x, y, across, high, std::int64_t{across} * samples, samples}, header, planes);
    } else if (palette.empty()) {
      place({piece.data(), x, y, across, high, std::int64_t{across} * samples, samples, rounding.data()}, header,
            planes);
    } else {
      const std::vector<unsigned char> colours = coloured(piece, palette);
      place({colours.data(), x, y, across, high, std::int64_t{across} * 3, 3}, header, planes);
    }
  }
  mark_no_data(header, planes);
  for (std::size_t c = 0; c < planes.size(); ++c)
    rounding[c].note(path, std::string(1, planes.size() == 1 ? 'Y' : "RGB"[c]), header.notes);
  return planes;
}

int encode_tiff(int descriptor, const RasterData& data) {
  silence_tiff();
  std::string description;
  for (const auto& [key, text] : data.text) {
    for (std::size_t start = 0; start <= text.size();) {
      const std::size_t end = std::min(text.find('\n', start), text.size());
      description += key + "=" + text.substr(start, end - start) + "\n";
      start = end + 1;
    }
  }
  Output output{descriptor, 0};
  const double bytes = static_cast<double>(data.samples.size()) * data.bits / 8;
  const char* mode = bytes > 3.9e9 ? "w8" : "w";  // beyond 4 GiB only BigTIFF can address the strips
  TiffHandle handle(TIFFClientOpen("output", mode, &output, read_bytes, write_bytes, seek_bytes, keep_open, file_size,
                                   nullptr, nullptr));
  const bool ok = handle && write_image(handle.get(), data, description);
  handle.reset();
  return output.error != 0 ? output.error : (ok ? 0 : EIO);
}

}  // namespace mtf::io::module
