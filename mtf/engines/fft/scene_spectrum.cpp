// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/fft/scene_spectrum.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/engines/fft/axis.h"
#include "mtf/engines/fft/fftw.h"
#include "mtf/engines/kernels.h"
#include "mtf/engines/statistics.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

constexpr int kCells = SceneSpectrum::kCells, kColumns = SceneSpectrum::kColumns, kRows = SceneSpectrum::kRows;

// Alias zone of a frequency in cells, for `ratio` samples a pitch: up to half the detector's sampling frequency is zone
// 0.
int zone_at(double place, double ratio) { return static_cast<int>(std::floor(place / (2.0 * kCells) * ratio + 0.5)); }

// The zones that the cell between corners i and i + 1 lies in: two where a boundary crosses it.
std::array<int, 2> zones_of(int i, double ratio) {
  constexpr double kInside = 1e-9;
  return {zone_at(i + kInside, ratio), zone_at(i + 1.0 - kInside, ratio)};
}

int zones(double ratio) { return 2 * (zones_of(kCells - 1, ratio)[1] + 1) + 1; }

// visit(zx, zy) for every pair of zones that a cell lies in, once.
template <class Visit>
void for_each_zone(int i, int j, double ratio_x, double ratio_y, const Visit& visit) {
  const auto across = zones_of(i, ratio_x), down = zones_of(j, ratio_y);
  for (int zx = across[0]; zx <= across[1]; ++zx)
    for (int zy = down[0]; zy <= down[1]; ++zy) visit(zx, zy);
}

// Sum over alias zones of the rms of each. A cell of x > 0 stands for its mirror image too, which lies in the zones
// mirrored: both have half of its power.
class ZoneSum {
 public:
  ZoneSum(double ratio_x, double ratio_y)
      : ratio_x_(ratio_x), ratio_y_(ratio_y), across_(zones(ratio_x)), down_(zones(ratio_y)) {
    squares_.assign(static_cast<std::size_t>(across_ * down_), 0.0);
  }
  void add(int i, int j, double square) {
    for_each_zone(i, j, ratio_x_, ratio_y_, [&](int zx, int zy) {
      at(zx, zy) += 0.5 * square;
      at(-zx, -zy) += 0.5 * square;
    });
  }
  double sum() const {
    double sum = 0.0;
    for (const double square : squares_) sum += std::sqrt(square);
    return sum;
  }

 private:
  double& at(int zx, int zy) {
    return squares_[static_cast<std::size_t>((zy + down_ / 2) * across_ + zx + across_ / 2)];
  }
  double ratio_x_, ratio_y_;
  int across_, down_;
  std::vector<double> squares_;
};

// D may be somewhat larger between the corners.
constexpr double kBetween = 1.1;

// Frequency k of n cosines, or of n exponentials, as a cell of its axis: the zeroth has none, its error is the mean's.
int cell(std::int64_t k, double per_cell) {
  return std::min(kCells - 1, static_cast<int>(static_cast<double>(k) / per_cell));
}

// First frequency of cell i, of `count` frequencies.
std::int64_t first_of_cell(std::int64_t i, std::int64_t count, double per_cell) {
  if (i >= kCells) return count;
  std::int64_t k = std::max<std::int64_t>(0, static_cast<std::int64_t>(static_cast<double>(i) * per_cell) - 1);
  while (k < count && cell(k, per_cell) < i) ++k;
  return k;
}

