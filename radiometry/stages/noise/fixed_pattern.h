// SPDX-License-Identifier: Apache-2.0
#pragma once

// What differs from pixel to pixel. Fixed patterns depend on the seed alone (frame 0 of their streams) and are the same
// in all frames and for any region; temporal row and column noise has a number for every frame too.

#include <span>
#include <string>
#include <vector>

#include "radiometry/fields.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

/// Rms of the responsivity from pixel to pixel, and of whole rows and columns, as fractions in [0, 1].
struct ResponsivityRms {
  double pixel = 0.0, row = 0.0, column = 0.0;
};
/// Responsivity non-uniformity as a map of factors, max(0, 1 + the sum of rms x standard normal). It is made once for a
/// sequence; a measured map may take its place.
void responsivity_map(mtf::ImageView<float> map, const ResponsivityRms& rms, std::uint64_t seed, Origin origin = {},
                      int threads = 1);
/// Offset non-uniformity: rms x standard normal.
void offset_map(mtf::ImageView<float> map, double rms, std::uint64_t seed, Origin origin = {}, int threads = 1);
/// Dark current that differs from pixel to pixel (DCNU): the mean dark current times a factor of each pixel, the same
/// in all frames,
///   f = exp(s z - s^2 / 2),   s^2 = ln(1 + rms^2),   z standard normal
/// log-normal with mean 1 and standard deviation rms exactly, never below 0: a rate that falls exponentially with an
/// energy that scatters normally. So it has the tail of warm pixels that detectors have, and unlike an offset (DSNU) it
/// grows with the exposure time and with everything that raises the dark current. Each pixel has the shot noise of its
/// own dark charge. Silicon has rms of 0.1 to 0.4. (Janesick, Photon Transfer, 2007, on dark current; Gow et al., IEEE
/// Trans. Electron Devices 54, 1321 (2007).)
/// Throws UsageError for rms that is not from 0 to 10, and for an origin out of its range.
void dark_current_map(mtf::ImageView<float> map, double rms, std::uint64_t seed, Origin origin = {}, int threads = 1);

/// Throws UsageError for a map with a number that is not finite or below `least`: it says the number and its pixel on
/// the detector. `name` is the map's, `origin` the pixel at which the map begins.
void require_numbers(const std::string& name, mtf::ImageView<const float> map, float least, Origin origin = {});

/// image *= map: mean electrons of light, before the shot noise. UsageError for a map of another size.
void multiply_by(mtf::ImageView<float> image, mtf::ImageView<const float> map);
/// image += map.
void add_map(mtf::ImageView<float> image, mtf::ImageView<const float> map, int threads = 1);

/// One Gaussian number of that rms for each of `count` lines from the first one on.
std::vector<float> line_numbers(double rms, const NoiseKey& key, Stream stream, std::int64_t first, std::int64_t count);

/// One number for every row, or column, of the detector.
void add_row_noise(mtf::ImageView<float> image, double rms, const NoiseKey& key, Stream stream, Origin origin = {});
void add_column_noise(mtf::ImageView<float> image, double rms, const NoiseKey& key, Stream stream, Origin origin = {});

/// Defective pixels by chance: every pixel of the detector is dead with one probability, hot with another.
struct Defects {
  double dead_fraction = 0.0;  ///< answer 0
  double hot_fraction = 0.0;
  double hot_e = 0.0;  ///< mean excess electrons of a hot pixel in a frame; each has its own, exponentially distributed

  static constexpr auto fields() {
    return std::tuple{
        optional(&Defects::dead_fraction, "dead_fraction", 0.0, 1.0, "0.001", "part of the pixels that are dead"),
        optional(&Defects::hot_fraction, "hot_fraction", 0.0, 1.0, "0.001", "part of the pixels that are hot"),
        optional(&Defects::hot_e, "hot", "e-", 0.0, 1e30, "\"5000 e-\"", "mean excess of a hot pixel in a frame")};
  }

  bool operator==(const Defects&) const = default;
};

struct DefectivePixel {
  std::int64_t x = 0, y = 0;  ///< in the region
  bool dead = false;
  float excess_e = 0.0F;  ///< of a hot one
};

/// The defective pixels of a region, row by row: found once for a sequence, the same for any region. Throws UsageError
/// for values out of their bounds, and for fractions that are more than all pixels together.
std::vector<DefectivePixel> find_defects(std::int64_t width, std::int64_t height, const Defects& defects,
                                         std::uint64_t seed, Origin origin = {}, int threads = 1);

/// Adds the excess of hot pixels to mean electrons and sets dead ones to 0. UsageError for a pixel outside the image.
void apply_defects(mtf::ImageView<float> image, std::span<const DefectivePixel> pixels);

}  // namespace radiometry
