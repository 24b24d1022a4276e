// SPDX-License-Identifier: Apache-2.0
#include "calib/iso12233/iso12233.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "calib/iso12233/iso12233_parts.h"
#include "mtf/error.h"

namespace calib {
namespace {

constexpr std::int64_t kMinSide_px = 10;
constexpr std::int64_t kSideColumns = 5;
constexpr double kMinContrast = 0.2;  // the reference's warnings
constexpr double kMaxEdgeRms_px = 3.0;
constexpr double kReferenceNyquist_cy_px = 0.495;
constexpr const char* kBias =
    "this method is biased: quarter-pixel bins are not divided out (-2.6 % at 0.5 cycles/pixel), the curve depends on "
    "the region's width and keeps the noise's bias; the default method has none of these and gives error bands";

std::string text(const char* format, double a, double b = 0.0) {
  char line[320];
  std::snprintf(line, sizeof line, format, a, b);
  return line;
}

void check(mtf::ImageView<const float> image, const Roi& roi, const Iso12233Options& options) {
  const std::string shown = std::to_string(roi.x) + "," + std::to_string(roi.y) + "," + std::to_string(roi.width) +
                            "," + std::to_string(roi.height);
  if (roi.width < 1 || roi.height < 1) throw mtf::UsageError("region " + shown + " is empty; give x,y,width,height");
  if (roi.x < 0 || roi.y < 0 || roi.width > image.width || roi.height > image.height ||
      roi.x > image.width - roi.width || roi.y > image.height - roi.height)
    throw mtf::UsageError("region " + shown + " extends beyond the image of " + std::to_string(image.width) + " x " +
                          std::to_string(image.height) + " pixels; move it inside");
  if (options.order < 1 || options.order > 5)
    throw mtf::UsageError("order " + std::to_string(options.order) + " of the edge; it has to be 1 to 5");
}

/// Mean of columns first .. first + kSideColumns - 1.
double side_mean(const iso::Region& region, std::int64_t first) {
  double sum = 0.0;
  for (std::int64_t row = 0; row < region.rows(); ++row)
    for (std::int64_t i = 0; i < kSideColumns; ++i) sum += region.at(row, first + i);
  return sum / static_cast<double>(kSideColumns * region.rows());
}

/// First frequency at which the SFR falls below `contrast`, interpolated linearly.
std::optional<double> crossing(const Iso12233Result& result, double contrast) {
  for (std::size_t i = 1; i < result.sfr.size(); ++i) {
    if (result.sfr[i] >= contrast) continue;
    const double share = (result.sfr[i - 1] - contrast) / (result.sfr[i - 1] - result.sfr[i]);
    return std::lerp(result.frequency_cy_px[i - 1], result.frequency_cy_px[i], share);
  }
  return std::nullopt;
}

std::optional<double> value_at(const Iso12233Result& result, double frequency_cy_px) {
  const auto after = std::lower_bound(result.frequency_cy_px.begin(), result.frequency_cy_px.end(), frequency_cy_px);
  if (after == result.frequency_cy_px.begin() || after == result.frequency_cy_px.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - result.frequency_cy_px.begin());
  const double from = result.frequency_cy_px[i - 1], to = result.frequency_cy_px[i];
  return std::lerp(result.sfr[i - 1], result.sfr[i], (frequency_cy_px - from) / (to - from));
}

/// The normal's angle of an edge whose column changes by `slope` a row, in the image before it was turned.
double normal_angle_deg(double slope, bool turned) {
  const double angle = turned ? std::atan2(1.0, slope) : -std::atan(slope);
  const double degrees = angle * 180.0 / std::numbers::pi;
  return degrees > 90.0 ? degrees - 180.0 : degrees;
}

// The method has no means against clipping: what the default method sees of it is said.
void note_clipping(mtf::ImageView<const float> image, const Roi& roi, const MeasureOptions& how,
                   Iso12233Result& result) {
  const EdgeMeasurement seen = measure_edge(image, roi, how);
  result.clipped_share = seen.clipped_share;
  constexpr const char* kTooHigh = "; this method takes clipped values as they are, and its curve is too high";
  if (seen.trouble == Trouble::clipped)
    result.warnings.push_back("clipped: " + seen.reason + kTooHigh);
  else if (seen.clipped_share > 0.0)
    result.warnings.push_back(text("%.2g %% of the pixels are clipped", 100.0 * seen.clipped_share) + kTooHigh);
  else if (seen.ends_abruptly)
    result.warnings.push_back(std::string(kEndsAbruptly));
}

bool leaves(const iso::RowPolynomial& curve, const iso::Region& region) {
  for (std::int64_t row = 0; row < region.rows(); ++row) {
    const double column = curve(static_cast<double>(row));
    if (!(column >= 0.0 && column <= static_cast<double>(region.columns() - 1))) return true;
  }
  return false;
}

}  // namespace

Iso12233Result measure_iso12233(mtf::ImageView<const float> image, const Roi& roi, const Iso12233Options& options) {
  check(image, roi, options);
  Iso12233Result result;
  result.roi = roi;
  result.warnings.emplace_back(kBias);
  const auto fail = [&](Trouble trouble, std::string reason) {
    result.trouble = trouble;
    result.reason = std::move(reason);
    return result;
  };

  for (std::int64_t y = roi.y; y < roi.y + roi.height; ++y)
    for (std::int64_t x = roi.x; x < roi.x + roi.width; ++x)
      if (!std::isfinite(image.at(x, y)))
        return fail(Trouble::no_data, "pixel (" + std::to_string(x) + "," + std::to_string(y) +
                                          ") is no number; ISO 12233 has no masks, use the default method");
  if (std::min(roi.width, roi.height) < kMinSide_px)
    return fail(Trouble::too_short, "fewer than 10 pixels a side; take a larger region");
  note_clipping(image, roi, options.image, result);

  const iso::Region region = iso::turn_upright(image, roi);
  const double left = side_mean(region, 0), right = side_mean(region, region.columns() - kSideColumns);
  result.contrast = std::abs(left - right) / (std::abs(left) + std::abs(right));
  if (left == right) return fail(Trouble::no_edge, "both sides have the same mean; put the edge across the region");

  const iso::EdgeFit fit = iso::fit_edge(region, options.order, options.tukey);
  if (!std::isfinite(fit.rms_px))
    return fail(Trouble::no_edge, "a row of the region is flat; the edge has to cross all of them");
  result.edge_rms_px = fit.rms_px;
  if (leaves(fit.curve, region))
    return fail(fit.rms_px > kMaxEdgeRms_px ? Trouble::no_edge : Trouble::off_region,
                "the edge runs out of the region's sides, or noise hides it; centre the region on one edge");
  const double slope = fit.line.slope(0.0);
  const std::int64_t rows = iso::whole_cycles(region.rows(), slope);
  if (rows == 0)
    return fail(Trouble::too_short,
                "the edge drifts by less than a pixel over the region's rows, so that ISO 12233 has no phases to "
                "average; take a longer edge, tilt the target or use the default method");
  iso::Profile profile = iso::project(region, rows, fit.curve);
  if (profile.esf.empty()) return fail(Trouble::no_edge, "no smooth edge in the region; centre the region on one edge");
  if (left > right)
    for (double& value : profile.esf) value = -value;
  result.sfr = iso::response(profile.esf, options.tukey);
  if (result.sfr.empty()) return fail(Trouble::no_edge, "no contrast across the edge that was found");

  result.angle_deg = normal_angle_deg(slope, region.turned);
  result.frequency_cy_px.resize(result.sfr.size());
  for (std::size_t k = 0; k < result.sfr.size(); ++k)
    result.frequency_cy_px[k] =
        static_cast<double>(k) / static_cast<double>(region.columns()) * std::sqrt(1.0 + slope * slope);
  if (left > right)
    for (double& value : profile.esf) value = -value;
  result.mtf50 = crossing(result, 0.5);
  result.mtf10 = crossing(result, 0.1);
  result.nyquist = value_at(result, 0.5);
  if (result.mtf10) result.sampling_efficiency = std::min(1.0, *result.mtf10 / kReferenceNyquist_cy_px);

  if (result.contrast < kMinContrast)
    result.warnings.push_back(
        text("contrast of %.1f %% is below 20 %%: noise weighs heavily", 100.0 * result.contrast));
  if (fit.rms_px > kMaxEdgeRms_px)
    result.warnings.push_back(
        text("rows lie %.1f px rms from the fitted edge, above 3 px: noise, or not one smooth edge", fit.rms_px));
  if (profile.empty_bins > 0)
    result.warnings.push_back(text(
        "%.0f of %.0f bins had no pixel and were filled from their neighbours: the edge's angle repeats its phases",
        static_cast<double>(profile.empty_bins), static_cast<double>(profile.esf.size())));
  result.esf = std::move(profile.esf);
  return result;
}

}  // namespace calib
