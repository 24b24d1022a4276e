// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_noise.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include "mtf/math/clones.h"

namespace calib {
namespace {

struct Spread {
  double sum = 0.0, dof = 0.0;
  double variance() const { return dof > 0.0 ? sum / dof : 0.0; }
  double error() const { return std::sqrt(2.0 / std::max(dof, 1.0)); }  // relative, of the variance
};

// On the dark plateau, on the edge, on the bright plateau.
struct Spreads {
  Spread dark, edge, bright;
};

constexpr double kPlateau = 0.08;

// The scatter of the pixels within their bins.
MTFKIT_CLONES Spreads spreads(const EdgeSums& sums, const BinRow& esf) {
  const BinRow &count = sums.moment(0), &residual = sums.residual(0), &square = sums.square();
  std::array<std::array<double, kLot>, 3> sum{}, dof{};
  for (std::size_t i = 0; i < kBins; i += kLot)
    for (std::size_t k = 0; k < kLot; ++k) {
      const double n = count[i + k], r = residual[i + k], e = esf[i + k];
      const bool some = n >= 2.0;
      const double more = some ? n - 1.0 : 0.0;
      const double own = std::max(0.0, square[i + k] - r * r / std::max(n, 1.0));
      const double error = some ? own : 0.0;
      const double dark = e < kPlateau ? 1.0 : 0.0, bright = e > 1.0 - kPlateau ? 1.0 : 0.0, edge = 1.0 - dark - bright;
      sum[0][k] += dark * error;
      sum[1][k] += edge * error;
      sum[2][k] += bright * error;
      dof[0][k] += dark * more;
      dof[1][k] += edge * more;
      dof[2][k] += bright * more;
    }
  const auto spread = [&](std::size_t j) {
    return Spread{std::accumulate(sum[j].begin(), sum[j].end(), 0.0),
                  std::accumulate(dof[j].begin(), dof[j].end(), 0.0)};
  };
  return {spread(0), spread(1), spread(2)};
}

// The sum of squares expected within the bins on the edge.
MTFKIT_CLONES double expected_on_edge(const EdgeSums& sums, const BinRow& esf, const NoiseModel& noise) {
  const BinRow& count = sums.moment(0);
  std::array<double, kLot> sum{};
  for (std::size_t i = 0; i < kBins; i += kLot)
    for (std::size_t k = 0; k < kLot; ++k) {
      const double e = esf[i + k];
      sum[k] += e >= kPlateau && e <= 1.0 - kPlateau ? std::max(0.0, count[i + k] - 1.0) * noise.at(e) : 0.0;
    }
  return std::accumulate(sum.begin(), sum.end(), 0.0);
}

MTFKIT_CLONES void fill_variances(const NoiseModel& noise, const BinRow& esf, BinRow& variance) {
  for (std::size_t i = 0; i < kBins; ++i) variance[i] = noise.at(esf[i]);
}

// The variance of the error that pixels of one value share after rounding in steps of 1, from the noise before it.
double shared_rounding(double variance) {
  return std::exp(-4.0 * std::numbers::pi * std::numbers::pi * std::max(0.0, variance)) / 12.0;
}

double step_at(const Rounding& rounding, double esf) {
  return rounding.dark + (rounding.bright - rounding.dark) * std::clamp(esf, 0.0, 1.0);
}

// The noise before rounding, in squared steps, of an edge that has a few distances a pixel. Pixels at one distance
// scatter by what their place between two steps makes of the noise, from nothing to half a step; the mean over the
// plateaus and the distances between them, each with a place of its own, is noise^2 + 1 / 12 less what they share.
double dither_of(const EdgeSums& sums, const StepProfile& profile, const Rounding& rounding) {
  constexpr int kApart = kFinest / 8;  // bins: an eighth of a pixel, as distances are counted
  constexpr double kFewest = 4.0;
  Spread dark, bright, one;
  double sum = 0.0, places = 0.0;
  const auto take = [&](Spread& spread) {
    if (spread.dof >= kFewest) sum += spread.variance(), places += 1.0;
    spread = {};
  };
  int empty = 0;
  for (int b = 0; b < kBins; ++b) {
    const double esf = profile.esf()[static_cast<std::size_t>(b)], step = step_at(rounding, esf), n = sums.count(b);
    empty = n > 0.0 ? 0 : empty + 1;
    if (empty == kApart) take(one);
    if (n < 2.0 || step <= 0.0) continue;
    Spread& spread = esf < kPlateau ? dark : esf > 1.0 - kPlateau ? bright : one;
    spread.sum += sums.pure_error(b) / (step * step);
    spread.dof += n - 1.0;
  }
  for (Spread* spread : {&one, &dark, &bright}) take(*spread);
  return places > 0.0 ? sum / places - 1.0 / 12.0 : 0.0;
}

// The same where distances of all kinds occur: on the edge the values of the pixels lie at all places between two
// steps, so that they scatter by noise^2 + 1 / 12, while a plateau that lies half way between two steps scatters by up
// to half a step however little noise there is.
double dither_on_edge(const EdgeSums& sums, const StepProfile& profile, const NoiseModel& noise,
                      const Rounding& rounding) {
  constexpr double kFewest = 50.0;
  const double step = step_at(rounding, 0.5);
  if (!(noise.at(0.5) < step * step)) return INFINITY;
  const Spread edge = spreads(sums, profile.esf()).edge;
  return edge.dof < kFewest ? INFINITY : edge.variance() / (step * step) - 1.0 / 12.0;
}

// How many pixels lie within an eighth of a pixel of the distance of each bin.
BinRow pixels_near(const EdgeSums& sums) {
  constexpr double kNear_px = 0.125;
  const DistanceBins& bins = DistanceBins::get();
  BinRow near;
  double n = 0.0;
  for (int b = 0, first = 0, end = 0; b < kBins; ++b) {
    for (; end < kBins && bins.centre(end) <= bins.centre(b) + kNear_px; ++end) n += sums.count(end);
    for (; bins.centre(first) < bins.centre(b) - kNear_px; ++first) n -= sums.count(first);
    near[static_cast<std::size_t>(b)] = n;
  }
  return near;
}

}  // namespace

NoiseModel estimate_noise(const EdgeSums& sums, const StepProfile& profile, double least, const Rounding& rounding) {
  const auto [dark, edge, bright] = spreads(sums, profile.esf());
  NoiseModel noise{.least_dark = std::max(least, rounding.dark * rounding.dark / 12.0),
                   .least_bright = std::max(least, rounding.bright * rounding.bright / 12.0)};
  constexpr double kFewest = 20.0;
  const Spread both{dark.sum + bright.sum, dark.dof + bright.dof};
  noise.dark = std::max(noise.least_dark, both.variance());
  noise.bright = std::max(noise.least_bright, both.variance());
  if (std::min(dark.dof, bright.dof) >= kFewest) {
    const double a = std::max(noise.least_dark, dark.variance()), b = std::max(noise.least_bright, bright.variance());
    if (std::abs(std::log(b / a)) > 3.5 * std::hypot(dark.error(), bright.error())) noise.dark = a, noise.bright = b;
  }
  // On the edge pixels may scatter more: the plateaus hide rounding.
  if (edge.dof < kFewest) return noise;
  const double expected = expected_on_edge(sums, profile.esf(), noise);
  if (edge.sum > expected * (1.0 + 5.0 * edge.error())) {
    noise.dark *= edge.sum / expected;
    noise.bright *= edge.sum / expected;
  }
  return noise;
}

BinRow variances(const NoiseModel& noise, const StepProfile& profile) {
  BinRow variance;
  fill_variances(noise, profile.esf(), variance);
  return variance;
}

BinRow pixel_weights(const EdgeSums& sums, const EdgeModel& model, const StepProfile& profile, const NoiseModel& noise,
                     const Rounding& rounding, bool few_distances) {
  constexpr double kLong = 0.25;  // of the blur's width
  BinRow weight = variances(noise, profile);
  for (double& one : weight) one = 1.0 / one;
  const bool rounds = rounding.dark > 0.0 && rounding.bright > 0.0, by_distance = rounds && few_distances;
  const double dither =
      by_distance ? dither_of(sums, profile, rounding) : dither_on_edge(sums, profile, noise, rounding);
  const BinRow near = by_distance ? pixels_near(sums) : BinRow{};
  const double long_px = kLong / std::max(1e-3, std::abs(profile.lsf()[kSideBins]));
  const auto share = [&](bool bright, double step, double variance) {
    const double own = variance / (step * step) - 1.0 / 12.0;
    const double shared = step * step * shared_rounding(by_distance ? dither : std::min(own, dither));
    const auto bin = [&](int k) { return bright ? kBins - 1 - k : k; };  // from the far end inwards
    const auto step_of = [&](int k) {
      const double esf = profile.esf()[static_cast<std::size_t>(bin(k))];
      return std::round(2.0 * model.contrast() * (bright ? 1.0 - esf : esf) / step);
    };
    const auto weigh = [&](int k, double alike) {
      double& one = weight[static_cast<std::size_t>(bin(k))];
      one = 1.0 / (1.0 / one + alike * shared);
    };
    for (int first = 0, last = 0; first < kSideBins; first = last) {
      double n = 0.0, length_px = 0.0;
      for (; last < kSideBins && step_of(last) == step_of(first); ++last) {
        n += sums.count(bin(last));
        length_px += DistanceBins::get().width(bin(last));
      }
      const bool plateau = length_px >= long_px;
      if (!plateau && !by_distance) break;
      for (int k = first; k < last; ++k) weigh(k, plateau ? n : near[static_cast<std::size_t>(bin(k))]);
    }
  };
  if (rounding.dark > 0.0) share(false, rounding.dark, noise.dark);
  if (rounding.bright > 0.0) share(true, rounding.bright, noise.bright);
  return weight;
}

}  // namespace calib
