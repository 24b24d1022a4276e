// SPDX-License-Identifier: Apache-2.0
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/giqe.h"
#include "radiometry/performance/mdtd.h"
#include "radiometry/performance/thermal_detector.h"
#include "radiometry/performance/ttp.h"
#include "tests/radiometry/performance_cases.h"

// One body for double and Jet: derivatives by every parameter against central differences, to 1e-6 of the largest
// (parameter x derivative), five points where the model allows, so that the differences are better than that.

namespace radiometry {
namespace {

using test::gaussian_mtf;

/// `model` takes an array of any scalar and returns one.
template <std::size_t N, class Model>
void expect_gradient(const Model& model, const std::array<double, N>& at) {
  using Jet = ceres::Jet<double, static_cast<int>(N)>;
  std::array<Jet, N> x;
  for (std::size_t i = 0; i < N; ++i) x[i] = Jet(at[i], static_cast<int>(i));
  const Jet value = model(x);
  EXPECT_NEAR(value.a, model(at), 1e-12 * std::abs(value.a));
  std::array<double, N> by_difference{};
  double largest = 0.0;
  for (std::size_t i = 0; i < N; ++i) {
    const auto g = [&](double factor) {
      std::array<double, N> moved = at;
      moved[i] *= factor;
      return model(moved);
    };
    by_difference[i] = slope_at(g, 1.0, 1e-3);
    largest = std::max(largest, std::abs(by_difference[i]));
  }
  ASSERT_GT(largest, 0.0);
  for (std::size_t i = 0; i < N; ++i)
    EXPECT_NEAR(value.v[static_cast<Eigen::Index>(i)] * at[i], by_difference[i], 1e-6 * largest) << "parameter " << i;
}

TEST(PerformanceJets, niirs) {
  const auto giqe4 = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const Giqe4Input<S> in{
        .gsd_m = x[0], .rer = x[1], .overshoot = x[2], .noise_gain = x[3], .snr = x[4], .elevation_deg = x[5]};
    return S(niirs_giqe4(in) + S(2) * niirs_giqe3(in));
  };
  expect_gradient(giqe4, std::array{0.5, 0.7, 1.2, 2.0, 20.0, 50.0});
  expect_gradient(giqe4, std::array{0.5, 1.1, 1.2, 2.0, 20.0, 50.0});
  const auto giqe5 = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    return niirs_giqe5(Giqe5Input<S>{.gsd_m = x[0], .rer_x = x[1], .rer_y = x[2], .snr = x[3], .elevation_deg = x[4]});
  };
  expect_gradient(giqe5, std::array{0.5, 0.5, 0.4, 5.0, 40.0});
  expect_gradient(giqe5, std::array{0.5, 0.2, 0.9, 50.0, 70.0});
}

// Without noise, and overhead where the projection is flat: no NaN in the derivatives.
TEST(PerformanceJets, niirs_at_its_limits) {
  using Jet = ceres::Jet<double, 2>;
  const Jet value = niirs_giqe5(Giqe5Input<Jet>{.gsd_m = Jet(0.5),
                                                .rer_x = Jet(0.5),
                                                .rer_y = Jet(0.5),
                                                .snr = Jet(std::numeric_limits<double>::infinity(), 0),
                                                .elevation_deg = Jet(90.0, 1)});
  EXPECT_EQ(value.v[0], 0.0);
  EXPECT_EQ(value.v[1], 0.0);
}

TEST(PerformanceJets, ground_resolved_distance) {
  const auto model = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const GrdInput<S> in{.snr = x[1], .ifov_mrad = x[2], .range_m = x[3]};
    return ground_resolved_distance(in, [&](double f) { return gaussian_mtf<S>(f, x[0]); }).grd_m;
  };
  expect_gradient(model, std::array{2.0, 20.0, 0.1, 1e3});  // by the MTF
  expect_gradient(model, std::array{2.0, 1e9, 0.5, 1e3});   // by the samples
}

template <class S, class Numbers>
AxisTtp<S> ttp_at(const Numbers& x) {
  const auto s = test::sensitivity_of<S>(x);
  return axis_ttp(sensitivity_course(s, 100.0), s, x[7]);
}

