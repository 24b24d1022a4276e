// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/data/edge_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "calib/edge/edge_pixels.h"
#include "calib/edge/reference_step.h"
#include "calib/measure/edge_facts.h"

namespace calib {
namespace {

// Rounding along the pixels' grid. Where an edge shows few distances a pixel, all pixels at one distance have the same
// value but for the noise. Noise that is small against the step between values does not break up their rounding errors:
// the pixels round alike and share one error.

struct RoundingByDistance {
  /// Of each pixel: how many pixels are as far from the edge, to an eighth of a pixel.
  std::vector<double> alike;
  /// Variance of the noise before rounding, in squared steps. Pixels at one distance scatter by what their place
  /// between two steps makes of the noise, from nothing to half a step; the mean over the places is the noise's and 1
  /// / 12.
  double noise_steps2 = 0.0;
};

constexpr double kNear_px = 0.125;

// Of the deviations of pixels from their mean.
struct Scatter {
  double squares = 0.0, dof = 0.0;
  void add(const Scatter& other) { squares += other.squares, dof += other.dof; }
};

/// `esf`: the edge spread function at each residual, whose plateaus are one place each; `quantum`: the step, above 0.
RoundingByDistance rounding_by_distance(std::span<const Residual> residuals, std::span<const double> esf,
                                        double quantum) {
  constexpr double kPlateau = 0.08, kFewest = 4.0;
  std::vector<std::size_t> order(residuals.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto distance = [&](std::size_t i) { return residuals[order[i]].distance_px; };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return residuals[a].distance_px < residuals[b].distance_px; });

  RoundingByDistance found{.alike = std::vector<double>(residuals.size())};
  for (std::size_t i = 0, first = 0, end = 0; i < order.size(); ++i) {
    while (end < order.size() && distance(end) <= distance(i) + kNear_px) ++end;
    while (distance(first) < distance(i) - kNear_px) ++first;
    found.alike[order[i]] = static_cast<double>(end - first);
  }

  double sum = 0.0, places = 0.0;
  const auto take = [&](const Scatter& place) {
    if (place.dof < kFewest) return;
    sum += place.squares / place.dof;
    places += 1.0;
  };
  std::array<Scatter, 2> plateaus{};
  for (std::size_t first = 0, end = 0; first < order.size(); first = end) {
    double n = 0.0, mean = 0.0;
    Scatter here{.squares = 0.0, .dof = -1.0};
    for (; end < order.size() && distance(end) <= distance(first) + 2.0 * kNear_px; ++end) {
      const Residual& r = residuals[order[end]];
      const double steps = r.value * r.sd / quantum, change = steps - mean;
      mean += change / (n += 1.0);
      here.squares += change * (steps - mean);
      here.dof += 1.0;
    }
    const double e = esf[order[first]];
    if (e > kPlateau && e < 1.0 - kPlateau)
      take(here);
    else
      plateaus[e < 0.5 ? 0 : 1].add(here);
  }
  for (const Scatter& plateau : plateaus) take(plateau);
  if (places > 0.0) found.noise_steps2 = std::max(0.0, sum / places - 1.0 / 12.0);
  return found;
}

/// |dH / d angle| from which the turn of the blur counts: an angle is known to a milliradian, and the step of a fit
/// needs no more than that.
constexpr double kTurns = 0.05;

/// The part of the variance of rounding that pixels of one value share: the first harmonic of rounding, from the
/// variance of the noise in squared steps (B. Widrow and I. Kollar, Quantization Noise, 2008).
double shared_share(double noise_steps2) { return std::exp(-4.0 * std::numbers::pi * std::numbers::pi * noise_steps2); }

/// Of 32 bytes.
constexpr std::size_t kMostPixels = 1000000;

/// t^k of t = s / half_length for k = 2, 3, ..; beyond the ends they continue along their tangents (edge_curve.h).
class Powers {
 public:
  Powers(const EdgeCurve& curve, double s)
      : t_(std::clamp(s / curve.half_length_px, -1.0, 1.0)), beyond_(s / curve.half_length_px - t_), slope_(2.0 * t_) {}
  double value() const { return slope_ * (t_ / k_ + beyond_); }
  double slope() const { return slope_; }  ///< by t
  void advance() {
    slope_ *= t_ * (k_ + 1.0) / k_;
    k_ += 1.0;
  }

