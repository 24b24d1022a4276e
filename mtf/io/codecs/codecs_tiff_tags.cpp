// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/codecs_tiff_tags.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "mtf/error.h"
#include "mtf/words.h"

namespace mtf::io::module {
namespace {

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
    add("read as page 1 of " + std::to_string(pages) + (pages >= 1000 ? " or more" : "") + ": the others",
        others.pages);
  if (!others.below.empty()) add("its " + std::to_string(others.below.size()) + " images in SubIFDs", others.below);
  // ImageJ writes stacks above 4 GiB behind a single directory.
  const auto images = header.attributes.find("images");
  if (pages == 1 && header.attributes.contains("ImageJ") && images != header.attributes.end() && images->second != "1")
    header.notes.push_back("read as image 1 of the " + printable(images->second, 20) +
                           " that ImageJ keeps in it: the others are not read");
}

}  // namespace

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

TiffOthers other_images(TIFF* tiff) {
  constexpr std::size_t most = 999;  // a damaged chain may be long; where it is circular, libtiff stops
  TiffOthers others;
  std::uint16_t count = 0;
  const std::uint64_t* offsets = nullptr;
  std::vector<std::uint64_t> below;
  if (TIFFGetField(tiff, TIFFTAG_SUBIFD, &count, &offsets) == 1 && offsets != nullptr)
    below.assign(offsets, offsets + std::min<std::size_t>(count, most));
  while (others.pages.size() < most && TIFFReadDirectory(tiff) == 1) others.pages.push_back(image_of(tiff));
  for (const std::uint64_t offset : below)
    if (TIFFSetSubDirectory(tiff, offset) == 1) others.below.push_back(image_of(tiff));
  TIFFSetDirectory(tiff, 0);
  return others;
}

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
  if (TIFFGetField(tiff, TIFFTAG_MAXSAMPLEVALUE, &most) == 1 && (header.type == "uint8" || header.type == "uint16") &&
      most < (header.type == "uint8" ? 255 : 65535))
    header.notes.push_back("its largest possible value is " + std::to_string(most) +
                           " (MaxSampleValue): where it clips there, --saturation says so");
}

}  // namespace mtf::io::module
