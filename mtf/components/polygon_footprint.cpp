// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/polygon_footprint.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mtf/math/special.h"

namespace mtf {
namespace {

constexpr double kSeriesUpTo = 0.5;  // cycles between the phases

// exp(z_m) x sum over k of h_k(z - z_m)/(k + n - 1)!, h_k the complete homogeneous polynomials, about the middle z_m.
Complex<double> by_series(std::span<const double> a) {
  const double middle = 0.5 * (a.front() + a.back());
  const std::size_t n = a.size();
  std::array<double, 4> h{}, offset{};
  for (std::size_t i = 0; i < n; ++i) offset[i] = 2.0 * kPi * (a[i] - middle);
  double factorial = n == 3 ? 0.5 : n == 4 ? 1.0 / 6.0 : 1.0;
  h.fill(1.0);  // of the first variable, the first two, ...
  Complex<double> sum{factorial, 0.0};
  for (int k = 1; k < 28; ++k) {
    for (std::size_t i = 0; i < n; ++i) h[i] = (i == 0 ? 0.0 : h[i - 1]) + offset[i] * h[i];
    factorial /= k + static_cast<int>(n) - 1;
    const double term = h[n - 1] * factorial;  // times (-i)^k
    (k % 2 == 0 ? sum.re : sum.im) += k % 4 == 0 || k % 4 == 3 ? term : -term;
  }
  return sum * Complex<double>{cos_pi(2.0 * middle), -sin_pi(2.0 * middle)};
}

Complex<double> difference(std::span<const double> a) {  // sorted
  const double span = a.back() - a.front();
  if (a.size() == 2) {
    const double sum = a.front() + a.back(), h = sinc(span).value;
    return {h * cos_pi(sum), -h * sin_pi(sum)};
  }
  if (span < kSeriesUpTo) return by_series(a);
  const Complex<double> upper = difference(a.subspan(1)), lower = difference(a.first(a.size() - 1));
  const double scale = 1.0 / (2.0 * kPi * span);  // 1/(-2 pi i span) = i scale
  return {-scale * (upper.im - lower.im), scale * (upper.re - lower.re)};
}

double cross(const Point& o, const Point& a, const Point& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

bool between(const Point& a, const Point& b, const Point& p) {  // p on the line through a and b
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}

bool touch(const Point& a, const Point& b, const Point& c, const Point& d) {
  const double u = cross(a, b, c), v = cross(a, b, d), p = cross(c, d, a), q = cross(c, d, b);
  if (((u > 0.0) != (v > 0.0)) && ((p > 0.0) != (q > 0.0)) && u != 0.0 && v != 0.0 && p != 0.0 && q != 0.0) return true;
  return (u == 0.0 && between(a, b, c)) || (v == 0.0 && between(a, b, d)) || (p == 0.0 && between(c, d, a)) ||
         (q == 0.0 && between(c, d, b));
}

}  // namespace

Complex<double> phase_divided_difference(std::span<const double> cycles) {
  std::array<double, 4> sorted{};
  const std::size_t n = cycles.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(cycles[i])) return {};
    sorted[i] = cycles[i];
  }
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n));
  if (!std::isfinite(sorted[n - 1] - sorted[0])) return {};
  return difference(std::span(sorted).first(n));
}

std::string polygon_fault(std::span<const Point> v) {
  const std::size_t n = v.size();
  if (n < 3) return "a polygon has at least three vertices";
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      if (v[i].x == v[j].x && v[i].y == v[j].y)
        return "vertices " + std::to_string(i + 1) + " and " + std::to_string(j + 1) +
               " are the same point; the polygon closes by itself";
  double area = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) area += cross(v[0], v[i], v[i + 1]);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const Point &a = v[i], &b = v[(i + 1) % n], &c = v[j], &d = v[(j + 1) % n];
      const bool follows = j == i + 1, precedes = (j + 1) % n == i;
      // Neighbours share a point; they may not fold back onto each other.
      const bool bad = follows    ? cross(a, b, d) == 0.0 && (n == 3 || between(a, b, d) || between(b, d, a))
                       : precedes ? cross(c, a, b) == 0.0 && (between(c, a, b) || between(a, b, c))
                                  : touch(a, b, c, d);
      if (bad)
        return "edges " + std::to_string(i + 1) + " and " + std::to_string(j + 1) +
               (n == 3 ? " lie on one line: no area" : " cross or touch; the outline has to be simple");
    }
  const auto [left, right] = std::minmax_element(v.begin(), v.end(), [](auto& a, auto& b) { return a.x < b.x; });
  const auto [top, bottom] = std::minmax_element(v.begin(), v.end(), [](auto& a, auto& b) { return a.y < b.y; });
  const double box = (right->x - left->x) * (bottom->y - top->y);
  return 0.5 * std::abs(area) <= 1e-6 * box ? "the polygon has less than 1e-6 of the area of the box around it" : "";
}

bool polygon_mirrored(std::span<const Point> v, double sx, double sy) {
  const std::size_t n = v.size();
  const bool reversed = sx * sy < 0.0;
  const auto same = [&](const Point& p, const Point& q) { return sx * p.x == q.x && sy * p.y == q.y; };
  for (std::size_t start = 0; start < n; ++start) {
    std::size_t k = 0;
    while (k < n && same(v[k], v[(start + (reversed ? n - k : k)) % n])) ++k;
    if (k == n) return true;
  }
  return false;
}

}  // namespace mtf
