// SPDX-License-Identifier: Apache-2.0
// The methods of a plan that work on samples: separable taps, sums of them, and direct kernels. The kernel is cut where
// what is left out costs this scene (or the worst one) no more than its share of the tolerance.

#include <algorithm>
#include <cmath>

#include "mtf/device/device_taps.h"
#include "mtf/engines/taps/taps.h"
#include "mtf/plan/plan_parts.h"
#include "mtf/plan/point_response.h"

namespace mtf {
namespace {

constexpr std::int64_t kLargestRatio = 16, kDirectHalfWidth = 8;
constexpr std::size_t kLargestRank = 6;

std::optional<std::int64_t> whole_ratio(double step, double pitch) {
  const double ratio = pitch / step;
  if (!is_whole(ratio) || ratio < 0.5 || ratio > static_cast<double>(kLargestRatio)) return std::nullopt;
  return std::llround(ratio);
}

// How errors of the OTF become errors of the image, and what is left of the tolerance for the kernel.
class Judge {
 public:
  Judge(const PlanTask& task, std::int64_t ratio_x, std::int64_t ratio_y)
      : task_(task), ratio_x_(static_cast<double>(ratio_x)), ratio_y_(static_cast<double>(ratio_y)) {
    const FactoredOtf& sampler = task.sampler;
    // An even OTF keeps the mirror symmetry of a reflected canvas: nothing of its energy can concentrate in the image.
    const bool mirror = task.options.border == Border::reflect;
    const bool symmetric = mirror && sampler.is_real() && sampler.is_even_x() && sampler.is_even_y();
    rms_per_otf_ = task.norm / (symmetric ? 2.0 : 1.0);
    crop_ = task.spectrum_gain / (symmetric ? 2.0 : 1.0);
    const double spread = rms_per_otf_ * task.alias, dropped = dropped_error(sampler),
                 quadrature = sampler.quadrature_error();
    parts_.dropped = dropped * spread;
    parts_.table = sampler.table_error() * spread;
    parts_.band = quadrature * spread;
  }

  double error_per_otf() const { return rms_per_otf_ * task_.alias; }

  /// rms error of an OTF error at the corners.
  double rms(std::span<const double> error) const {
    const double worst = rms_per_otf_ * SceneSpectrum::worst_error(error, ratio_x_, ratio_y_);
    if (!task_.options.spectrum) return worst;
    return std::min(worst, crop_ * task_.options.spectrum->rms_error(error, ratio_x_, ratio_y_));
  }
  /// What the kernel may cost when its sums err by `arithmetic`.
  double budget(double arithmetic) const {
    PredictedError parts = parts_;
    parts.arithmetic = arithmetic;
    return 0.98 * (task_.options.tolerance - parts.total());
  }
  /// Whether an error that the corners do not show is small enough all the same.
  bool negligible(double excess) const { return error_per_otf() * excess <= 0.05 * task_.options.tolerance; }
  PredictedError predicted(double kernel, double arithmetic) const {
    PredictedError p = parts_;
    p.kernel = kernel;
    p.arithmetic = arithmetic;
    return p;
  }
  // Sums of n products: random roundings of partial sums no larger than the sum of the moduli.
  double arithmetic(double terms, double moduli) const {
    const double canvas = std::max(1.0, task_.canvas_norm / (task_.options.border == Border::reflect ? 2.0 : 1.0));
    return kFloatUnit * moduli * (2.0 + 0.5 * std::sqrt(terms)) * canvas +
           task_.sampler.gain() * storage_error(task_.options);
  }

 private:
  const PlanTask& task_;
  double ratio_x_, ratio_y_, rms_per_otf_ = 1.0, crop_ = 1.0;
  PredictedError parts_;
};

double moduli(const std::vector<double>& taps) {
  double sum = 0.0;
  for (const double tap : taps) sum += std::abs(tap);
  return sum;
}

TapAxis tap_axis(std::int64_t samples, std::int64_t outputs, std::int64_t ratio, std::int64_t count) {
  // The centre of detector sample 0 stands (ratio - 1) / 2 samples after that of scene sample 0.
  return {samples, outputs, ratio, (ratio - count) / 2, count};
}

std::vector<float> narrow(const std::vector<double>& taps) { return {taps.begin(), taps.end()}; }

std::string taps_text(std::size_t x, std::size_t y) { return std::to_string(x) + " x " + std::to_string(y) + " taps"; }

// The smallest half width whose cost fits the budget; nothing when even the largest does not fit. Costs fall with the
// half width but for ripples, which make the result somewhat larger than it need be.
template <class Cost>
std::optional<std::int64_t> smallest_half_width(std::int64_t least, std::int64_t most, double budget,
                                                const Cost& cost) {
  if (!(cost(most) <= budget)) return std::nullopt;
  while (least < most) {
    const std::int64_t middle = (least + most) / 2;
    if (cost(middle) <= budget)
      most = middle;
    else
      least = middle + 1;
  }
  return most;
}

MethodCandidate impossible(Method method, std::string reason) {
  MethodCandidate candidate;
  candidate.report.method = method;
  candidate.report.reason = std::move(reason);
  return candidate;
}

struct Work {
  const PlanTask& task;
  const Judge& judge;
  std::int64_t ratio_x, ratio_y;

