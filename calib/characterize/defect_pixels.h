// SPDX-License-Identifier: Apache-2.0
#pragma once

// Defective pixels of a camera, as [defects] of a sensor file has them (radiometry/stages/noise/fixed_pattern.h).
//   hot    more dark signal than its row and column by x, exponentially distributed over a part f of the pixels:
//          P(x) = exp(-x/m)/m. Those beyond the limit F of a defect (pattern.h) are found. As the exponential forgets
//          where it begins, they exceed F by m on average, and there are f exp(-F/m + s^2/(2 m^2)) of all pixels, with
//          s the scatter of the others, which lifts more pixels over F than it takes below. With the number n of them
//          the relative errors are 1/sqrt(n) of m, and of f sqrt(1 + (F/m - s^2/m^2)^2)/sqrt(n).
//   dead   a response below half of that of the others
// A pixel beyond the limit that is neither answers weakly, or is cold; the chain has none of those. What defects add to
// the mean of a dark frame, and to the noise, is no part of the offset and of the read noise of the others. Crosstalk
// gives the neighbours of a defect a part of its signal, which is taken back from them. A pixel whose noise is more
// than that of its signal is restless: where some blink (blinking_pixels.h) it is none of these.

#include "calib/characterize/characterize.h"

namespace calib {

struct DefectSums {
  std::vector<Defect> hot{};            ///< that are not dead
  std::int64_t dead = 0;                ///< also those that stand at a value of their own
  std::int64_t others = 0;              ///< beyond the limit in the dark or in the response, and neither
  double mean = 0.0;                    ///< what all these add to the mean of a dark frame, counts
  std::set<std::int64_t> with_noise{};  ///< whose noise may be another, by their places: all but the dead
};

/// `dark`: of the mean dark frame. `response`: of its difference to one of that much more signal; may be null.
/// `restless`: pixels that blink or may, which are neither hot nor others. `lit`: the frame `dark` holds what the
/// responses make of a signal; pixels beyond the limit in them are not hot.
DefectSums defect_sums(const PlaneSquares& dark, const PlaneSquares* response, double signal,
                       const std::set<std::int64_t>& restless, bool lit = false);

/// The blinking pixels of a dark stack.
struct BlinkingPixels {
  BlinkingNoise noise{};
  std::set<std::int64_t> restless{};  ///< noisier than a signal of theirs makes them
  double noisy = 0.0;                 ///< how many are noisier than most, and
  double looked_at = 0.0;             ///< of how many the series are
  double all = 0.0;                   ///< of how many the variances are
  bool known = false;                 ///< whether pixels blink: the stack is long enough, and was read twice
  /// They are enough to tell the numbers of all.
  bool found() const { return known && noise.pixels.size() >= 5 && noise.change.sd > 0.0; }
  /// Sum of the squares of the excesses.
  double squares() const;
  /// How many noisy pixels blink or have the noise of their signal.
  double explained() const;
  /// What those that keep their level in the dark stack, of n frames each, can add to the variance of pixels in others,
  /// and to the mean. Which they are is not known: these are errors.
  double unseen_variance(double n) const;
  double unseen_mean() const;
  bool unseen_count = false;  ///< of some level: that variance exceeds its other errors
  /// By how much sums of products of two of them scatter more, as their states last.
  double slowness() const;
  /// Of the mean of n frames, what the chance states of these pixels make of it.
  double mean_variance(double n, double pixels) const;
};
/// `shot`: of estimate_blinking(); `side`: crosstalk, which makes neighbours of blinking pixels blink.
BlinkingPixels blinking_pixels(const StackSummary& dark, const PlaneSquares& plane, double shot, double side);

/// Pixels of a stack that are noisier than the light, as it is shaded, makes them and the dark signal of those that are
/// hot: by the planes of two stacks, of the dark one's squares and `shot` as above.
std::vector<std::int64_t> noisy_for_light(const Stack& stack, const Stack& dark, const Stack& bright,
                                          const PlaneSquares& plane, double shot);

/// The share of so many of the pixels, with Poisson limits.
Finding share_finding(const char* name, double count, double pixels, const std::string& from);

/// Whether stacks have exposure times that differ by a hundredth and more.
bool exposures_differ(const std::vector<Stack>& stacks);
inline constexpr std::string_view kHotChanges =
    "the stacks have several exposure times, with which hot pixels change; they are in the offset and the noise, and "
    "in "
    "the list of defects";

/// Takes what crosstalk gave of the signal of defects from their neighbours.
void take_back_leaks(mtf::Image& plane, const std::vector<Defect>& defects, double side, double corner);

/// hot_fraction, and hot_excess in `unit`, of which there are `gain` counts; `sums.hot` are of that plane.
void add_hot_pixels(const DefectSums& sums, const PlaneSquares& dark, const Estimate& gain, const std::string& unit,
                    const std::string& from, Characterization& camera);
void add_dead_pixels(const DefectSums& sums, double pixels, const std::string& from, Characterization& camera);
/// blinking_fraction, blinking_excess and blinking_dwell.
void add_blinking_pixels(const BlinkingPixels& blinking, const Estimate& gain, const std::string& unit,
                         const std::string& from, Characterization& camera);

}  // namespace calib
