// SPDX-License-Identifier: Apache-2.0
#include "mtf/components/pupil/defocus_pupil.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "mtf/components/pupil/pupil.h"
#include "mtf/math/quadrature.h"
#include "mtf/math/special.h"

namespace mtf {
namespace {

using Cplx = std::complex<double>;

constexpr int kNodes = 32;
constexpr double kFewCycles = 24.0;  // phase up to which kNodes resolve the integrand; beyond, the path of descent

// Integrals over 0..angle of exp(i K cos t) times these weights: what an area, its derivative by k, a moving arc along
// x and a growing arc need.
struct ArcIntegrals {
  Cplx area{};    // sin^2 t
  Cplx moment{};  // sin^2 t cos t
  Cplx shift{};   // cos t
  Cplx length{};  // 1

  void add(const Cplx& weight, const Cplx& cosine, const Cplx& sine_square) {
    area += weight * sine_square;
    moment += weight * sine_square * cosine;
    shift += weight * cosine;
    length += weight;
  }
};

// Gauss-Legendre in t; `exponential` is exp(i K cos t), or that less 1.
template <class F>
ArcIntegrals on_the_arc(double angle, const F& exponential) {
  ArcIntegrals sum;
  const GaussRule& rule = gauss_legendre(kNodes);
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double t = 0.5 * angle * (1.0 + rule.node[i]), c = std::cos(t), s = std::sin(t);
    sum.add(0.5 * angle * rule.weight[i] * exponential(c), c, s * s);
  }
  return sum;
}

// For many cycles: with u = 1 - cos t the integrand is exp(i K (1 - u)) g(u) / sqrt(u (2 - u)) du over 0..U, and falls
// as exp(-K |Im u|) below the real axis. The path goes down from u = 0, back up to U; with u = u0 - i q^2/K both legs
// are smooth in q and of Gaussian decay (steepest descent, exact here: no terms are left out).
ArcIntegrals by_descent(double angle, double k) {
  constexpr double kReach = 6.2;  // exp(-6.2^2) = 2e-17
  const double half_sine = std::sin(0.5 * angle), u_end = 2.0 * half_sine * half_sine;
  ArcIntegrals sum;
  const GaussRule& rule = gauss_legendre(kNodes);
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double q = 0.5 * kReach * (1.0 + rule.node[i]), weight = 0.5 * kReach * rule.weight[i] * std::exp(-q * q);
    const Cplx down(0.0, -q * q / k);
    // From u = 0: du / sqrt(u) = 2 sqrt(-i/K) dq.
    const Cplx root = std::sqrt(2.0 / k) * Cplx(1.0, -1.0);
    sum.add(weight * root / std::sqrt(2.0 - down), 1.0 - down, down * (2.0 - down));
    const Cplx u = u_end + down;
    const Cplx back = std::polar(1.0, -k * u_end) * Cplx(0.0, 2.0 * q / k) / std::sqrt(u * (2.0 - u));
    sum.add(weight * back, 1.0 - u, u * (2.0 - u));
  }
  const Cplx start = std::polar(1.0, k);
  return {start * sum.area, start * sum.moment, start * sum.shift, start * sum.length};
}

// 0..angle, angle up to pi, k >= 0.
ArcIntegrals arc_integrals(double angle, double k) {
  if (angle <= 0.5 * kPi) {
    if (k * (1.0 - std::cos(angle)) > kFewCycles) return by_descent(angle, k);
    return on_the_arc(angle, [k](double cosine) { return std::polar(1.0, k * cosine); });
  }
  // The whole half circle by Bessel functions, less the rest; t -> pi - t turns the sign of cos t.
  const double half_jinc = 0.5 * jinc(k).value, j0 = ::j0(k), j1 = ::j1(k);
  ArcIntegrals all{kPi * half_jinc, Cplx(0.0, -kPi * 0.5 * jinc(k).slope), Cplx(0.0, kPi * j1), kPi * j0};
  if (angle >= kPi) return all;
  const ArcIntegrals rest = arc_integrals(kPi - angle, k);
  return {all.area - std::conj(rest.area), all.moment + std::conj(rest.moment), all.shift + std::conj(rest.shift),
          all.length - std::conj(rest.length)};
}

}  // namespace

DefocusOtf defocus_pupil_otf(double nu, double obscuration, double w020_waves) {
  const double e = std::min(obscuration, 1.0 - 0x1p-53);
  const PupilMtf focused = annular_pupil_mtf(nu, e);
  const double waves = std::abs(w020_waves), k = 8.0 * kPi * waves * nu;
  if (!(nu < 1.0) || k == 0.0) return {focused.value, focused.d_nu, focused.d_obscuration, 0.0};

  // Little phase: the integral of cos(k x) - 1 is added to the exact MTF in focus, so that nothing exceeds 1.
  const bool little = k <= 1.0;
  double value = 0.0, d_k = 0.0, d_distance = 0.0, d_hole = 0.0;
  for (const PupilCap& cap : pupil_caps(nu, e)) {
    const double r = cap.radius, start = k * cap.centre * cap.side;
    ArcIntegrals arc;
    Cplx turn{1.0, 0.0};
    if (little) {
      arc = on_the_arc(cap.angle, [&](double cosine) {
        const double half = 0.5 * (start + k * r * cosine), s = std::sin(half);
        return Cplx(-2.0 * s * s, 2.0 * s * std::cos(half));
      });
    } else {
      arc = arc_integrals(cap.angle, k * r);
      turn = std::polar(1.0, start);
    }
    // x counted from the cap's side: mirrored caps give the same real part.
    value += cap.sign * 2.0 * r * r * (turn * arc.area).real();
    d_k -= cap.sign * 2.0 * r * r * (turn * (cap.side * cap.centre * arc.area + r * arc.moment)).imag();
    d_distance -= cap.sign * r * (turn * arc.shift).real();
    if (cap.hole) d_hole += cap.sign * 2.0 * r * (turn * arc.length).real();
  }
  const double ring = (1.0 - e) * (1.0 + e), scale = 1.0 / (kPi * ring);
  const double d_k_total = scale * d_k;
  DefocusOtf h{scale * value, 2.0 * scale * d_distance, scale * d_hole, 8.0 * kPi * nu * d_k_total};
  if (e > 0.0) h.d_obscuration += 2.0 * e / ring * h.value;
  if (little) {
    h.value += focused.value;
    h.d_nu += focused.d_nu;
    h.d_obscuration += focused.d_obscuration;
  }
  h.d_nu += 8.0 * kPi * waves * d_k_total;
  if (w020_waves < 0.0) h.d_w020 = -h.d_w020;
  return h;
}

}  // namespace mtf
