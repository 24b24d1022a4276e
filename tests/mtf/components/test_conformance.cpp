// SPDX-License-Identifier: Apache-2.0
// What every component keeps, in double and in float, over its whole range of parameters.
#include <gtest/gtest.h>

#include <set>

#include "mtf/components/conformance/properties.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

using conformance::Outcome;
using conformance::Subject;

template <class S>
Subject<S, Component<S>> subject(const Case& c) {
  if constexpr (std::is_same_v<S, double>)
    return subject_of(c, c.system);
  else
    return subject_of(c, cast<S>(c.system));
}

template <class S>
using Check = void (*)(const Subject<S, Component<S>>&, Outcome&);

/// Every case has the property; gives what was compared.
template <class S>
Outcome expect_of_all(Check<S> check) {
  Outcome outcome;
  for (const Case& c : conformance_cases()) check(subject<S>(c), outcome);
  EXPECT_EQ(conformance::describe_failures({outcome}), "");
  EXPECT_GT(outcome.compared, 0u);
  return outcome;
}

template <class S>
class Conformance : public testing::Test {};
using Scalars = testing::Types<double, float>;
TYPED_TEST_SUITE(Conformance, Scalars);

TYPED_TEST(Conformance, unity_at_zero_frequency) {
  expect_of_all<TypeParam>(conformance::unity_at_zero_frequency);
  EXPECT_GE(conformance_cases().size(), 3000u);
}
TYPED_TEST(Conformance, passive_ones_do_not_amplify) {
  expect_of_all<TypeParam>(conformance::passive_ones_do_not_amplify);
}
TYPED_TEST(Conformance, hermitian) { expect_of_all<TypeParam>(conformance::hermitian); }
TYPED_TEST(Conformance, declared_symmetry_is_true) { expect_of_all<TypeParam>(conformance::declared_symmetry_is_true); }
TYPED_TEST(Conformance, finite_everywhere) { expect_of_all<TypeParam>(conformance::finite_everywhere); }
TYPED_TEST(Conformance, deviation_bounds_the_distance_from_one) {
  expect_of_all<TypeParam>(conformance::deviation_bounds_the_distance_from_one);
}

TYPED_TEST(Conformance, cutoff_is_true_and_tight) {
  expect_of_all<TypeParam>(conformance::cutoff_is_true_and_tight);
  int with_cutoff = 0;
  for (const Case& c : conformance_cases())
    with_cutoff += std::isfinite(only_component(c.system).cutoff_cy_mm(c.system.context())) ? 1 : 0;
  EXPECT_GE(with_cutoff, 20);
}

TYPED_TEST(Conformance, chromatic_flag_is_true) {
  expect_of_all<TypeParam>(conformance::chromatic_flag_is_true);
  std::set<std::string> chromatic_kinds;
  for (const Case& c : conformance_cases()) {
    const auto s = subject<TypeParam>(c);
    if (s.traits().chromatic) chromatic_kinds.emplace(s.component.kind());
  }
  EXPECT_EQ(chromatic_kinds, (std::set<std::string>{"aerosol", "defocus", "diffraction", "random_wavefront",
                                                    "rms_wavefront", "turbulence", "wavefront"}));
}

TEST(ConformanceRows, equal_the_otf_pointwise) { expect_of_all<double>(conformance::rows_equal_the_otf); }

TEST(ConformanceLine, only_the_projection_counts) { expect_of_all<double>(conformance::only_the_projection_counts); }

TEST(ConformanceFloat, equals_double_pointwise) {
  Outcome outcome;
  for (const Case& c : conformance_cases()) {
    if (!c.typical) continue;
    Case rounded = c;
    for (const auto& scalar : scalars_of(only_component(rounded.system)))
      *scalar.value = static_cast<double>(static_cast<float>(*scalar.value));
    conformance::float_equals_double(subject<double>(rounded), subject<float>(rounded), outcome);
  }
  EXPECT_EQ(conformance::describe_failures({outcome}), "");
  EXPECT_GT(outcome.compared, 0u);
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
  Outcome outcome;
  for (const Case& c : conformance_cases())
    if (c.name.ends_with("#0"))
      conformance::values_outside_their_range_are_refused_by_name(subject<double>(c), outcome);
  EXPECT_EQ(conformance::describe_failures({outcome}), "");
  EXPECT_GE(outcome.compared, 100u);
}

}  // namespace
}  // namespace mtf::test
