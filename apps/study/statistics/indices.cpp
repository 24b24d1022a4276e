// SPDX-License-Identifier: Apache-2.0
#include "apps/study/statistics/indices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "apps/study/statistics/sampling.h"
#include "mtf/parallel.h"
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

}  // namespace study