 private:
  double t_, beyond_, slope_, k_ = 2.0;
};

}  // namespace

EdgeBlock::Place EdgeBlock::on_curve(const EdgeCurve& curve, double across, double along, double near) {
  // Third order: the distance is exact to 1e-8 px on an edge that bends by a tenth of its length.
  constexpr double kSmallStep_px = 0.02;
  const CurveFoot foot = foot_near(curve, across, along, near, kSmallStep_px);
  const double scale = 1.0 / std::sqrt(1.0 + foot.slope * foot.slope);
  return {
      foot.distance_px, foot.along_px, across, -scale, scale * (foot.along_px + foot.height_px * foot.slope), scale};
}

inline EdgeBlock::Place EdgeBlock::place_of(const EdgeCurve& curve, Point normal, const Pixel& pixel) {
  const double px = pixel.x + 0.5 - curve.origin.x, py = pixel.y + 0.5 - curve.origin.y;
  const double across = normal.x * px + normal.y * py, along = normal.x * py - normal.y * px;
  if (curve.shape == EdgeCurve::Shape::line) return {across, along, across, -1.0, along, 1.0};
  return on_curve(curve, across, along, along);
}

bool EdgeBlock::keeps_places() const {
  constexpr std::size_t kMostKept = 500000;  // of 48 bytes
  return data_->start.curve.shape != EdgeCurve::Shape::line && pixels_.size() <= kMostKept;
}

// The curve has moved a little since the last pass: each foot is searched from where it was.
const std::vector<EdgeBlock::Place>& EdgeBlock::places(std::span<const double> own) const {
  const std::span<const double> shape = own.first(2 + curve_unknowns());
  if (std::equal(shape.begin(), shape.end(), placed_for_.begin(), placed_for_.end())) return places_;
  placed_for_.assign(shape.begin(), shape.end());
  const EdgeCurve edge = curve(own);
  const Point normal = edge.normal();
  const bool placed = !places_.empty();
  places_.resize(pixels_.size());
  for (std::size_t p = 0; p < pixels_.size(); ++p) {
    const double px = pixels_[p].x + 0.5 - edge.origin.x, py = pixels_[p].y + 0.5 - edge.origin.y;
    const double across = normal.x * px + normal.y * py, along = normal.x * py - normal.y * px;
    places_[p] = on_curve(edge, across, along, placed ? places_[p].along : along);
  }
  return places_;
}

EdgeBlock::EdgeBlock(const EdgeData& data) : data_(&data), place_(data.condition) {
  const Roi& roi = data.roi;
  const EdgeCurve& curve = data.start.curve;
  const Point normal = curve.normal();
  const ValueLimits limits{data.saturation, data.floor};
  // The curve stays this near its tangent, over the region and some more.
  double rises = 0.0;
  const double longest = std::hypot(static_cast<double>(roi.width), static_cast<double>(roi.height));
  for (int i = -64; i <= 64; ++i) rises = std::max(rises, std::abs(offset_at(curve, longest * i / 64.0)));

  // Pixels farther from the starting curve would determine the plateaus only, as in measure_edge.
  const auto visit = [&](const auto& take) {
    for (std::int64_t y = roi.y; y < roi.y + roi.height; ++y)
      for (std::int64_t x = roi.x; x < roi.x + roi.width; ++x) {
        const double px = static_cast<double>(x) + 0.5 - curve.origin.x,
                     py = static_cast<double>(y) + 0.5 - curve.origin.y;
        if (std::abs(normal.x * px + normal.y * py) > kRange_px + 2.0 * rises) continue;
        const float value = data.image.at(x, y);
        if (!std::isfinite(value) || limits.clipped(value)) continue;
        const Pixel pixel{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<double>(value), 1.0};
        const double distance = place_of(curve, normal, pixel).distance;
        if (!(std::abs(distance) > kRange_px)) take(pixel, distance);
      }
  };
  // Scattered, as rows or columns left out would leave out phases of the edge.
  const auto scatter = [](const Pixel& pixel) {
    std::uint64_t h = (static_cast<std::uint64_t>(pixel.x) << 32) ^ static_cast<std::uint64_t>(pixel.y);
    h = (h ^ (h >> 31)) * 0x9E3779B97F4A7C15U;
    h = (h ^ (h >> 29)) * 0xBF58476D1CE4E5B9U;
    return static_cast<double>(h >> 11) * 0x1p-53;
  };
  double share = 1.0;
  if (static_cast<std::size_t>(roi.width) > kMostPixels / static_cast<std::size_t>(roi.height)) {
    std::size_t count = 0;
    visit([&](const Pixel&, double) { ++count; });
    thinned_ = count > kMostPixels;
    if (thinned_) share = static_cast<double>(kMostPixels) / static_cast<double>(count);
  }
  visit([&](Pixel pixel, double distance) {
    if (thinned_ && scatter(pixel) >= share) return;
    range_px_ = std::max(range_px_, std::abs(distance));
    pixel.sd = sd_at(distance < 0.0 ? data.start.dark : data.start.bright);
    pixels_.push_back(pixel);
  });
  range_px_ += 2.0;
}

