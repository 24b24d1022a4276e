// SPDX-License-Identifier: Apache-2.0
#pragma once

// A camera from stacks of flat frames: gain, noise, response, crosstalk and fixed patterns with their errors, as far as
// frames tell them. Each stack is reduced to a StackSummary in one pass (stack_statistics.h); then
//   fit of means and temporal variances over the levels (photon_transfer.h), whose chi-square tests the model
//   crosstalk from the covariances (crosstalk_estimate.h), which corrects the variances, the gain and what follows
//   patterns: dark signal (DSNU) from the dark stack of the most frames, photo response (PRNU) from the difference of a
//   bright and that dark mean frame, in which the offsets cancel, over the signal's slope K g'(e) e (pattern.h)
//   temporal noise of rows, columns and frames, pooled over the stacks (components.h)
// What frames cannot tell is named with the reason, never guessed: quantum efficiency and transmission apart, f-number,
// fill factor.
//   std::vector<calib::Stack> stacks;
//   stacks.push_back({.name = "dark", .sums = calib::summary_of(dark)});
//   stacks.push_back({.name = "5 ms", .light = 5.0, .sums = calib::summary_of(bright)}); ...
//   const calib::Characterization camera = calib::characterize(std::move(stacks), {.nonlinearity = 1});
//   camera.find("read_noise")->value

#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "calib/characterize/blinking_pixels.h"
#include "calib/characterize/crosstalk_estimate.h"
#include "calib/characterize/pattern.h"
#include "calib/characterize/photon_transfer.h"
#include "calib/characterize/slow_noise.h"

namespace calib {

/// What is kept of a stack.
struct StackSummary {
  std::int64_t frames = 0;
  double mean = 0.0;
  radiometry::MeanSquares squares;
  std::array<Covariance, kLags.size()> covariance{};
  double variance_sd = 0.0, share_low = 0.0, share_high = 0.0, von_neumann = 2.0;
  std::vector<std::int64_t> at_low{}, at_high{};  ///< pixels at an end of the scale in all frames, where they are few
  FrameDrift drift{};
  /// Of a pixel's noise in successive frames, 0 for noise without memory, above it for 1/f noise, lag and averages over
  /// frames; sd of independent ones, 0: not known, as of two frames.
  Estimate frame_correlation{};
  std::vector<float> variances{};  ///< of pixels in time, those of every `rows_apart`-th row
  std::int64_t rows_apart = 1;
  std::uint32_t step = 1;
  std::vector<double> frame_means{};
  double lasting = 0.0;  ///< what 1/f noise adds to the variance of a pixel's mean over the frames, counts^2
  Estimate apart{};      ///< what pixels that are left out add to the mean square tvh, counts^2
  PixelSeries series{};  ///< of noisy pixels, from a second reading; may be empty
  mtf::Image pattern{};  ///< pixel means less the mean of all; may be empty
  NoiseScales noise{};   ///< of pixels empty where that is
};
/// Throws UsageError for a single frame.
StackSummary summary_of(const StackStatistics& stack);
/// Variance of a pixel as most are: by the median of all.
double typical_variance(const StackSummary& stack);
/// Pixels whose temporal variance the noise of the others hardly makes (kNoisy_p), by their places along rows, where
/// variances are in proportion to what is expected, or alike; and the series of them to be read, of no more than
/// kMostSeriesValues in all.
std::vector<std::int64_t> noisy_places(const StackSummary& stack,
                                       const std::function<double(std::int64_t place)>& expected = {});
PixelSeries empty_series(const StackSummary& stack);
/// Of a pixel in one of the rows that are kept.
inline double variance_at(const StackSummary& stack, std::int64_t place) {
  const auto columns = static_cast<std::int64_t>(stack.squares.columns);
  const std::int64_t row = place / columns / stack.rows_apart;
  return static_cast<double>(stack.variances[static_cast<std::size_t>(row * columns + place % columns)]);
}
/// Sets `apart` and `variance_sd` for pixels that are left out. What rows, columns and frames share is told from all
/// pixels, those that are left out too, whose own noise lets it scatter: below 3 standard deviations, `slowness` times
/// those of noise without memory, none is assumed, and its error stays.
void leave_out(StackSummary& stack, const std::set<std::int64_t>& places, double slowness);
/// Pixels by ln(variance / mean of all) in units of variance_bin().
std::map<int, std::int64_t> pixels_by_variance(const StackSummary& stack);
/// A quarter of the relative standard deviation of a pixel's variance.
inline double variance_bin(const StackSummary& stack) { return 0.25 * std::sqrt(2.0 / (stack.squares.frames - 1.0)); }
/// Relative variance of a mean, over so many pixels in so many rows, of products of their noise in time, of which each
/// has that of a normal number times another.
double variance_of_products(const StackSummary& stack, double pixels, double rows);

struct Stack {
  std::string name;
  double light = 0.0;   ///< photons, or any unit that is proportional to them; 0 in the dark
  double time_s = 0.0;  ///< of the exposure
  double light_per_k = 0.0, light_per_emissivity = 0.0;  ///< of a blackbody (thermal.h): by how much its light grows
  StackSummary sums;
  bool saturates = false;                    ///< its pixels are full, below the upper end of the scale
  double stuck_low = 0.0, stuck_high = 0.0;  ///< parts of its values of pixels that are stuck there in all stacks

