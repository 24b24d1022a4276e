// SPDX-License-Identifier: Apache-2.0
#include "calib/iso12233/iso12233.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "calib/dense.h"
#include "mtf/error.h"

namespace calib {
namespace {

// The steps of iso12233.h. Rows and columns are of the region as turned, counted from 0. Where the reference program
// has a peculiarity (ends of differences, an index off by one, a rounded width), published figures contain it, so it is
// kept and named.

constexpr std::int64_t kMinSide_px = 10;
constexpr std::int64_t kSideColumns = 5;
constexpr double kMinContrast = 0.2;  // the reference's warnings
constexpr double kMaxEdgeRms_px = 3.0;
constexpr double kReferenceNyquist_cy_px = 0.495;
constexpr const char* kBias =
    "this method is biased: quarter-pixel bins are not divided out (-2.6 % at 0.5 cycles/pixel), the curve depends on "
    "the region's width and keeps the noise's bias; the default method has none of these and gives error bands";
constexpr std::int64_t kBins = 4;         // a column
constexpr std::int64_t kSpareBins = 150;  // beyond those over which the edge drifts
constexpr double kMaxCorrection = 10.0;   // of the response of differences

/// The region, turned by a quarter against the clock where its edge is closer to horizontal.
struct Region {
  mtf::ImageView<const float> image;
  Roi roi;
  bool turned = false;

  std::int64_t rows() const { return turned ? roi.width : roi.height; }
  std::int64_t columns() const { return turned ? roi.height : roi.width; }
  double at(std::int64_t row, std::int64_t column) const {
    return turned ? image.at(roi.x + roi.width - 1 - row, roi.y + column) : image.at(roi.x + column, roi.y + row);
  }
};

/// Mean of some rows and columns.
double mean_of(const Region& region, std::int64_t row, std::int64_t rows, std::int64_t column, std::int64_t columns) {
  double sum = 0.0;
  for (std::int64_t j = row; j < row + rows; ++j)
    for (std::int64_t i = column; i < column + columns; ++i) sum += region.at(j, i);
  return sum / static_cast<double>(rows * columns);
}

/// The edge is taken as horizontal when the third rows from both ends differ more than the third columns. At least 4
/// pixels a side.
Region turn_upright(mtf::ImageView<const float> image, const Roi& roi) {
  const Region upright{image, roi, false};
  const auto row = [&](std::int64_t at) { return mean_of(upright, at, 1, 0, roi.width); };
  const auto column = [&](std::int64_t at) { return mean_of(upright, 0, roi.height, at, 1); };
  const double down = row(roi.height - 4) - row(2), across = column(roi.width - 4) - column(2);
  return {image, roi, std::abs(down) > std::abs(across)};
}

/// Column of the edge, a polynomial in z = (row - mean) / sd of the rows 0 .. rows - 1.
class RowPolynomial {
 public:
  RowPolynomial() = default;
  /// Least squares through `column`, one a row, more rows than `order`.
  RowPolynomial(const std::vector<double>& column, int order) {
    const double n = static_cast<double>(column.size());
    mean_ = 0.5 * (n - 1.0);
    sd_ = std::sqrt(n * (n + 1.0) / 12.0);
    Eigen::MatrixXd powers(column.size(), order + 1);
    for (Eigen::Index i = 0; i < powers.rows(); ++i) {
      double power = 1.0;
      for (Eigen::Index k = 0; k <= order; ++k, power *= (static_cast<double>(i) - mean_) / sd_) powers(i, k) = power;
    }
    const Eigen::VectorXd positions = Eigen::Map<const Eigen::VectorXd>(column.data(), powers.rows());
    const Eigen::VectorXd solution = least_squares(powers, positions);
    std::copy(solution.begin(), solution.end(), coefficient_.begin());
  }
  double operator()(double row) const {
    const double z = (row - mean_) / sd_;
    double value = 0.0;
    for (std::size_t k = coefficient_.size(); k-- > 0;) value = value * z + coefficient_[k];
    return value;
  }
  double slope(double row) const {
    const double z = (row - mean_) / sd_;
    double value = 0.0;
    for (std::size_t k = coefficient_.size(); k-- > 1;) value = value * z + static_cast<double>(k) * coefficient_[k];
    return value / sd_;
  }

