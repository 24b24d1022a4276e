// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/math/special.h"
#include "tests/mtf/components/one_component.h"

namespace mtf::test {
namespace {

Component<double> polygon(Taps<double> vertices, double unit_um = 17.0) {
  auto c = Component<double>::make("polygon_footprint");
  *std::get<Taps<double>*>(field(c, "vertices").value) = std::move(vertices);
  set(c, "unit_length", unit_um, "um");
  return c;
}

Taps<double> box(double left, double right, double top, double bottom) {
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

double distance(const Complex<double>& a, const Complex<double>& b) { return std::hypot(a.re - b.re, a.im - b.im); }

Complex<double> box_transform(double left, double right, double top, double bottom, double fx, double fy) {
  const double h = sinc((right - left) * fx).value * sinc((bottom - top) * fy).value;
  const Complex<double> phase = phase_of((left + right) * fx + (top + bottom) * fy);
  return {h * phase.re, h * phase.im};
}

const std::vector<Freq<double>> kFrequencies{
    {0.0, 0.0},    {5e-324, 0.0}, {1e-12, -1e-9}, {0.3, 0.0},  {0.0, 7.0},     {29.0, 29.0}, {29.0, -29.0},
    {58.8, 117.6}, {80.0, 1e-13}, {-200.0, 90.0}, {1e3, 1e-3}, {470.0, 333.0}, {1e6, -2.5e5}};

// Flat to flat 1, f in units of 1/width: towards a corner as published, across the flats by integrating the profile.
TEST(PolygonFootprint, hexagon) {
  const double r = 1.0 / std::sqrt(3.0);
  Taps<double> hexagon;
  for (int k = 0; k < 6; ++k) hexagon.push_back({r * sin_pi(k / 3.0), r * cos_pi(k / 3.0)});
  const auto c = polygon(hexagon, 1000.0);  // 1 mm
  const std::array corner{.916756, .694503, .404067}, flat{.9167579453, .6946030046, .4050671276};
  for (std::size_t i = 0; i < 3; ++i) {
    const double f = 0.25 * static_cast<double>(i + 1);
    EXPECT_NEAR(modulus(otf_at(c, 0.0, f)), corner[i], 5.01e-7) << i;
    EXPECT_NEAR(modulus(otf_at(c, f, 0.0)), flat[i], kTenDigits) << i;
  }
}

TEST(PolygonFootprint, square_is_the_rectangular_footprint) {
  const auto square = polygon(box(-0.5, 0.5, -0.5, 0.5));
  for (const auto& f : kFrequencies) {
    const Complex<double> h = otf_at(square, f.x, f.y);
    EXPECT_NEAR(h.re, otf_at(footprint(17.0), f.x, f.y).re, 2e-15) << f.x << " " << f.y;
    EXPECT_EQ(h.im, 0.0);
  }
}

// Off-centre: the phase of its centroid. Either sense of the outline.
TEST(PolygonFootprint, l_shape_is_two_rectangles) {
  const Taps<double> shape{{-0.5, -0.5}, {0.5, -0.5}, {0.5, -0.1}, {0.1, -0.1}, {0.1, 0.5}, {-0.5, 0.5}};
  Taps<double> back(shape.rbegin(), shape.rend());
  const double a = 1.0 * 0.4, b = 0.6 * 0.6;
  for (const auto& f : kFrequencies) {
    const double u = f.x * 0.017, v = f.y * 0.017;
    const Complex<double> wide = box_transform(-0.5, 0.5, -0.5, -0.1, u, v),
                          tall = box_transform(-0.5, 0.1, -0.1, 0.5, u, v);
    const Complex<double> h{(a * wide.re + b * tall.re) / (a + b), (a * wide.im + b * tall.im) / (a + b)};
    const double tolerance = 4e-15 * (1.0 + std::hypot(u, v) / (1.0 + std::hypot(u, v)));
    EXPECT_LE(distance(otf_at(polygon(shape), f.x, f.y), h), tolerance) << f.x << " " << f.y;
    EXPECT_LE(distance(otf_at(polygon(back), f.x, f.y), h), tolerance) << f.x << " " << f.y;
  }
}

// Right triangle with legs along the axes: by parts, (exp(-i a) (...)) with a = 2 pi u, equal legs of 1 from the
// origin.
TEST(PolygonFootprint, triangle_in_closed_form) {
  const auto c = polygon({{0, 0}, {1, 0}, {0, 1}}, 1000.0);
  for (const auto& [u, v] : {std::pair{0.3, 0.8}, {1.7, -0.4}, {-2.2, 5.1}, {40.3, 17.9}}) {
    // 2 x [ (E(u) - 1)/(a) - (E(v) - 1)/(b) ]/(...) with E(t) = exp(-2 pi i t), z = -2 pi i t.
    const auto e = [](double t) { return phase_of(2.0 * t); };
    const auto over = [](const Complex<double>& n, double t) {  // n/(-2 pi i t)
      return Complex<double>{-n.im / (2.0 * kPi * t), n.re / (2.0 * kPi * t)};
    };
    const Complex<double> p = over({e(u).re - 1.0, e(u).im}, u), q = over({e(v).re - 1.0, e(v).im}, v);
    const Complex<double> h = over({p.re - q.re, p.im - q.im}, u - v);
    EXPECT_LE(distance(otf_at(c, u, v), {2.0 * h.re, 2.0 * h.im}), 3e-15) << u << " " << v;
  }
}

// Many corners of a circle.
TEST(PolygonFootprint, of_many_corners_is_the_circle) {
  Taps<double> circle;
  for (int k = 0; k < 200; ++k) circle.push_back({0.5 * cos_pi(k / 100.0), 0.5 * sin_pi(k / 100.0)});
  auto round = Component<double>::make("circular_footprint");
  set(round, "diameter", 17.0, "um");
  for (const double f : {1.0, 30.0, 71.0, 150.0})
    EXPECT_NEAR(otf_at(polygon(circle), f, 0.3 * f).re, otf_at(round, f, 0.3 * f).re, 4e-4) << f;
}

// Phases of neighbouring corners pass each other, or the limit of the series, without a step.
TEST(PolygonFootprint, no_step_where_phases_meet) {
  const auto c = polygon({{-0.5, -0.5}, {0.5, -0.5}, {0.2, 0.6}}, 1000.0);
  for (double f = 0.0; f < 3.0; f += 0.003)
    for (const double h : {1e-13, 1e-10}) {
      const Complex<double> a = otf_at(c, f, 0.0), b = otf_at(c, f + h, 0.0), d = otf_at(c, f, h);
      EXPECT_LE(distance(a, b), 4.0 * h + 3e-15) << f;
      EXPECT_LE(distance(a, d), 4.0 * h + 3e-15) << f;
    }
}

TEST(PolygonFootprint, symmetry_is_found) {
  const auto traits = [](Taps<double> v) { return polygon(std::move(v)).traits(detector().context()); };
  const Traits square = traits(box(-0.5, 0.5, -0.3, 0.3)), aside = traits(box(-0.5, 0.4, -0.3, 0.3)),
               rhomboid = traits({{-0.5, -0.3}, {0.3, -0.3}, {0.5, 0.3}, {-0.3, 0.3}});
  EXPECT_TRUE(square.real && square.even_x && square.even_y);
  EXPECT_TRUE(!aside.real && !aside.even_x && aside.even_y);
  EXPECT_TRUE(rhomboid.real && !rhomboid.even_x && !rhomboid.even_y);
}

// Sizes whose products exceed float, and corners that float moves onto one line: a point there, far from the middle.
TEST(PolygonFootprint, in_float_at_any_size) {
  const auto in_float = [](Taps<double> v, double unit_um, double f) {
    System<double> s = detector();
    s.add(Stage::presample, polygon(std::move(v), unit_um));
    const System<float> single = cast<float>(s);
    return single.list(Stage::presample).front().component.otf({static_cast<float>(f), 0.0F}, single.context());
  };
  for (const double f : {0.0, 0.3, 1e9, 1e30, 3e38}) {
    const Complex<float> h = in_float(box(-1e6, 1e6, -1e6, 1e6), 1e9, f);
    EXPECT_LE(std::hypot(h.re, h.im), f == 0.0 ? 1.0F : 1e-9F) << f;
  }
  const Complex<float> far = in_float(box(1e6 - 1e-3, 1e6, 1e6 - 1e-3, 1e6), 1000.0, 0.125e-6);  // a shift of 1 km
  EXPECT_NEAR(far.re, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(far.im, -std::sqrt(0.5), 1e-6);
}

TEST(PolygonFootprint, refusals) {
  const Taps<double> bow{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, line{{0, 0}, {1, 1}, {2, 2}}, two{{0, 0}, {1, 1}},
      triple{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, closed{{0, 0}, {1, 0}, {0, 1}, {0, 0}},
      spike{{0, 0}, {1, 0}, {2, 0}, {1, 0.0}, {0, 1}}, fold{{0, 0}, {2, 0}, {1, 0}, {0, 1}},
      touching{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}, sliver{{0, 0}, {1, 1}, {0.5, 0.5000009}};
  for (const Taps<double>& bad : {bow, line, two, triple, closed, spike, fold, touching, sliver})
    EXPECT_TRUE(refused(polygon(bad), "vertices")) << bad.size();
  EXPECT_TRUE(refused(polygon({}), "vertices"));
  EXPECT_FALSE(refused(polygon({{0, 0}, {1, 0}, {2, 0}, {0, 1}}), "vertices"));  // a corner of 180 degrees is none
  const auto large = polygon(box(-0.6, 0.5, -0.5, 0.5)).check(detector().context());
  ASSERT_EQ(large.size(), 1u);
  EXPECT_FALSE(large[0].error);
}

}  // namespace
}  // namespace mtf::test