// Power of the cosine transform of the half-sample mirror: coefficients c_k of sum c_k cos(pi k (i + 1/2) / n).
std::vector<double> cosine_power(ImageView<const float> scene, const Statistics& s, int threads) {
  const std::int64_t w = scene.width, h = scene.height;
  const fft::RealForward forward_x(w, fft::Rigor::estimate), forward_y(h, fft::Rigor::estimate);
  const std::vector<float> turn_x = cosine_twiddles<float>(w), turn_y = cosine_twiddles<float>(h);
  Image columns(h, w);  // transposed: row k holds coefficient k of every image row
  const auto padded = [](std::int64_t n) { return static_cast<std::size_t>(n + 16); };
  constexpr std::int64_t kTogether = 16;  // rows that are written to the transpose at once
  parallel_for(h, kTogether, threads, [&](std::int64_t begin, std::int64_t end) {
    const AlignedBuffer<float> row(padded(w)), half(padded(w)), c(padded(w) * static_cast<std::size_t>(kTogether));
    for (std::int64_t y = begin; y < end; ++y) {
      kernels::center_ordered(scene.row(y), w, s.mean, 1.0 / s.std, row.data());
      forward_x.execute(row.data(), half.data());
      kernels::cosine_from_half(half.data(), turn_x.data(), w, c.data() + (y - begin) * (w + 16));
    }
    for (std::int64_t k = 0; k < w; ++k)
      for (std::int64_t y = begin; y < end; ++y)
        columns.at(y, k) = c[static_cast<std::size_t>((y - begin) * (w + 16) + k)];
  });
  const double area = static_cast<double>(w) * static_cast<double>(h);
  // Each cell of x adds its own columns, in order: the same sums for any number of threads.
  std::vector<double> parts(static_cast<std::size_t>(kCells * kCells), 0.0);
  parallel_for(kCells, 1, threads, [&](std::int64_t i, std::int64_t) {
    const AlignedBuffer<float> row(padded(h)), half(padded(h)), c(padded(h));
    double* part = parts.data() + i * kCells;
    for (std::int64_t k = first_of_cell(i, w, static_cast<double>(w) / kCells);
         k < first_of_cell(i + 1, w, static_cast<double>(w) / kCells); ++k) {
      kernels::center_ordered(columns.view().row(k), h, 0.0, 1.0, row.data());
      forward_y.execute(row.data(), half.data());
      kernels::cosine_from_half(half.data(), turn_y.data(), h, c.data());
      for (std::int64_t l = k == 0 ? 1 : 0; l < h; ++l) {
        // Mean square of c cos cos: each cosine that is not constant contributes one half.
        const double v = c[static_cast<std::size_t>(l)];
        const double weight = (k == 0 ? 1.0 : 2.0) * (l == 0 ? 1.0 : 2.0) / (area * area);
        part[cell(l, static_cast<double>(h) / kCells)] += weight * v * v;
      }
    }
  });
  std::vector<double> power(static_cast<std::size_t>(2 * kCells * kCells), 0.0);
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const double half = 0.5 * parts[static_cast<std::size_t>(i * kCells + j)];
      power[static_cast<std::size_t>((kCells + j) * kCells + i)] += half;
      power[static_cast<std::size_t>((kCells - 1 - j) * kCells + i)] += half;
    }
  return power;
}

