// SPDX-License-Identifier: Apache-2.0
#include "calib/spot_block.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mtf/error.h"

namespace calib {
namespace {

constexpr std::int64_t kMostSide = 64;
constexpr std::size_t kFewestPixels = 16;
constexpr std::int64_t kMostFrequencies = 512;  // of one axis

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// exp(2 pi i f d) for pixels at d, d + 1, .. and f = (first + j) / period.
class PhaseTable {
 public:
  PhaseTable(double d, std::size_t pixels, std::int64_t first, std::size_t frequencies, double period)
      : first_(static_cast<double>(first)), turn_(2.0 * std::numbers::pi / period), columns_(frequencies) {
    for (std::size_t p = 0; p < pixels; ++p)
      for (std::size_t j = 0; j < frequencies; ++j) {
        const double angle = turn_ * (first_ + static_cast<double>(j)) * (d + static_cast<double>(p));
        phases_.push_back({std::cos(angle), std::sin(angle)});
      }
  }
  const mtf::Complex<double>& at(std::size_t pixel, std::size_t j) const { return phases_[pixel * columns_ + j]; }
  /// By a shift of the source: times -2 pi i f.
  mtf::Complex<double> slope(std::size_t pixel, std::size_t j) const {
    const double factor = turn_ * (first_ + static_cast<double>(j));
    return {factor * at(pixel, j).im, -factor * at(pixel, j).re};
  }

