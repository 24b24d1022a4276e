// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera does to its counts: two-point non-uniformity correction and replacement of bad pixels.
//   corrected = gain x raw + offset,   gain = response of all / response of the pixel,
// such that both flat frames it was measured with become uniform. At signals between and beyond the two a pixel that is
// not linear keeps a residual, and the noise of the flat frames stays in the maps: average many.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mtf/image.h"
#include "radiometry/fields.h"
#include "radiometry/stages/detector/saturation.h"

namespace radiometry {

struct Place {
  std::int64_t x = 0, y = 0;
};

struct TwoPoint {
  mtf::Image gain, offset;
  std::vector<Place> bad;  ///< they have gain 1 and offset 0, and are to be replaced
  HeldPixels saturated{};  ///< of the flat frames, all together
};

/// From two flat frames, each the mean of many. A pixel is bad when a value is not finite or its response, hot minus
/// cold, differs from the median one by more than `limit` of it, 0 < limit <= 1. Throws UsageError for images of
/// different or no size, and when the median response is not above 0.
TwoPoint two_point_correction(mtf::ImageView<const float> cold, mtf::ImageView<const float> hot, double limit = 0.5);

/// image = gain x image + offset. UsageError for an image of another size.
void correct(mtf::ImageView<float> image, const TwoPoint& correction, int threads = 1);

/// Gives each bad pixel the mean of the good ones in the smallest square around it that has any, up to 17 x 17, or else
/// of all good ones. Good pixels stay. Throws UsageError for places outside of the image and when no pixel is good.
void replace_bad(mtf::ImageView<float> image, std::span<const Place> bad);

/// The correction as a camera gets it: from the means of flat frames at two signals, with all the noise that these
/// have. So a simulation has the residual of a camera: non-linearity between the two signals, and the noise of the
/// means.
struct CorrectionSettings {
  double low = 0.2, high = 0.8;
  int frames = 64;
  double limit = 0.5;
  bool replace_bad = true;
  /// Of a thermal detector, which has no well: the temperatures of two blackbodies that fill the field. `low` and
  /// `high` are parts of the step from the first to the second then, 0 and 1.
  std::optional<double> cold_k{}, hot_k{};

  static constexpr auto fields() {
    using T = CorrectionSettings;
    return std::tuple{
        optional(&T::low, "low", 0.0, 1.0, "0.2", "charge of the cold flat frame, part of the full well"),
        above(optional(&T::high, "high", 0.0, 1.0, "0.8", "charge of the hot flat frame")),
        optional(&T::frames, "frames", 1, 4096, "64", "frames averaged for each flat frame"),
        above(optional(&T::limit, "limit", 0.0, 1.0, "0.5",
                       "a pixel is bad when its response differs from the median one by more than this part of it")),
        optional(&T::replace_bad, "replace_bad", "false", "whether bad pixels take the mean of their good neighbours")};
  }
};

/// Throws UsageError, which names the cause, for a flat frame that no scene gives: that part of the full well is less
/// than what the detector has without one.
void require_reachable(const CorrectionSettings& settings, double fill, double background_e, double full_well_e);

/// The same for a flat frame with more than a tenth of its pixels at an end of the range.
void require_unsaturated(const CorrectionSettings& settings, double fill, const HeldPixels& held);

/// Makes the flat frame of a number: a scene that fills that part of the well, with all that the detector does to it,
/// in the unit that is to be corrected.
using FlatFrame = std::function<void(double fill, std::uint32_t frame, mtf::ImageView<float> out)>;

/// The correction of a detector or a region of it. Frames are numbered from 2^32 - 1 downwards, so that their noise is
/// none of a sequence that begins at 0; the same frames give the same correction. Throws UsageError for settings out of
/// their bounds, a `low` that is not below `high`, no pixels, and what two_point_correction refuses.
TwoPoint measure_correction(std::int64_t width, std::int64_t height, const CorrectionSettings& settings,
                            const FlatFrame& flat);

}  // namespace radiometry
