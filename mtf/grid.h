// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sample grids and their frequencies: the one place that maps a transform index to cycles/mm.
//
// Centre of sample i is (i + 0.5) x step from the outer corner that scene and detector share. Along one axis an image
// of n samples is expanded in one of two bases:
//   fourier  exp(2 pi i k x / (L step)), a canvas of L samples that repeats; k = -floor(L/2) .. floor(L/2).
//            L even: k = L/2 and -L/2 share one coefficient, half of it each (the trigonometric polynomial of least
//            degree).
//   cosine   cos(pi k x / (n step)), k = 0 .. n-1: the half-sample mirror of period 2n, exactly, without padding.

#include <cstdint>
#include <optional>
#include <vector>

namespace mtf {

/// Size and sample spacing of an image plane. All positive.
struct SampleGrid {
  bool operator==(const SampleGrid&) const = default;
  std::int64_t width = 0;
  std::int64_t height = 0;
  double step_x_um = 0.0;
  double step_y_um = 0.0;

  double area_um2() const { return static_cast<double>(width) * step_x_um * (static_cast<double>(height) * step_y_um); }
};

/// Whole number of samples of `in` that a pixel of `out` touches at least partly, 1 or more: the number of frequencies
/// that may alias onto one.
double samples_per_pixel(const SampleGrid& in, const SampleGrid& out);

struct PitchRatio {
  std::int64_t samples = 1, pixels = 1;  ///< p, q
};
/// The ratio of pitch to sample as p/q with q up to 64, exact to the rounding of a double; nothing for any other.
std::optional<PitchRatio> pitch_ratio(double pitch_um, double step_um);

/// A length is a whole number of pitches within this many pitches.
inline constexpr double kWholeEpsilon = 1e-9;
bool is_whole(double pitches);

enum class Basis { fourier, cosine };

/// Frequencies of one axis.
struct FrequencyAxis {
  bool operator==(const FrequencyAxis&) const = default;
  Basis basis = Basis::fourier;
  std::int64_t length = 0;  ///< fourier: canvas samples L; cosine: image samples n
  double step_um = 0.0;

  double period_um() const { return static_cast<double>(basis == Basis::cosine ? 2 * length : length) * step_um; }
  double cy_mm(std::int64_t k) const { return static_cast<double>(k) * (1e3 / period_um()); }
  /// Number of frequencies k >= 0.
  std::int64_t half_count() const { return basis == Basis::cosine ? length : length / 2 + 1; }
  double nyquist_cy_mm() const { return 500.0 / step_um; }
  /// The k >= 0 frequencies, in order.
  std::vector<double> half_frequencies() const;
  /// All frequencies in transform order 0 .. L-1 as signed values; for even L also -L/2, at the end. Cosine: as above.
  std::vector<double> all_frequencies() const;
  /// Signed k of row r of all_frequencies().
  std::int64_t signed_index(std::int64_t r) const {
    if (basis == Basis::cosine) return r;
    if (r == length) return -length / 2;
    return r <= length / 2 ? r : r - length;
  }
};

/// Smallest 2^a 3^b 5^c 7^d >= n, n >= 1.
std::int64_t next_smooth(std::int64_t n);
bool is_smooth(std::int64_t n);

}  // namespace mtf
