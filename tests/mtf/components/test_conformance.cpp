// SPDX-License-Identifier: Apache-2.0
// What every component promises, in double and in float, over its whole parameter box.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

template <class S>
System<S> as(const System<double>& system) {
  if constexpr (std::is_same_v<S, double>)
    return system;
  else
    return cast<S>(system);
}

template <class S>
struct Subject {
  System<S> system;
  Context<S> ctx;
  Traits traits;
  explicit Subject(const Case& c)
      : system(as<S>(c.system)), ctx(system.context()), traits(only_component(system).traits(ctx)) {}
  Complex<S> otf(S x, S y) const { return only_component(system).otf({x, y}, ctx); }
};

template <class S>
constexpr double ulp() {
  return static_cast<double>(std::numeric_limits<S>::epsilon());
}

template <class S>
bool finite(const Complex<S>& h) {
  return std::isfinite(h.re) && std::isfinite(h.im);
}

template <class S>
double modulus(const Complex<S>& h) {
  return std::hypot(static_cast<double>(h.re), static_cast<double>(h.im));
}

template <class S>
double distance(const Complex<S>& a, const Complex<S>& b) {
  return std::hypot(static_cast<double>(a.re) - static_cast<double>(b.re),
                    static_cast<double>(a.im) - static_cast<double>(b.im));
}

// The largest modulus that a component which amplifies admits, the scale of its rounding; 1 for all others.
double gain_scale(const System<double>& system) {
  const Context<double> ctx = system.context();
  const Component<double>& component = only_component(system);
  return component.traits(ctx).gain ? 1.0 + component.deviation(1e300, 1e300, ctx) : 1.0;
}

double random_frequency(Random& random) {
  const double f = random.decades(1e-3, 300.0);
  return random.below(2) == 1 ? f : -f;
}

template <class S>
class Conformance : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(Conformance, Scalars);

TYPED_TEST(Conformance, unity_at_zero_frequency) {
  for (const Case& c : conformance_cases()) {
    const Subject<TypeParam> s(c);
    const double tolerance = 4.0 * ulp<TypeParam>() * gain_scale(c.system);
    const Complex<TypeParam> h = s.otf(TypeParam(0), TypeParam(0));
    EXPECT_NEAR(static_cast<double>(h.re), s.traits.dc, tolerance) << c.name;
    EXPECT_EQ(h.im, TypeParam(0)) << c.name;
    if (!s.traits.gain) {
      EXPECT_EQ(s.traits.dc, 1.0) << c.name;
    }
  }
}

TYPED_TEST(Conformance, passive_ones_do_not_amplify) {
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 1);
    const Subject<TypeParam> s(c);
    if (s.traits.gain) continue;
    for (int i = 0; i < 200; ++i) {
      const TypeParam x(static_cast<TypeParam>(random_frequency(random))),
          y(static_cast<TypeParam>(random_frequency(random)));
      EXPECT_LE(modulus(s.otf(x, i % 3 ? y : TypeParam(0))), 1.0 + 4.0 * ulp<TypeParam>()) << c.name << " " << x;
    }
  }
}

TYPED_TEST(Conformance, hermitian) {
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 2);
    const Subject<TypeParam> s(c);
    for (int i = 0; i < 50; ++i) {
      const TypeParam x = static_cast<TypeParam>(random_frequency(random)),
                      y = static_cast<TypeParam>(random_frequency(random));
      const Complex<TypeParam> h = s.otf(x, y), g = s.otf(-x, -y);
      EXPECT_LE(distance(h, {g.re, -g.im}), 1e-15 * gain_scale(c.system)) << c.name << " " << x << " " << y;
    }
  }
}

