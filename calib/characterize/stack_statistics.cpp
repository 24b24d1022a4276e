// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/stack_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <string>

#include "mtf/error.h"
#include "mtf/math/clones.h"
#include "mtf/parallel.h"

namespace calib {
namespace {

constexpr std::int64_t kRows = 64;  // of a block; blocks are added in order, whoever worked on them
constexpr std::int64_t kLanes = 8;

/// One row: the values about the reference into `x`, the sums of pixels and columns, and what there is to count.
struct RowCounts {
  std::int64_t low, high;
  std::uint32_t bits;
  bool whole, finite;
};
MTFKIT_CLONES RowCounts add_row(const float* values, std::int64_t width, double reference, CountRange range,
                                double* __restrict x, double* __restrict pixel, double* __restrict pixel_squares,
                                double* __restrict columns) {
  for (std::int64_t i = 0; i < width; ++i) {
    const double d = static_cast<double>(values[i]) - reference;
    x[i] = d;
    pixel[i] += d;
    pixel_squares[i] += d * d;
    columns[i] += d;
  }
  const auto lowest = static_cast<float>(range.low), highest = static_cast<float>(range.high);
  std::int32_t low = 0, high = 0, fractions = 0, others = 0;
  std::uint32_t bits = 0;
  for (std::int64_t i = 0; i < width; ++i) {
    low += values[i] <= lowest ? 1 : 0;
    high += values[i] >= highest ? 1 : 0;
    // What a converter gives; larger values and fractions are no counts, nor is NaN, which std::max leaves out here.
    const float within = std::min(std::max(-2147483648.0F, values[i]), 2147483520.0F);
    const auto number = static_cast<std::int32_t>(within);
    fractions += static_cast<float>(number) != values[i] ? 1 : 0;
    others += values[i] - values[i] != 0.0F ? 1 : 0;
    bits |= static_cast<std::uint32_t>(number);
  }
  return {low, high, bits, fractions == 0, others == 0};
}

/// The sums of a row of values, of their squares and of their products at kLags, which are exact for counts of up to
/// 2^19 pixels within 2^17 of the reference. `rows`: the row and the two above it, with zeros around them, so that a
/// pixel without a neighbour adds none. Eight partial sums each: they are as many lanes, and the order of additions is
/// the same on every machine.
using RowSums = std::array<double, 2 + kLags.size()>;
MTFKIT_CLONES void sum_row(const double* const* rows, std::int64_t width, double* sums) {
  double part[2 + kLags.size()][kLanes]{};
  for (std::int64_t i = 0; i < width; i += kLanes)
    for (std::int64_t k = 0; k < kLanes; ++k) {
      const double x = rows[0][i + k];
      part[0][k] += x;
      part[1][k] += x * x;
      for (std::size_t j = 0; j < kLags.size(); ++j)
        part[2 + j][k] += x * rows[kLags[j].rows][i + k - kLags[j].columns];
    }
  for (std::size_t j = 0; j < 2 + kLags.size(); ++j) {
    const double* p = part[j];
    sums[j] = ((p[0] + p[1]) + (p[2] + p[3])) + ((p[4] + p[5]) + (p[6] + p[7]));
  }
}

/// Adds the squares of the steps from the row in the frame before, which it becomes.
MTFKIT_CLONES void add_steps(const float* __restrict row, float* __restrict before, float* __restrict squares,
                             std::int64_t width) {
  for (std::int64_t i = 0; i < width; ++i) {
    const float step = row[i] - before[i];
    squares[i] += step * step;
    before[i] = row[i];
  }
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

/// What a block of rows of a frame adds to the totals. Sums of counts are exact: long doubles are up to 2^64.
struct StackStatistics::Part {
  std::array<long double, 2 + kLags.size()> sums{};  ///< as RowSums
  long double row_squares = 0.0L;
  std::vector<double> columns{};
  std::int64_t low = 0, high = 0;
  std::uint32_t bits = 0;
  bool whole = true, finite = true;
};

StackStatistics::StackStatistics(std::int64_t width, std::int64_t height, CountRange range)
    // The scatter of a million pixels is known well enough; an odd step meets rows of either parity.
    : width_(width),
      height_(height),
      range_(range),
      every_((width * height >> 20) | 1),
      scale_every_((width * height >> 18) | 1) {
  if (width < 2 || height < 2)
    throw mtf::UsageError("frames of " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels; at least two columns and two rows are needed");
  sum_.assign(static_cast<std::size_t>(pixels()), 0.0);
  squares_.assign(static_cast<std::size_t>((height_ + every_ - 1) / every_ * width_), 0.0);
  scales_ = TimeScales((height_ + scale_every_ - 1) / scale_every_ * width_);
  before_.assign(squares_.size(), 0.0F);
  steps_ = before_;
}

void StackStatistics::add(std::span<const mtf::ImageView<const float>> frames, int threads) {
  if (frames.empty()) return;
  for (const auto& frame : frames)
    if (frame.width != width_ || frame.height != height_) {
      frames_ += &frame - frames.data();
      throw mtf::UsageError("a frame of " + std::to_string(frame.width) + " x " + std::to_string(frame.height) +
                            " among frames of " + std::to_string(width_) + " x " + std::to_string(height_) +
                            "; give all one size");
    }
  if (frames_ == 0) {
    double sum = 0.0;
    for (std::int64_t y = 0; y < height_; ++y)
      for (std::int64_t x = 0; x < width_; ++x) sum += static_cast<double>(frames[0].at(x, y));
    reference_ = std::floor(sum / static_cast<double>(pixels()));
  }
  scales_.reserve(frames_ + std::ssize(frames));
  const std::vector<Part> parts = reduce(frames, threads);
  const std::size_t blocks = parts.size() / frames.size();
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::span<const Part> frame(parts.data() + f * blocks, blocks);
    if (std::any_of(frame.begin(), frame.end(), [](const Part& part) { return !part.finite; })) {
      std::int64_t i = 0;
      while (std::isfinite(frames[f].at(i % width_, i / width_))) ++i;
      throw mtf::UsageError("frame " + std::to_string(frames_ + 1) + " holds NaN or infinite values, the first at " +
                            std::to_string(i % width_) + ", " + std::to_string(i / width_) + "; leave it out");
    }
    take(frame);
  }
}

std::vector<StackStatistics::Part> StackStatistics::reduce(std::span<const mtf::ImageView<const float>> frames,
                                                           int threads) {
  const std::int64_t blocks = (height_ + kRows - 1) / kRows;
  std::vector<Part> parts(frames.size() * static_cast<std::size_t>(blocks));
  mtf::parallel_for(blocks, 1, threads, [&](std::int64_t block, std::int64_t) {
    // Of each frame a row and the two above it, in turn; zeros around them make whole lanes.
    const std::int64_t stride = (width_ + 3 * kLanes - 1) / kLanes * kLanes;
    std::vector<double> not_kept(static_cast<std::size_t>(width_)),
        about(frames.size() * 3 * static_cast<std::size_t>(stride));
    const std::int64_t first = block * kRows, last = std::min(height_, first + kRows);
    for (std::int64_t y = std::max<std::int64_t>(0, first - 2); y < last; ++y)
      for (std::size_t f = 0; f < frames.size(); ++f) {
        const auto line = [&](std::int64_t row) {
          return about.data() + (static_cast<std::int64_t>(3 * f) + row % 3) * stride + kLanes;
        };
        if (y < first) {
          for (std::int64_t x = 0; x < width_; ++x) line(y)[x] = static_cast<double>(frames[f].at(x, y)) - reference_;
          continue;
        }
        Part& part = parts[f * static_cast<std::size_t>(blocks) + static_cast<std::size_t>(block)];
        part.columns.resize(static_cast<std::size_t>(width_));
        double* squares = y % every_ == 0 ? squares_.data() + y / every_ * width_ : not_kept.data();
        const RowCounts row = add_row(frames[f].row(y), width_, reference_, range_, line(y), sum_.data() + y * width_,
                                      squares, part.columns.data());
        part.low += row.low;
        part.high += row.high;
        part.bits |= row.bits;
        part.whole = part.whole && row.whole;
        part.finite = part.finite && row.finite;
        RowSums sums;
        sum_row(std::array<const double*, 3>{line(y), line(y + 2), line(y + 1)}.data(), width_, sums.data());
        for (std::size_t j = 0; j < sums.size(); ++j) part.sums[j] += sums[j];
        part.row_squares += static_cast<long double>(sums[0]) * sums[0];
        if (y % scale_every_ == 0)
          scales_.add(y / scale_every_ * width_, {line(y), static_cast<std::size_t>(width_)},
                      frames_ + static_cast<std::int64_t>(f));
        if (y % every_ != 0) continue;
        float* const before = before_.data() + y / every_ * width_;
        if (frames_ == 0 && f == 0) std::copy_n(frames[f].row(y), width_, before);
        add_steps(frames[f].row(y), before, steps_.data() + y / every_ * width_, width_);
      }
  });
  return parts;
}

void StackStatistics::take(std::span<const Part> frame) {
  std::vector<double> columns(static_cast<std::size_t>(width_), 0.0);
  long double total = 0.0L;
  for (const Part& part : frame) {
    total += part.sums[0];
    all_squares_ += part.sums[1];
    row_squares_ += part.row_squares;
    low_ += part.low;
    high_ += part.high;
    bits_ |= part.bits;
    whole_ = whole_ && part.whole;
    for (std::size_t k = 0; k < kLags.size(); ++k) products_[k] += part.sums[2 + k];
    for (std::size_t x = 0; x < columns.size(); ++x) columns[x] += part.columns[x];
  }
  for (const double column : columns) column_squares_ += static_cast<long double>(column) * column;
  frame_squares_ += total * total;
  frame_sums_.push_back(static_cast<double>(total));
  total_ += total;
  ++frames_;
}

double StackStatistics::share(std::int64_t count) const {
  return frames_ == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(frames_ * pixels());
}

std::vector<std::int64_t> StackStatistics::stuck(bool high) const {
  std::vector<std::int64_t> places;
  const auto most = static_cast<std::size_t>(kMostStuck * static_cast<double>(pixels()));
  for (std::int64_t i = 0; i < pixels() && places.size() <= most; ++i)
    if (high ? pixel_mean(i) >= range_.high : pixel_mean(i) <= range_.low) places.push_back(i);
  return places.size() > most ? std::vector<std::int64_t>() : places;
}

double StackStatistics::mean() const {
  return reference_ + static_cast<double>(total_ / static_cast<long double>(frames_ * pixels()));
}

std::vector<double> StackStatistics::frame_means() const {
  std::vector<double> means;
  for (const double sum : frame_sums_) means.push_back(reference_ + sum / static_cast<double>(pixels()));
  return means;
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

double StackStatistics::kept_variance(std::int64_t i) const {
  if (frames_ < 2) throw mtf::UsageError("one frame has no temporal variance; give two frames or more");
  const auto T = static_cast<double>(frames_);
  const double sum = sum_[static_cast<std::size_t>(i / width_ * every_ * width_ + i % width_)];
  return (squares_[static_cast<std::size_t>(i)] - sum * sum / T) / (T - 1.0);
}

double StackStatistics::frame_correlation() const {
  double variance = 0.0;
  for (std::int64_t i = 0; i < std::ssize(squares_); ++i) variance += kept_variance(i);
  const double steps = std::accumulate(steps_.begin(), steps_.end(), 0.0) / static_cast<double>(frames_ - 1);
  return variance > 0.0 ? 1.0 - steps / (2.0 * variance) : 0.0;
}

std::vector<float> StackStatistics::pixel_variances() const {
  std::vector<float> variances;
  for (std::int64_t i = 0; i < std::ssize(squares_); ++i) variances.push_back(static_cast<float>(kept_variance(i)));
  return variances;
}

NoiseScales StackStatistics::noise_scales() const {
  NoiseScales noise{.pixels = scales_.squares(frames_), .frames = frames_, .rows_apart = scale_every_};
  TimeScales of_frames(1);
  of_frames.reserve(frames_);
  for (std::int64_t t = 0; t < frames_; ++t) {
    const double mean = frame_sums_[static_cast<std::size_t>(t)] / static_cast<double>(pixels());
    of_frames.add(0, {&mean, 1}, t);
  }
  for (const std::vector<float>& one : of_frames.squares(frames_))
    noise.frame.push_back(static_cast<double>(one.front()));
  for (const std::vector<float>& one : noise.pixels)
    noise.mean.push_back(std::accumulate(one.begin(), one.end(), 0.0) /
                         (noise.differences(noise.mean.size()) * static_cast<double>(one.size())));
  return noise;
}

std::uint32_t StackStatistics::step() const {
  if (!whole_) return 0;
  return bits_ == 0 ? 1 : std::uint32_t{1} << std::countr_zero(bits_);
}

double StackStatistics::von_neumann() const {
  const auto T = static_cast<long double>(frames_);
  const long double about_mean = frame_squares_ - total_ * total_ / T;
  if (frames_ < 3 || !(about_mean > 0.0L)) return 2.0;
  long double squares = 0.0L;
  for (std::size_t t = 1; t < frame_sums_.size(); ++t) {
    const long double step = static_cast<long double>(frame_sums_[t]) - frame_sums_[t - 1];
    squares += step * step;
  }
  return static_cast<double>((squares / (T - 1.0L)) / (about_mean / T));
}

FrameDrift StackStatistics::drift() const {
  if (frames_ < 4) return {};
  const auto T = static_cast<long double>(frames_), size = static_cast<long double>(pixels());
  const long double spread = T * (T * T - 1.0L) / 12.0L;  // of the frames' numbers about their mean
  long double moment = 0.0L;
  for (std::size_t t = 0; t < frame_sums_.size(); ++t)
    moment += (static_cast<long double>(t) - 0.5L * (T - 1.0L)) * frame_sums_[t];
  const long double slope = moment / spread;
  const long double rest = frame_squares_ - total_ * total_ / T - slope * slope * spread;
  return {static_cast<double>(slope / size),
          static_cast<double>(std::sqrt(std::max(0.0L, rest) / ((T - 2.0L) * spread)) / size)};
}

}  // namespace calib