std::vector<double> fourier_power(ImageView<const float> scene, const Statistics& s, int threads) {
  const std::int64_t w = scene.width, h = scene.height, half_w = w / 2 + 1;
  const fft::RealForward forward_x(w, fft::Rigor::estimate);
  const fft::Split<float> forward_y(h, 1, fft::Rigor::estimate);
  Image columns(2 * h, half_w);
  parallel_for(h, 16, threads, [&](std::int64_t begin, std::int64_t end) {
    const AlignedBuffer<float> row(static_cast<std::size_t>(w)), half(static_cast<std::size_t>(w + 2));
    for (std::int64_t y = begin; y < end; ++y) {
      kernels::standardise(scene.row(y), w, s.mean, 1.0 / s.std, row.data());
      forward_x.execute(row.data(), half.data());
      for (std::int64_t k = 0; k < half_w; ++k) {
        columns.at(2 * y, k) = half[static_cast<std::size_t>(2 * k)];
        columns.at(2 * y + 1, k) = half[static_cast<std::size_t>(2 * k + 1)];
      }
    }
  });
  const double area = static_cast<double>(w) * static_cast<double>(h);
  std::vector<double> power(static_cast<std::size_t>(2 * kCells * kCells), 0.0);
  const double per_cell = 0.5 * static_cast<double>(w) / kCells;
  parallel_for(kCells, 1, threads, [&](std::int64_t i, std::int64_t) {
    const AlignedBuffer<float> c(static_cast<std::size_t>(2 * h));
    for (std::int64_t k = first_of_cell(i, half_w, per_cell); k < first_of_cell(i + 1, half_w, per_cell); ++k) {
      std::copy_n(columns.view().row(k), 2 * h, c.data());
      forward_y.forward(c.data(), c.data() + 1);
      for (std::int64_t r = k == 0 ? 1 : 0; r < h; ++r) {
        const double re = c[static_cast<std::size_t>(2 * r)], im = c[static_cast<std::size_t>(2 * r + 1)];
        const double weight = (k == 0 || 2 * k == w ? 1.0 : 2.0) / (area * area);
        const std::int64_t l = r <= h / 2 ? r : r - h;
        const int j = cell(std::abs(l), 0.5 * static_cast<double>(h) / kCells);
        power[static_cast<std::size_t>((l < 0 ? kCells - 1 - j : kCells + j) * kCells + i)] +=
            weight * (re * re + im * im);
      }
    }
  });
  return power;
}

}  // namespace

double SceneSpectrum::rms_error(std::span<const double> error, double ratio_x, double ratio_y) const {
  ZoneSum sum(ratio_x, ratio_y);
  for (int j = 0; j < 2 * kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const double power = power_[static_cast<std::size_t>(j * kCells + i)];
      if (power == 0.0) continue;
      const double* corner = error.data() + j * kColumns + i;
      const double d = kBetween * std::max({corner[0], corner[1], corner[kColumns], corner[kColumns + 1]});
      sum.add(i, j - kCells, d * d * power);
    }
  return sum.sum();
}

double SceneSpectrum::worst_error(std::span<const double> error, double ratio_x, double ratio_y) {
  const int across = zones(ratio_x), down = zones(ratio_y);
  std::vector<double> largest(static_cast<std::size_t>(across * down), 0.0);
  for (int j = 0; j < 2 * kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const double* corner = error.data() + j * kColumns + i;
      const double d = std::max({corner[0], corner[1], corner[kColumns], corner[kColumns + 1]});
      for_each_zone(i, j - kCells, ratio_x, ratio_y, [&](int zx, int zy) {
        for (const int sign : {1, -1}) {
          double& zone = largest[static_cast<std::size_t>((sign * zy + down / 2) * across + sign * zx + across / 2)];
          zone = std::max(zone, kBetween * d);
        }
      });
    }
  double squares = 0.0;
  for (const double zone : largest) squares += zone * zone;
  return std::sqrt(squares);
}

std::shared_ptr<const SceneSpectrum> scene_spectrum(ImageView<const float> scene, Border border, int threads) {
  if (border != Border::reflect && border != Border::periodic) return nullptr;
  const Statistics s = statistics(scene);
  if (s.not_finite > 0 || s.std == 0.0) return nullptr;
  std::vector<double> power =
      border == Border::reflect ? cosine_power(scene, s, threads) : fourier_power(scene, s, threads);
  return std::make_shared<SceneSpectrum>(scene.width, scene.height, border, std::move(power));
}

std::shared_ptr<const SceneSpectrum> largest_of(std::span<const std::shared_ptr<const SceneSpectrum>> spectra) {
  std::vector<double> power(static_cast<std::size_t>(2 * kCells * kCells), 0.0);
  for (const auto& spectrum : spectra) {
    if (!spectrum) return nullptr;
    for (std::size_t i = 0; i < power.size(); ++i) power[i] = std::max(power[i], spectrum->power()[i]);
  }
  return spectra.empty() ? nullptr : std::make_shared<SceneSpectrum>(spectra.front()->with_power(std::move(power)));
}

}  // namespace mtf
