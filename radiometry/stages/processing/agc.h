// SPDX-License-Identifier: Apache-2.0
#pragma once

// Automatic gain: the curve from counts to display levels, found from one frame and applied to it or to the next.
//   linear   a straight line between two quantiles of the frame
//   plateau  the cumulated histogram between them, each bin counted with at most `plateau` of the pixels: large and
//            uniform areas take no more display levels than that, rare values keep theirs (1: histogram equalisation;
//            towards 0: linear over the values that occur) (Vickers, Opt. Eng. 35, 1921 (1996))
// Display levels are linear numbers from 0 to the largest; rounding to integers is left to the file that is written.

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

enum class GainMethod { linear, plateau };
inline constexpr std::array<std::string_view, 2> kGainMethodNames{"linear", "plateau"};
constexpr std::span<const std::string_view> words(GainMethod) { return kGainMethodNames; }

/// Which end of the signal is bright.
enum class Polarity { white_hot, black_hot };
inline constexpr std::array<std::string_view, 2> kPolarityNames{"white_hot", "black_hot"};
constexpr std::span<const std::string_view> words(Polarity) { return kPolarityNames; }

struct AutomaticGain {
  GainMethod method = GainMethod::linear;
  double clip = 0.005;     ///< part of the pixels below the lower and above the upper end
  double plateau = 0.002;  ///< largest part of the pixels that counts in one bin
  int bins = 4096;
  double most_level = 255.0;
  Polarity polarity = Polarity::white_hot;

  static constexpr auto fields() {
    return std::tuple{
        optional(&AutomaticGain::method, "method", "\"plateau\"", "linear, or plateau (histogram)"),
        optional(&AutomaticGain::clip, "clip", 0.0, 0.49, "", "part of the pixels cut at each end"),
        above(optional(&AutomaticGain::plateau, "plateau", 0.0, 1.0, "", "largest part of the pixels in one bin")),
        optional(&AutomaticGain::bins, "bins", 2, 65536, "", "bins of the histogram"),
        above(optional(&AutomaticGain::most_level, "most_level", 0.0, 1e9, "", "largest display level")),
        optional(&AutomaticGain::polarity, "polarity", "\"white_hot\"",
                 "which end of the signal is bright: white_hot, black_hot")};
  }
};

/// A curve from values to display levels: `level` holds those of evenly spaced values from `low` to `high`, rising; the
/// curve is straight between them and constant outside.
struct ToneCurve {
  double low = 0.0, high = 1.0;
  std::vector<float> level{};

  /// NaN for NaN. Throws mtf::UsageError for a curve without an interval.
  float at(float value) const;
  /// Intervals of the curve for one unit of value.
  double scale() const { return static_cast<double>(level.size() - 1) / (high - low); }
};

/// What a curve is made from: the pixels of a frame, wherever it is.
struct FramePixels {
  std::int64_t finite = 0;  ///< how many of them
  /// The values at two ranks of the sorted finite ones.
  std::function<std::array<double, 2>(const std::array<std::int64_t, 2>& ranks)> values_at;
  /// How many have (value - low) x scale in each of so many intervals of 1 from 0 on, the end in the last.
  std::function<std::vector<std::int64_t>(double low, double scale, std::int64_t bins)> histogram;
};
ToneCurve tone_curve(const FramePixels& pixels, const AutomaticGain& gain);

/// The curve of a frame; NaN pixels do not count. A uniform frame gets the display level in the middle. Throws
/// UsageError for settings out of bounds and a frame without a finite pixel.
ToneCurve tone_curve(mtf::ImageView<const float> frame, const AutomaticGain& gain, int threads = 1);

/// image = curve(image).
void apply(mtf::ImageView<float> image, const ToneCurve& curve, int threads = 1);

/// White for black, for Polarity::black_hot: image = most_level - image.
void invert_polarity(mtf::ImageView<float> image, double most_level);

}  // namespace radiometry
