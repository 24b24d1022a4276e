// SPDX-License-Identifier: Apache-2.0
#include "calib/measure/edge_facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <vector>

#include "calib/edge/median.h"
#include "mtf/math/clones.h"
#include "mtf/words.h"

namespace calib {
namespace {

// The smallest and the largest value, and how many pixels have them.
struct Ends {
  std::ptrdiff_t at_low = 0, at_high = 0;
  double low = 0.0, high = 0.0;
};

MTFKIT_CLONES Ends ends_of(const double* values, std::size_t n) {
  constexpr std::size_t kLanes = 16;
  std::array<double, kLanes> low, high;
  std::array<std::int64_t, kLanes> at_low{}, at_high{};
  low.fill(INFINITY);
  high.fill(-INFINITY);
  const std::size_t whole = n / kLanes * kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) {
      low[k] = values[i + k] < low[k] ? values[i + k] : low[k];
      high[k] = values[i + k] > high[k] ? values[i + k] : high[k];
    }
  double least = *std::min_element(low.begin(), low.end()), most = *std::max_element(high.begin(), high.end());
  for (std::size_t i = whole; i < n; ++i) least = std::min(least, values[i]), most = std::max(most, values[i]);
  const auto take = [&](std::size_t k, double value) {
    at_low[k] += value == least ? 1 : 0;
    at_high[k] += value == most ? 1 : 0;
  };
  for (std::size_t i = 0; i < whole; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) take(k, values[i + k]);
  for (std::size_t i = whole; i < n; ++i) take(0, values[i]);
  return {std::accumulate(at_low.begin(), at_low.end(), std::ptrdiff_t{0}),
          std::accumulate(at_high.begin(), at_high.end(), std::ptrdiff_t{0}), least, most};
}

// Of two different values between two limits: of rounded values a step or more.
double least_difference(const EdgePixels& pixels, double low, double high) {
  std::vector<double> between;
  std::copy_if(pixels.value(), pixels.value() + pixels.size(), std::back_inserter(between),
               [&](double value) { return value > low && value < high; });
  std::sort(between.begin(), between.end());
  between.erase(std::unique(between.begin(), between.end()), between.end());
  double least = high - low;
  for (std::size_t i = 1; i < between.size(); ++i) least = std::min(least, between[i] - between[i - 1]);
  return least;
}

// Of the residuals at the edge about straight lines of an eighth of a pixel.
struct Scatter {
  double sum = 0.0, dof = 0.0;
  double variance() const { return sum / std::max(1.0, dof); }
};
Scatter scatter_on_edge(const FitState& state) {
  constexpr int kMerged = kFinest / 8;
  constexpr double kPlateau = 0.15;
  Scatter scatter;
  for (int first = 0; first + kMerged <= kBins; first += kMerged) {
    const double esf = state.profile.esf()[static_cast<std::size_t>(first)];
    if (esf < kPlateau || esf > 1.0 - kPlateau) continue;
    double n = 0.0, x = 0.0, xx = 0.0, r = 0.0, xr = 0.0, rr = 0.0;
    for (int k = 0; k < kMerged; ++k) {
      const auto bin = static_cast<std::size_t>(first + k);
      const double count = state.sums.moment(0)[bin], residual = state.sums.residual(0)[bin];
      n += count;
      x += k * count;
      xx += k * k * count;
      r += residual;
      xr += k * residual;
      rr += state.sums.square()[bin];
    }
    if (n < 3.0) continue;
    const double spread = xx - x * x / n, slope = spread > 0.0 ? (xr - x * r / n) / spread : 0.0;
    scatter.sum += std::max(0.0, rr - r * r / n - slope * slope * spread);
    scatter.dof += n - 2.0;
  }
  return scatter;
}

// Whether fewer values lie near one end than a step further from it; `sign` is 1 at the smallest.
bool ends_abruptly(const EdgePixels& pixels, double end, double sign, double step) {
  constexpr double kFewest = 5.0, kGradual = 1.5;
  double near = 0.0, further = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const double away = sign * (pixels.value()[i] - end);
    near += away > 0.0 && away <= step ? 1.0 : 0.0;
    further += away > step && away <= 2.0 * step ? 1.0 : 0.0;
  }
  return further >= kFewest && near < kGradual * further;
}

/// Structure beside the edge, as a share of the contrast, from which a warning is given.
constexpr double kVisibleStructure = 0.03;