  /// Few of its values are at an end of the scale, below and above, those of stuck pixels apart.
  bool is_clipped_low() const { return sums.share_low - stuck_low > kClipped; }
  bool is_clipped_high() const { return sums.share_high - stuck_high > kClipped; }
  bool is_usable() const { return !is_clipped_low() && !is_clipped_high() && !saturates; }
  static constexpr double kClipped = 3.2e-5;  ///< of normal noise 4 sd from the end
};
/// The stack in the dark that tells the patterns and the blinking pixels: usable, with a plane, of the most frames, and
/// of equals of the shortest exposure. Null where there is none.
const Stack* dark_stack(const std::vector<Stack>& stacks);
/// Empties the planes that characterize() will not look at, for those who read one stack after the other.
void drop_planes(std::vector<Stack>& stacks);

struct CharacterizeOptions {
  int nonlinearity = 0;              ///< terms of the response: 0, 1 (a2), 2 (a2, a3), 3 (a2, a3, a4)
  double full_well_e = 0.0;          ///< to which they refer; 0: the range of counts up to `most_counts` by the gain
  double most_counts = 0.0;          ///< the largest count of the converter
  int trend = 2;                     ///< degree of the shading that is no part of the response's pattern (pattern.h)
  double light_repeatability = 0.0;  ///< relative sd of the light from stack to stack
  bool counts_time = false;  ///< the times of the stacks are known: dark current where dark stacks differ in them
  double misfit_p = 1e-3;    ///< below, the model does not describe the frames
};

enum class Verdict { determined, upper_limit, not_determined, predicted };
std::string_view verdict_name(Verdict verdict);

struct Finding {
  std::string name, unit;
  Verdict verdict = Verdict::determined;
  double value = 0.0, sd = 0.0;
  double low95 = 0.0, high95 = 0.0;
  std::optional<double>
      sd_array{};  ///< of the number of this one array, where `sd` is that of the process it is a draw of
  std::optional<double> sd_systematic{};  ///< of what does not average down over frames; beside `sd`, in the interval
  std::string from{};                     ///< stacks and method
  std::string why{};                      ///< it is not determined
};

/// A number with its 95 % interval of normal errors.
Finding finding_of(const std::string& name, const std::string& unit, const Estimate& e, const std::string& from);

struct Characterization {
  std::vector<Stack> stacks;  ///< by light, then time
  std::vector<int> level_of;  ///< of each stack in `transfer.levels`; -1: left out
  std::vector<TransferLevel> levels;
  PhotonTransfer transfer;   ///< apparent, before the correction for crosstalk
  double reference_k = 0.0;  ///< of the kelvin of thermal.h; 0: frames by light
  CrosstalkEstimate crosstalk;
  double full_well_e = 0.0;  ///< of a2, a3, a4
  std::vector<Finding> findings;
  std::vector<Defect> defects;  ///< of the dark, in counts
  /// Places in `stacks` of those whose planes tell the patterns; -1: there is none. Of blackbodies `dark` is the one
  /// nearest to the reference.
  int dark = -1, bright = -1;
  double bright_signal = 0.0;   ///< K g'(e) e of the bright one: counts of the responsivity's pattern
  double flicker_lowest = 0.0;  ///< cycles per frame; 0: no 1/f noise is looked for
  int trend = 0;                ///< degree of the shading that was taken from it
  std::vector<std::string> warnings;
  bool misfit = false;
  std::string misfit_reason;  ///< with the level that disagrees most

