// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "mtf/error.h"
#include "mtf/io/codecs/opencv_filters.h"
#include "mtf/version.h"

namespace mtf::io {
namespace {

int border_type(Border border) {
  constexpr std::array kBorders{cv::BORDER_REFLECT, cv::BORDER_REPLICATE, cv::BORDER_CONSTANT, cv::BORDER_WRAP};
  return kBorders[static_cast<std::size_t>(border)];
}

cv::Mat as_floats(const std::vector<double>& values, std::int64_t rows, std::int64_t columns) {
  cv::Mat mat(static_cast<int>(rows), static_cast<int>(columns), CV_32F);
  for (int y = 0; y < mat.rows; ++y)
    for (int x = 0; x < mat.cols; ++x)
      mat.at<float>(y, x) = static_cast<float>(values[static_cast<std::size_t>(y * columns + x)]);
  return mat;
}

cv::Mat view_of(ImageView<const float> image) {  // OpenCV has no matrix of const; nobody writes to this one
  return {static_cast<int>(image.height), static_cast<int>(image.width), CV_32F, const_cast<float*>(image.data),
          static_cast<std::size_t>(image.stride) * sizeof(float)};
}

class Filter {
 public:
  explicit Filter(const OpenCvJob& job) : job_(job) {
    if (job.method == OpenCvJob::Method::dft) {
      const cv::Mat kernel = as_floats(job.kernel, job.kernel_height, job.kernel_width);
      cv::dft(kernel, kernel_);
      job_.kernel.clear();
      return;
    }
    // OpenCV correlates: a convolution needs the kernel turned about its origin.
    if (job.method == OpenCvJob::Method::filter2d)
      cv::flip(as_floats(job.kernel, job.kernel_height, job.kernel_width), kernel_, -1);
    const auto turned = [](std::vector<double> values) {
      std::reverse(values.begin(), values.end());
      return as_floats(values, 1, static_cast<std::int64_t>(values.size()));
    };
    kernel_x_ = turned(job.kernel_x);
    kernel_y_ = turned(job.kernel_y);
    anchor_ = {static_cast<int>(job.kernel_width - 1 - job.origin_x),
               static_cast<int>(job.kernel_height - 1 - job.origin_y)};
  }

  void operator()(ImageView<const float> in, ImageView<float> out) {
    const cv::Mat scene = view_of(in);
    if (job_.method == OpenCvJob::Method::dft)
      by_transform(scene);
    else
      by_kernel(scene);
    const bool dft = job_.method == OpenCvJob::Method::dft;
    const std::int64_t x0 = job_.first_x + (dft ? job_.pad_x : 0), y0 = job_.first_y + (dft ? job_.pad_y : 0);
    for (std::int64_t y = 0; y < out.height; ++y) {
      const float* from = filtered_.ptr<float>(static_cast<int>(y0 + y * job_.stride_y)) + x0;
      for (std::int64_t x = 0; x < out.width; ++x) out.row(y)[x] = from[x * job_.stride_x];
    }
  }

 private:
  void by_transform(const cv::Mat& scene) {
    cv::copyMakeBorder(scene, padded_, static_cast<int>(job_.pad_y),
                       static_cast<int>(job_.kernel_height - job_.height - job_.pad_y), static_cast<int>(job_.pad_x),
                       static_cast<int>(job_.kernel_width - job_.width - job_.pad_x), border_type(job_.border),
                       cv::Scalar(job_.border_value));
    cv::dft(padded_, spectrum_);
    cv::mulSpectrums(spectrum_, kernel_, spectrum_, 0);
    cv::dft(spectrum_, filtered_, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
  }

  void by_kernel(const cv::Mat& scene) {
    int type = border_type(job_.border);
    cv::Mat source = scene;
    if (job_.border == Border::constant || job_.border == Border::periodic) {
      // These filters have neither a constant border value nor wrapping, but they do read the samples around a region.
      const int left = static_cast<int>(job_.kernel_width), top = static_cast<int>(job_.kernel_height);
      cv::copyMakeBorder(scene, padded_, top, top, left, left, type, cv::Scalar(job_.border_value));
      source = padded_(cv::Rect(left, top, scene.cols, scene.rows));
      type = cv::BORDER_REPLICATE;
    }
    if (job_.method == OpenCvJob::Method::sep)
      cv::sepFilter2D(source, filtered_, CV_32F, kernel_x_, kernel_y_, anchor_, 0.0, type);
    else
      cv::filter2D(source, filtered_, CV_32F, kernel_, anchor_, 0.0, type);
  }

  OpenCvJob job_;
  cv::Mat kernel_, kernel_x_, kernel_y_, padded_, spectrum_, filtered_;
  cv::Point anchor_{-1, -1};
};

template <class Work>
auto guarded(const Work& work) {
  try {
    return work();
  } catch (const cv::Exception& e) {
    throw RuntimeError("OpenCV refuses to filter: " + e.err);
  }
}

OpenCvFilter make_filter(const OpenCvJob& job) {
  return guarded([&]() -> OpenCvFilter {
    cv::setNumThreads(1);
    const auto filter = std::make_shared<Filter>(job);
    return [filter](ImageView<const float> in, ImageView<float> out) { guarded([&] { (*filter)(in, out); }); };
  });
}

}  // namespace
}  // namespace mtf::io

extern "C" __attribute__((visibility("default"))) const void* mtfkit_opencv_table() {
  static const mtf::io::OpenCv table{{mtf::version, mtf::git_commit}, mtf::io::make_filter};
  return &table;
}
