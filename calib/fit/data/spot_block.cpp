// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/data/spot_block.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/edge/edge_pixels.h"
#include "calib/edge/median.h"

namespace calib {
namespace {

using mtf::Complex;

constexpr std::int64_t kLeastSide = 32, kMostSide = 64;  // of what is left of a larger region
constexpr std::size_t kFewestPixels = 16;
constexpr double kMostFrequencies = 1024.0;  // of one axis, on either side of 0

/// Calls take(x, y, value) for every pixel whose value counts.
template <class Take>
void for_pixels(const SpotData& data, const Roi& roi, const Take& take) {
  const ValueLimits limits{data.saturation, data.floor};
  for (std::int64_t y = roi.y; y < roi.y + roi.height; ++y)
    for (std::int64_t x = roi.x; x < roi.x + roi.width; ++x) {
      const float value = data.image.at(x, y);
      if (std::isfinite(value) && !limits.clipped(value)) take(x, y, static_cast<double>(value));
    }
}

/// `side` pixels around the middle, inside of what there is.
void shorten(std::int64_t& first, std::int64_t& size, std::int64_t middle, std::int64_t side) {
  if (size <= side) return;
  first = std::clamp(middle - side / 2, first, first + size - side);
  size = side;
}

Complex<double> turned(double turns) {
  const double angle = 2.0 * std::numbers::pi * (turns - std::nearbyint(turns));
  return {std::cos(angle), std::sin(angle)};
}

}  // namespace

SpotBlock::SpotBlock(const SpotData& data) : data_(&data), place_(data.condition), roi_(data.roi) {
  find_peak();
  if (reason_.empty()) measure_rim();
  if (reason_.empty()) start_from_light();
}

// The brightest 3 x 3 pixels, as one alone may be hot; the pixels above half of it determine the width and the part
// that is kept.
void SpotBlock::find_peak() {
  const auto near = [&](std::int64_t x, std::int64_t y) {
    double sum = 0.0, count = 0.0;
    const Roi& r = data_->roi;
    const std::int64_t left = std::max(r.x, x - 1), top = std::max(r.y, y - 1);
    for_pixels(*data_, {left, top, std::min(r.x + r.width, x + 2) - left, std::min(r.y + r.height, y + 2) - top},
               [&](std::int64_t, std::int64_t, double value) { sum += value, count += 1.0; });
    return sum / count;
  };
  double most = -INFINITY;
  std::vector<double> rim;
  for_pixels(*data_, roi_, [&](std::int64_t x, std::int64_t y, double value) {
    ++pixels_;
    if (x == roi_.x || y == roi_.y || x + 1 == roi_.x + roi_.width || y + 1 == roi_.y + roi_.height)
      rim.push_back(value);
    if (const double mean = near(x, y); mean > most) most = mean, peak_x_ = x, peak_y_ = y;
  });
  if (pixels_ < kFewestPixels || rim.size() < 8) {
    reason_ = "fewer than " + std::to_string(kFewestPixels) + " pixels with a value; take a larger region";
    return;
  }
  const double background = median(rim);
  Roi around = roi_;
  shorten(around.x, around.width, peak_x_, kMostSide);
  shorten(around.y, around.height, peak_y_, kMostSide);
  double largest = -INFINITY;
  for_pixels(*data_, around, [&](std::int64_t, std::int64_t, double value) { largest = std::max(largest, value); });
  double above = 0.0, plateau = 0.0;
  for_pixels(*data_, around, [&](std::int64_t, std::int64_t, double value) {
    above += value - background > 0.5 * (largest - background);
    plateau += value == largest;
  });
  // A round top is flat over a small part of its width at half height only.
  if (plateau >= 5.0 && plateau > 0.15 * above && largest > background) {
    reason_ = "saturated: " + std::to_string(static_cast<int>(plateau)) +
              " pixels have the largest value; take a shorter exposure";
    return;
  }
  width_px_ = std::sqrt(std::max(1.0, above) / std::numbers::pi) / std::sqrt(2.0 * std::numbers::ln2);
  const auto side = std::clamp(static_cast<std::int64_t>(std::ceil(10.0 * width_px_)), kLeastSide, kMostSide);
  shorten(roi_.x, roi_.width, peak_x_, side);
  shorten(roi_.y, roi_.height, peak_y_, side);
}

// The rim gives the background and its noise; the spot is what exceeds them.
void SpotBlock::measure_rim() {
  std::vector<double> rim, off;
  double largest = -INFINITY;
  pixels_ = 0;
  for_pixels(*data_, roi_, [&](std::int64_t x, std::int64_t y, double value) {
    ++pixels_;
    largest = std::max(largest, value);
    if (x == roi_.x || y == roi_.y || x + 1 == roi_.x + roi_.width || y + 1 == roi_.y + roi_.height)
      rim.push_back(value);
  });
  if (pixels_ < kFewestPixels || rim.size() < 8) {
    reason_ = "too few pixels around its peak have a value";
    return;
  }
  const double background = median(rim);
  for (const double value : rim) off.push_back(std::abs(value - background));
  // A rim without any noise still has rounding.
  const double sd = std::max(1.4826 * median(off), 1e-6 * std::max(std::abs(largest), std::abs(background)));
  if (!(largest - background > 5.0 * sd)) {
    reason_ = "no point source: the brightest pixel is within the noise of the background";
    return;
  }
  unit_ = largest - background;
  background_ = background / unit_;
  sd_ = sd / unit_;
}

void SpotBlock::start_from_light() {
  double weight = 0.0;
  const double near = 3.0 * width_px_ + 1.5;
  for_pixels(*data_, roi_, [&](std::int64_t x, std::int64_t y, double value) {
    const double light = value / unit_ - background_;
    if (light < 3.0 * sd_) return;
    if (std::hypot(static_cast<double>(x - peak_x_), static_cast<double>(y - peak_y_)) > near) return;
    flux_ += light;
    x0_ += light * (static_cast<double>(x) + 0.5);
    y0_ += light * (static_cast<double>(y) + 0.5);
    weight += light;
  });
  if (!(weight > 0.0)) {
    reason_ = "no point source: nothing but single pixels exceeds the noise of the background";
    return;
  }
  x0_ /= weight;
  y0_ /= weight;
}

// As much as there are frequencies for: the sharper the PSF, the sooner it has ended.
std::size_t SpotBlock::period_px(double top_cy_px) const {
  const auto side = static_cast<double>(std::max(roi_.width, roi_.height));
  const double wanted = side + std::max({side, 12.0 * width_px_, 16.0});
  return static_cast<std::size_t>(std::clamp(kMostFrequencies / top_cy_px, std::min(wanted, side + 8.0), wanted));
}

std::vector<std::vector<double>> SpotBlock::images(const Sensors& sensors, double x0, double y0) const {
  const double top_x = std::max(1e-3, sensors.top_cy_px(place_, 0.0)),
               top_y = std::max(1e-3, sensors.top_cy_px(place_, 0.5 * std::numbers::pi));
  const std::size_t n = period_px(std::max(top_x, top_y));
  const auto period = static_cast<double>(n);
  const auto harmonics = [&](double top) {
    return static_cast<std::int64_t>(std::min(kMostFrequencies, std::ceil(top * period)));
  };
  const std::int64_t mx = harmonics(top_x), my = harmonics(top_y);
  const double dx = static_cast<double>(roi_.x) + 0.5 - x0, dy = static_cast<double>(roi_.y) + 0.5 - y0;
  std::vector<Complex<double>> across;
  for (std::int64_t i = 0; i <= mx; ++i) across.push_back(turned(static_cast<double>(i) * dx / period));

  // 0 the PSF, 1 and 2 its slopes by x0 and y0, then the parameters: their spectra, frequencies modulo 1 cycle/px.
  const std::size_t count = sensors.parameters() + 3;
  std::vector<std::vector<Complex<double>>> folded(count, std::vector<Complex<double>>(n * n));
  std::vector<PixelFreq> f(static_cast<std::size_t>(mx) + 1);
  for (std::int64_t j = -my; j <= my; ++j) {
    const double fy = static_cast<double>(j) / period;
    for (std::size_t i = 0; i < f.size(); ++i) f[i] = {static_cast<double>(i) / period, fy, 0.0, 0.0};
    const OtfTable h = sensors.otf(place_, f);  // half the plane: H(-f) is the conjugate of H(f)
    const Complex<double> down = turned(static_cast<double>(j) * dy / period);
    const std::size_t row =
        static_cast<std::size_t>((j % static_cast<std::int64_t>(n)) + static_cast<std::int64_t>(n)) % n * n;
    for (std::size_t i = 0; i < f.size(); ++i) {
      const double weight = (i == 0 ? 1.0 : 2.0) / (period * period);
      const Complex<double> turn = Complex<double>{weight, 0.0} * across[i] * down;
      const std::size_t at = row + i % n;
      const Complex<double> z = h[0][i] * turn;
      folded[0][at] = folded[0][at] + z;
      // By a shift of the source: times -2 pi i f.
      const double kx = 2.0 * std::numbers::pi * f[i].x, ky = 2.0 * std::numbers::pi * fy;
      folded[1][at] = folded[1][at] + Complex<double>{kx * z.im, -kx * z.re};
      folded[2][at] = folded[2][at] + Complex<double>{ky * z.im, -ky * z.re};
      for (std::size_t k = 3; k < count; ++k) folded[k][at] = folded[k][at] + h[k - 2][i] * turn;
    }
  }

  std::vector<Complex<double>> circle;
  for (std::size_t a = 0; a < n; ++a) circle.push_back(turned(static_cast<double>(a) / period));
  const auto width = static_cast<std::size_t>(roi_.width), height = static_cast<std::size_t>(roi_.height);
  std::vector<std::vector<double>> images(count, std::vector<double>(width * height));
  std::vector<Complex<double>> line(n);
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t y = 0; y < height; ++y) {
      std::fill(line.begin(), line.end(), Complex<double>{});
      for (std::size_t b = 0; b < n; ++b)
        for (std::size_t a = 0; a < n; ++a) line[a] = line[a] + folded[k][b * n + a] * circle[b * y % n];
      for (std::size_t x = 0; x < width; ++x)
        for (std::size_t a = 0; a < n; ++a) {
          const Complex<double>& turn = circle[a * x % n];
          images[k][y * width + x] += line[a].re * turn.re - line[a].im * turn.im;
        }
    }
  return images;
}

