// SPDX-License-Identifier: Apache-2.0
#pragma once

// Detector footprint of any simple polygon, uniform response: L-shape, hexagon, trapezoid ...
//   otf = (1/area) integral over the polygon of exp(-2 pi i f.x) dx
// Vertices [x, y] in order (either sense) as plain numbers of unit_length, +x right, +y down from the pixel's centre.
// Complex: the shift of an off-centre polygon is kept in the phase. Real when the polygon is point-symmetric. Computed
// as a sum of signed triangles: the error is a few 2^-53 times the sum of their areas relative to that of the polygon,
// and what the rounding of the phases f.x adds. (Lee and Mittra, IEEE Trans. Antennas Propag. 31, 99 (1983).)

#include "mtf/components/field.h"

namespace mtf {

// The Fourier transform of a polygon, by triangles instead of edges. The mean of exp(-2 pi i f.x) over a triangle is
// twice the divided difference of exp(-2 pi i a) at the three phases a = f.vertex (Hermite and Genocchi), so nothing is
// divided by |f|^2: f = 0 and edges across f need no case of their own.

/// Divided difference of z -> exp(z) at z = -2 pi i a for two to four phases a (cycles): real and imaginary part.
/// Absolute error a few 2^-53, plus that of the phases.
Complex<double> phase_divided_difference(std::span<const double> cycles);

struct Point {
  double x = 0.0, y = 0.0;
};

/// Why the closed line through the vertices is no polygon with an inside (fewer than three, repeated, crossing or
/// touching itself, thinner than rounding allows), or "".
std::string polygon_fault(std::span<const Point> vertices);

/// Whether the polygon is its own image under (x, y) -> (sx x, sy y), sx, sy = 1 or -1.
bool polygon_mirrored(std::span<const Point> vertices, double sx, double sy);

template <class S>
struct PolygonFootprint {
  static constexpr std::string_view kind = "polygon_footprint";
  static constexpr std::string_view doc = "detector footprint of any simple polygon";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::detector;
  static constexpr bool is_footprint = true;
  static constexpr std::size_t kMostVertices = 200;

  Taps<S> vertices{};
  AxisPair<S> unit_length{};

  static constexpr auto fields() {
    return std::tuple{required(&PolygonFootprint::vertices, "vertices", -1e6, 1e6,
                               "[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.1], [0.1, 0.1], [0.1, 0.5], [-0.5, 0.5]]",
                               "corners [x, y] in order, in units of unit_length"),
                      required(&PolygonFootprint::unit_length, "unit_length", 0.0, 1e9, "\"15 um\"",
                               "length that 1 stands for in vertices, per axis")};
  }
  std::vector<Point> points() const {
    std::vector<Point> all;
    for (const auto& v : vertices) all.push_back({value_of(v[0]), value_of(v[1])});
    return all;
  }
  Traits traits(const Context<S>&) const {
    const std::vector<Point> p = points();
    return {.even_x = polygon_mirrored(p, -1.0, 1.0),
            .even_y = polygon_mirrored(p, 1.0, -1.0),
            .real = polygon_mirrored(p, -1.0, -1.0)};
  }
  /// What does not depend on the frequency is done once: for many frequencies at one context.
  auto evaluator(const Context<S>& ctx) const {
    return [fan = fan(), ux = T(unit_length.x_um(ctx.frame)) * T(1e-3), uy = T(unit_length.y_um(ctx.frame)) * T(1e-3),
            real = polygon_mirrored(points(), -1.0, -1.0)](const Freq<S>& f) {
      const Complex<T> h = transform(fan, T(f.x) * ux, T(f.y) * uy);
      return Complex<S>{S(h.re), real ? S(lift({0.0, 1.0}, h.im)) : S(h.im)};
    };
  }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const { return evaluator(ctx)(f); }
  /// |1 - exp(-2 pi i a)| = 2 sin(pi |a|) for the farthest corner; real: its real part alone, 2 sin^2(pi a).
  double deviation(double fx, double fy, const Context<S>& ctx) const {
    double largest = 0.0;
    for (const Point& p : points())
      largest = std::max(largest, std::abs(p.x) * fx * value_of(unit_length.x_um(ctx.frame)) * 1e-3 +
                                      std::abs(p.y) * fy * value_of(unit_length.y_um(ctx.frame)) * 1e-3);
    const double sine = sin_pi(std::min(0.5, largest));
    return polygon_mirrored(points(), -1.0, -1.0) ? 2.0 * sine * sine : 2.0 * sine;
  }
  std::vector<Problem> check(const Context<S>& ctx) const {
    const auto fault = [](std::string text) {
      return std::vector<Problem>{{.field = "vertices", .text = std::move(text)}};
    };
    for (const auto& v : vertices)
      if (v.size() != 2) return fault("every vertex is a pair [x, y]");
    if (vertices.size() > kMostVertices) return fault("more than " + std::to_string(kMostVertices) + " vertices");
    const std::vector<Point> p = points();
    if (std::string text = polygon_fault(p); !text.empty()) return fault(std::move(text));
    const auto [left, right] = std::minmax_element(p.begin(), p.end(), [](auto& a, auto& b) { return a.x < b.x; });
    const auto [top, bottom] = std::minmax_element(p.begin(), p.end(), [](auto& a, auto& b) { return a.y < b.y; });
    const auto wide = [&](double length, const S& unit_um, Axis axis) {
      return length * value_of(unit_um) > value_of(ctx.frame.pitch_um(axis)) * (1.0 + 1e-9);
    };
    if (wide(right->x - left->x, unit_length.x_um(ctx.frame), Axis::x) ||
        wide(bottom->y - top->y, unit_length.y_um(ctx.frame), Axis::y))
      return {{.error = false, .field = "vertices", .text = "the polygon is larger than the pitch"}};
    return {};
  }

