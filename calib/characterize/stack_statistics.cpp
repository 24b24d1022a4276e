// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/stack_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "mtf/error.h"
#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace calib {
namespace {

constexpr std::int64_t kRows = 32;  // of a block; blocks are added in order, whoever worked on them

/// What a block of rows adds to the totals. Sums of counts are exact: those of a row, of up to 2^19 pixels within 2^17
/// of the reference, in doubles, all others in long doubles up to 2^64.
struct Block {
  long double squares = 0.0L, row_squares = 0.0L, total = 0.0L;
  std::array<long double, kLags.size()> products{};
  std::vector<double> columns;
  std::int64_t low = 0, high = 0;
  std::uint32_t bits = 0;
  bool whole = true;
};

/// Eight partial sums: they are as many lanes, and the order of additions is the same on every machine.
MTFKIT_CLONES double sum_of_products(const double* a, const double* b, std::int64_t count) {
  std::array<double, 8> part{};
  std::int64_t i = 0;
  for (; i + 8 <= count; i += 8)
    for (std::int64_t k = 0; k < 8; ++k) part[static_cast<std::size_t>(k)] += a[i + k] * b[i + k];
  for (; i < count; ++i) part[0] += a[i] * b[i];
  return ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
}

/// One row: the values about the reference into `x`, the sums of pixels and columns, and what there is to count.
struct RowCounts {
  std::int64_t low, high;
  std::uint32_t bits;
  bool whole;
};
MTFKIT_CLONES RowCounts add_row(const float* values, std::int64_t width, double reference, CountRange range, double* x,
                                double* pixel, double* pixel_squares, double* columns) {
  for (std::int64_t i = 0; i < width; ++i) {
    const double d = static_cast<double>(values[i]) - reference;
    x[i] = d;
    pixel[i] += d;
    pixel_squares[i] += d * d;
    columns[i] += d;
  }
  const auto lowest = static_cast<float>(range.low), highest = static_cast<float>(range.high);
  std::int32_t low = 0, high = 0, fractions = 0;
  std::uint32_t bits = 0;
  for (std::int64_t i = 0; i < width; ++i) {
    low += values[i] <= lowest ? 1 : 0;
    high += values[i] >= highest ? 1 : 0;
    // What a converter gives; larger values and fractions are no counts.
    const float within = std::min(std::max(values[i], -2147483648.0F), 2147483520.0F);
    const auto number = static_cast<std::int32_t>(within);
    fractions += static_cast<float>(number) != values[i] ? 1 : 0;
    bits |= static_cast<std::uint32_t>(number);
  }
  return {low, high, bits, fractions == 0};
}

MTFKIT_CLONES bool all_finite(const float* values, std::int64_t width) {
  std::int32_t others = 0;
  for (std::int64_t i = 0; i < width; ++i) others += values[i] - values[i] != 0.0F ? 1 : 0;
  return others == 0;
}

/// Of the pairs of a lag in a row: the first columns of the upper (or left) and of the lower pixel, and their number.
struct Pairs {
  std::int64_t first, second, count;
};
Pairs pairs_of(Lag lag, std::int64_t width) {
  const std::int64_t shift = lag.columns;
  return {std::max<std::int64_t>(0, -shift), std::max<std::int64_t>(0, shift), width - std::abs(shift)};
}

}  // namespace