// What rounding adds: half a step of the image's values, and of the float that holds them.
double EdgeBlock::sd_at(double value) const {
  const EdgeMeasurement& start = data_->start;
  const double size = std::max(std::abs(start.dark), std::abs(start.bright));
  const double rounding = std::max(data_->quantum / std::sqrt(12.0), size * 3e-8);
  const double middle = 0.5 * (start.dark + start.bright);
  const double variance = start.noise_sd * start.noise_sd + start.noise_gain * (value - middle);
  // A gain that leaves no variance on one side was estimated too large.
  const double floor = 0.01 * start.noise_sd * start.noise_sd;
  return noise_factor_ * std::sqrt(std::max({variance, floor, rounding * rounding}));
}

void EdgeBlock::scale_noise(double factor) {
  noise_factor_ *= std::sqrt(factor);
  for (Pixel& pixel : pixels_) pixel.sd *= std::sqrt(factor);
}

std::size_t EdgeBlock::curve_unknowns() const {
  const EdgeCurve& curve = data_->start.curve;
  return curve.shape == EdgeCurve::Shape::circle       ? 1
         : curve.shape == EdgeCurve::Shape::polynomial ? curve.coefficient.size()
                                                       : 0;
}

std::vector<double> EdgeBlock::start() const {
  const EdgeMeasurement& measured = data_->start;
  std::vector<double> own{0.0, 0.0};
  if (measured.curve.shape == EdgeCurve::Shape::circle) own.push_back(measured.curve.curvature_per_px);
  if (measured.curve.shape == EdgeCurve::Shape::polynomial)
    own.insert(own.end(), measured.curve.coefficient.begin(), measured.curve.coefficient.end());
  own.push_back(measured.dark);
  own.push_back(measured.bright - measured.dark);
  if (gradients_) own.resize(own.size() + 4, 0.0);
  return own;
}

EdgeCurve EdgeBlock::curve(std::span<const double> own) const {
  EdgeCurve curve = data_->start.curve;
  const Point normal = curve.normal();
  curve.origin = {curve.origin.x + own[0] * normal.x, curve.origin.y + own[0] * normal.y};
  curve.angle_rad += own[1];
  if (curve.shape == EdgeCurve::Shape::circle) curve.curvature_per_px = own[2];
  if (curve.shape == EdgeCurve::Shape::polynomial)
    for (std::size_t k = 0; k < curve.coefficient.size(); ++k) curve.coefficient[k] = own[2 + k];
  return curve;
}

const StepResponse& EdgeBlock::response(const Sensors& sensors, const EdgeCurve& curve) const {
  if (kept_.sensors == &sensors && kept_.version == sensors.version() && kept_.angle_rad == curve.angle_rad)
    return *kept_.step;
  const SliceNodes nodes = sensors.slice(place_, curve.angle_rad, range_px_);
  OtfTable h = sensors.otf(place_, along(curve.angle_rad, nodes.f_cy_px));
  double most = 0.0;
  for (const auto& by_angle : h.back()) most = std::max(most, std::hypot(by_angle.re, by_angle.im));
  const bool turns = most > kTurns;
  if (!turns) h.pop_back();
  kept_ = {&sensors, sensors.version(), curve.angle_rad, turns, StepResponse(nodes, h)};
  return *kept_.step;
}

