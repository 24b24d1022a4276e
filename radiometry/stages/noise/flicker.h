// SPDX-License-Identifier: Apache-2.0
#pragma once

// 1/f noise of a readout that sends the pixels one after another.
//   S(f) = W^2 (1 + fc / f)
// f in cycles per pixel of the readout, W = rms of the white noise, fc = corner, where both parts are equal. Only the
// 1/f part, W^2 fc / f, is added here; the white one is the read noise. S is two-sided, the variance its integral from
// -1/2 to 1/2. Pixels follow one another along rows (or columns) without a pause, so that the noise shows as bands and
// drift. It is a sum over octaves i of random numbers 2^i pixels apart, joined by straight lines that begin at a random
// place in every frame (after Voss; Gardner, Scientific American 238 (4), 16 (1978)):
//   S(f) = W^2 fc x 2.0829 sum of a_i 2^i (sin(2^i pi f) / (2^i sin(pi f)))^4,   a = 1.061, 1.763, 0.826, 1, 1, ...
// which is 1/f within 4.5 % up to 0.02 cycles per pixel and 11 % up to the Nyquist frequency; below one cycle in a
// frame it is flat. Each number is that of its place, so a region is a crop of the detector's noise however large that
// is; frames are independent. (Hooge, Kleinpenning and Vandamme, Rep. Prog. Phys. 44, 479 (1981).)

#include "radiometry/fields.h"
#include "radiometry/stages/noise/noise.h"

namespace radiometry {

enum class ReadoutOrder { rows, columns };
inline constexpr std::array<std::string_view, 2> kReadoutOrderNames{"rows", "columns"};
constexpr std::span<const std::string_view> words(ReadoutOrder) { return kReadoutOrderNames; }

struct Flicker {
  double white_e = 0.0;
  double corner_cy_px = 0.0;
  ReadoutOrder order = ReadoutOrder::rows;

  static constexpr auto fields() {
    return std::tuple{
        required(&Flicker::white_e, "white", "e-", 0.0, 1e15, "\"30 e-\"",
                 "rms of the white noise that the corner refers to; not added here"),
        required(&Flicker::corner_cy_px, "corner", 0.0, 1e6, "0.01",
                 "frequency at which 1/f and white noise are equal, in cycles per pixel: in units of the pixel clock"),
        optional(&Flicker::order, "order", "\"columns\"", "whether pixels are read along rows or columns")};
  }
};

/// Two-sided spectral density of what is added, e-^2 per (cycle per pixel), by the sum above; f above 0, up to 1/2.
double flicker_density(const Flicker& flicker, std::int64_t columns, std::int64_t rows, double f_cy_px);

/// Variance of a pixel, e-^2.
double flicker_variance(const Flicker& flicker, std::int64_t columns, std::int64_t rows);

/// Adds the noise of a detector of columns x rows to a region of it. Throws UsageError for values out of their bounds,
/// a region outside of the detector, and detectors of more than 2^62 pixels.
void add_flicker(mtf::ImageView<float> image, const Flicker& flicker, std::int64_t columns, std::int64_t rows,
                 const NoiseKey& key, Origin origin = {}, int threads = 1);

}  // namespace radiometry