StackStatistics::StackStatistics(std::int64_t width, std::int64_t height, CountRange range)
    : width_(width), height_(height), range_(range) {
  if (width < 2 || height < 2)
    throw mtf::UsageError("frames of " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels; at least two columns and two rows are needed");
  sum_.assign(static_cast<std::size_t>(pixels()), 0.0);
  squares_.assign(static_cast<std::size_t>(pixels()), 0.0);
}

void StackStatistics::add(mtf::ImageView<const float> frame, int threads) {
  if (frame.width != width_ || frame.height != height_)
    throw mtf::UsageError("a frame of " + std::to_string(frame.width) + " x " + std::to_string(frame.height) +
                          " among frames of " + std::to_string(width_) + " x " + std::to_string(height_) +
                          "; give all one size");
  for (std::int64_t y = 0; y < height_; ++y)
    for (std::int64_t x = all_finite(frame.row(y), width_) ? width_ : 0; x < width_; ++x)
      if (!std::isfinite(frame.at(x, y)))
        throw mtf::UsageError("frame " + std::to_string(frames_ + 1) + " holds NaN or infinite values, the first at " +
                              std::to_string(x) + ", " + std::to_string(y) + "; leave it out");
  if (frames_ == 0) {
    double sum = 0.0;
    for (std::int64_t y = 0; y < height_; ++y)
      for (std::int64_t x = 0; x < width_; ++x) sum += static_cast<double>(frame.at(x, y));
    reference_ = std::floor(sum / static_cast<double>(pixels()));
  }
  const std::int64_t blocks = (height_ + kRows - 1) / kRows;
  std::vector<Block> parts(static_cast<std::size_t>(blocks));
  mtf::parallel_for(blocks, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    const auto n = static_cast<std::size_t>(width_);
    std::vector<double> about(3 * n);  // the values of a row and of the two above it
    const std::vector<double> ones(n, 1.0);
    for (std::int64_t b = begin; b < end; ++b) {
      Block& part = parts[static_cast<std::size_t>(b)];
      part.columns.assign(n, 0.0);
      const auto line = [&](std::int64_t y) { return about.data() + static_cast<std::size_t>(y % 3) * n; };
      const std::int64_t first = b * kRows, last = std::min(height_, first + kRows);
      for (std::int64_t y = std::max<std::int64_t>(0, first - 2); y < first; ++y)
        for (std::int64_t x = 0; x < width_; ++x) line(y)[x] = static_cast<double>(frame.at(x, y)) - reference_;
      for (std::int64_t y = first; y < last; ++y) {
        const std::int64_t at = y * width_;
        const RowCounts row = add_row(frame.row(y), width_, reference_, range_, line(y), sum_.data() + at,
                                      squares_.data() + at, part.columns.data());
        const double sum = sum_of_products(line(y), ones.data(), width_);
        part.total += sum;
        part.squares += sum_of_products(line(y), line(y), width_);
        part.row_squares += static_cast<long double>(sum) * sum;
        part.low += row.low;
        part.high += row.high;
        part.bits |= row.bits;
        part.whole = part.whole && row.whole;
        for (std::size_t k = 0; k < kLags.size(); ++k) {
          if (y < kLags[k].rows) continue;
          const Pairs p = pairs_of(kLags[k], width_);
          part.products[k] += sum_of_products(line(y - kLags[k].rows) + p.first, line(y) + p.second, p.count);
        }
      }
    }
  });
  std::vector<double> columns(static_cast<std::size_t>(width_), 0.0);
  long double total = 0.0L;
  for (const Block& part : parts) {
    total += part.total;
    all_squares_ += part.squares;
    row_squares_ += part.row_squares;
    low_ += part.low;
    high_ += part.high;
    bits_ |= part.bits;
    whole_ = whole_ && part.whole;
    for (std::size_t k = 0; k < kLags.size(); ++k) products_[k] += part.products[k];
    for (std::size_t x = 0; x < columns.size(); ++x) columns[x] += part.columns[x];
  }
  for (const double column : columns) column_squares_ += static_cast<long double>(column) * column;
  frame_squares_ += total * total;
  const auto sum = static_cast<double>(total);
  if (frames_ > 0) step_squares_ += (static_cast<long double>(sum) - last_) * (static_cast<long double>(sum) - last_);
  last_ = sum;
  total_ += total;
  ++frames_;
}

double StackStatistics::share(std::int64_t count) const {
  return frames_ == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(frames_ * pixels());
}

double StackStatistics::mean() const {
  return reference_ + static_cast<double>(total_ / static_cast<long double>(frames_ * pixels()));
}