template <class Rows>
Rows EdgeBlock::rows_of(const Sensors& sensors, std::span<const double> own, bool gradients) const {
  const EdgeCurve edge = curve(own);
  const Point normal = edge.normal();
  const StepResponse& step = response(sensors, edge);
  const std::size_t bends = curve_unknowns(), plateaus = 2 + bends, parameters = sensors.parameters();
  const std::size_t first_parameter = plateaus + (gradients ? 6 : 2);
  Rows all(first_parameter + parameters);

  const double length = edge.half_length_px, dark = own[plateaus], contrast = own[plateaus + 1];
  std::array<double, 4> g{};
  if (own.size() > plateaus + 2) std::copy_n(own.begin() + static_cast<std::ptrdiff_t>(plateaus) + 2, 4, g.begin());
  std::vector<double> e(step.count());
  const std::vector<Place>* const kept = keeps_places() && every_ == 1 ? &places(own) : nullptr;
  for (std::size_t p = 0; p < pixels_.size(); p += every_) {
    const Pixel& pixel = pixels_[p];
    const Place at = kept != nullptr ? (*kept)[p] : place_of(edge, normal, pixel);
    const double spread = step.at(at.distance, e);
    const double s = at.along / length, u = at.across / length;
    const double low = dark + g[0] * s + g[1] * u, rise = contrast + (g[2] - g[0]) * s + (g[3] - g[1]) * u;
    const BentResidual r = bent((pixel.value - low - rise * e[0]) / pixel.sd, robust_);
    const double weight = -r.slope / pixel.sd, by_distance = weight * rise * spread;

    const std::span<double> row = all.next();
    row[0] = by_distance * at.by_offset;
    row[1] = by_distance * at.by_turn + (kept_.turns ? weight * rise * e[parameters + 1] : 0.0);
    if (edge.shape == EdgeCurve::Shape::circle) {
      row[2] = -by_distance * at.scale * 0.5 * at.along * at.along;  // of a small curvature
    } else if (bends > 0) {
      Powers power(edge, at.along);
      for (std::size_t k = 0; k < bends; ++k, power.advance()) row[2 + k] = -by_distance * at.scale * power.value();
    }
    row[plateaus] = weight;
    row[plateaus + 1] = weight * e[0];
    if (gradients) {
      row[plateaus + 2] = weight * s * (1.0 - e[0]);
      row[plateaus + 3] = weight * u * (1.0 - e[0]);
      row[plateaus + 4] = weight * s * e[0];
      row[plateaus + 5] = weight * u * e[0];
    }
    for (std::size_t i = 0; i < parameters; ++i) row[first_parameter + i] = weight * rise * e[1 + i];
    row[first_parameter + parameters] = r.value;
    all.add();
  }
  return all;
}

NormalMatrix EdgeBlock::normal(const Sensors& sensors, std::span<const double> own) const {
  return rows_of<NormalMatrix>(sensors, own, gradients_);
}
NormalMatrix EdgeBlock::normal_with_gradients(const Sensors& sensors, std::span<const double> own) const {
  return rows_of<NormalMatrix>(sensors, own, true);
}
Eigen::MatrixXd EdgeBlock::score_covariance(const Sensors& sensors, std::span<const double> own,
                                            const NoiseCorrelation& noise) const {
  std::vector<PixelPlace> places;
  for (std::size_t p = 0; p < pixels_.size(); p += every_) places.push_back({pixels_[p].x, pixels_[p].y});
  return calib::score_covariance(rows_of<PixelRows>(sensors, own, gradients_), places, noise);
}

std::vector<Residual> EdgeBlock::residuals(const Sensors& sensors, std::span<const double> own,
                                           std::size_t every) const {
  const EdgeCurve edge = curve(own);
  const Point normal = edge.normal();
  const StepResponse& step = response(sensors, edge);
  const std::size_t plateaus = 2 + curve_unknowns();
  const double length = edge.half_length_px, dark = own[plateaus], contrast = own[plateaus + 1];
  std::array<double, 4> g{};
  if (gradients_) std::copy_n(own.begin() + static_cast<std::ptrdiff_t>(plateaus) + 2, 4, g.begin());
  std::vector<double> e(step.count());
  const std::vector<Place>* const kept = keeps_places() && every == 1 ? &places(own) : nullptr;
  std::vector<Residual> all;
  all.reserve(pixels_.size() / every + 1);
  for (std::size_t p = 0; p < pixels_.size(); p += every) {
    const Pixel& pixel = pixels_[p];
    const Place at = kept != nullptr ? (*kept)[p] : place_of(edge, normal, pixel);
    step.at(at.distance, e);
    const double s = at.along / length, u = at.across / length;
    const double low = dark + g[0] * s + g[1] * u, rise = contrast + (g[2] - g[0]) * s + (g[3] - g[1]) * u;
    all.push_back({pixel.x, pixel.y, (pixel.value - low - rise * e[0]) / pixel.sd, at.distance, pixel.sd,
                   alike_ * data_->quantum * data_->quantum / (12.0 * pixel.sd * pixel.sd)});
  }
  return all;
}