 private:
  double mean_ = 0.0, sd_ = 1.0;
  std::array<double, 6> coefficient_{};
};

/// Windows of n samples numbered from 1 with their maximum near `centre`, falling to both ends at the pace of the
/// longer side. Tukey with alpha = 1: a raised cosine over round(2 x longer side) samples, cut at the far end. Hamming:
/// its centre lies half a sample later.
std::vector<double> tukey_window(std::int64_t n, double centre) {
  const double count = static_cast<double>(n);
  const auto length = static_cast<std::int64_t>(std::llround(2.0 * std::max(centre, count - centre)));
  const std::int64_t skip = centre >= 0.5 * count ? 0 : length - n;
  std::vector<double> window(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i) {
    const std::int64_t from_end = std::min(skip + i, length - 1 - skip - i);
    window[static_cast<std::size_t>(i)] =
        0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(from_end) / static_cast<double>(length - 1));
  }
  return window;
}

std::vector<double> hamming_window(std::int64_t n, double centre) {
  const double middle = centre + 0.5;
  const double side = std::max(middle - 1.0, static_cast<double>(n) - middle);
  std::vector<double> window(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i)
    window[static_cast<std::size_t>(i)] =
        0.54 + 0.46 * std::cos(std::numbers::pi * (static_cast<double>(i + 1) - middle) / side);
  return window;
}

/// The Tukey window over a row's differences never falls below this, so that an edge far from the first guess counts.
constexpr double kWindowFloor = 0.05;

std::vector<double> edge_window(std::int64_t n, double centre, bool tukey) {
  if (!tukey) return hamming_window(n, centre);
  std::vector<double> window = tukey_window(n, centre);
  for (double& w : window) w = (1.0 - kWindowFloor) * w + kWindowFloor;
  return window;
}

/// Differences of neighbours in a row. The reference repeats the second and the last but one at the ends.
void differences(const Region& region, std::int64_t row, std::vector<double>& d) {
  const std::size_t n = d.size();
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const auto column = static_cast<std::int64_t>(i);
    d[i] = region.at(row, column + 1) - region.at(row, column);
  }
  d[0] = d[1];
  d[n - 1] = d[n - 2];
}

double centroid(const std::vector<double>& d, const std::vector<double>& window) {
  double sum = 0.0, moment = 0.0;
  for (std::size_t i = 0; i < d.size(); ++i) {
    sum += window[i] * d[i];
    moment += window[i] * d[i] * static_cast<double>(i);
  }
  return moment / sum + 0.5;
}

struct EdgeFit {
  RowPolynomial curve, line;
  double rms_px = 0.0;  ///< NaN when a row has no gradient at all
};

/// Through the centroids of the rows' windowed differences, twice: the second time windows are centred on the first
/// fit.
EdgeFit fit_edge(const Region& region, int order, bool tukey) {
  const std::int64_t rows = region.rows(), columns = region.columns();
  std::vector<double> position(static_cast<std::size_t>(rows)), d(static_cast<std::size_t>(columns));
  EdgeFit fit;
  fit.rms_px = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> middle = edge_window(columns, 0.5 * static_cast<double>(columns + 1), tukey);
  for (const bool first : {true, false}) {
    for (std::int64_t row = 0; row < rows; ++row) {
      differences(region, row, d);
      // A curve that left the region has no window there; the middle one keeps its length bounded.
      const double centre = fit.curve(static_cast<double>(row));
      const bool inside = centre >= 0.0 && centre <= static_cast<double>(columns);
      double& at = position[static_cast<std::size_t>(row)];
      at = centroid(d, first || !inside ? middle : edge_window(columns, centre, tukey));
      if (!std::isfinite(at)) return fit;
    }
    fit.curve = RowPolynomial(position, order);
  }
  fit.line = RowPolynomial(position, 1);
  double squares = 0.0;
  for (std::int64_t row = 0; row < rows; ++row) {
    const double deviation = position[static_cast<std::size_t>(row)] - fit.curve(static_cast<double>(row));
    squares += deviation * deviation;
  }
  fit.rms_px = std::sqrt(squares / static_cast<double>(rows));
  return fit;
}