TEST(PerformanceJets, ttp_and_its_band) {
  // The model of the eye is a number that no derivative is asked for: the first scalar is taken without its own.
  const auto model = [](const auto& y) {
    using S = std::decay_t<decltype(y[0])>;
    return ttp_at<S>(std::array<S, 8>{S(2), y[0], y[1], y[2], y[3], y[4], y[5], y[6]}).value;
  };
  expect_gradient(model, std::array{34.26, 10.0, 10.0, 0.9, 1.5, 4.0, 0.2});
  expect_gradient(model, std::array{34.26, 10.0, 1.0, 0.9, 1.2, 4.0, 0.01});
}

/// The root of a margin with its derivatives, as studies take them: solved with plain numbers, then one step of
/// Newton's. `margin`: scalars and range -> ln of what is offered over what is needed.
template <class S, std::size_t N, class Margin>
S range_of(const std::array<S, N>& x, const Margin& margin) {
  std::array<double, N> plain;
  for (std::size_t i = 0; i < N; ++i) plain[i] = mtf::value_of(x[i]);
  const auto of_range = [&](double range_m) { return margin(plain, range_m); };
  const double range_m = longest_range(of_range, 1e-6, 1e8, 1e3).range_m;
  const double slope = slope_at([&](double l) { return std::expm1(of_range(std::exp(l))); }, std::log(range_m), 1e-4);
  return range_with_slopes(range_m, S(margin(x, range_m)), slope);
}

TEST(PerformanceJets, ttp_range) {
  const auto model = [](const auto& y) {
    return range_of(y, [](const auto& x, double range_m) {
      using std::exp;
      using std::log;
      using S = std::decay_t<decltype(x[0])>;
      const auto s = test::sensitivity_of<S>(std::array<S, 7>{S(0), S(34.26), S(15), x[0], S(1), x[1], x[2]});
      const auto other = test::sensitivity_of<S>(std::array<S, 7>{S(0), S(34.26), S(15), x[0], S(1), x[1], S(3)});
      const S contrast = x[4] * exp(S(-1e-3 * range_m) * x[5]);
      const S ttp = ttp_of(axis_ttp(sensitivity_course(s, 100.0), s, contrast),
                           axis_ttp(sensitivity_course(other, 100.0), other, contrast));
      return S(log(cycles_on_target(ttp, x[3], S(range_m)) / x[6]));
    });
  };
  expect_gradient(model, std::array{10.0, 1.2, 4.0, 3.1, 0.2, 0.2, 13.0});
  expect_gradient(model, std::array{10.0, 1.2, 4.0, 3.1, 0.1, 1.0, 4.0});
}

/// The first eleven numbers.
template <class S, std::size_t n>
MrtdInput<S> mrtd_input(const std::array<S, n>& x) {
  return {.tvh_k = x[0],
          .vh_k = x[1],
          .th_k = x[2],
          .tv_k = x[3],
          .h_k = x[4],
          .v_k = x[5],
          .spacing_x_mrad = x[6],
          .spacing_y_mrad = x[7],
          .snr_threshold = x[8],
          .eye_time_s = x[9],
          .frame_rate_hz = x[10]};
}

TEST(PerformanceJets, mrtd) {
  for (const mtf::Axis axis : {mtf::Axis::x, mtf::Axis::y})
    for (const double f : {0.05, 1.0, 3.0}) {
      const auto model = [&](const auto& x) {
        using S = std::decay_t<decltype(x[0])>;
        const MrtdInput<S> in = mrtd_input(x);
        const auto noise = [&](double g) { return gaussian_mtf<S>(g, x[12]); };
        return mrtd_k(
            in, axis, f, [&](double g) { return gaussian_mtf<S>(g, x[11]); }, noise, noise);
      };
      expect_gradient(model, std::array{0.05, 0.02, 0.01, 0.015, 0.007, 0.009, 0.1, 0.12, 2.5, 0.1, 60.0, 2.0, 4.0});
    }
}

TEST(PerformanceJets, mdtd) {
  for (const double w : {0.05, 0.3, 4.0}) {
    const auto model = [&](const auto& x) {
      using S = std::decay_t<decltype(x[0])>;
      const MrtdInput<S> in = mrtd_input(x);
      const auto h = [&](double g) { return gaussian_mtf<S>(g, x[11]); };
      const auto noise = [&](double g) { return gaussian_mtf<S>(g, x[12]); };
      return mdtd_k(in, w, S(20), h, h, noise, noise);
    };
    expect_gradient(model, std::array{0.05, 0.02, 0.01, 0.015, 0.007, 0.009, 0.1, 0.12, 2.5, 0.1, 60.0, 2.0, 4.0});
  }
}