 private:
  using T = std::conditional_t<std::is_same_v<S, float>, double, S>;  ///< products of sizes exceed float

  /// The polygon as signed triangles from one point to its edges.
  struct Fan {
    Point middle;
    std::vector<Freq<T>> corner;  ///< relative to the middle
    std::vector<T> share;         ///< of the area, for the edge from each corner to the next
  };
  Fan fan() const {
    const std::size_t n = vertices.size();
    Fan all;
    // Any point serves as the common corner of the triangles; inside, few of them are negative.
    for (const Point& p : points()) all.middle = {all.middle.x + p.x, all.middle.y + p.y};
    all.middle = {all.middle.x / static_cast<double>(n), all.middle.y / static_cast<double>(n)};
    for (const auto& v : vertices) all.corner.push_back({T(v[0]) - T(all.middle.x), T(v[1]) - T(all.middle.y)});
    T area(0);
    double size = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const Freq<T>&p = all.corner[k], &q = all.corner[(k + 1) % n];
      all.share.push_back(p.x * q.y - q.x * p.y);
      area = area + all.share.back();
      size += std::abs(value_of(p.x) * value_of(q.y)) + std::abs(value_of(q.x) * value_of(p.y));
    }
    // Where float has moved the corners onto one line there are no areas left to weigh with.
    const bool flat = !(std::abs(value_of(area)) > 1e-12 * size);
    // The last one is what is left: their sum is 1, with no slope, to the last digit.
    T sum(0);
    for (std::size_t k = 0; k + 1 < n; ++k) {
      all.share[k] = flat ? T(1.0 / static_cast<double>(n)) : T(all.share[k] / area);
      sum = sum + all.share[k];
    }
    all.share[n - 1] = T(1) - sum;
    return all;
  }
  /// gx, gy: cycles per unit of the vertices.
  static Complex<T> transform(const Fan& fan, const T& gx, const T& gy) {
    if (!(std::hypot(value_of(gx), value_of(gy)) < 1e150)) return {};  // nothing is left, and no phase to tell
    const auto phase = [&](std::size_t k) { return T(gx * fan.corner[k].x + gy * fan.corner[k].y); };
    Complex<T> sum{};
    for (std::size_t k = 0; k < fan.corner.size(); ++k) {
      const Complex<T> mean = triangle_mean(phase(k), phase((k + 1) % fan.corner.size()));
      sum = sum + Complex<T>{fan.share[k] * mean.re, fan.share[k] * mean.im};
    }
    const T shift = T(2) * (gx * T(fan.middle.x) + gy * T(fan.middle.y));
    return sum * phase_of(shift);
  }
  /// Mean of exp(-2 pi i a) over a triangle with the phases 0, a and b at its corners.
  static Complex<T> triangle_mean(const T& a, const T& b) {
    const double u = value_of(a), v = value_of(b);
    const Complex<double> h = phase_divided_difference(std::array{0.0, u, v});
    if constexpr (requires { a.a; }) {
      const Complex<double> by_a = phase_divided_difference(std::array{0.0, u, u, v}),
                            by_b = phase_divided_difference(std::array{0.0, u, v, v});  // by z = -2 pi i a
      const double c = 4.0 * kPi;
      return {lift({2.0 * h.re, c * by_a.im}, a) + lift({0.0, c * by_b.im}, b),
              lift({2.0 * h.im, -c * by_a.re}, a) + lift({0.0, -c * by_b.re}, b)};
    } else {
      return {T(2.0 * h.re), T(2.0 * h.im)};
    }
  }
};

}  // namespace mtf