TYPED_TEST(Conformance, declared_symmetry_is_true) {
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 3);
    const Subject<TypeParam> s(c);
    const double rounding = ulp<TypeParam>() * gain_scale(c.system);
    const Complex<TypeParam> zero = s.otf(TypeParam(0), TypeParam(0));
    for (int i = 0; i < 50; ++i) {
      const double u = random_frequency(random), v = random_frequency(random);
      const TypeParam x = static_cast<TypeParam>(u), y = static_cast<TypeParam>(v);
      const Complex<TypeParam> h = s.otf(x, y);
      const std::string where = c.name + " " + std::to_string(u) + " " + std::to_string(v);
      if (s.traits.real) {
        EXPECT_EQ(h.im, TypeParam(0)) << where;
      }
      if (s.traits.even_x) {
        EXPECT_LE(distance(h, s.otf(-x, y)), 8.0 * rounding) << where;
      }
      if (s.traits.even_y) {
        EXPECT_LE(distance(h, s.otf(x, -y)), 8.0 * rounding) << where;
      }
      if (s.traits.radial) {  // slopes against log f stay below a few units for all but narrow annuli
        const TypeParam r = static_cast<TypeParam>(std::hypot(static_cast<double>(x), static_cast<double>(y)));
        const double steep = c.typical ? 32.0 : 1e4;
        EXPECT_LE(distance(h, s.otf(r, TypeParam(0))), steep * rounding) << where;
        EXPECT_LE(distance(h, s.otf(TypeParam(0), -r)), steep * rounding) << where;
      }
      if (s.traits.square) {
        EXPECT_LE(distance(s.otf(x, TypeParam(0)), s.otf(TypeParam(0), x)), 8.0 * rounding) << where;
      }
      if (s.traits.flat_x) {
        EXPECT_LE(distance(s.otf(x, TypeParam(0)), {TypeParam(1), TypeParam(0)}), 8.0 * rounding) << where;
      }
      if (s.traits.flat_y) {
        EXPECT_LE(distance(s.otf(TypeParam(0), y), {TypeParam(1), TypeParam(0)}), 8.0 * rounding) << where;
      }
      if (s.traits.separable) {
        EXPECT_LE(distance(h * zero, s.otf(x, TypeParam(0)) * s.otf(TypeParam(0), y)), 8.0 * rounding) << where;
      }
    }
  }
}

TYPED_TEST(Conformance, cutoff_is_true_and_tight) {
  int with_cutoff = 0;
  for (const Case& c : conformance_cases()) {
    const Subject<TypeParam> s(c);
    const double cutoff = only_component(s.system).cutoff_cy_mm(s.ctx);
    ASSERT_GT(cutoff, 0.0) << c.name;
    if (!std::isfinite(cutoff)) continue;
    ++with_cutoff;
    for (const double angle : {0.0, 0.3, 1.1, 2.0, 3.1}) {
      const double cosine = std::cos(angle), sine = std::sin(angle);
      const auto at = [&](double f) {
        return modulus(s.otf(static_cast<TypeParam>(f * cosine), static_cast<TypeParam>(f * sine)));
      };
      for (const double factor : {1.0 + 8.0 * ulp<TypeParam>(), 1.001, 2.0, 1e6})
        EXPECT_EQ(at(cutoff * factor), 0.0) << c.name << " " << factor;
      EXPECT_GT(at(0.99 * cutoff), c.typical ? 1e-4 : 0.0) << c.name;
      if (c.typical) {  // the cutoff itself may round to either side
        EXPECT_LE(at(cutoff), 100.0 * std::pow(4.0 * ulp<TypeParam>(), 1.5)) << c.name;
      }
    }
  }
  EXPECT_GE(with_cutoff, 20);
}

TYPED_TEST(Conformance, finite_everywhere) {
  const double largest = std::is_same_v<TypeParam, float> ? 3e38 : 1e300;
  std::vector<double> frequencies{0.0, 5e-324, 1e-300, 1e-45, 1e-9, 0.01, 20.0, 125.0, 1e4, 1e18, 1e30, largest};
  for (const Case& c : conformance_cases()) {
    const Subject<TypeParam> s(c);
    const double scale = gain_scale(c.system) * (1.0 + 8.0 * ulp<TypeParam>());
    for (const double a : frequencies)
      for (const double b : frequencies)
        for (const double sign : {1.0, -1.0}) {
          const Complex<TypeParam> h = s.otf(static_cast<TypeParam>(a), static_cast<TypeParam>(sign * b));
          EXPECT_TRUE(finite(h) && modulus(h) <= 1.05 * scale) << c.name << " " << a << " " << sign * b << " " << h.re;
        }
  }
}

