// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/point_response.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mtf/engines/fft/axis.h"

namespace mtf {
namespace {

constexpr int kCells = SceneSpectrum::kCells, kColumns = SceneSpectrum::kColumns, kRows = SceneSpectrum::kRows;

std::int64_t taps_within(std::int64_t half_width, double offset) { return 2 * half_width + (offset > 0.0 ? 0 : 1); }
double position(std::int64_t t, std::int64_t count) {
  return static_cast<double>(t) - 0.5 * static_cast<double>(count - 1);
}

// exp(sign 2 pi i k x / (2 kCells)) for taps 0 .. count - 1 of one frequency, in cells.
std::vector<Complex<double>> phases(double k, std::int64_t count, double sign) {
  std::vector<Complex<double>> e;
  for (std::int64_t t = 0; t < count; ++t)
    e.push_back(rotation(static_cast<long double>(sign * k * position(t, count) / (2.0 * kCells))));
  return e;
}

// Frequencies that no period of an OTF falls in step with: golden-ratio steps, one in each of `count` equal parts.
std::vector<double> irregular(int count, double low, double high) {
  std::vector<double> f;
  for (int i = 0; i < count; ++i) {
    const double jitter = std::fmod(0.381966011250105 + 0.618033988749895 * static_cast<double>(i), 1.0);
    f.push_back(low + (high - low) * (static_cast<double>(i) + jitter) / static_cast<double>(count));
  }
  return f;
}

std::vector<double> in_cy_mm(std::vector<double> cells, double step_um) {
  for (double& f : cells) f *= SceneSpectrum::corner_cy_mm(1, 500.0 / step_um);
  return cells;
}

constexpr double kMoreThanCorners = 1.5;

std::size_t index(std::int64_t row, std::int64_t column, std::int64_t columns) {
  return static_cast<std::size_t>(row * columns + column);
}

constexpr std::int64_t kFine = 1024, kFinePerCell = kFine / (2 * kCells);

// Largest of the values about each corner, from one cell before it to one after.
std::vector<double> about_corners(const std::vector<double>& fine) {
  std::vector<double> corners;
  for (std::int64_t i = 0; i <= kCells; ++i) {
    const std::int64_t lo = std::max<std::int64_t>(0, (i - 1) * kFinePerCell),
                       hi = std::min(kFine / 2, (i + 1) * kFinePerCell);
    corners.push_back(*std::max_element(fine.begin() + lo, fine.begin() + hi + 1));
  }
  return corners;
}

}  // namespace

double TapBox::sum() const { return std::accumulate(value.begin(), value.end(), 0.0); }

PointResponse::PointResponse(const FactoredOtf& sampler, const SampleGrid& in, std::int64_t ratio_x,
                             std::int64_t ratio_y)
    : offset_x_(ratio_x % 2 == 0 ? 0.5 : 0.0), offset_y_(ratio_y % 2 == 0 ? 0.5 : 0.0) {
  std::vector<double> fx, fy;
  for (int i = 0; i < kColumns; ++i) fx.push_back(SceneSpectrum::corner_cy_mm(i, 500.0 / in.step_x_um));
  for (int j = 0; j < kRows; ++j) fy.push_back(SceneSpectrum::corner_cy_mm(j - kCells, 500.0 / in.step_y_um));
  const FactoredOtf::Grid grid(sampler, fx, fy);
  std::vector<Complex<float>> row(kColumns);
  for (std::size_t j = 0; j < kRows; ++j) {
    grid.complex_row(j, row);
    for (const Complex<float>& h : row) otf_.push_back({h.re, h.im});
  }

  probe_x_ = irregular(24, 0.0, kCells);
  probe_y_ = irregular(40, -kCells, kCells);
  const FactoredOtf::Grid between(sampler, in_cy_mm(probe_x_, in.step_x_um), in_cy_mm(probe_y_, in.step_y_um));
  row.resize(probe_x_.size());
  for (std::size_t j = 0; j < probe_y_.size(); ++j) {
    between.complex_row(j, row);
    for (const Complex<float>& h : row) probes_.push_back({h.re, h.im});
  }

  taps_.rows = taps_within(kHalfWidth, offset_y_);
  taps_.columns = taps_within(kHalfWidth, offset_x_);
  taps_.value.assign(static_cast<std::size_t>(taps_.rows * taps_.columns), 0.0);
  // Along y for every column of corners, then along x; the corners at both Nyquist ends share one coefficient.
  std::vector<Complex<double>> along_y(static_cast<std::size_t>(taps_.rows * kColumns));
  for (int j = 0; j < kRows; ++j) {
    const auto e = phases(j - kCells, taps_.rows, -1.0);
    const double weight = (j == 0 || j == kRows - 1 ? 0.5 : 1.0) / (2.0 * kCells);
    for (std::int64_t t = 0; t < taps_.rows; ++t) {
      const Complex<double> w{e[static_cast<std::size_t>(t)].re * weight, e[static_cast<std::size_t>(t)].im * weight};
      for (int i = 0; i < kColumns; ++i) {
        const Complex<double>& h = otf_[index(j, i, kColumns)];
        Complex<double>& sum = along_y[index(t, i, kColumns)];
        sum.re += w.re * h.re - w.im * h.im;
        sum.im += w.re * h.im + w.im * h.re;
      }
    }
  }
  for (int i = 0; i < kColumns; ++i) {
    const auto e = phases(i, taps_.columns, -1.0);
    const double weight = (i == 0 || i == kColumns - 1 ? 1.0 : 2.0) / (2.0 * kCells);
    for (std::int64_t r = 0; r < taps_.rows; ++r) {
      const Complex<double> h = along_y[index(r, i, kColumns)];
      for (std::int64_t t = 0; t < taps_.columns; ++t)
        taps_.at(r, t) +=
            weight * (h.re * e[static_cast<std::size_t>(t)].re - h.im * e[static_cast<std::size_t>(t)].im);
    }
  }
}

TapBox PointResponse::box(std::int64_t half_x, std::int64_t half_y) const {
  TapBox box{taps_within(half_y, offset_y_), taps_within(half_x, offset_x_), {}};
  const std::int64_t top = (taps_.rows - box.rows) / 2, left = (taps_.columns - box.columns) / 2;
  for (std::int64_t r = 0; r < box.rows; ++r)
    for (std::int64_t c = 0; c < box.columns; ++c) box.value.push_back(taps_.at(top + r, left + c));
  return box;
}

std::vector<double> PointResponse::error(const TapBox& taps) const {
  std::vector<double> error(static_cast<std::size_t>(kRows * kColumns));
  std::vector<std::vector<Complex<double>>> e_x;
  for (int i = 0; i < kColumns; ++i) e_x.push_back(phases(i, taps.columns, 1.0));
  std::vector<Complex<double>> along_y(static_cast<std::size_t>(taps.columns));
  for (int j = 0; j < kRows; ++j) {
    const auto e = phases(j - kCells, taps.rows, 1.0);
    std::fill(along_y.begin(), along_y.end(), Complex<double>{});
    for (std::int64_t r = 0; r < taps.rows; ++r)
      for (std::int64_t c = 0; c < taps.columns; ++c) {
        along_y[static_cast<std::size_t>(c)].re += taps.at(r, c) * e[static_cast<std::size_t>(r)].re;
        along_y[static_cast<std::size_t>(c)].im += taps.at(r, c) * e[static_cast<std::size_t>(r)].im;
      }
    for (int i = 0; i < kColumns; ++i) {
      Complex<double> sum = otf_[index(j, i, kColumns)];
      const auto& turn = e_x[static_cast<std::size_t>(i)];
      for (std::size_t c = 0; c < along_y.size(); ++c) {
        sum.re -= along_y[c].re * turn[c].re - along_y[c].im * turn[c].im;
        sum.im -= along_y[c].re * turn[c].im + along_y[c].im * turn[c].re;
      }
      error[index(j, i, kColumns)] = std::sqrt(sum.re * sum.re + sum.im * sum.im);
    }
  }
  return error;
}

double PointResponse::excess(const TapBox& taps, std::span<const double> error) const {
  double worst = 0.0;
  std::vector<Complex<double>> along_y(static_cast<std::size_t>(taps.columns));
  for (std::size_t j = 0; j < probe_y_.size(); ++j) {
    const auto e = phases(probe_y_[j], taps.rows, 1.0);
    std::fill(along_y.begin(), along_y.end(), Complex<double>{});
    for (std::int64_t r = 0; r < taps.rows; ++r)
      for (std::int64_t c = 0; c < taps.columns; ++c) {
        along_y[static_cast<std::size_t>(c)].re += taps.at(r, c) * e[static_cast<std::size_t>(r)].re;
        along_y[static_cast<std::size_t>(c)].im += taps.at(r, c) * e[static_cast<std::size_t>(r)].im;
      }
    const auto row = static_cast<std::int64_t>(std::floor(probe_y_[j])) + kCells;
    for (std::size_t i = 0; i < probe_x_.size(); ++i) {
      const auto turn = phases(probe_x_[i], taps.columns, 1.0);
      Complex<double> sum{};
      for (std::size_t c = 0; c < along_y.size(); ++c) sum = sum + along_y[c] * turn[c];
      const Complex<double>& h = probes_[j * probe_x_.size() + i];
      const auto column = static_cast<std::int64_t>(std::floor(probe_x_[i]));
      const double* corner = error.data() + row * kColumns + column;
      const double about = std::max({corner[0], corner[1], corner[kColumns], corner[kColumns + 1]});
      worst = std::max(worst, std::hypot(sum.re - h.re, sum.im - h.im) - kMoreThanCorners * about);
    }
  }
  return worst;
}

double PointResponse::largest() const {
  double squares = 0.0;
  for (const Complex<double>& h : otf_) squares = std::max(squares, h.re * h.re + h.im * h.im);
  return std::sqrt(squares);
}

AxisResponse::AxisResponse(const FactoredOtf& sampler, Axis axis, double step_um, std::int64_t ratio)
    : offset_(ratio % 2 == 0 ? 0.5 : 0.0) {
  const FrequencyAxis along{Basis::fourier, kFine, step_um};
  std::vector<double> f;
  for (std::int64_t r = 0; r < kFine; ++r) f.push_back(along.cy_mm(along.signed_index(r)));
  const std::vector<double> zero{0.0};
  const double dc = sampler.dc();
  const FactoredOtf::Grid grid(sampler, axis == Axis::x ? f : zero, axis == Axis::x ? zero : f);
  std::vector<Complex<float>> row(axis == Axis::x ? f.size() : 1);
  for (std::size_t j = 0; j < (axis == Axis::x ? 1 : f.size()); ++j) {
    grid.complex_row(j, row);
    for (const Complex<float>& h : row) otf_.push_back({h.re / dc, h.im / dc});
  }
  // The transform has sign +1, taps need -1: they are real, so the conjugate serves. Both ends of the spectrum share
  // one coefficient, of which the taps see the real part.
  probe_ = irregular(96, 0.0, kCells);
  const std::vector<double> probes = in_cy_mm(probe_, step_um);
  const FactoredOtf::Grid between(sampler, axis == Axis::x ? probes : zero, axis == Axis::x ? zero : probes);
  row.resize(axis == Axis::x ? probes.size() : 1);
  for (std::size_t j = 0; j < (axis == Axis::x ? 1 : probes.size()); ++j) {
    between.complex_row(j, row);
    for (const Complex<float>& h : row) probes_.push_back({h.re / dc, h.im / dc});
  }
  std::vector<Complex<double>> kernel = otf_;
  for (std::int64_t r = 0; r < kFine; ++r) {
    Complex<double>& h = kernel[static_cast<std::size_t>(r)];
    const auto k = static_cast<double>(along.signed_index(r));
    h = Complex<double>{h.re, -h.im} * rotation(static_cast<long double>(offset_ * k / kFine));
    if (2 * r == kFine) h.im = 0.0;
  }
  fft::inverse(kernel);
  const std::int64_t count = taps_within(kHalfWidth, offset_);
  for (std::int64_t t = 0; t < count; ++t) {
    const auto at = static_cast<std::int64_t>(std::llround(position(t, count) - offset_));
    taps_.push_back(kernel[static_cast<std::size_t>((at + kFine) % kFine)].re / kFine);
  }
}

std::vector<double> AxisResponse::raw_taps(std::int64_t half_width) const {
  const std::int64_t count = taps_within(half_width, offset_);
  const std::int64_t first = (static_cast<std::int64_t>(taps_.size()) - count) / 2;
  return {taps_.begin() + first, taps_.begin() + first + count};
}

double AxisResponse::share(std::int64_t half_width) const {
  const std::vector<double> taps = raw_taps(half_width);
  return std::accumulate(taps.begin(), taps.end(), 0.0);
}

std::vector<double> AxisResponse::taps(std::int64_t half_width) const {
  std::vector<double> taps = raw_taps(half_width);
  const double sum = share(half_width);
  if (holds_most_of_spread(sum))
    for (double& tap : taps) tap /= sum;
  return taps;
}

std::vector<double> AxisResponse::error(const std::vector<double>& taps) const {
  const auto count = static_cast<std::int64_t>(taps.size());
  std::vector<Complex<double>> sum(static_cast<std::size_t>(kFine));
  for (std::int64_t t = 0; t < count; ++t) {
    const auto at = static_cast<std::int64_t>(std::llround(position(t, count) - offset_));
    sum[static_cast<std::size_t>((at + kFine) % kFine)].re += taps[static_cast<std::size_t>(t)];
  }
  fft::inverse(sum);
  std::vector<double> fine;
  for (std::int64_t k = 0; k <= kFine / 2; ++k) {
    const Complex<double> through =
        sum[static_cast<std::size_t>(k)] * rotation(static_cast<long double>(offset_ * static_cast<double>(k) / kFine));
    const Complex<double>& h = otf_[static_cast<std::size_t>(k)];
    fine.push_back(std::hypot(through.re - h.re, through.im - h.im));
  }
  return about_corners(fine);
}

double AxisResponse::excess(const std::vector<double>& taps, std::span<const double> error) const {
  double worst = 0.0;
  for (std::size_t i = 0; i < probe_.size(); ++i) {
    const auto turn = phases(probe_[i], static_cast<std::int64_t>(taps.size()), 1.0);
    Complex<double> sum{};
    for (std::size_t t = 0; t < taps.size(); ++t)
      sum = sum + Complex<double>{taps[t] * turn[t].re, taps[t] * turn[t].im};
    const auto cell = static_cast<std::size_t>(probe_[i]);
    const double about = std::max(error[cell], error[cell + 1]);
    worst = std::max(worst, std::hypot(sum.re - probes_[i].re, sum.im - probes_[i].im) - kMoreThanCorners * about);
  }
  return worst;
}

std::vector<double> AxisResponse::modulus() const {
  std::vector<double> fine;
  for (std::int64_t k = 0; k <= kFine / 2; ++k)
    fine.push_back(std::hypot(otf_[static_cast<std::size_t>(k)].re, otf_[static_cast<std::size_t>(k)].im));
  return about_corners(fine);
}

SeparableTerms separable_terms(const TapBox& kernel, std::size_t most) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> matrix(kernel.value.data(), kernel.rows, kernel.columns);
  // Filled up with zeros to a square, whose singular vectors only grow by zeros: a square needs no QR preconditioner,
  // and Eigen's preconditioners take half a minute to compile. Kernels are of 49 x 49 taps at most.
  const Eigen::Index size = std::max(matrix.rows(), matrix.cols());
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(size, size);
  square.topLeftCorner(matrix.rows(), matrix.cols()) = matrix;
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(square,
                                                                         Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double scale = matrix.cwiseAbs().maxCoeff();
  const bool mirrored = (matrix - matrix.rowwise().reverse()).cwiseAbs().maxCoeff() <= 1e-12 * scale &&
                        (matrix - matrix.colwise().reverse()).cwiseAbs().maxCoeff() <= 1e-12 * scale;
  // Rounding leaves mirror images that differ in their last bits, and only rounding makes terms of odd symmetry.
  const auto even = [mirrored](std::vector<double> taps) {
    for (std::size_t i = 0; mirrored && 2 * i < taps.size(); ++i)
      taps[i] = taps[taps.size() - 1 - i] = 0.5 * (taps[i] + taps[taps.size() - 1 - i]);
    return taps;
  };
  SeparableTerms terms;
  const auto rank = std::min<std::size_t>(most, static_cast<std::size_t>(std::min(matrix.rows(), matrix.cols())));
  for (std::size_t k = 0; k < rank; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double root = std::sqrt(svd.singularValues()(i));
    std::vector<double> y, x;
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) y.push_back(root * svd.matrixU()(r, i));
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) x.push_back(root * svd.matrixV()(c, i));
    terms.along_y.push_back(even(std::move(y)));
    terms.along_x.push_back(even(std::move(x)));
  }
  return terms;
}

TapBox product_of(const SeparableTerms& terms, std::size_t count) {
  TapBox box{static_cast<std::int64_t>(terms.along_y.front().size()),
             static_cast<std::int64_t>(terms.along_x.front().size()),
             {}};
  box.value.assign(static_cast<std::size_t>(box.rows * box.columns), 0.0);
  for (std::size_t k = 0; k < std::min(count, terms.along_y.size()); ++k)
    for (std::int64_t r = 0; r < box.rows; ++r)
      for (std::int64_t c = 0; c < box.columns; ++c)
        box.at(r, c) += terms.along_y[k][static_cast<std::size_t>(r)] * terms.along_x[k][static_cast<std::size_t>(c)];
  return box;
}

}  // namespace mtf