constexpr std::int64_t kFewestPixels = 24;
constexpr double kClippedShare = 0.05;
constexpr double kLeastLength_px = 8.0;
constexpr double kLeastCnr = 1.5, kLeastSignificance = 8.0;
constexpr double kOtherEdge = 0.25, kStructure = 0.10;  // of the contrast

std::string number(double value, int digits = 3) { return mtf::significant(value, digits); }

/// What pixels of the plateaus differ by from the model, and pixels at equal distances from each other, beyond what
/// neighbouring pixels differ by, as a share of the contrast; of the range of the values, 1, where the fitted contrast
/// is larger than that.
double structure_share(const EdgeFacts& facts) {
  const double seen = std::max(facts.plateau_sd, facts.noise_sd);
  const double excess = seen * seen - 1.5 * facts.local_noise_sd * facts.local_noise_sd;
  return std::sqrt(std::max(0.0, excess)) / std::clamp(facts.contrast, 1e-300, 1.0);
}

}  // namespace

double local_noise(mtf::ImageView<const float> image, const Roi& roi, const RegionFacts& facts) {
  constexpr std::int64_t kPairs = 2000;
  std::vector<float> differences;
  const std::int64_t step = std::max<std::int64_t>(1, roi.width * roi.height / kPairs) | 1;
  for (const std::int64_t apart :
       {3, 4}) {  // farther than noise is correlated; a Bayer plane has data in every other column
    visit_some(roi, step, [&](std::int64_t x, std::int64_t y) {
      if (x + apart >= roi.x + roi.width) return;
      const auto difference = static_cast<float>(
          (static_cast<double>(image.at(x + apart, y)) - static_cast<double>(image.at(x, y))) / facts.scale);
      if (std::isfinite(difference)) differences.push_back(std::abs(difference));
    });
    if (differences.size() > 16) break;
  }
  if (differences.empty()) return 0.0;
  return static_cast<double>(nth_least(differences, differences.size() / 2)) / (0.6745 * std::sqrt(2.0));
}

EdgeFacts facts_of(const EdgePixels& pixels, const FitState& state, const EdgeModel& model, double local_noise_sd) {
  const DistanceBins& bins = DistanceBins::get();
  EdgeFacts facts{.length_px = 2.0 * model.curve.half_length_px, .local_noise_sd = local_noise_sd};
  facts.width_px = 1.0 / std::max(1e-3, state.profile.lsf()[kSideBins]);
  facts.contrast = model.contrast();
  facts.noise_sd = std::sqrt(state.noise.at(0.5));
  double dark = 0.0, bright = 0.0, plateau = 0.0, squares = 0.0;
  std::array<double, 2> side_error{}, side_dof{};
  for (int i = 0; i < kBins; ++i) {
    const double n = state.sums.count(i), d = bins.centre(i);
    (d < 0.0 ? dark : bright) += n;
    if (std::abs(d) < 2.0 * facts.width_px) continue;
    plateau += n;
    squares += state.sums.square()[static_cast<std::size_t>(i)];
    side_error[d < 0.0 ? 0 : 1] += state.sums.pure_error(i);
    side_dof[d < 0.0 ? 0 : 1] += std::max(0.0, n - 1.0);
  }
  const Ends ends = ends_of(pixels.value(), pixels.size());
  const double share = static_cast<double>(pixels.size()) / std::max(1.0, dark + bright);
  facts.extent_dark_px = share * dark / facts.length_px;
  facts.extent_bright_px = share * bright / facts.length_px;
  facts.plateau_sd = std::sqrt(squares / std::max(1.0, plateau));
  const double sides = dark * bright / std::max(1.0, dark + bright);
  facts.significance = facts.contrast / std::max(1e-300, facts.noise_sd) * std::sqrt(std::max(0.0, sides));
  const double a = side_error[0] / std::max(1.0, side_dof[0]), b = side_error[1] / std::max(1.0, side_dof[1]);
  const bool enough = std::min(side_dof[0], side_dof[1]) > 50.0;
  const double visible = 1e-5 * facts.contrast * facts.contrast;
  // A side whose noise is below the step between values has one or two of them though it is not clipped. The step is
  // that of the quarter of the values at the end: on a sharp edge the last but one may be far from the last by chance.
  const auto fine = [&](double variance, double low, double high) {
    const double step = least_difference(pixels, low, high);
    return variance > 0.36 * step * step;
  };
  constexpr double kHeaped = 0.2;  // of a side's pixels
  const bool low_is_heaped = static_cast<double>(ends.at_low) > kHeaped * dark,
             high_is_heaped = static_cast<double>(ends.at_high) > kHeaped * bright;
  const double quarter = 0.25 * (ends.high - ends.low);
  facts.bright_is_flat =
      enough && a > visible && (b < 1e-10 || high_is_heaped) && fine(a, ends.high - quarter, ends.high);
  facts.dark_is_flat = enough && b > visible && (a < 1e-10 || low_is_heaped) && fine(b, ends.low, ends.low + quarter);
  constexpr int kHalf_px = 2, kPerPixel = 8, kMerged = kFinest / kPerPixel;
  int filled = 0;
  for (int k = -kHalf_px * kPerPixel; k < kHalf_px * kPerPixel; ++k) {
    double n = 0.0;
    for (int m = 0; m < kMerged; ++m) n += state.sums.count(kSideBins + k * kMerged + m);
    filled += n > 0.0;
  }
  facts.oversampling = static_cast<double>(filled) / (2.0 * kHalf_px);
  if (low_is_heaped && high_is_heaped) {
    constexpr double kFewestOnEdge = 10.0, kQuiet = 0.5;
    const Scatter on_edge = scatter_on_edge(state);
    facts.both_are_flat = on_edge.dof >= kFewestOnEdge && on_edge.variance() > visible &&
                          std::max(a, b) < kQuiet * on_edge.variance() && fine(on_edge.variance(), ends.low, ends.high);
  }
  constexpr double kStep = 0.05;
  const double step = kStep * facts.contrast;
  facts.ends_abruptly = ((low_is_heaped && ends_abruptly(pixels, ends.low, 1.0, step)) ||
                         (high_is_heaped && ends_abruptly(pixels, ends.high, -1.0, step))) &&
                        !facts.few_distances() && least_difference(pixels, ends.low, ends.high) <= 0.25 * step;
  return facts;
}