TYPED_TEST(Conformance, deviation_bounds_the_distance_from_one) {
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 5);
    const Subject<TypeParam> s(c);
    const double rounding = 4.0 * ulp<TypeParam>() * gain_scale(c.system);
    for (int i = 0; i < 40; ++i) {
      const double fx = random.decades(1e-4, 500.0), fy = random.below(4) == 0 ? 0.0 : random.decades(1e-4, 500.0);
      const double bound = only_component(s.system).deviation(fx, fy, s.ctx);
      ASSERT_TRUE(bound >= 0.0 && std::isfinite(bound)) << c.name;
      for (int k = 0; k < 5; ++k) {
        const TypeParam x = static_cast<TypeParam>(k == 0 ? fx : random.uniform(-fx, fx)),
                        y = static_cast<TypeParam>(k == 0 ? fy : random.uniform(-fy, fy));
        const Complex<TypeParam> one{TypeParam(1), TypeParam(0)};
        EXPECT_LE(distance(s.otf(x, y), one), bound * (1.0 + 64.0 * ulp<TypeParam>()) + rounding)
            << c.name << " " << x << " of " << fx << ", " << y << " of " << fy;
      }
    }
  }
}

TYPED_TEST(Conformance, chromatic_flag_is_true) {
  std::set<std::string> chromatic_kinds;
  for (const Case& c : conformance_cases()) {
    const Subject<TypeParam> s(c);
    Context<TypeParam> other = s.ctx;
    other.wavelength_um = s.ctx.wavelength_um * TypeParam(1.25);
    bool differs = false;
    for (const double f : {0.1, 3.0, 20.0, 60.0}) {
      const Freq<TypeParam> at{static_cast<TypeParam>(f), static_cast<TypeParam>(0.7 * f)};
      differs |= distance(only_component(s.system).otf(at, s.ctx), only_component(s.system).otf(at, other)) > 0.0;
    }
    if (!s.traits.chromatic) {
      EXPECT_FALSE(differs) << c.name;
    }
    if (s.traits.chromatic && c.typical) {
      EXPECT_TRUE(differs) << c.name;
    }
    if (s.traits.chromatic) chromatic_kinds.emplace(only_component(s.system).kind());
  }
  EXPECT_EQ(chromatic_kinds, (std::set<std::string>{"aerosol", "defocus", "diffraction", "random_wavefront",
                                                    "rms_wavefront", "turbulence", "wavefront"}));
}

// Parameters and frequencies that float holds exactly, so that only the arithmetic differs.
TEST(ConformanceRows, equal_the_otf_pointwise) {
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 31);
    const Subject<double> subject(c);
    std::vector<double> fx(5);
    for (double& f : fx) f = random_frequency(random);
    const auto rows = only_component(subject.system).rows(fx, subject.ctx);
    for (int repeat = 0; repeat < 2; ++repeat) {
      const double fy = random_frequency(random);
      std::vector<Complex<double>> h(4, {0.0, 2.0});
      rows(fy, h);
      for (std::size_t i = 0; i < h.size(); ++i) {
        const Complex<double> expected = subject.otf(fx[i], fy) * Complex<double>{0.0, 2.0};
        ASSERT_LE(distance(h[i], expected), 32.0 * ulp<double>() * gain_scale(c.system)) << c.name;
      }
    }
  }
}

TEST(ConformanceLine, only_the_projection_counts) {
  int lines = 0;
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 32);
    const Subject<double> subject(c);
    const auto u = only_component(subject.system).line(subject.ctx);
    if (!c.typical || !u) continue;
    ++lines;
    EXPECT_NEAR(std::hypot(u->x, u->y), 1.0, 1e-15);
    for (int repeat = 0; repeat < 20; ++repeat) {
      const double x = random_frequency(random), y = random_frequency(random), along = x * u->x + y * u->y;
      ASSERT_LE(distance(subject.otf(x, y), subject.otf(along * u->x, along * u->y)), 1e-11) << c.name;
    }
  }
  EXPECT_GT(lines, 0);
}

