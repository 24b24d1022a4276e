// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/codecs.h"

#include "mtf/io/codecs/opencv_filters.h"

namespace mtf::io {
namespace {

constexpr Module kCodecs{"mtfkit_codecs", "the PNG, TIFF and JPEG codecs"};
constexpr Module kOpenCv{.name = "mtfkit_opencv", .what = "OpenCV", .in_all = true, .package = "mtfkit-codecs"};

}  // namespace

const Codecs& codecs() {
  static const Codecs& table = open_module<Codecs>(kCodecs);
  return table;
}

bool has_codecs() { return has_module(kCodecs); }

bool has_opencv() { return has_module(kOpenCv); }

OpenCvFilter opencv_filter(const OpenCvJob& job) {
  static const OpenCv& table = open_module<OpenCv>(kOpenCv);
  return table.filter(job);
}

}  // namespace mtf::io
