// SPDX-License-Identifier: Apache-2.0
#pragma once

// Plain OpenCV doing the work of a plan, as its users write it: what benchmarks compare with. Lives in a module of its
// own (CMake target `mtfkit_opencv`), opened on first use (mtf/work/module.h): nothing else needs OpenCV.

#include <cstdint>
#include <functional>
#include <vector>

#include "mtf/border.h"
#include "mtf/image.h"
#include "mtf/work/module.h"

namespace mtf::io {

/// Filter at the scene's own samples, then pick every stride-th of them.
struct OpenCvJob {
  enum class Method { dft, filter2d, sep } method{};
  std::int64_t width = 0, height = 0;  ///< of the scene
  Border border{};
  double border_value = 0.0;
  /// The point spread, convolved with the scene. filter2d: kernel_height rows of kernel_width. sep: kernel_x and
  /// kernel_y. dft: its size is the transform's, it wraps, the origin is its first sample.
  std::int64_t kernel_width = 0, kernel_height = 0;
  std::vector<double> kernel, kernel_x, kernel_y;
  std::int64_t origin_x = 0, origin_y = 0;  ///< sample of the kernel at shift 0; filter2d and sep
  std::int64_t pad_x = 0, pad_y = 0;        ///< border samples to the left and above; dft
  std::int64_t first_x = 0, first_y = 0, stride_x = 1, stride_y = 1;  ///< samples that are picked
};

/// Filters one plane of the job's size into one of as many samples as are wanted. One thread.
using OpenCvFilter = std::function<void(ImageView<const float> in, ImageView<float> out)>;

/// Ready to run, kernels and their spectra prepared. Throws RuntimeError when OpenCV refuses, or when the module cannot
/// be opened (mtf/work/module.h).
OpenCvFilter opencv_filter(const OpenCvJob& job);

/// Whether the module is there; opens nothing.
bool has_opencv();

/// The table of the module mtfkit_opencv.
struct OpenCv {
  ModuleBuild build;
  OpenCvFilter (*filter)(const OpenCvJob& job);
};

}  // namespace mtf::io