/// Rows that make whole cycles of the phase; 0 when the edge drifts by less than a column.
std::int64_t whole_cycles(std::int64_t rows, double slope) {
  const double pace = std::abs(slope);
  const double cycles = std::floor(static_cast<double>(rows) * pace);
  return cycles < 1.0 ? 0 : std::min<std::int64_t>(rows, std::llround(cycles / pace));
}

struct Profile {
  std::vector<double> esf;      ///< 4 a column; empty when the curve is too steep to be projected along
  std::int64_t empty_bins = 0;  ///< filled from their neighbours
};

/// Averages of the first `rows` rows in bins of a quarter column along the curve.
Profile project(const Region& region, std::int64_t rows, const RowPolynomial& curve) {
  const std::int64_t columns = region.columns(), bins = kBins * columns;
  const double drift = static_cast<double>(kBins * (rows - 1)) * curve.slope(0.0);
  if (!(std::abs(drift) <= 16.0 * static_cast<double>(kBins * (rows + columns)))) return {};
  const std::int64_t shift = std::abs(std::llround(drift));
  const std::int64_t offset = drift > 0.0 ? -shift : 0;
  const std::int64_t first = std::llround(0.5 * static_cast<double>(shift));
  const std::int64_t all = bins + shift + kSpareBins;

  std::vector<double> count(static_cast<std::size_t>(all), 0.0), sum(static_cast<std::size_t>(all), 0.0);
  for (std::int64_t row = 0; row < rows; ++row) {
    const double edge = curve(static_cast<double>(row)) - curve(0.0);
    for (std::int64_t column = 0; column < columns; ++column) {
      const double bin = std::ceil((static_cast<double>(column) - edge) * kBins) - static_cast<double>(offset);
      const auto k = static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(all - 1)));
      count[k] += 1.0;
      sum[k] += region.at(row, column);
    }
  }

  Profile profile;
  profile.esf.resize(static_cast<std::size_t>(bins));
  double last = std::numeric_limits<double>::quiet_NaN();
  for (std::int64_t i = 0; i < bins; ++i) {
    const auto k = static_cast<std::size_t>(first + i);
    if (count[k] == 0.0) {
      ++profile.empty_bins;
      // Halves of both neighbours' counts and sums; at the ends the one inside.
      const bool before = k > 0, after = i + 1 < bins || k == 0;
      const double share = before && after ? 0.5 : 1.0;
      count[k] = share * ((before ? count[k - 1] : 0.0) + (after ? count[k + 1] : 0.0));
      sum[k] = share * ((before ? sum[k - 1] : 0.0) + (after ? sum[k + 1] : 0.0));
    }
    // Runs of empty bins at the start have no neighbour yet; they take the first value below.
    if (count[k] > 0.0) last = sum[k] / count[k];
    profile.esf[static_cast<std::size_t>(i)] = last;
  }
  const auto known = std::find_if(profile.esf.begin(), profile.esf.end(), [](double v) { return std::isfinite(v); });
  if (known == profile.esf.end()) return {};
  std::fill(profile.esf.begin(), known, *known);
  return profile;
}

/// Central differences; the ends repeat their neighbours.
std::vector<double> line_spread(const std::vector<double>& esf) {
  const std::size_t n = esf.size();
  std::vector<double> d(n);
  for (std::size_t i = 1; i + 1 < n; ++i) d[i] = 0.5 * (esf[i + 1] - esf[i - 1]);
  d[0] = d[1];
  d[n - 1] = d[n - 2];
  return d;
}