Outcome judge_region(const RegionFacts& facts, const Roi& roi, const MeasureOptions& options) {
  if (facts.finite < kFewestPixels)
    return {Trouble::no_data, "only " + std::to_string(facts.finite) + " of " + std::to_string(roi.width * roi.height) +
                                  " pixels hold data: take a larger region or one outside the mask"};
  if (static_cast<double>(facts.clipped) > kClippedShare * static_cast<double>(facts.finite))
    return {Trouble::clipped,
            number(100.0 * static_cast<double>(facts.clipped) / static_cast<double>(facts.finite)) +
                " % of the pixels are clipped: expose so that both sides stay between the floor and the saturation"};
  if (facts.finite - facts.clipped < kFewestPixels)
    return {Trouble::no_data, "too few pixels between the floor and the saturation: take a larger region"};
  if (!(facts.high - facts.low > options.quantum))
    return {Trouble::no_edge, "all pixels have the same value: move the region onto an edge"};
  return {};
}

Outcome judge_edge(const EdgeFacts& facts) {
  const double cnr = facts.contrast / std::max(1e-300, facts.noise_sd);
  if (!(facts.contrast > 0.0) || cnr < kLeastCnr)
    return {Trouble::no_edge,
            "the contrast of the best line is " + number(std::max(0.0, cnr)) +
                " times the noise of a pixel, at least " + number(kLeastCnr) +
                " is needed: average frames, or choose an edge of more contrast, straight and alone in its region"};
  if (facts.significance < kLeastSignificance)
    return {Trouble::no_edge, "the contrast of the best line is " + number(facts.significance) +
                                  " times its own standard deviation, at least " + number(kLeastSignificance) +
                                  " is needed: take a larger region on an edge"};
  if (!(facts.length_px >= kLeastLength_px))
    return {Trouble::too_short, "the edge is " + number(facts.length_px) + " px long inside the region, at least " +
                                    number(kLeastLength_px) + " are needed: take a region along the edge"};
  const double shorter = std::min(facts.extent_dark_px, facts.extent_bright_px);
  const char* side = facts.extent_dark_px < facts.extent_bright_px ? "dark" : "bright";
  const double needed = std::max(2.0, 1.25 * facts.width_px);
  if (facts.width_px > 48.0 || facts.width_px > 0.7 * (facts.extent_dark_px + facts.extent_bright_px))
    return {
        Trouble::no_edge,
        "the region holds a ramp rather than an edge between two plateaus: take a larger region, or one on an edge"};
  if (shorter < needed)
    return {Trouble::off_region, "only " + number(shorter) + " px of the " + side + " side are inside the region, " +
                                     number(needed) + " are needed for its plateau: centre the region on the edge"};
  return {};
}

