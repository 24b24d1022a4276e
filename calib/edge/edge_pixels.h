// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pixels that an edge is measured from, as lists.

#include <cstdint>
#include <memory>
#include <optional>

#include "calib/edge/edge_curve.h"
#include "mtf/image.h"

namespace calib {

/// Positions in pixels from the middle of the region, values less `offset` over `scale`, so that sums of squares
/// neither overflow nor lose digits. The three lists share one allocation: with three smaller ones the C library would
/// return the memory to the system after each edge and map it again page by page.
class EdgePixels {
 public:
  explicit EdgePixels(std::size_t most) : most_(most), data_(std::make_unique_for_overwrite<double[]>(3 * most)) {}
  std::size_t size() const { return size_; }
  const double* x() const { return data_.get(); }
  const double* y() const { return data_.get() + most_; }
  const double* value() const { return data_.get() + 2 * most_; }
  double* x() { return data_.get(); }
  double* y() { return data_.get() + most_; }
  double* value() { return data_.get() + 2 * most_; }
  /// The first `size` of `most` pixels.
  void resize(std::size_t size) { size_ = size; }
  void add(double x_px, double y_px, double one) {
    x()[size_] = x_px;
    y()[size_] = y_px;
    value()[size_++] = one;
  }

 private:
  std::size_t most_, size_ = 0;
  std::unique_ptr<double[]> data_;
};

/// The step through the list that takes about `some` of the pixels. It is prime to the length of the rows: an upright
/// edge is seen in few columns, none of which may be left out.
std::size_t step_for(const EdgePixels& pixels, std::size_t some);

/// Statistics of a region, before anything is known of its edge.
struct RegionFacts {
  Point middle;                      ///< of the region, pixels of the image
  std::int64_t finite = 0;           ///< pixels with data
  std::int64_t clipped = 0;          ///< of these, at the saturation or floor
  double low = 0.0, high = 0.0;      ///< smallest and largest value that is not wild
  std::int64_t wild = 0;             ///< values many times further from nearly all others than these from each other
  double offset = 0.0, scale = 1.0;  ///< value = offset + scale x EdgePixels::value
  bool holds(double value) const { return value >= low && value <= high; }  ///< neither wild nor NaN
};

/// Why no pixel of a region without finite values has data: "" unless some are infinite.
std::string why_infinite(mtf::ImageView<const float> image, const Roi& roi);

/// Limits beyond which values are clipped. Clipped and wild values, NaN and infinite ones are left out of the lists.
struct ValueLimits {
  std::optional<double> saturation, floor;
  /// The limits are compared as float32, the type of the pixels.
  bool clipped(float value) const {
    return (saturation && value >= static_cast<float>(*saturation)) || (floor && value <= static_cast<float>(*floor));
  }
};

/// Calls visit(x, y) for every `step`-th pixel of a region, row by row.
template <class Visit>
void visit_some(const Roi& roi, std::int64_t step, const Visit& visit) {
  for (std::int64_t i = 0, j = 0;; i += step) {
    if (i >= roi.width) {
      j += i / roi.width;
      i %= roi.width;
    }
    if (j >= roi.height) return;
    visit(roi.x + i, roi.y + j);
  }
}

RegionFacts survey(mtf::ImageView<const float> image, const Roi& roi, const ValueLimits& limits);

/// Means of square blocks, at most about 48 x 48 of them; `block_px` is set to their side.
EdgePixels gather_blocks(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts,
                         const ValueLimits& limits, std::int64_t& block_px);

/// All pixels within `range_px` of the curve's tangent at its origin.
EdgePixels gather_pixels(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts,
                         const ValueLimits& limits, const EdgeCurve& curve, double range_px);

}  // namespace calib
