// SPDX-License-Identifier: Apache-2.0
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

#include <turbojpeg.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <memory>
#include <stdexcept>

#include "mtf/error.h"
#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/io/codecs/jpeg_scan.h"
#include "mtf/io/codecs/png_scan.h"
#include "mtf/io/file_checks.h"

namespace mtf::io::module {
namespace {

[[noreturn]] void damaged(const std::string& path, const std::string& format, const std::string& why) {
  throw RuntimeError("cannot read " + path + ": damaged, incomplete or unsupported " + format + " file" +
                     (why.empty() ? "" : " (" + printable(why) + ")") + "; copy or export the file again");
}

template <class T>
Image plane_of(const cv::Mat& pixels, int channel, int scale) {
  Image plane(pixels.cols, pixels.rows);
  const int step = pixels.channels();
  const float factor = 1.0F / static_cast<float>(scale);
  for (int y = 0; y < pixels.rows; ++y) {
    const T* from = pixels.ptr<T>(y) + channel;
    float* to = plane.view().row(y);
    if (scale == 1)
      for (int x = 0; x < pixels.cols; ++x) to[x] = static_cast<float>(from[x * step]);
    else
      for (int x = 0; x < pixels.cols; ++x) to[x] = static_cast<float>(from[x * step]) * factor;
  }
  return plane;
}

Image plane_of(const std::string& path, const cv::Mat& pixels, int channel, int scale) {
  switch (pixels.depth()) {
    case CV_8U:
      return plane_of<std::uint8_t>(pixels, channel, scale);
    case CV_16U:
      return plane_of<std::uint16_t>(pixels, channel, scale);
    case CV_32F:
      return plane_of<float>(pixels, channel, scale);
    case CV_64F:
      return plane_of<double>(pixels, channel, scale);
    default:
      throw RuntimeError(path + ": pixel type is not read; convert it to 8 or 16-bit integers or float");
  }
}

template <class Decode>
std::vector<Image> decode(const std::string& path, const std::string& format, const RasterHeader& header,
                          Decode&& read) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::Mat pixels;
  try {
    pixels = read();
  } catch (const Error&) {
    throw;
  } catch (const cv::Exception& error) {
    damaged(path, format, error.err);
  } catch (const std::exception& error) {
    damaged(path, format, error.what());
  }
  if (pixels.empty()) damaged(path, format, "");
  const bool as_announced = pixels.cols == header.width && pixels.rows == header.height &&
                            (header.type == "uint8"    ? pixels.depth() == CV_8U
                             : header.type == "uint16" ? pixels.depth() == CV_16U
                             : header.type == "double" ? pixels.depth() == CV_64F
                                                       : pixels.depth() == CV_32F);
  if (!as_announced || pixels.channels() < header.colours) damaged(path, format, "pixels do not match the header");
  std::vector<Image> planes;
  for (int i = 0; i < header.colours; ++i)  // OpenCV keeps colours as B,G,R
    planes.push_back(plane_of(path, pixels, header.colours == 3 ? 2 - i : 0, header.scale));
  if (header.no_data)
    for (Image& plane : planes)
      std::replace(plane.data(), plane.data() + plane.size(), header.no_data->value,
                   std::numeric_limits<float>::quiet_NaN());
  return planes;
}

/// The luminance plane as it is stored. Of damaged data libjpeg makes some image, with a warning, and OpenCV hands it
/// on: here the first warning is an error.
cv::Mat luminance_of_jpeg(const std::vector<unsigned char>& file, const RasterHeader& header) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), &tjDestroy);
  cv::Mat pixels(static_cast<int>(header.height), static_cast<int>(header.width), CV_8UC1);
  const int failed =
      tjDecompress2(decoder.get(), file.data(), file.size(), pixels.data, pixels.cols, static_cast<int>(pixels.step),
                    pixels.rows, TJPF_GRAY, TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT);
  if (failed != 0) throw std::runtime_error(tjGetErrorStr2(decoder.get()));
  return pixels;
}

}  // namespace

std::vector<Image> decode_png(const std::string& path, const RasterHeader& header) {
  return decode(path, "PNG", header, [&] {
    std::vector<unsigned char> file;
    static_cast<void>(scan_png(path, &file));
    return cv::imdecode(file, cv::IMREAD_UNCHANGED);
  });
}

std::vector<Image> decode_jpeg(const std::string& path, const RasterHeader& header) {
  return decode(path, "JPEG", header, [&] {
    std::vector<unsigned char> file;
    static_cast<void>(scan_jpeg(path, &file));
    return luminance_of_jpeg(file, header);
  });
}

std::vector<Image> decode_tiff(const std::string& path, const RasterHeader& header) {
  return decode(path, "TIFF", header, [&] {
    verify_tiff(path);
    cv::Mat pixels = cv::imread(path, cv::IMREAD_UNCHANGED);
    silence_tiff();  // OpenCV may have installed its own handlers
    return pixels;
  });
}

}  // namespace mtf::io::module