Outcome judge_structure(const EdgeFacts& facts) {
  if (structure_share(facts) > kOtherEdge)
    return {Trouble::several_edges, "beside the strongest edge the region has structure of " +
                                        number(100.0 * structure_share(facts)) +
                                        " % of its contrast: draw the region around one edge"};
  if (structure_share(facts) > kStructure)
    return {Trouble::contaminated, "structure of " + number(100.0 * structure_share(facts)) +
                                       " % of the contrast lies beside the edge, or the edge is bent more than its "
                                       "curve can be: narrow the region to even sides, or allow a higher order"};
  if (facts.bright_is_flat)
    return {Trouble::clipped,
            "many pixels of the bright side have the largest value of all while the dark side has noise, as saturated "
            "sides do: expose so that both sides stay below the saturation"};
  if (facts.dark_is_flat)
    return {Trouble::clipped,
            "many pixels of the dark side have the smallest value of all while the bright side has noise, as sides at "
            "the floor do: expose more, or add an offset, so that both sides stay above the floor"};
  if (facts.both_are_flat)
    return {Trouble::clipped,
            "many pixels have exactly the smallest and many exactly the largest value while the edge between them has "
            "noise, as where both sides are clipped: expose so that both stay between the floor and the saturation"};
  return {};
}

Outcome judge_response(const EdgeMeasurement& out) {
  // Sharpening lifts the MTF with the square of the frequency and overshoots by parts of the step.
  constexpr double kLow_cy_px = 0.05, kMostLow = 1.2, kMost = 2.0, kOvershoot = 0.6, kSure = 4.0, kImpossible = 10.0;
  const auto because = [&out](const std::string& what) {
    if (out.oversampling < kFewDistances)
      return Outcome{Trouble::too_short, "only " + number(out.oversampling) +
                                             " distances a pixel occur, too few for so sharp an edge (" + what +
                                             "): tilt the edge by 2 to 10 degrees or take a longer one"};
    return Outcome{Trouble::contaminated, what +
                                              ": a ridge, a glow or another edge is in the region, not a step between "
                                              "two plateaus; draw the region around one edge"};
  };
  for (std::size_t i = 0; i < out.mtf.size(); ++i) {
    if (!std::isfinite(out.mtf[i]) || !std::isfinite(out.mtf_sd[i]))
      return {Trouble::no_edge, "the pixels do not determine a response: take a larger region on an edge"};
    // However large the error that comes with it.
    if (out.frequency_cy_px[i] <= 0.5 && out.mtf[i] > kImpossible)
      return because("the pixels do not determine the MTF at " + number(out.frequency_cy_px[i]) +
                     " cycles per pixel, where it comes out as " + number(out.mtf[i]));
    const double most = out.frequency_cy_px[i] <= kLow_cy_px ? kMostLow : kMost;
    if (out.mtf[i] > most + kSure * out.mtf_sd[i])
      return because("the MTF rises to " + number(out.mtf[i]) + " at " + number(out.frequency_cy_px[i]) +
                     " cycles per pixel");
  }
  for (std::size_t i = 0; i < out.esf.size(); ++i) {
    const double beyond = std::max(out.esf[i] - 1.0, -out.esf[i]);
    if (beyond > kOvershoot + kSure * out.esf_sd[i])
      return because("the edge spread function leaves the range of its plateaus by " + number(100.0 * beyond) + " %");
  }
  return {};
}