TEST(ConformanceFloat, equals_double_pointwise) {
  for (const Case& c : conformance_cases()) {
    Random random(c.name, 6);
    if (!c.typical) continue;
    Case rounded = c;
    for (const Scalar<double>& scalar : scalars_of(only_component(rounded.system)))
      *scalar.value = static_cast<double>(static_cast<float>(*scalar.value));
    const Subject<double> exact(rounded);
    const Subject<float> single(rounded);
    const double reach = c.stage == Stage::presample ? 4.0 : 1.0;  // times the detector's Nyquist frequency
    for (int i = 0; i < 300; ++i) {
      const auto draw = [&](Axis axis) {
        return static_cast<float>(reach * exact.ctx.frame.nyquist_cy_mm(axis) * random.uniform(-1.0, 1.0));
      };
      const float x = draw(Axis::x), y = draw(Axis::y);
      const Complex<double> h = exact.otf(static_cast<double>(x), static_cast<double>(y));
      const Complex<float> g = single.otf(x, y);
      const double off = distance(h, {static_cast<double>(g.re), static_cast<double>(g.im)});
      if (off <= 1e-6 * gain_scale(c.system)) continue;
      // A phase is the sum of two products, along x and y, each of which carries the roundings of four factors to
      // float, 4 x 2^-24 of itself. Almost across a motion of ten cycles they cancel, their roundings do not.
      const double nudge = 1.0 + 0x1p-22, u = static_cast<double>(x), v = static_cast<double>(y);
      EXPECT_LE(off, distance(h, exact.otf(nudge * u, v)) + distance(h, exact.otf(u, nudge * v)))
          << c.name << " " << x << " " << y;
    }
  }
}

TEST(ConformanceList, covers_every_kind_and_field) {
  std::set<std::string> seen;
  for (const Case& c : conformance_cases())
    for (const std::string& name : c.given) seen.insert(std::string(only_component(c.system).kind()) + "." + name);
  std::set<std::string> kinds;
  for (const Case& c : conformance_cases()) kinds.emplace(only_component(c.system).kind());
  for (const std::string_view kind : component_kinds()) {
    EXPECT_TRUE(kinds.contains(std::string(kind))) << kind;
    for (const auto& field : Component<double>::make(kind).fields())
      if (field.info->presence != Presence::required) {
        EXPECT_TRUE(seen.contains(std::string(kind) + "." + std::string(field.info->name))) << field.info->name;
      }
  }
}

TEST(ConformanceList, values_outside_their_range_are_refused_by_name) {
  int tried = 0;
  for (const Case& c : conformance_cases()) {
    if (!c.name.ends_with("#0")) continue;
    System<double> system = c.system;
    const std::size_t count = scalars_of(only_component(system)).size();
    for (std::size_t i = 0; i < count; ++i) {
      System<double> broken = c.system;
      const Scalar<double> scalar = scalars_of(only_component(broken))[i];
      const FieldInfo& info = *scalar.info;
      const double inf = std::numeric_limits<double>::infinity();
      for (const double bad : {info.lo_open ? info.lo : std::nextafter(info.lo, -inf),
                               info.hi_open ? info.hi : std::nextafter(info.hi, inf), inf, -inf,
                               std::numeric_limits<double>::quiet_NaN()}) {
        *scalar.value = bad;
        const auto problems = only_component(broken).check(broken.context());
        const bool named = std::any_of(problems.begin(), problems.end(), [&](const Problem& p) {
          return p.error && p.field.starts_with(info.name) && p.text.find("outside") != std::string::npos;
        });
        EXPECT_TRUE(named) << c.name << "." << scalar.name << " = " << bad;
        ++tried;
      }
    }
  }
  EXPECT_GE(tried, 100);
}

}  // namespace
}  // namespace mtf::test
