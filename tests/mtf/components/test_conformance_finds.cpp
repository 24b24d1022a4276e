// SPDX-License-Identifier: Apache-2.0
// The list of properties against a component that is right, and against one fault at a time.
#include <gtest/gtest.h>

#include <set>

#include "mtf/components/conformance/conformance.h"

namespace mtf::test {
namespace {

enum class Fault {
  none,
  zero_frequency,
  amplifies,
  not_hermitian,
  not_separable,
  lower_cutoff,
  not_finite,
  deviation,
  chromatic,
  cancels,
  rows,
  example_outside,
  never_accepted
};

/// A Gaussian of a width in um, not in the list of components.
template <class S, Fault fault>
struct Blur {
  static constexpr std::string_view kind = "blur";
  static constexpr Stages stages{.presample = true};
  static constexpr SensorPart part = SensorPart::optics;

  NumberIn<S, micrometres> width_um{};
  Choice axis{0, kAxisNames};

  static constexpr auto fields() {
    return std::tuple{
        Field{&Blur::width_um, FieldInfo{.name = "width",
                                         .dimension = Dimension::length,
                                         .unit = "um",
                                         .lo = 0.0,
                                         .hi = 1e6,
                                         .example = fault == Fault::example_outside ? "\"-3 um\"" : "\"3 um\"",
                                         .doc = "standard deviation"}},
        Field{&Blur::axis, kAxisInfo}};
  }
  Traits traits(const Context<S>&) const {
    return {.radial = true,
            .separable = fault != Fault::not_hermitian,
            .even_x = true,
            .even_y = true,
            .real = fault != Fault::not_hermitian};
  }
  double cutoff_cy_mm(const Context<S>&) const { return fault == Fault::lower_cutoff ? 30.0 : kInfinity; }
  Complex<S> otf(const Freq<S>& f, const Context<S>& ctx) const {
    const S u = width_um.value * S(1e-3) * f.x, v = width_um.value * S(1e-3) * f.y;
    S h = gaussian_of(u) * gaussian_of(v), phase(0);
    if (fault == Fault::zero_frequency) h = h * S(0.999);
    if (fault == Fault::amplifies) h = S(2) - h;
    if (fault == Fault::not_hermitian) phase = h * gaussian_of(S(v - S(0.1)));
    if (fault == Fault::not_separable) h = gaussian_of(S(u * v));
    if (fault == Fault::not_finite) h = h * (S(1) + u * u * u * u) / (S(1) + u * u * u * u);
    if (fault == Fault::chromatic) h = gaussian_of(S(u * ctx.wavelength_um)) * gaussian_of(S(v * ctx.wavelength_um));
    if (fault == Fault::cancels) h = S((S(1000) + h) - S(1000)) / S((S(1000) + S(1)) - S(1000));
    return {h, phase};
  }
  double deviation(double fx, double fy, const Context<S>&) const {
    const double x = value_of(width_um.value) * 1e-3 * fx, y = value_of(width_um.value) * 1e-3 * fy;
    return -std::expm1(-2.0 * kPi * kPi * (x * x + y * y)) * (fault == Fault::deviation ? 0.5 : 1.0);
  }
  auto rows(std::span<const S> fx, const Context<S>& ctx) const {
    return [*this, fx, ctx](const S& fy, std::span<Complex<S>> h) {
      const S row = fault == Fault::rows ? S(0) : fy;
      for (std::size_t i = 0; i < h.size(); ++i) h[i] = h[i] * otf({fx[i], row}, ctx);
    };
  }
  std::vector<Problem> check(const Context<S>&) const {
    if (fault == Fault::never_accepted) return {{.field = "width", .text = "not today"}};
    return {};
  }
};

template <Fault fault>
struct With {
  template <class S>
  using Type = Blur<S, fault>;
};

template <Fault fault>
std::set<std::string> failed() {
  std::set<std::string> names;
  for (const conformance::Outcome& outcome : conformance::check<With<fault>::template Type>()) {
    EXPECT_EQ(outcome.ok(), conformance::describe_failures({outcome}).empty());
    if (outcome.ok()) continue;
    names.insert(outcome.property);
    EXPECT_FALSE(outcome.where.empty()) << outcome.property;
    EXPECT_FALSE(outcome.found <= outcome.allowed) << outcome.property;
    EXPECT_LE(outcome.failed, outcome.compared);
  }
  return names;
}

TEST(ConformanceCheck, a_component_that_is_right_passes) {
  const auto outcomes = conformance::check<With<Fault::none>::Type>();
  EXPECT_EQ(conformance::describe_failures(outcomes), "");
  EXPECT_TRUE(conformance::all_ok(outcomes));
  EXPECT_EQ(outcomes.size(), 1u + 8u + 3u + 8u + 1u);
  for (const conformance::Outcome& outcome : outcomes)
    EXPECT_TRUE(outcome.compared > 0 || outcome.property == "only the projection on a motion counts")
        << outcome.property;
}

TEST(ConformanceCheck, each_fault_is_found_by_its_property) {
  EXPECT_TRUE(failed<Fault::zero_frequency>().contains("unity at zero frequency"));
  EXPECT_TRUE(failed<Fault::amplifies>().contains("passive ones do not amplify"));
  EXPECT_TRUE(failed<Fault::not_hermitian>().contains("hermitian"));
  EXPECT_TRUE(failed<Fault::not_separable>().contains("declared symmetry is true"));
  EXPECT_TRUE(failed<Fault::lower_cutoff>().contains("cutoff is true and tight"));
  EXPECT_TRUE(failed<Fault::not_finite>().contains("finite everywhere"));
  EXPECT_TRUE(failed<Fault::deviation>().contains("deviation bounds the distance from one"));
  EXPECT_TRUE(failed<Fault::chromatic>().contains("chromatic flag is true"));
  EXPECT_TRUE(failed<Fault::cancels>().contains("float equals double"));
  EXPECT_EQ(failed<Fault::rows>(), std::set<std::string>{"rows and evaluator equal the otf"});
}

TEST(ConformanceCheck, an_example_outside_of_its_range_is_found) {
  EXPECT_EQ(failed<Fault::example_outside>(), std::set<std::string>{"the examples of the field table are accepted"});
}

TEST(ConformanceCheck, a_component_that_accepts_nothing_is_found) {
  const auto outcomes = conformance::check<With<Fault::never_accepted>::Type>();
  EXPECT_EQ(outcomes.front().failed, 3u);  // no draw at all, none with the width, none with the axis
  for (const conformance::Outcome& outcome : outcomes)
    EXPECT_TRUE(&outcome == outcomes.data() || outcome.compared == 0);
}

TEST(ConformanceCheck, the_worst_failure_is_kept) {
  conformance::Outcome outcome{.property = "p"};
  const auto place = [](const char* name) { return [name] { return std::string(name); }; };
  outcome.at_most(1.0, 2.0, place("fine"));
  outcome.at_most(3.0, 2.0, place("bad"));
  outcome.at_most(9.0, 2.0, place("worst"));
  outcome.at_most(4.0, 2.0, place("bad again"));
  EXPECT_EQ(outcome.compared, 4u);
  EXPECT_EQ(outcome.failed, 3u);
  EXPECT_EQ(outcome.where, "worst");
  outcome.at_most(std::nan(""), 2.0, place("no number"));
  outcome.at_most(99.0, 2.0, place("less bad than no number"));
  EXPECT_EQ(outcome.where, "no number");
  EXPECT_EQ(conformance::describe_failures({outcome}),
            "p: 5 of 6 comparisons fail; the worst gives nan where at most 2 is allowed: no number\n");
}

}  // namespace
}  // namespace mtf::test