/// Shifted so that its maximum, the mean place of equal ones, is in the middle; zeros come in.
std::vector<double> centred(const std::vector<double>& d) {
  const auto n = static_cast<std::int64_t>(d.size());
  const double top = *std::max_element(d.begin(), d.end());
  double place = 0.0, count = 0.0;
  for (std::int64_t i = 0; i < n; ++i)
    if (d[static_cast<std::size_t>(i)] == top) place += static_cast<double>(i + 1), count += 1.0;
  const std::int64_t middle = std::llround(0.5 * static_cast<double>(n + 1));
  const std::int64_t shift = std::llround(place / count - static_cast<double>(middle));
  std::vector<double> moved(d.size(), 0.0);
  for (std::int64_t i = std::max<std::int64_t>(0, -shift); i < std::min(n, n - shift); ++i)
    moved[static_cast<std::size_t>(i)] = d[static_cast<std::size_t>(i + shift)];
  return moved;
}

/// Response of central differences by the index of the sample, one step ahead of the frequency as in the reference.
double difference_correction(std::size_t k, std::size_t samples) {
  if (k == 0) return 1.0;
  const double x = std::numbers::pi * static_cast<double>(k + 1) / static_cast<double>(samples + 1);
  return std::min(std::abs(x / std::sin(x)), kMaxCorrection);
}

/// columns + 1 samples, 1 / columns cycles per column apart, of an edge function that rises. Empty when no line spread
/// remains within the window.
std::vector<double> response(const std::vector<double>& esf, bool tukey) {
  std::vector<double> lsf = centred(line_spread(esf));
  const auto n = static_cast<std::int64_t>(lsf.size());
  const double middle = 0.5 * static_cast<double>(n);
  const std::vector<double> window = tukey ? tukey_window(n, middle) : hamming_window(n, middle);
  for (std::size_t i = 0; i < lsf.size(); ++i) lsf[i] *= window[i];

  std::vector<double> cosine(lsf.size());
  for (std::size_t i = 0; i < cosine.size(); ++i)
    cosine[i] = std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
  const std::size_t half = lsf.size() / 2 + 1, quarter = lsf.size() / kBins;
  std::vector<double> sfr(quarter + 1);
  for (std::size_t k = 0; k < sfr.size(); ++k) {
    double re = 0.0, im = 0.0;
    // n is a multiple of 4: the sine is the cosine a quarter turn back.
    for (std::size_t i = 0, turn = 0; i < lsf.size(); ++i, turn = (turn + k) % lsf.size()) {
      re += lsf[i] * cosine[turn];
      im += lsf[i] * cosine[turn >= quarter ? turn - quarter : turn + 3 * quarter];
    }
    sfr[k] = std::hypot(re, im) * difference_correction(k, half);
  }
  const double total = sfr[0];
  if (!(total > 0.0)) return {};
  for (double& value : sfr) value /= total;
  return sfr;
}

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

bool leaves(const RowPolynomial& curve, const Region& region) {
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

  const Region region = turn_upright(image, roi);
  const auto side = [&](std::int64_t first) { return mean_of(region, 0, region.rows(), first, kSideColumns); };
  const double left = side(0), right = side(region.columns() - kSideColumns);
  result.contrast = std::abs(left - right) / (std::abs(left) + std::abs(right));
  if (left == right) return fail(Trouble::no_edge, "both sides have the same mean; put the edge across the region");

  const EdgeFit fit = fit_edge(region, options.order, options.tukey);
  if (!std::isfinite(fit.rms_px))
    return fail(Trouble::no_edge, "a row of the region is flat; the edge has to cross all of them");
  result.edge_rms_px = fit.rms_px;
  if (leaves(fit.curve, region))
    return fail(fit.rms_px > kMaxEdgeRms_px ? Trouble::no_edge : Trouble::off_region,
                "the edge runs out of the region's sides, or noise hides it; centre the region on one edge");
  const double slope = fit.line.slope(0.0);
  const std::int64_t rows = whole_cycles(region.rows(), slope);
  if (rows == 0)
    return fail(Trouble::too_short,
                "the edge drifts by less than a pixel over the region's rows, so that ISO 12233 has no phases to "
                "average; take a longer edge, tilt the target or use the default method");
  Profile profile = project(region, rows, fit.curve);
  if (profile.esf.empty()) return fail(Trouble::no_edge, "no smooth edge in the region; centre the region on one edge");
  if (left > right)
    for (double& value : profile.esf) value = -value;
  result.sfr = response(profile.esf, options.tukey);
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
