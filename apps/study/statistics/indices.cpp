// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/indices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "apps/study/statistics/sampling.h"
#include "mtf/parallel.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/stages/noise/random.h"

namespace study {
namespace {

constexpr int kBootstraps = 200;
constexpr std::int64_t kPiece = 16;
constexpr auto kPoints = static_cast<std::uint32_t>(Purpose::indices),
               kResamples = static_cast<std::uint32_t>(Purpose::bootstrap);

/// Coordinate of a point in [0, 1): set 0 is A, 1 is B.
double coordinate(std::uint64_t seed, std::int64_t sample, std::size_t parameter, std::uint32_t set) {
  const radiometry::Bits128 bits = radiometry::philox(
      {static_cast<std::uint32_t>(sample), static_cast<std::uint32_t>(parameter), set, kPoints}, seed);
  return std::min(radiometry::uniform(bits[0], bits[1]).u, 1.0 - 0x1p-53);
}

/// Results at A, B and AB_1 ... AB_k of every sample, of one result: [sample][k + 2].
struct Values {
  std::size_t stride;
  std::vector<double> f;

  std::span<const double> at(std::size_t sample) const { return std::span(f).subspan(sample * stride, stride); }
  std::size_t samples() const { return f.size() / stride; }
};

/// Sums over samples from which the shares follow; samples may be counted more than once.
class Sums {
 public:
  explicit Sums(std::size_t parameters) : first_(parameters), total_(parameters) {}

  void add(std::span<const double> f) {
    ++count_;
    sum_ += f[0] + f[1];
    square_ += f[0] * f[0] + f[1] * f[1];
    for (std::size_t j = 0; j < first_.size(); ++j) {
      const double step = f[j + 2] - f[0];
      first_[j] += f[1] * step;
      total_[j] += step * step;
    }
  }

  double variance() const {
    const double n = 2.0 * static_cast<double>(count_);
    return (square_ - sum_ * sum_ / n) / (n - 1.0);
  }
  double first(std::size_t j) const { return first_[j] / static_cast<double>(count_) / variance(); }
  double total(std::size_t j) const { return 0.5 * total_[j] / static_cast<double>(count_) / variance(); }

 private:
  std::int64_t count_ = 0;
  double sum_ = 0.0, square_ = 0.0;
  std::vector<double> first_, total_;
};

/// Standard deviation of numbers met one by one.
struct Spread {
  double n = 0.0, mean = 0.0, m2 = 0.0;
  void add(double x) {
    n += 1.0;
    const double d = x - mean;
    mean += d / n;
    m2 += d * (x - mean);
  }
  double sd() const { return std::sqrt(m2 / (n - 1.0)); }
};

std::vector<Index> indices_of(const Values& values, std::uint64_t seed) {
  const std::size_t parameters = values.stride - 2, n = values.samples();
  Sums all(parameters);
  for (std::size_t i = 0; i < n; ++i) all.add(values.at(i));
  std::vector<Index> result(parameters);
  for (std::size_t j = 0; j < parameters; ++j) result[j] = {.first = all.first(j), .total = all.total(j)};
  std::vector<Spread> first(parameters), total(parameters);
  for (int b = 0; b < kBootstraps; ++b) {
    Sums some(parameters);
    for (std::size_t i = 0; i < n; ++i) {
      const auto bits =
          radiometry::philox({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(b), 0, kResamples}, seed);
      some.add(values.at((std::uint64_t{bits[0]} * n) >> 32));
    }
    if (!(some.variance() > 0.0)) continue;
    for (std::size_t j = 0; j < parameters; ++j) {
      first[j].add(some.first(j));
      total[j].add(some.total(j));
    }
  }
  for (std::size_t j = 0; j < parameters; ++j) {
    result[j].first_sd = first[j].sd();
    result[j].total_sd = total[j].sd();
  }
  return result;
}

/// The samples that have all their numbers, about their mean and scaled to their largest distance from it: results of
/// any size keep their digits. Empty when nothing varies.
Values steady(Values values) {
  std::vector<double> kept;
  for (std::size_t i = 0; i < values.samples(); ++i) {
    const auto f = values.at(i);
    if (std::ranges::all_of(f, [](double v) { return std::isfinite(v); })) kept.insert(kept.end(), f.begin(), f.end());
  }
  values.f = std::move(kept);
  double size = 0.0, mean = 0.0, largest = 0.0;
  for (const double v : values.f) size = std::max(size, std::abs(v));
  if (size == 0.0) return {values.stride, {}};
  for (double& v : values.f) mean += (v /= size);
  mean /= static_cast<double>(values.f.size());
  for (double& v : values.f) largest = std::max(largest, std::abs(v -= mean));
  // Below this only rounding varies.
  if (largest < 1e-14) return {values.stride, {}};
  for (double& v : values.f) v /= largest;
  return values;
}

/// Evaluators that wait for work, so that pieces of work in any thread share a few.
class EvaluatorPool {
 public:
  explicit EvaluatorPool(std::shared_ptr<const Study> study) : study_(std::move(study)) {}