double StackStatistics::pixel_mean(std::int64_t i) const {
  return reference_ + sum_[static_cast<std::size_t>(i)] / static_cast<double>(frames_);
}

radiometry::MeanSquares StackStatistics::mean_squares() const {
  if (frames_ < 2)
    throw mtf::UsageError("a stack of " + std::to_string(frames_) + (frames_ == 1 ? " frame has" : " frames has") +
                          " no temporal noise; give two frames or more");
  const auto T = static_cast<double>(frames_), V = static_cast<double>(height_), H = static_cast<double>(width_);
  long double pixel_squares = 0.0L, row_squares = 0.0L, column_squares = 0.0L;
  std::vector<long double> columns(static_cast<std::size_t>(width_), 0.0L);
  for (std::int64_t y = 0, i = 0; y < height_; ++y) {
    long double row = 0.0L;
    for (std::int64_t x = 0; x < width_; ++x, ++i) {
      const long double value = sum_[static_cast<std::size_t>(i)];
      pixel_squares += value * value;
      columns[static_cast<std::size_t>(x)] += value;
      row += value;
    }
    row_squares += row * row;
  }
  for (const long double column : columns) column_squares += column * column;
  return radiometry::mean_squares({.frames = T,
                                   .rows = V,
                                   .columns = H,
                                   .all = total_ * total_ / (T * V * H),
                                   .t = frame_squares_ / (V * H),
                                   .v = row_squares / (T * H),
                                   .h = column_squares / (T * V),
                                   .tv = row_squares_ / H,
                                   .th = column_squares_ / V,
                                   .vh = pixel_squares / T,
                                   .tvh = all_squares_});
}

Covariance StackStatistics::covariance(Lag lag) const {
  const auto found = std::find_if(kLags.begin(), kLags.end(),
                                  [&](Lag one) { return one.rows == lag.rows && one.columns == lag.columns; });
  const Pairs p = pairs_of(lag, width_);
  if (found == kLags.end() || frames_ < 2 || p.count < 1 || height_ <= lag.rows)
    throw mtf::UsageError("the covariance needs two frames, and a lag that is summed and within the frame");
  long double fixed = 0.0L;
  for (std::int64_t y = lag.rows; y < height_; ++y) {
    const double *above = sum_.data() + (y - lag.rows) * width_ + p.first, *here = sum_.data() + y * width_ + p.second;
    for (std::int64_t x = 0; x < p.count; ++x) fixed += static_cast<long double>(above[x]) * here[x];
  }
  const auto T = static_cast<long double>(frames_);
  const auto pairs = static_cast<double>(p.count * (height_ - lag.rows));
  const long double sum = products_[static_cast<std::size_t>(found - kLags.begin())] - fixed / T;
  return {static_cast<double>(sum / (T - 1.0L)) / pairs, pairs};
}

double StackStatistics::variance_sd() const {
  if (frames_ < 2) throw mtf::UsageError("one frame has no temporal variance; give two frames or more");
  const auto T = static_cast<double>(frames_), n = static_cast<double>(pixels());
  const auto variance = [&](std::size_t i) { return (squares_[i] - sum_[i] * sum_[i] / T) / (T - 1.0); };
  double mean = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < sum_.size(); ++i) mean += variance(i) / n;
  for (std::size_t i = 0; i < sum_.size(); ++i) squares += (variance(i) - mean) * (variance(i) - mean);
  return std::sqrt(squares / (n - 1.0) / n);
}

std::uint32_t StackStatistics::step() const {
  if (!whole_) return 0;
  return bits_ == 0 ? 1 : std::uint32_t{1} << std::countr_zero(bits_);
}

double StackStatistics::von_neumann() const {
  const auto T = static_cast<long double>(frames_);
  const long double about_mean = frame_squares_ - total_ * total_ / T;
  return frames_ < 3 || !(about_mean > 0.0L) ? 2.0
                                             : static_cast<double>((step_squares_ / (T - 1.0L)) / (about_mean / T));
}

}  // namespace calib