 private:
  double first_, turn_;
  std::size_t columns_;
  std::vector<mtf::Complex<double>> phases_;
};

}  // namespace

SpotBlock::SpotBlock(const SpotData& data) : data_(&data) {
  const Roi& roi = data.roi;
  if (std::max(roi.width, roi.height) > kMostSide)
    throw mtf::UsageError(data.name + ": a region of a point source is at most " + std::to_string(kMostSide) +
                          " pixels a side; cut it closer");
  // The rim tells the background and its noise; what exceeds them is the spot.
  std::vector<double> rim, all;
  for (std::int64_t y = roi.y; y < roi.y + roi.height; ++y)
    for (std::int64_t x = roi.x; x < roi.x + roi.width; ++x) {
      const double value = data.image.at(x, y);
      if (!std::isfinite(value)) continue;
      all.push_back(value);
      if (x == roi.x || y == roi.y || x + 1 == roi.x + roi.width || y + 1 == roi.y + roi.height) rim.push_back(value);
    }
  pixels_ = all.size();
  if (pixels_ < kFewestPixels || rim.size() < 8) {
    reason_ = "fewer than " + std::to_string(kFewestPixels) + " pixels with a value; take a larger region";
    return;
  }
  background_ = middle_of(rim);
  std::vector<double> off;
  for (const double value : rim) off.push_back(std::abs(value - background_));
  const double peak = *std::max_element(all.begin(), all.end());
  // A rim without any noise still has rounding.
  sd_ = std::max(1.4826 * middle_of(off), 1e-6 * std::max(std::abs(peak), std::abs(background_)));
  if (!(peak - background_ > 5.0 * sd_)) {
    reason_ = "no point source: the brightest pixel is within the noise of the background";
    return;
  }
  double weight = 0.0;
  for (std::int64_t y = roi.y; y < roi.y + roi.height; ++y)
    for (std::int64_t x = roi.x; x < roi.x + roi.width; ++x) {
      const double value = data.image.at(x, y);
      if (!std::isfinite(value)) continue;
      const double light = value - background_;
      flux_ += light;
      if (light < 3.0 * sd_) continue;
      x0_ += light * (static_cast<double>(x) + 0.5);
      y0_ += light * (static_cast<double>(y) + 0.5);
      weight += light;
    }
  x0_ /= weight;
  y0_ /= weight;
}

std::vector<std::vector<double>> SpotBlock::images(const Sensors& sensors, double x0, double y0) const {
  const Roi& roi = data_->roi;
  const double period = 4.0 * static_cast<double>(std::max<std::int64_t>(8, std::max(roi.width, roi.height)));
  const auto reach = [&](double angle) {
    const double steps = std::ceil(sensors.top_cy_px(condition(), angle) * period);
    return std::min<std::int64_t>(kMostFrequencies / 2, static_cast<std::int64_t>(steps));
  };
  const std::int64_t mx = reach(0.0), my = reach(0.5 * std::numbers::pi);
  std::vector<PixelFreq> f;  // half the plane: H(-f) is the conjugate of H(f)
  for (std::int64_t j = -my; j <= my; ++j)
    for (std::int64_t i = 0; i <= mx; ++i)
      f.push_back({static_cast<double>(i) / period, static_cast<double>(j) / period, 0.0, 0.0});
  const OtfTable h = sensors.otf(condition(), f);

  const auto width = static_cast<std::size_t>(roi.width), height = static_cast<std::size_t>(roi.height);
  const std::size_t columns = static_cast<std::size_t>(mx) + 1, rows = 2 * static_cast<std::size_t>(my) + 1;
  std::vector<std::vector<double>> images(sensors.parameters() + 3, std::vector<double>(width * height));
  const PhaseTable across(static_cast<double>(roi.x) + 0.5 - x0, width, 0, columns, period);
  const PhaseTable down(static_cast<double>(roi.y) + 0.5 - y0, height, -my, rows, period);
  std::vector<mtf::Complex<double>> line(columns);
  for (std::size_t k = 0; k < images.size(); ++k) {
    // 0 the PSF, 1 and 2 its slopes by x0 and y0, then the parameters.
    const std::vector<mtf::Complex<double>>& spectrum = k < 3 ? h[0] : h[k - 2];
    for (std::size_t y = 0; y < height; ++y) {
      std::fill(line.begin(), line.end(), mtf::Complex<double>{});
      for (std::size_t j = 0; j < rows; ++j) {
        const mtf::Complex<double> turn = k == 2 ? down.slope(y, j) : down.at(y, j);
        for (std::size_t i = 0; i < columns; ++i) line[i] = line[i] + spectrum[j * columns + i] * turn;
      }
      for (std::size_t x = 0; x < width; ++x) {
        double sum = 0.0;
        for (std::size_t i = 0; i < columns; ++i) {
          const mtf::Complex<double> turn = k == 1 ? across.slope(x, i) : across.at(x, i);
          sum += (i == 0 ? 1.0 : 2.0) * (line[i].re * turn.re - line[i].im * turn.im);
        }
        images[k][y * width + x] = sum / (period * period);
      }
    }
  }
  return images;
}

NormalMatrix SpotBlock::normal(const Sensors& sensors, std::span<const double> own) const {
  const auto psf = images(sensors, own[0], own[1]);
  const std::size_t n = sensors.parameters();
  const double flux = own[2], background = own[3];
  NormalMatrix all(4 + n);
  std::size_t i = 0;
  for (std::int64_t y = 0; y < data_->roi.height; ++y)
    for (std::int64_t x = 0; x < data_->roi.width; ++x, ++i) {
      const double value = data_->image.at(data_->roi.x + x, data_->roi.y + y);
      if (!std::isfinite(value)) continue;
      const BentResidual r = bent((value - background - flux * psf[0][i]) / sd_, robust_);
      const double weight = -r.slope / sd_;
      const std::span<double> row = all.next();
      row[0] = weight * flux * psf[1][i];
      row[1] = weight * flux * psf[2][i];
      row[2] = weight * psf[0][i];
      row[3] = weight;
      for (std::size_t k = 0; k < n; ++k) row[4 + k] = weight * flux * psf[3 + k][i];
      row[4 + n] = r.value;
      all.add();
    }
  return all;
}

std::vector<Residual> SpotBlock::residuals(const Sensors& sensors, std::span<const double> own) const {
  const auto psf = images(sensors, own[0], own[1]);
  std::vector<Residual> all;
  std::size_t i = 0;
  for (std::int64_t y = 0; y < data_->roi.height; ++y)
    for (std::int64_t x = 0; x < data_->roi.width; ++x, ++i) {
      const double value = data_->image.at(data_->roi.x + x, data_->roi.y + y);
      if (!std::isfinite(value)) continue;
      const double r = (value - own[3] - own[2] * psf[0][i]) / sd_;
      all.push_back({.x = data_->roi.x + x, .y = data_->roi.y + y, .value = r, .sd = sd_});
    }
  return all;
}

}  // namespace calib
