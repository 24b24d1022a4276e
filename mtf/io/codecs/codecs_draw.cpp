// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mtf/error.h"
#include "mtf/io/codecs/codecs_parts.h"

namespace mtf::io::module {
namespace {

constexpr int kShift = 4;  // sixteenths of a pixel
constexpr double kFarthest = 1e6;

cv::Scalar scalar(const Colour& colour) { return {double(colour[0]), double(colour[1]), double(colour[2])}; }

/// OpenCV puts centres of pixels at whole numbers.
cv::Point sixteenths(double x, double y, int zoom) {
  const auto place = [&](double at) {
    return cvRound(std::clamp(at * zoom - 0.5, -kFarthest, kFarthest) * (1 << kShift));
  };
  return {place(x), place(y)};
}

void write(cv::Mat& picture, const Caption& caption, int zoom) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  const double scale = 0.4 * caption.size;
  const int thickness = std::max(1, cvRound(caption.size));
  int below = 0;
  const cv::Size size = cv::getTextSize(caption.text, kFont, scale, thickness, &below);
  cv::Point at = sixteenths(caption.x, caption.y, zoom);
  at = {(at.x >> kShift) - cvRound(caption.alignment * size.width), at.y >> kShift};
  // A dark rim keeps the words readable on any ground.
  for (const auto& [colour, width] :
       {std::pair{cv::Scalar(0, 0, 0), thickness + 2}, std::pair{scalar(caption.colour), thickness}})
    cv::putText(picture, caption.text, at, kFont, scale, colour, width, cv::LINE_AA);
}

}  // namespace

RasterData draw(const RasterData& data, const Drawing& drawing) {
  try {
    cv::Mat picture(static_cast<int>(data.height), static_cast<int>(data.width), CV_8UC3);
    std::copy(data.samples.begin(), data.samples.end(), picture.ptr<std::uint8_t>());
    if (drawing.false_colour) {
      cv::applyColorMap(picture, picture, cv::COLORMAP_INFERNO);
      cv::cvtColor(picture, picture, cv::COLOR_BGR2RGB);
    }
    if (drawing.zoom > 1) cv::resize(picture, picture, {}, drawing.zoom, drawing.zoom, cv::INTER_NEAREST);
    for (const Stroke& stroke : drawing.strokes) {
      std::vector<cv::Point> points;
      for (const auto& [x, y] : stroke.points) points.push_back(sixteenths(x, y, drawing.zoom));
      cv::polylines(picture, points, false, scalar(stroke.colour), 1, cv::LINE_AA, kShift);
    }
    for (const Caption& caption : drawing.captions) write(picture, caption, drawing.zoom);
    RasterData drawn = data;
    drawn.width = picture.cols;
    drawn.height = picture.rows;
    drawn.samples.assign(picture.ptr<std::uint8_t>(), picture.ptr<std::uint8_t>() + picture.total() * 3);
    return drawn;
  } catch (const cv::Exception& e) {
    throw RuntimeError("OpenCV refuses to draw: " + e.err);
  }
}

}  // namespace mtf::io::module