  /// Lends an evaluator, which goes back to the pool with the last copy of the pointer. The pool has to outlive it.
  std::shared_ptr<Evaluator> take() {
    std::unique_ptr<Evaluator> one;
    {
      const std::lock_guard guard(lock_);
      if (!free_.empty()) {
        one = std::move(free_.back());
        free_.pop_back();
      }
    }
    if (!one) one = std::make_unique<Evaluator>(study_);
    return {one.release(), [this](Evaluator* back) {
              std::unique_ptr<Evaluator> owned(back);
              const std::lock_guard guard(lock_);
              free_.push_back(std::move(owned));
            }};
  }

 private:
  std::shared_ptr<const Study> study_;
  std::mutex lock_;
  std::vector<std::unique_ptr<Evaluator>> free_;
};

bool varies(const Axis& axis) { return axis.values.empty() ? axis.to != axis.from : axis.values.size() > 1; }

/// At most 4096, and about as many points as a quarter of the designs, or 4096.
std::int64_t index_samples(const Study& study, std::size_t parameters) {
  constexpr std::int64_t most = 4096;
  const auto points = std::max<std::int64_t>(most, study.designs / 4);
  return std::min(most, points / static_cast<std::int64_t>(parameters + 2));
}

}  // namespace

Indices sensitivity_indices(const IndexJob& job) {
  const std::size_t parameters = job.parameters, stride = parameters + 2;
  const auto samples = static_cast<std::size_t>(job.samples);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<Values> values(job.results, Values{stride, std::vector<double>(samples * stride, kNone)});
  std::mutex lock;
  std::int64_t finished = 0;
  mtf::parallel_for(job.samples, kPiece, job.threads, [&](std::int64_t begin, std::int64_t end) {
    if (begin > 0 && job.go_on && !job.go_on()) return;
    const PointMaker point = job.make();
    std::vector<double> a(parameters), b(parameters), results(job.results);
    for (std::int64_t i = begin; i < end; ++i) {
      const auto keep = [&](std::size_t which) {
        for (std::size_t r = 0; r < job.results; ++r)
          values[r].f[static_cast<std::size_t>(i) * stride + which] = results[r];
      };
      for (std::size_t j = 0; j < parameters; ++j) {
        a[j] = coordinate(job.seed, i, j, 0);
        b[j] = coordinate(job.seed, i, j, 1);
      }
      point(a, results);
      keep(0);
      point(b, results);
      keep(1);
      for (std::size_t j = 0; j < parameters; ++j) {
        std::swap(a[j], b[j]);
        point(a, results);
        keep(j + 2);
        std::swap(a[j], b[j]);
      }
    }
    const std::lock_guard guard(lock);
    finished += end - begin;
    if (job.done) job.done(static_cast<double>(finished) / static_cast<double>(job.samples));
  });
  Indices result{.of = {}, .samples = finished, .used = {}};
  for (Values& each : values) {
    each = steady(std::move(each));
    result.used.push_back(static_cast<std::int64_t>(each.samples()));
    const bool enough = each.samples() > 1 && 2 * std::ssize(each.f) >= finished * static_cast<std::int64_t>(stride);
    result.of.push_back(enough ? indices_of(each, job.seed)
                               : std::vector<Index>(parameters, Index{kNone, kNone, kNone, kNone}));
  }
  return result;
}

StudyIndices study_indices(const std::shared_ptr<const Study>& study, const std::vector<Column>& columns,
                           double seconds, int threads, const std::function<void(double)>& done) {
  StudyIndices result;
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].role == Column::Role::metric || columns[c].role == Column::Role::objective)
      result.columns.push_back(c);
  const std::size_t axes = study->axes.size();
  std::vector<std::size_t> varying;
  for (std::size_t a = 0; a < axes; ++a)
    if (varies(study->axes[a])) varying.push_back(a);
  EvaluatorPool pool(study);
  const auto make = [&]() -> PointMaker {
    return
        [&, evaluator = pool.take(), at = std::vector<double>(axes, 0.5), values = std::vector<double>(axes),
         row = std::vector<double>(columns.size())](std::span<const double> unit, std::span<double> results) mutable {
          for (std::size_t j = 0; j < varying.size(); ++j) at[varying[j]] = unit[j];
          design_at_quantiles(*study, at, values);
          evaluator->evaluate_at(values, row);
          for (std::size_t r = 0; r < results.size(); ++r) results[r] = row[result.columns[r]];
        };
  };
  const mtf::Stopwatch watch;
  Indices found = sensitivity_indices({.parameters = varying.size(),
                                       .results = result.columns.size(),
                                       .samples = varying.empty() ? 0 : index_samples(*study, varying.size()),
                                       .seed = study->seed,
                                       .threads = threads,
                                       .make = make,
                                       .done = done,
                                       .go_on = [&] { return watch.seconds() < seconds; }});
  // An axis of one value has no part in what varies; where nothing varies there are no shares.
  for (std::vector<Index>& of : found.of) {
    const bool none = varying.empty() || std::isnan(of.front().total);
    std::vector<Index> all(axes, none ? Index{NAN, NAN, NAN, NAN} : Index{});
    for (std::size_t j = 0; j < varying.size(); ++j) all[varying[j]] = of[j];
    of = std::move(all);
  }
  result.indices = std::move(found);
  return result;
}

}  // namespace study
