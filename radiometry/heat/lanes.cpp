// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/lanes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "mtf/math/simd.h"
#include "radiometry/heat/surface_loss.h"

// Plain loops over the lanes, which the compiler turns into vectors of the widest kind of the machine (simd::run).
#define MTFKIT_LANES(l) for (std::size_t l = 0; l < kLanes; ++l)

namespace radiometry::heat {
namespace {

/// x^(1/3) for x >= 0: a third of the exponent, then three of Halley's steps (an error e becomes 2/3 e^3, from 0.05).
MTFKIT_INLINE double cube_root(double x) {
  const auto bits = std::bit_cast<std::int32_t>(static_cast<float>(x) + 1e-30f);
  double r = std::bit_cast<float>(bits / 3 + 709921077);
  for (int i = 0; i < 3; ++i) {
    const double cube = r * r * r;
    r *= (cube + 2.0 * x) / (2.0 * cube + x);
  }
  return r;
}

/// What a film carries: heat by the wind; by buoyancy too; vapour too.
enum class Film { forced, natural, wet };

/// As SurfaceLoss::at.
template <Film F>
MTFKIT_INLINE LossAndSlope loss_of(const Surface& surface, const Buoyancy& buoyancy, std::size_t l, double t) {
  const double cube = t * t * std::abs(t), excess = t - surface.air_k;
  LossAndSlope sum{surface.emission * cube * t + surface.film * excess, 4.0 * surface.emission * cube + surface.film};
  if constexpr (F != Film::forced) {
    const double c = (excess > 0.0 ? buoyancy.warm[l] : buoyancy.cold[l]) * cube_root(std::abs(excess));
    sum.loss += c * excess;
    sum.slope += 4.0 / 3.0 * c;
  }
  if constexpr (F == Film::wet) {
    const Vapour at_surface = saturation(t);
    sum.loss += surface.latent * (at_surface.pressure_pa - surface.vapour_pa);
    sum.slope += surface.latent * at_surface.slope_pa_k;
  }
  return sum;
}

template <Film F>
MTFKIT_INLINE double net(const Surface& surface, const Buoyancy& buoyancy, std::size_t l, double t) {
  return surface.absorbed[l] - loss_of<F>(surface, buoyancy, l, t).loss;
}

MTFKIT_INLINE double inside_flow(const GroupGrid& group, double inside, double t) {
  return group.inner_flux ? inside : group.grid->inner_w_m2_k * (inside - t);
}

/// b of the end nodes += weight * (flow over the boundaries at `at`)
template <Sides S, Film F>
MTFKIT_INLINE void add_boundary_flow(const GroupGrid& group, const Boundary& at, double weight,
                                     const double* __restrict t, double* __restrict b) {
  const std::size_t last = (group.grid->nodes() - 1) * kLanes;
  MTFKIT_LANES(l) b[l] += weight * net<F>(at.front, *group.front_buoyancy, l, t[l]);
  if constexpr (S == Sides::one)
    MTFKIT_LANES(l) b[last + l] += weight * inside_flow(group, at.inside, t[last + l]);
  else
    MTFKIT_LANES(l) b[last + l] += weight * net<F>(at.back, *group.back_buoyancy, l, t[last + l]);
}

/// Increments of earlier stages, with their weights in a right-hand side.
struct Increments {
  double of_first;
  const double* first;
  double of_second;
  const double* second;  ///< only where Second
};

/// Right-hand side and forward elimination in one sweep from the inside outwards:
///   b = [flows over the boundaries, in b of the end nodes] + M (increments) + weight (-K T) + source
template <Sides S, bool Second>
MTFKIT_INLINE void sweep_outwards(const Grid& grid, const Elimination<double>& e, double weight,
                                  const Increments& increments, const double* source, const double* __restrict t,
                                  double* __restrict b) {
  const std::size_t n = grid.nodes();
  double* back = b + (n - 1) * kLanes;
  Lanes inner;  // flow to the node inside of this one
  for (std::size_t i = n; i-- > 0;) {
    const double m = grid.capacity[i], g = i > 0 ? weight * grid.conductance[i - 1] : 0.0;
    const double forward = i + 1 < n ? e.forward[i + 1] : 0.0;
    const double* here = t + i * kLanes;
    const double* outer = i > 0 ? here - kLanes : here;
    const double* first = increments.first + i * kLanes;
    const double* second = increments.second + i * kLanes;
    double* row = b + i * kLanes;
    const double* eliminated = i + 1 < n ? row + kLanes : row;
    const bool end = i == 0 || i + 1 == n;
    MTFKIT_LANES(l) {
      const double flow = g * (outer[l] - here[l]);
      double sum = increments.of_first * m * first[l] + (flow - inner[l]) + forward * eliminated[l];
      if constexpr (Second) sum += increments.of_second * m * second[l];
      row[l] = end ? row[l] + sum : sum;
      inner[l] = flow;
    }
    if (source != nullptr) MTFKIT_LANES(l) row[l] += source[i];
    if constexpr (S == Sides::two)
      if (!end) MTFKIT_LANES(l) back[l] += e.to_back[i] * row[l];
  }
}

/// Back substitution: increments and temperatures of the nodes but the first (and of a sheet the last).
template <Sides S>
MTFKIT_INLINE void sweep_inwards(const Elimination<double>& e, std::size_t nodes, const double* __restrict b,
                                 double* __restrict d, double* __restrict t) {
  const std::size_t last = (nodes - 1) * kLanes;
  MTFKIT_LANES(l) t[l] += d[l];
  for (std::size_t i = 1; i < e.end; ++i) {
    const double inverse = e.inverse[i], forward = e.forward[i], to_back = e.to_back[i];
    const double* row = b + i * kLanes;
    const double* outer = d + (i - 1) * kLanes;
    double* here = d + i * kLanes;
    double* temperature = t + i * kLanes;
    MTFKIT_LANES(l) {
      double sum = inverse * row[l] + forward * outer[l];
      if constexpr (S == Sides::two) sum += to_back * d[last + l];
      here[l] = sum;
      temperature[l] += sum;
    }
  }
  if constexpr (S == Sides::two) MTFKIT_LANES(l) t[last + l] += d[last + l];
}

MTFKIT_INLINE void clear_ends(std::size_t nodes, double* b) {
  MTFKIT_LANES(l) b[l] = b[(nodes - 1) * kLanes + l] = 0.0;
}

/// Newton's method ends when no lane moved by more: it is quadratic, so what is left is below the rounding.
constexpr double kLastMove_k = 1e-5;
constexpr int kMostIterations = 60;

/// x: the increments of the front node; on one node, the losses of both sides.
template <Sides S, Film F>
MTFKIT_INLINE void solve_one(const GroupGrid& group, const Elimination<double>& e, const Boundary& at,
                             const double* __restrict t, const double* __restrict b, double* __restrict x) {
  Lanes at_start;
  const auto loss = [&](std::size_t l, double temperature) {
    LossAndSlope sum = loss_of<F>(at.front, *group.front_buoyancy, l, temperature);
    if constexpr (S == Sides::two_on_one_node) {
      const LossAndSlope other = loss_of<F>(at.back, *group.back_buoyancy, l, temperature);
      sum.loss += other.loss;
      sum.slope += other.slope;
    }
    return sum;
  };
  MTFKIT_LANES(l) {
    const LossAndSlope start = loss(l, t[l]);
    at_start[l] = start.loss;
    x[l] = b[l] / (e.own + e.a * start.slope);
  }
  for (int i = 0; i < kMostIterations; ++i) {
    int moving = 0;
    MTFKIT_LANES(l) {
      const LossAndSlope now = loss(l, t[l] + x[l]);
      const double move = (e.own * x[l] + e.a * (now.loss - at_start[l]) - b[l]) / (e.own + e.a * now.slope);
      x[l] -= move;
      moving += std::abs(move) > kLastMove_k;
    }
    if (moving == 0) break;
  }
}

/// x and y: the increments of the front and the back node of a sheet.
template <Film F>
MTFKIT_INLINE void solve_two(const GroupGrid& group, const Elimination<double>& e, const Boundary& at, const double* t,
                             const double* t_back, const double* b, const double* b_back, double* x, double* y) {
  Lanes front_start, back_start;
  MTFKIT_LANES(l) {
    front_start[l] = loss_of<F>(at.front, *group.front_buoyancy, l, t[l]).loss;
    back_start[l] = loss_of<F>(at.back, *group.back_buoyancy, l, t_back[l]).loss;
    x[l] = y[l] = 0.0;
  }
  for (int i = 0; i < kMostIterations; ++i) {
    int moving = 0;
    MTFKIT_LANES(l) {
      const LossAndSlope f = loss_of<F>(at.front, *group.front_buoyancy, l, t[l] + x[l]);
      const LossAndSlope k = loss_of<F>(at.back, *group.back_buoyancy, l, t_back[l] + y[l]);
      const double between = e.mutual * (x[l] - y[l]);
      const double rest = e.own * x[l] + between + e.a * (f.loss - front_start[l]) - b[l];
      const double rest_back = e.back_own * y[l] - between + e.a * (k.loss - back_start[l]) - b_back[l];
      const double p = e.own + e.a * f.slope, q = e.back_own + e.a * k.slope;
      const double determinant = p * q + e.mutual * (p + q);
      const double move = (q * rest + e.mutual * (rest + rest_back)) / determinant;
      const double move_back = (p * rest_back + e.mutual * (rest + rest_back)) / determinant;
      x[l] -= move;
      y[l] -= move_back;
      moving += (std::abs(move) > kLastMove_k) | (std::abs(move_back) > kLastMove_k);
    }
    if (moving == 0) break;
  }
}

template <Sides S, Film F>
struct Stage {
  template <int Bytes>
  static MTFKIT_INLINE void run(const GroupGrid* group, const StageRequest* request, const double* source,
                                double* __restrict t, double* __restrict d, double* __restrict b) {
    const Grid& grid = *group->grid;
    const Elimination<double>& e = *request->elimination;
    const std::size_t n = grid.nodes(), last = (n - 1) * kLanes;
    clear_ends(n, b);
    if (request->before) add_boundary_flow<S, F>(*group, *request->before, e.a, t, b);
    add_boundary_flow<S, F>(*group, *request->at, e.a, t, b);
    sweep_outwards<S, false>(grid, e, (request->before ? 2.0 : 1.0) * e.a, {request->keep, d, 0.0, d}, source, t, b);
    if constexpr (S == Sides::two)
      solve_two<F>(*group, e, *request->at, t, t + last, b, b + last, d, d + last);
    else
      solve_one<S, F>(*group, e, *request->at, t, b, d);
    sweep_inwards<S>(e, n, b, d, t);
  }
};

template <Sides S, Film F>
struct SurfaceError {
  template <int Bytes>
  static MTFKIT_INLINE void run(const GroupGrid* group, const Elimination<double>* elimination,
                                const ErrorWeights* weights, const Boundary* at, const double* source, const double* t,
                                const double* first, const double* second, double* b, double* worst) {
    const Grid& grid = *group->grid;
    const Elimination<double>& e = *elimination;
    const std::size_t n = grid.nodes(), last = (n - 1) * kLanes;
    clear_ends(n, b);
    add_boundary_flow<S, F>(*group, *at, weights->of_flow * e.a, t, b);
    sweep_outwards<S, true>(grid, e, weights->of_flow * e.a, {weights->of_first, first, weights->of_second, second},
                            source, t, b);
    Lanes error;
    MTFKIT_LANES(l) {
      double p = e.own + e.a * loss_of<F>(at->front, *group->front_buoyancy, l, t[l]).slope;
      if constexpr (S == Sides::one) {
        error[l] = std::abs(b[l] / p);
      } else {
        const double back = e.a * loss_of<F>(at->back, *group->back_buoyancy, l, t[last + l]).slope;
        if constexpr (S == Sides::two) {
          const double q = e.back_own + back, both = e.mutual * (b[l] + b[last + l]);
          const double determinant = p * q + e.mutual * (p + q);
          error[l] = std::max(std::abs(q * b[l] + both), std::abs(p * b[last + l] + both)) / determinant;
        } else {
          error[l] = std::abs(b[l] / (p + back));
        }
      }
    }
    for (const double one : error.at)
      if (!(one <= *worst)) *worst = one;  // a NaN stays
  }
};

/// What the nodes get from sources, times a weight, added.
void add_sources(const Grid& grid, const Boundary& at, double weight, std::vector<double>& sum) {
  const std::size_t layers = at.source_w_m3.size();
  if (layers == 0) return;
  sum.resize(grid.nodes(), 0.0);
  for (std::size_t i = 0; i < sum.size(); ++i)
    for (std::size_t k = 0; k < layers; ++k) sum[i] += weight * grid.layer_m[i * layers + k] * at.source_w_m3[k];
}

const double* data_of(const std::vector<double>& sources) { return sources.empty() ? nullptr : sources.data(); }

template <Sides S, Film F>
struct AddHeat {
  template <int Bytes>
  static MTFKIT_INLINE void run(const GroupGrid* group, const Boundary* at, const double* t, double duration_s,
                                HeatSums* sums) {
    const std::size_t last = (group->grid->nodes() - 1) * kLanes;
    const auto side = [&](const Surface& surface, const Buoyancy& buoyancy, const double* temperature) {
      MTFKIT_LANES(l) {
        const double t4 =
            surface.emission * temperature[l] * temperature[l] * temperature[l] * std::abs(temperature[l]);
        sums->absorbed[l] += duration_s * surface.absorbed[l];
        sums->emitted[l] += duration_s * t4;
        sums->convected[l] += duration_s * (loss_of<F>(surface, buoyancy, l, temperature[l]).loss - t4);
      }
    };
    side(at->front, *group->front_buoyancy, t);
    if constexpr (S == Sides::one)
      MTFKIT_LANES(l) sums->inside[l] += duration_s * inside_flow(*group, at->inside, t[last + l]);
    else
      side(at->back, *group->back_buoyancy, t + last);
  }
};

template <template <Sides, Film> class Kernel, class... A>
void run_for(const GroupGrid& group, A... a) {
  const Film film = group.wet                                                       ? Film::wet
                    : group.front_buoyancy->present || group.back_buoyancy->present ? Film::natural
                                                                                    : Film::forced;
  const auto with = [&]<Sides S>() {
    if (film == Film::forced) return mtf::simd::run<Kernel<S, Film::forced>>(a...);
    if (film == Film::natural) return mtf::simd::run<Kernel<S, Film::natural>>(a...);
    return mtf::simd::run<Kernel<S, Film::wet>>(a...);
  };
  if (group.sides == Sides::one) return with.template operator()<Sides::one>();
  if (group.sides == Sides::two_on_one_node) return with.template operator()<Sides::two_on_one_node>();
  return with.template operator()<Sides::two>();
}

}  // namespace

void run_stage(const GroupGrid& group, const StageRequest& request, std::vector<double>& t, std::vector<double>& d,
               std::vector<double>& scratch) {
  std::vector<double> sources;
  if (request.before) add_sources(*group.grid, *request.before, request.elimination->a, sources);
  add_sources(*group.grid, *request.at, request.elimination->a, sources);
  run_for<Stage>(group, &group, &request, data_of(sources), t.data(), d.data(), scratch.data());
}

double surface_error(const GroupGrid& group, const Elimination<double>& elimination, const ErrorWeights& weights,
                     const Boundary& at, const std::vector<double>& t, const std::vector<double>& first,
                     const std::vector<double>& second, std::vector<double>& scratch) {
  double worst = 0.0;
  std::vector<double> sources;
  add_sources(*group.grid, at, weights.of_flow * elimination.a, sources);
  run_for<SurfaceError>(group, &group, &elimination, &weights, &at, data_of(sources), t.data(), first.data(),
                        second.data(), scratch.data(), &worst);
  return worst;
}

void add_heat(const GroupGrid& group, const Boundary& at, const std::vector<double>& t, double duration_s,
              HeatSums& sums) {
  run_for<AddHeat>(group, &group, &at, t.data(), duration_s, &sums);
  std::vector<double> sources;
  add_sources(*group.grid, at, duration_s, sources);
  for (const double source : sources) MTFKIT_LANES(l) sums.inside[l] += source;
}

}  // namespace radiometry::heat