/// A camera's MRTD along both axes, and the range it gives.
TEST(PerformanceJets, mrtd_2d_and_johnson) {
  const auto camera = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    return MrtdInput<S>{
        .tvh_k = x[0], .vh_k = x[1], .spacing_x_mrad = x[2], .spacing_y_mrad = x[3], .frame_rate_hz = S(60)};
  };
  const auto along = [camera](const auto& x, mtf::Axis axis) {
    using S = std::decay_t<decltype(x[0])>;
    const MrtdInput<S> in = camera(x);
    const S a = axis == mtf::Axis::x ? x[4] : x[5];
    return [in, a, axis](double f) {
      const auto h = [&](double g) { return gaussian_mtf<S>(g, a); };
      return mrtd_k(in, axis, f, h, h, h);
    };
  };
  const auto two = [along](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    return mrtd_2d_k<S>(1.5, along(x, mtf::Axis::x), along(x, mtf::Axis::y));
  };
  expect_gradient(two, std::array{0.05, 0.02, 0.1, 0.12, 2.0, 3.0});
  const auto range = [along](const auto& y) {
    return range_of(y, [along](const auto& x, double range_m) {
      using std::log;
      using S = std::decay_t<decltype(x[0])>;
      const S f = S(1e-3 * range_m) * x[9] / x[6];
      const auto mrtd = [&](double at) { return mrtd_2d_k<S>(at, along(x, mtf::Axis::x), along(x, mtf::Axis::y)); };
      const double middle = mtf::value_of(f);
      return S(log(x[7] / continued(mrtd, middle, f, 1e-3 * middle)) - S(1e-3 * range_m) * x[8]);
    });
  };
  expect_gradient(range, std::array{0.05, 0.02, 0.1, 0.12, 2.0, 3.0, 2.3, 1.25, 0.2, 3.0});
}

TEST(PerformanceJets, observer) {
  const auto model = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const Observer<S> o{.luminance_cd_m2 = x[0], .field_deg = x[1], .magnification = x[2]};
    const auto post = [&](double f) { return eye_mtf_at(o, S(f)); };
    const S density = noise_density(x[3], x[4], S(0.1), x[5]);
    const S q = channel_bandwidth<S>(0.8, post), across = bandwidth<S>(20.0, post);
    const S factor = noise_factor(observer_alpha(o), density, q, across, x[6]);
    return S(minimum_resolvable_k(x[6], system_sensitivity(o, 0.8, gaussian_mtf<S>(0.8, x[7]), factor)));
  };
  expect_gradient(model, std::array{34.26, 10.0, 4.0, 0.05, 0.1, 30.0, 2.0, 2.0});
}

TEST(PerformanceJets, probability) {
  for (const Psychometric p : {Psychometric::ttp_nvthermip, Psychometric::ttp_nvipm, Psychometric::johnson})
    for (const double at : {0.2, 0.99, 3.0})
      expect_gradient([&](const auto& x) { return task_probability(p, x[0]); }, std::array{at});
}

TEST(PerformanceJets, noise_of_a_bolometer) {
  const auto noise_w = [](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const ThermalBody<S> body{.heat_capacity_j_k = x[0], .conductance_w_k = x[1], .temperature_k = x[2]};
    const BolometerReadout<S> readout{.resistance_ohm = x[3],
                                      .tcr_per_k = x[4],
                                      .bias_v = x[5],
                                      .corner_hz = x[6],
                                      .lowest_hz = x[7],
                                      .readout_v = x[8],
                                      .bandwidth_hz = x[9]};
    return bolometer_noise(body, readout).total_w();
  };
  expect_gradient(noise_w, std::array{3e-10, 3e-8, 300.0, 1e5, -0.02, 2.0, 1e3, 0.01, 2e-6, 8e3});
  expect_gradient(noise_w, std::array{3e-10, 3e-8, 300.0, 1e5, 0.02, 20.0, 10.0, 0.01, 2e-6, 40.0});
}

}  // namespace
}  // namespace radiometry