std::vector<SpotBlock::PixelRow> SpotBlock::rows(const Sensors& sensors, std::span<const double> own) const {
  const auto psf = images(sensors, own[0], own[1]);
  const double flux = own[2], background = own[3];
  std::vector<PixelRow> all;
  for_pixels(*data_, roi_, [&](std::int64_t x, std::int64_t y, double value) {
    const auto i = static_cast<std::size_t>((y - roi_.y) * roi_.width + x - roi_.x);
    PixelRow row{.x = x, .y = y, .light = flux * psf[0][i]};
    row.slopes = {flux * psf[1][i], flux * psf[2][i], psf[0][i], 1.0};
    for (std::size_t k = 3; k < psf.size(); ++k) row.slopes.push_back(flux * psf[k][i]);
    row.left = value / unit_ - background - row.light;
    all.push_back(std::move(row));
  });
  return all;
}

NormalMatrix SpotBlock::normal(const Sensors& sensors, std::span<const double> own) const {
  NormalMatrix all(4 + sensors.parameters());
  for (const PixelRow& pixel : rows(sensors, own)) {
    const double sd = sd_at(pixel.light);
    const BentResidual r = bent(pixel.left / sd, robust_);
    const std::span<double> row = all.next();
    for (std::size_t k = 0; k < pixel.slopes.size(); ++k) row[k] = -r.slope / sd * pixel.slopes[k];
    row.back() = r.value;
    all.add();
  }
  return all;
}