// Rounding errors of noise below half a step repeat among the pixels that round alike: those whose values differ by
// less than a step, `run` of them along d. Together they hold no more information than one: a plateau is known to half
// a step, however many pixels it has. Along the pixels' grid so do the pixels at one distance.
void EdgeBlock::update_noise(const Sensors& sensors, std::span<const double> own) {
  const std::vector<Residual> all = residuals(sensors, own);
  const StepResponse& step = response(sensors, curve(own));
  const EdgeMeasurement& start = data_->start;
  const double quantum = data_->quantum, rounding = quantum * quantum / 12.0;
  const double contrast = std::abs(own[contrast_index()]),
               per_px = static_cast<double>(pixels_.size()) / (2.0 * range_px_);
  std::vector<double> e(step.count());
  RoundingByDistance by_distance;
  if (rounds_coarsely() && start.oversampling > 0.0 && start.oversampling < kFewDistances) {
    std::vector<double> esf;
    for (const Residual& r : all) step.at(r.distance_px, e), esf.push_back(e[0]);
    by_distance = rounding_by_distance(all, esf, quantum);
    alike_ = shared_share(by_distance.noise_steps2);
  }
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const double value = pixels_[i].value - all[i].value * pixels_[i].sd, sd = sd_at(value);
    double variance = sd * sd;
    if (rounds_coarsely()) {
      const bool along_grid = !by_distance.alike.empty();
      const double alike = along_grid ? alike_ : shared_share(std::max(0.0, variance - rounding) / (quantum * quantum));
      const double slope = contrast * std::abs(step.at(all[i].distance_px, e));
      double run = per_px * std::min(range_px_, quantum / std::max(slope, 1e-300));
      if (along_grid) run = std::max(run, by_distance.alike[i]);
      variance += rounding * alike * std::max(0.0, run - 1.0);
    }
    pixels_[i].sd = std::sqrt(variance);
  }
}

bool EdgeBlock::rounds_coarsely() const {
  const EdgeMeasurement& start = data_->start;
  return data_->quantum > 1e-3 * std::abs(start.bright - start.dark) && rounds();
}

bool EdgeBlock::rounding_hides_noise() const {
  const double least = std::min(sd_at(data_->start.dark), sd_at(data_->start.bright)) / noise_factor_;
  return least * least < kRoundsAlike_steps2 * data_->quantum * data_->quantum;
}

bool EdgeBlock::noise_follows() const { return data_->start.noise_gain != 0.0 || rounds_coarsely(); }

Eigen::MatrixXd score_covariance(const PixelRows& rows, std::span<const PixelPlace> places,
                                 const NoiseCorrelation& noise) {
  const auto jacobian = rows.jacobian();
  // Of each pixel: the rows of its neighbours in one half plane, times their correlations.
  PixelRows::Matrix shared = PixelRows::Matrix::Zero(jacobian.rows(), jacobian.cols());
  for (const PixelLag& lag : noise.lags) {
    const double correlation = noise.margin * lag.correlation;
    std::size_t other = 0;  // the places at a lag are in the order of the pixels
    for (std::size_t p = 0; p < places.size(); ++p) {
      const auto before = [&](PixelPlace place) {
        const std::int32_t y = places[p].y + lag.y, x = places[p].x + lag.x;
        return place.y < y || (place.y == y && place.x < x);
      };
      while (other < places.size() && before(places[other])) ++other;
      if (other == places.size()) break;
      if (places[other].x != places[p].x + lag.x || places[other].y != places[p].y + lag.y) continue;
      shared.row(static_cast<Eigen::Index>(p)) += correlation * jacobian.row(static_cast<Eigen::Index>(other));
    }
  }
  const Eigen::MatrixXd half = jacobian.transpose() * shared;
  return jacobian.transpose() * jacobian + half + half.transpose();
}

}  // namespace calib
