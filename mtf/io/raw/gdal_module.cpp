// SPDX-License-Identifier: Apache-2.0
// The module of GDAL, the only file that sees it.

#include "mtf/io/raw/gdal.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <dlfcn.h>
#include <gdal.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/error.h"
#include "mtf/version.h"

namespace mtf::io {
namespace {

/// What is in a file decides who reads it; drivers that open other files or addresses that a file names stay out.
constexpr std::array<const char*, 5> kDrivers{"NITF", "HDF5", "HDF5Image", "JP2OpenJPEG", nullptr};
// Each image is a file that stays open, with the headers of all of them: 64 take half a second and some 70 MiB, 300 of
// HDF5 14 s and 700 MiB.
constexpr int kMostImages = 64;
constexpr int kMostBands = 10'000;  // of all images that are opened
constexpr GIntBig kCacheBytes = GIntBig{64} << 20;

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  std::string why = CPLGetLastErrorMsg();
  std::ranges::replace(why, '\n', ' ');
  throw RuntimeError("cannot read " + path + ": " + what + (why.empty() ? "" : " (GDAL: " + why + ")") +
                     "; export it again, by gdal_translate to GeoTIFF or ENVI");
}

/// GDAL's messages stay out of the output while this lives; the last one is kept for errors.
class Quiet {
 public:
  Quiet() {
    CPLErrorReset();
    CPLPushErrorHandler(CPLQuietErrorHandler);
  }
  ~Quiet() { CPLPopErrorHandler(); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
};

void start_once() {
  static const bool started = [] {
    CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");  // no .aux.xml is read or written
    CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
    GDALSetCacheMax64(kCacheBytes);
    GDALAllRegister();
    // HDF5's library prints what it returns as errors, and GDAL lets it; it is there where GDAL was built with it.
    using SetPrinter = int (*)(std::int64_t stack, void* function, void* data);
    if (const auto set_printer = reinterpret_cast<SetPrinter>(dlsym(RTLD_DEFAULT, "H5Eset_auto2")))
      set_printer(0, nullptr, nullptr);
    return true;
  }();
  static_cast<void>(started);
}

std::shared_ptr<void> opened(const std::string& name) {
  GDALDatasetH dataset = GDALOpenEx(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data(), nullptr, nullptr);
  return {dataset, [](void* open) {
            const Quiet quiet;
            if (open != nullptr) GDALClose(open);
          }};
}

GdalBand band_of(const std::string& path, GDALRasterBandH from, int number) {
  GdalBand band;
  const GDALDataType type = GDALGetRasterDataType(from);
  if (GDALDataTypeIsComplex(type) != 0)
    fail(path, "band " + std::to_string(number) + " has complex numbers, which are not read; take their modulus");
  band.kind = GDALDataTypeIsFloating(type) != 0 ? 'f' : GDALDataTypeIsSigned(type) != 0 ? 'i' : 'u';
  band.bytes = GDALGetDataTypeSizeBytes(type);
  if (GDALGetRasterColorTable(from) != nullptr)
    fail(path, "band " + std::to_string(number) + " has a palette, whose entries are no radiances");
  band.name = GDALGetDescription(from);
  int has = 0;
  const double gain = GDALGetRasterScale(from, &has);
  if (has != 0) band.gain = gain;
  const double offset = GDALGetRasterOffset(from, &has);
  if (has != 0) band.offset = offset;
  const double no_data = GDALGetRasterNoDataValue(from, &has);
  if (has != 0) band.no_data = no_data;
  // Attributes of netCDF, which its driver applies and that of HDF5 does not: NAME_scale_factor and so on.
  char** attributes = GDALGetMetadata(from, nullptr);
  for (int i = 0; i < CSLCount(attributes); ++i) {
    const std::string_view line = attributes[i], name = line.substr(0, line.find('='));
    const auto is = [&](std::string_view ending) {
      return name == ending || name.ends_with("_" + std::string(ending));
    };
    const double value = CPLAtof(attributes[i] + std::min(name.size() + 1, line.size()));
    if (is("scale_factor")) band.gain = value;
    if (is("add_offset")) band.offset = value;
    if (is("_FillValue")) band.no_data = value;
  }
  if (!std::isfinite(band.gain) || band.gain == 0.0 || !std::isfinite(band.offset))
    fail(path, "band " + std::to_string(number) + " has no finite scale and offset");
  return band;
}

GdalImage image_of(const std::string& path, std::shared_ptr<void> dataset, const std::string& name) {
  GdalImage image{.format = GDALGetDriverLongName(GDALGetDatasetDriver(dataset.get())),
                  .name = name,
                  .width = GDALGetRasterXSize(dataset.get()),
                  .height = GDALGetRasterYSize(dataset.get()),
                  .dataset = dataset};
  const int bands = GDALGetRasterCount(dataset.get());
  if (bands > kMostBands) fail(path, "it has " + std::to_string(bands) + " bands, more than are read");
  for (int i = 1; i <= bands; ++i) image.bands.push_back(band_of(path, GDALGetRasterBand(dataset.get(), i), i));
  std::array<double, 6> transform{};
  if (GDALGetGeoTransform(dataset.get(), transform.data()) == CE_None) image.geotransform = transform;
  if (const char* system = GDALGetProjectionRef(dataset.get()); system != nullptr && *system != '\0')
    image.coordinate_system = system;
  return image;
}

std::vector<std::pair<int, GdalImage>> open(const std::string& path, std::optional<int> number) {
  start_once();
  const Quiet quiet;
  std::shared_ptr<void> file = opened(path);
  if (file == nullptr) fail(path, "it is damaged, or of a kind that this GDAL does not read");
  std::vector<std::string> names;  // of the images in it
  char** parts = GDALGetMetadata(file.get(), "SUBDATASETS");
  for (int i = 0; i < CSLCount(parts); ++i) {
    const std::string_view line = parts[i], key = line.substr(0, line.find('='));
    if (key.ends_with("_NAME")) names.emplace_back(line.substr(std::min(key.size() + 1, line.size())));
  }
  if (!number && names.size() > kMostImages)
    throw UsageError(path + ": it has " + std::to_string(names.size()) + " images, at most " +
                     std::to_string(kMostImages) +
                     " of which are opened at a time; choose one by --part N, N from 0 (" + names.front() + ") to " +
                     std::to_string(names.size() - 1) + " (" + names.back() + ")");
  std::vector<std::pair<int, GdalImage>> images;
  std::size_t bands = 0;
  const auto take = [&](int place, std::shared_ptr<void> dataset, const std::string& name) {
    if (GDALGetRasterCount(dataset.get()) < 1) return;
    images.emplace_back(place, image_of(path, std::move(dataset), name));
    bands += images.back().second.bands.size();
    if (bands > kMostBands)
      fail(path, "it has more than the " + std::to_string(kMostBands) + " bands that are read at a time");
  };
  for (int i = 0; i < std::ssize(names); ++i) {
    if (number.value_or(i) != i) continue;
    const std::string& name = names[static_cast<std::size_t>(i)];
    std::shared_ptr<void> part = opened(name);
    if (part == nullptr) fail(path, "its image " + name + " cannot be opened");
    take(i, std::move(part), name.substr(name.rfind(':') + 1));
  }
  if (names.empty()) take(0, file, "");
  if (images.empty() && number)
    throw UsageError(path + ": part " + std::to_string(*number) + " is none of its " + std::to_string(names.size()) +
                     " images, which are counted from 0");
  if (images.empty()) fail(path, "it holds no image");
  return images;
}

void read(void* dataset, const std::string& path, int band, std::int64_t x, std::int64_t y, std::int64_t width,
          std::int64_t height, double* out) {
  const Quiet quiet;
  const int w = static_cast<int>(width), h = static_cast<int>(height);
  if (GDALRasterIO(GDALGetRasterBand(dataset, band + 1), GF_Read, static_cast<int>(x), static_cast<int>(y), w, h, out,
                   w, h, GDT_Float64, 0, 0) != CE_None)
    fail(path, "its pixels cannot be decoded");
}

constexpr Gdal kTable{.build = {version, git_commit}, .open = open, .read = read};

}  // namespace
}  // namespace mtf::io

extern "C" __attribute__((visibility("default"))) const void* mtfkit_gdal_table() { return &mtf::io::kTable; }