std::vector<Residual> SpotBlock::residuals(const Sensors& sensors, std::span<const double> own) const {
  std::vector<Residual> all;
  for (const PixelRow& pixel : rows(sensors, own)) {
    const double sd = sd_at(pixel.light);
    all.push_back({.x = pixel.x, .y = pixel.y, .value = pixel.left / sd, .sd = sd * unit_});
  }
  return all;
}

// Few pixels have most of the light, and a fit that takes their noise for that of the rim goes through them. So each
// guess of the gain is followed by the residuals of the linear fit with the weights that it makes, each square over
// what the fit leaves of its variance, 1 - h.
bool SpotBlock::update_noise(const Sensors& sensors, std::span<const double> own) {
  constexpr int kGuesses = 20;
  constexpr double kSure_sd = 5.0, kSame = 0.1, kLeast = 0.05;  // of the gain; of the variance that the fit leaves
  const std::vector<PixelRow> pixels = rows(sensors, own);
  const Eigen::Index n = std::ssize(pixels), width = std::ssize(pixels.front().slopes);
  Eigen::MatrixXd slopes(n, width);
  Eigen::VectorXd left(n), light(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PixelRow& pixel = pixels[static_cast<std::size_t>(i)];
    slopes.row(i) = Eigen::Map<const Eigen::RowVectorXd>(pixel.slopes.data(), width);
    left[i] = pixel.left;
    light[i] = std::max(0.0, pixel.light);
  }
  double gain = gain_;
  for (int guess = 0; guess < kGuesses; ++guess) {
    const Eigen::ArrayXd variance = sd_ * sd_ + gain * light.array();
    const Eigen::VectorXd root = variance.rsqrt();
    const Eigen::MatrixXd weighted = root.asDiagonal() * slopes;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(weighted);
    const Eigen::MatrixXd basis = qr.householderQ() * Eigen::MatrixXd::Identity(n, qr.rank());
    const Eigen::VectorXd scaled = root.asDiagonal() * left, rest = scaled - basis * (basis.transpose() * scaled);
    const Eigen::ArrayXd kept = (1.0 - basis.rowwise().squaredNorm().array()).max(kLeast);
    const Eigen::ArrayXd by_light = light.array() / variance, excess = rest.array().square() / kept;
    const double information = by_light.square().sum();
    if (!(information > 0.0)) return false;
    // In units of the variance: excess = (sd^2 + gain x light) / variance.
    gain = std::max(0.0, (by_light * (excess - sd_ * sd_ / variance)).sum() / information);
  }
  const double sd_of_none = std::sqrt(2.0) * sd_ * sd_ / light.norm();
  if (gain < kSure_sd * sd_of_none) gain = 0.0;
  const bool changed = std::abs(gain - gain_) > kSame * std::max(gain, gain_);
  if (changed) gain_ = gain;
  return changed;
}

}  // namespace calib