  const Finding* find(std::string_view name) const;
};

/// The covariances of the noise of pixels: less the components that rows, columns and frames share, which the same
/// frames tell. Neighbours that share noise raise the component of
/// their line, which is undone.
std::array<Estimate, kLags.size()> pixel_covariance(const StackSummary& stack);
/// Tells pixels that are stuck at an end of the scale, as they are there in every frame of all the stacks, from clipped
/// ones. They are defects.
void mark_stuck(std::vector<Stack>& stacks);
/// Marks the stacks from which on the noise is a third below the largest, which is that of light: pixels are full; and
/// those just before in which some are, whose noise is down already. Where noise falls from the dark on the frames are
/// processed, where the mean falls stacks and light are paired wrongly; both are refused.
void mark_saturated(const std::vector<Stack*>& by_light);
/// Why a stack is not usable, the same with its name and that it is left out, and whether rounding hides the noise of
/// one: kHidden_counts of rounding.h, and the pixels are within half a count of each other.
std::string clipped_words(const Stack& stack);
std::string left_out_words(const Stack& stack);
/// Why light of that exposure is not told from dark signal, where all dark stacks have another one; "" where it is, or
/// there is none. Dark stacks of two exposures tell the dark current.
std::string other_exposure_words(const std::string& name, double time_s, const std::set<double>& dark_s);
/// Throws UsageError with these words.
void require_dark_exposures(const std::vector<Stack>& stacks);
bool is_hidden_by_rounding(const Stack& stack);
/// Temporal variance that a pixel has in common with others of its row, column or frame.
double shared_variance(const radiometry::MeanSquares& squares);
/// All of it: the mean over the pixels.
double pixel_variance(const radiometry::MeanSquares& squares);
/// The part of the rounding error of a pixel that does not change from frame to frame, in counts^2.
double rounding_of(const Stack& stack);
/// The mean frame of `stack` less that of `other`.
mtf::Image pattern_difference(const Stack& stack, const Stack& other);
/// Adds a warning where the noise of neighbours correlates beyond what their rows and columns share.
void warn_of_neighbours(const Stack& dark, std::vector<std::string>& warnings);
/// Adds what the noise of a pixel is in time, and warnings where frames are not independent, or some pixels are noisier
/// than normal noise makes any: `frame_correlation` and `noisy_pixels` of the stack with
/// the least light, as neither grows with it. `known`: 1/f noise or blinking is found, and no warning needed.
/// `explained`: how many noisy pixels are known to be so.
void add_noise_in_time(const std::vector<Stack>& by_light, std::vector<Finding>& findings,
                       std::vector<std::string>& warnings, bool known = false, double explained = 0.0);
/// Of the stack's dark frames; and what add_noise_in_time's correlation is of, as flicker_octave with flicker_lowest,
/// and flicker_corner.
SlowNoise slow_noise_of(const Stack& dark);
void add_slow_noise(const SlowNoise& slow, int dark, const Estimate& gain, Characterization& camera);
double number_of_values(const Stack& stack);
/// Throws UsageError for no stacks, stacks of other sizes, means that fall while the light rises, and drifts: of all
/// stacks together by von Neumann's ratio; of one alone where a line through its frames' means rises or falls by more
/// than a thousandth of the signal, more than three times the repeatability, and more than chance makes of any stack in
/// 10^4 sets (Student's t).
void require_sound(const std::vector<Stack>& by_light, double light_repeatability = 0.0);

/// Throws UsageError, naming stack and remedy, for stacks of other sizes, without a level that is not clipped, whose
/// means do not follow the light, whose light drifts, and as fit_photon_transfer().
Characterization characterize(std::vector<Stack> stacks, const CharacterizeOptions& options);

}  // namespace calib