  TapAxis x(std::size_t count) const {
    return tap_axis(task.in.width, task.out.width, ratio_x, static_cast<std::int64_t>(count));
  }
  TapAxis y(std::size_t count) const {
    return tap_axis(task.in.height, task.out.height, ratio_y, static_cast<std::int64_t>(count));
  }
};

MethodCandidate separable_candidate(const Work& work, Method method, std::vector<std::vector<double>> x_taps,
                                    std::vector<std::vector<double>> y_taps, double kernel) {
  const TapAxis x = work.x(x_taps.front().size()), y = work.y(y_taps.front().size());
  double sum = 0.0;
  for (std::size_t k = 0; k < x_taps.size(); ++k) sum += moduli(x_taps[k]) * moduli(y_taps[k]);
  const double terms = static_cast<double>(x.count + y.count * static_cast<std::int64_t>(x_taps.size()));
  MethodCandidate candidate;
  Candidate& c = candidate.report;
  c.method = method;
  c.detail = taps_text(x_taps.front().size(), y_taps.front().size());
  if (method == Method::low_rank) c.detail += ", rank " + std::to_string(x_taps.size());
  c.predicted = work.judge.predicted(kernel, work.judge.arithmetic(terms, sum));
  c.cost_ms = separable_cost_ms(x, y, static_cast<std::int64_t>(x_taps.size()));
  std::vector<std::vector<float>> fx, fy;
  for (const auto& taps : x_taps) fx.push_back(narrow(taps));
  for (const auto& taps : y_taps) fy.push_back(narrow(taps));
  auto engine = make_separable_engine(x, y, work.task.options.border, std::move(fx), std::move(fy));
  c.bytes = engine->filter_bytes() + engine->run_bytes(1, 1);
  candidate.make = [engine](const Engine*) { return engine; };
  return candidate;
}

// H factors by itself: each axis on its own, exactly, with half of the budget.
MethodCandidate exact_separable(const Work& work) {
  const Method method = Method::separable;
  const FactoredOtf& sampler = work.task.sampler;
  if (!sampler.is_separable()) return impossible(method, "the OTF does not factor");
  const double dc = sampler.dc();
  const AxisResponse x(sampler, Axis::x, work.task.in.step_x_um, work.ratio_x);
  const AxisResponse y(sampler, Axis::y, work.task.in.step_y_um, work.ratio_y);
  const std::vector<double> modulus_x = x.modulus(), modulus_y = y.modulus();
  const auto cost = [&](const std::vector<double>& ex, const std::vector<double>& ey) {
    std::vector<double> error;
    for (int j = -SceneSpectrum::kCells; j <= SceneSpectrum::kCells; ++j)
      for (std::size_t i = 0; i < ex.size(); ++i) {
        const auto k = static_cast<std::size_t>(std::abs(j));
        error.push_back(std::abs(dc) * (ex[i] * modulus_y[k] + (modulus_x[i] + ex[i]) * ey[k]));
      }
    return work.judge.rms(error);
  };
  const std::vector<double> none(modulus_x.size(), 0.0);
  const double budget = work.judge.budget(work.judge.arithmetic(32.0, 1.0));
  const auto half_x = smallest_half_width(1, AxisResponse::kHalfWidth, 0.5 * budget,
                                          [&](std::int64_t r) { return cost(x.error(x.taps(r)), none); });
  const auto half_y = smallest_half_width(1, AxisResponse::kHalfWidth, 0.5 * budget,
                                          [&](std::int64_t r) { return cost(none, y.error(y.taps(r))); });
  const std::string too_wide =
      "the point spread is wider than " + std::to_string(2 * AxisResponse::kHalfWidth) + " samples at this tolerance";
  if (!half_x || !half_y || !holds_most_of_spread(x.share(*half_x)) || !holds_most_of_spread(y.share(*half_y)))
    return impossible(method, too_wide);
  std::vector<double> x_taps = x.taps(*half_x), y_taps = y.taps(*half_y);
  const std::vector<double> error_x = x.error(x_taps), error_y = y.error(y_taps);
  if (!work.judge.negligible(std::abs(dc) * (x.excess(x_taps, error_x) + y.excess(y_taps, error_y))))
    return impossible(method, too_wide);
  const double kernel = cost(error_x, error_y);
  for (double& tap : y_taps) tap *= dc;
  return separable_candidate(work, method, {x_taps}, {y_taps}, kernel);
}

// Keeps the gain of the mean, so that slow contrast comes out exactly. A kernel that holds but a part of the point
// spread is no kernel: it becomes zero.
void normalise(TapBox& box, double dc) {
  const double sum = box.sum();
  const double factor = holds_most_of_spread(sum / dc) ? dc / sum : 0.0;
  for (double& tap : box.value) tap *= factor;
}

MethodCandidate low_rank(const Work& work, const PointResponse& response, double limit_ms) {
  const Method method = Method::low_rank;
  if (work.task.sampler.is_separable()) return impossible(method, "the OTF factors exactly");
  const double budget = work.judge.budget(work.judge.arithmetic(48.0, 1.5));
  const auto normalised = [&](std::int64_t r) {
    TapBox box = response.box(r, r);
    normalise(box, work.task.sampler.dc());
    return box;
  };
  const auto half_width = smallest_half_width(1, PointResponse::kHalfWidth, 0.6 * budget, [&](std::int64_t r) {
    return work.judge.rms(response.error(normalised(r)));
  });
  const std::string too_wide =
      "the point spread is wider than " + std::to_string(2 * PointResponse::kHalfWidth) + " samples at this tolerance";
  if (!half_width) return impossible(method, too_wide);
  const TapBox box = normalised(*half_width);
  if (box.sum() == 0.0) return impossible(method, too_wide);
  const SeparableTerms terms = separable_terms(box, kLargestRank);
  for (std::size_t rank = 1; rank <= terms.along_x.size(); ++rank) {
    if (separable_cost_ms(work.x(terms.along_x.front().size()), work.y(terms.along_y.front().size()),
                          static_cast<std::int64_t>(rank)) > limit_ms)
      return impossible(method, "needs rank " + std::to_string(rank) + " or more: far slower than other methods");
    const TapBox product = product_of(terms, rank);
    const std::vector<double> error = response.error(product);
    const double kernel = work.judge.rms(error);
    if (kernel > budget) continue;
    if (!work.judge.negligible(response.excess(product, error))) return impossible(method, too_wide);
    const auto count = static_cast<std::ptrdiff_t>(rank);
    return separable_candidate(work, method, {terms.along_x.begin(), terms.along_x.begin() + count},
                               {terms.along_y.begin(), terms.along_y.begin() + count}, kernel);
  }
  return impossible(method, "needs a rank above " + std::to_string(kLargestRank));
}

// Zeroes the taps outside of the support of the given half width.
void clip(TapBox& box, Method method, double half_width) {
  for (std::int64_t r = 0; r < box.rows; ++r)
    for (std::int64_t c = 0; c < box.columns; ++c) {
      const double x = std::abs(static_cast<double>(c) - 0.5 * static_cast<double>(box.columns - 1));
      const double y = std::abs(static_cast<double>(r) - 0.5 * static_cast<double>(box.rows - 1));
      const bool inside = method == Method::direct_square ? true
                          : method == Method::direct_disc ? x * x + y * y <= half_width * (half_width + 1.0)
                                                          : x + y <= half_width;
      if (!inside) box.at(r, c) = 0.0;
    }
}

/// The founding paper's rhombus can be the device's work too.
std::vector<MethodCandidate> direct(const Work& work, const PointResponse& response, Method method, double limit_ms) {
  const double budget = work.judge.budget(work.judge.arithmetic(48.0, 1.2));
  const auto taps = [&](std::int64_t r) {
    TapBox box = response.box(r, r);
    clip(box, method, static_cast<double>(r));
    normalise(box, work.task.sampler.dc());
    return box;
  };
  const std::int64_t most = kDirectHalfWidth;
  const auto half_width =
      smallest_half_width(1, most, budget, [&](std::int64_t r) { return work.judge.rms(response.error(taps(r))); });
  const std::string too_wide = "needs more than " + std::to_string(2 * most) + " samples across at this tolerance";
  std::vector<MethodCandidate> candidates;
  const auto with = [&](MethodCandidate candidate) {
    candidates.push_back(std::move(candidate));
    return std::move(candidates);
  };
  if (!half_width) return with(impossible(method, too_wide));
  const TapBox box = taps(*half_width);
  if (box.sum() == 0.0) return with(impossible(method, too_wide));
  const auto used = std::count_if(box.value.begin(), box.value.end(), [](double tap) { return tap != 0.0; });
  const bool mirrored = work.task.sampler.is_real() && work.task.sampler.is_even_x() && work.task.sampler.is_even_y();
  const TapAxis x = work.x(static_cast<std::size_t>(box.columns)), y = work.y(static_cast<std::size_t>(box.rows));
  MethodCandidate candidate;
  Candidate& c = candidate.report;
  c.method = method;
  c.detail = taps_text(static_cast<std::size_t>(box.columns), static_cast<std::size_t>(box.rows)) + ", " +
             std::to_string(used) + " used";
  c.cost_ms = direct_cost_ms(x, y, used, mirrored);
  std::shared_ptr<const Device> device;
  if (method == Method::direct_diamond) device = work.task.options.device.device;
  const bool is_slow = c.cost_ms > limit_ms;
  if (is_slow) candidates.push_back(impossible(method, c.detail + ": far slower than other methods"));
  if (is_slow && !device) return candidates;
  const std::vector<double> error = response.error(box);
  if (!work.judge.negligible(response.excess(box, error)))
    return is_slow ? std::move(candidates) : with(impossible(method, too_wide));
  c.predicted =
      work.judge.predicted(work.judge.rms(error), work.judge.arithmetic(static_cast<double>(used), moduli(box.value)));
  std::vector<float> narrowed = narrow(box.value);
  if (mirrored)  // bit by bit, so that mirrored samples may be added first
    for (std::int64_t r = 0; r < box.rows; ++r)
      for (std::int64_t t = 0; t < box.columns; ++t) {
        const std::int64_t mr = std::min(r, box.rows - 1 - r), mt = std::min(t, box.columns - 1 - t);
        narrowed[static_cast<std::size_t>(r * box.columns + t)] =
            narrowed[static_cast<std::size_t>(mr * box.columns + mt)];
      }
  const Border border = work.task.options.border;
  if (!is_slow) {
    const auto engine = make_direct_engine(x, y, border, narrowed);
    c.bytes = engine->filter_bytes() + engine->run_bytes(1, 1);
    candidate.make = [engine](const Engine*) { return engine; };
    candidates.push_back(candidate);
  }
  if (!device) return candidates;
  candidate.report.on_device = true;
  c.detail += ", on " + device->info().name;
  c.reason = device_taps_obstacle(device->info(), x, y);
  c.bytes = device_taps_bytes(x, y);
  c.cost_ms = device_taps_cost_ms(*device, x, y, used);
  candidate.make = [=](const Engine*) { return make_device_taps(device, x, y, border, narrowed); };
  return with(std::move(candidate));
}

}  // namespace

std::vector<MethodCandidate> tap_candidates(const PlanTask& task, double fft_ms) {
  std::vector<MethodCandidate> candidates;
  const auto ratio_x = whole_ratio(task.in.step_x_um, task.out.step_x_um);
  const auto ratio_y = whole_ratio(task.in.step_y_um, task.out.step_y_um);
  constexpr std::array direct_methods{Method::direct_square, Method::direct_disc, Method::direct_diamond};
  const auto none = [&](const std::string& reason) {  // of those that are not there yet
    if (candidates.empty()) candidates.push_back(impossible(Method::separable, reason));
    candidates.push_back(impossible(Method::low_rank, reason));
    for (const Method method : direct_methods) candidates.push_back(impossible(method, reason));
    return candidates;
  };
  if (!ratio_x || !ratio_y) return none("the pitch is not 1 to " + std::to_string(kLargestRatio) + " whole samples");
  if (task.sampler.dc() == 0.0)
    return none("the mean does not pass (the near part of a split OTF takes it from the far part)");
  const Judge judge(task, *ratio_x, *ratio_y);
  if (!(judge.budget(judge.arithmetic(1.0, 1.0)) > 0.0)) return none("float sums do not keep the tolerance");
  const Work work{task, judge, *ratio_x, *ratio_y};
  candidates.push_back(exact_separable(work));
  // A method that is several times slower than another one is of no use, and designing its kernel takes time.
  const double limit_ms = 4.0 * std::min(fft_ms, candidates.front().make ? candidates.front().report.cost_ms : fft_ms);
  // A kernel of a slow OTF costs more frequencies to design than a small image has.
  constexpr std::int64_t kCorners = std::int64_t{SceneSpectrum::kRows} * SceneSpectrum::kColumns;
  if (task.sampler.is_slow() && task.in.width * task.in.height < 4 * kCorners)
    return none("designing a kernel of this OTF costs more than the image");
  const PointResponse response(task.sampler, task.in, *ratio_x, *ratio_y);
  candidates.push_back(low_rank(work, response, limit_ms));
  for (const Method method : direct_methods)
    for (MethodCandidate& candidate : direct(work, response, method, limit_ms))
      candidates.push_back(std::move(candidate));
  // Between the corners |H| may be somewhat larger.
  const double gain = task.sampler.has_gain() ? std::min(task.sampler.gain(), 1.05 * response.largest()) : 1.0;
  for (MethodCandidate& candidate : candidates) {
    candidate.largest_gain = std::max(1.0, gain);
    candidate.error_per_otf = judge.error_per_otf();
  }
  return candidates;
}

}  // namespace mtf
