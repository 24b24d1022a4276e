// SPDX-License-Identifier: Apache-2.0
#include "mtf/metrics/edge_sums.h"

#include "mtf/math/simd.h"

namespace mtf::detail {
namespace {

/// kEdgeLanes sums side by side in vectors of that many bytes.
template <int Bytes>
struct Lanes {
  using V = simd::Vector<double, Bytes>;
  static constexpr std::size_t kSize = Bytes / sizeof(double), kVectors = kEdgeLanes / kSize;
  V sum[kVectors] = {};

  MTFKIT_INLINE double total() const {
    double lane[kEdgeLanes];
    for (std::size_t v = 0; v < kVectors; ++v) simd::store(sum[v], lane + v * kSize);
    return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
  }
};

struct Spread {
  template <int Bytes>
  static MTFKIT_INLINE void run(const EdgeTerms<double>* terms, const double* sine, const double* cosine,
                                SpreadSums<double>* sums) {
    using L = Lanes<Bytes>;
    L step, line, slope, curvature;
    for (std::size_t first = 0; first < terms->u.size(); first += kEdgeLanes)
      for (std::size_t v = 0; v < L::kVectors; ++v) {
        const std::size_t i = first + v * L::kSize;
        const auto at = [i](const double* p) { return simd::load<typename L::V>(p + i); };
        const auto s = at(sine), c = at(cosine), u = at(terms->u.data());
        const auto re = at(terms->re.data()), im = at(terms->im.data());
        const auto even = re * c - im * s, odd = re * s + im * c;
        step.sum[v] += odd * at(terms->per_u.data());
        line.sum[v] += even;
        slope.sum[v] += u * odd;
        curvature.sum[v] += u * u * even;
      }
    *sums = {step.total(), line.total(), slope.total(), curvature.total()};
  }
};

struct Stepped {
  template <int Bytes>
  static MTFKIT_INLINE void run(const EdgeTerms<double>* terms, double* sine, double* cosine, const double* turn_sine,
                                const double* turn_cosine, std::vector<double>* step, double* line) {
    using L = Lanes<Bytes>;
    for (std::size_t k = 0; k < step->size(); ++k) {
      L steps, lines;
      for (std::size_t first = 0; first < terms->u.size(); first += kEdgeLanes)
        for (std::size_t v = 0; v < L::kVectors; ++v) {
          const std::size_t i = first + v * L::kSize;
          const auto at = [i](const double* p) { return simd::load<typename L::V>(p + i); };
          const auto s = at(sine), c = at(cosine), turn_s = at(turn_sine), turn_c = at(turn_cosine);
          const auto re = at(terms->re.data()), im = at(terms->im.data());
          steps.sum[v] += at(terms->per_u.data()) * (re * s + im * c);
          lines.sum[v] += re * c - im * s;
          simd::store(s * turn_c + c * turn_s, sine + i);
          simd::store(c * turn_c - s * turn_s, cosine + i);
        }
      (*step)[k] = steps.total();
      line[k] = lines.total();
    }
  }
};

}  // namespace

SpreadSums<double> spread_sums(const EdgeTerms<double>& terms, const std::vector<double>& sine,
                               const std::vector<double>& cosine) {
  assert(terms.u.size() % kEdgeLanes == 0);
  SpreadSums<double> sums;
  simd::run<Spread>(&terms, sine.data(), cosine.data(), &sums);
  return sums;
}

void stepped_sums(const EdgeTerms<double>& terms, std::vector<double>& sine, std::vector<double>& cosine,
                  const std::vector<double>& turn_sine, const std::vector<double>& turn_cosine,
                  std::vector<double>& step, std::vector<double>& line) {
  assert(terms.u.size() % kEdgeLanes == 0);
  simd::run<Stepped>(&terms, sine.data(), cosine.data(), turn_sine.data(), turn_cosine.data(), &step, line.data());
}

}  // namespace mtf::detail