std::vector<std::string> warnings_of(const EdgeFacts& facts, const EdgeMeasurement& out, bool sparse) {
  std::vector<std::string> warnings;
  if (structure_share(facts) > kVisibleStructure)
    warnings.push_back("the sides are uneven by " + number(100.0 * structure_share(facts)) +
                       " % of the contrast: the MTF below 0.1 cycles per pixel may be off by as much");
  if (facts.oversampling < 4.0)
    warnings.push_back(
        "the edge runs so close to the pixels' grid that only " + number(facts.oversampling) +
        " distances a pixel occur: fine structure of the MTF cannot be seen, tilt the edge by 2 to 10 degrees");
  constexpr double kVisibleMisfit = 3e-3;  // of the contrast
  constexpr double kLikely = 0.5, kPossible = 0.2, kCertain = 0.95;
  constexpr double kShown = 0.99;  // before the pixels are seen, far light has the probability 0.9
  if (out.chi2_per_dof > 2.0 && std::sqrt(out.chi2_per_dof) > kVisibleMisfit * out.cnr)
    warnings.push_back("the pixels lie " + number(std::sqrt(out.chi2_per_dof)) +
                       " times further from the model than their noise: something else is in the region");
  const double shorter = std::min(facts.extent_dark_px, facts.extent_bright_px);
  if (facts.short_sides())
    warnings.push_back("only " + number(shorter) +
                       " px of one side are inside the region: tails of the blur may count as its plateau, and the "
                       "intervals allow for tails of other sizes");
  if (facts.large_errors)
    warnings.push_back("the contrast is only " + number(out.cnr) +
                       " times the noise of a pixel: the MTF is not linear in errors so large, and the intervals allow "
                       "for a sharper edge; average frames");
  if (facts.neighbour_px > 0.0)
    warnings.push_back("another edge or other structure lies " + mtf::fixed(facts.neighbour_px, 0) +
                       " px away, beside the region: the tail of its diffraction is part of the model, and sides that "
                       "end before it make the intervals wider");
  if (facts.unclear_diffraction)
    warnings.emplace_back(
        "the noise hides how much of the blur is diffraction, which lowers the MTF at low frequencies: the intervals "
        "allow for any part, take a longer edge or average frames for narrower ones");
  constexpr double kVisibleShare = 0.08;  // less widens intervals by a few per cent
  if (facts.shared_noise > kVisibleShare)
    warnings.push_back("noise is correlated between neighbouring pixels: they share " +
                       number(100.0 * facts.shared_noise, 2) +
                       " % of it, as after demosaicing, denoising, resampling or JPEG, and the intervals are wider by "
                       "that; take the MTF from the raw image for narrower ones");
  if (facts.curvature > kLikely)
    warnings.emplace_back(
        "the sides change nonlinearly with the distance from the edge, as under uneven light, which is taken out");
  const std::string held = facts.far_reach_px > shorter
                               ? "the intervals allow for what is scattered over " + mtf::fixed(shorter, 0) +
                                     " px, as far as the shorter side extends; those of all but FWHM do not cover what "
                                     "is scattered further, for which take at least " +
                                     number(facts.far_reach_px) + " px on each side"
                               : "the intervals allow for it, take a larger region or average frames for narrower ones";
  if (facts.far_light > kShown)
    warnings.push_back(
        "the sides approach their plateaus slowly, as where light is scattered far, which is part of the MTF: " + held);
  else if (facts.far_light > kLikely)
    warnings.push_back("the noise hides whether a part of the light is scattered far, which lowers the MTF: " + held);
  if (std::min(facts.far_light, facts.gradient) > kPossible && std::max(facts.far_light, facts.gradient) < kCertain)
    warnings.emplace_back(
        "light that is scattered far and a gradient of the illumination cannot be told apart in this region: the "
        "intervals allow for either, take a wider region for narrower ones");
  if (facts.stripes > 0.0)
    warnings.push_back("the columns or rows of the image have offsets of their own, of " +
                       number(100.0 * facts.stripes, 2) +
                       " % of the noise of a pixel, as fixed-pattern noise is: the intervals are wider by that; "
                       "correct the offsets for narrower ones");
  if (out.ends_abruptly) warnings.emplace_back(kEndsAbruptly);
  const double finite = std::max(1.0, static_cast<double>(out.roi.width * out.roi.height - out.missing));
  const auto percent = [&](double count) { return number(100.0 * count / finite, 2) + " %"; };
  if (facts.outliers > 0)
    warnings.push_back(
        std::to_string(facts.outliers) +
        (facts.outliers == 1
             ? " pixel far from the others at its distance from the edge, as a hot or dead one is, is left out ("
             : " pixels far from the others at their distances from the edge, as hot and dead ones are, are left out "
               "(") +
        percent(static_cast<double>(facts.outliers)) + ")");
  if (out.missing > 0 && !sparse)
    warnings.push_back(std::to_string(out.missing) + (out.missing == 1 ? " pixel is" : " pixels are") +
                       " no number or infinite and left out");
  if (facts.cut > 0)
    warnings.push_back(
        "the noise is cut off at the smallest or largest value: " + percent(static_cast<double>(facts.cut)) +
        " of the pixels count as values beyond it, on the assumption of Gaussian noise");
  if (facts.clipped > 0)
    warnings.push_back(percent(static_cast<double>(facts.clipped)) + " of the pixels are clipped and left out");
  return warnings;
}

}  // namespace calib
