// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/double_counting.h"
#include "tests/expect_error.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

/// The example of a kind, as the field table gives it, with that word chosen where the pattern names one.
std::optional<Component<double>> example_of(std::string_view pattern) {
  const std::string_view kind = pattern.substr(0, pattern.find(':'));
  for (const Case& c : conformance_cases()) {
    if (only_component(c.system).kind() != kind || !c.name.ends_with("#0")) continue;
    Component<double> component = only_component(c.system);
    if (kind.size() == pattern.size()) return component;
    for (const FieldRef<double>& field : component.fields())
      if (auto* const* choice = std::get_if<Choice*>(&field.value))
        for (std::size_t i = 0; i < (*choice)->names.size(); ++i)
          if ((*choice)->names[i] == pattern.substr(kind.size() + 1)) {
            (*choice)->index = static_cast<int>(i);
            return component;
          }
  }
  return std::nullopt;
}

void add(System<double>& system, const Component<double>& component) {
  for (const Stage stage : kStages)
    if (component.stages().allows(stage)) return system.add(stage, component);
}

int warnings(const System<double>& system, std::string_view why) {
  int count = 0;
  for (const auto& f : system.check())
    if (f.problem.text.find(why) != std::string::npos) {
      EXPECT_FALSE(f.problem.error);
      EXPECT_TRUE(f.where.ends_with(".kind")) << f.where;
      ++count;
    }
  return count;
}

// Every pair of every row, in both orders, is warned about once; each component alone is not.
TEST(DoubleCounting, every_row_of_the_table) {
  int pairs = 0;
  for (const DoubleCounting& rule : kDoubleCounting) {
    const bool alike = rule.other.front().empty();
    for (const std::string_view one : rule.one)
      for (const std::string_view other : alike ? rule.one : rule.other) {
        if (one.empty() || other.empty()) continue;
        const auto a = example_of(one), b = example_of(other);
        ASSERT_TRUE(a && b) << "no such component: " << (a ? other : one);
        for (const bool swapped : {false, true}) {
          System<double> s = mwir();
          s.list(Stage::presample).clear();
          s.optics.aperture_mm.reset();
          add(s, swapped ? *b : *a);
          EXPECT_EQ(warnings(s, rule.why), 0) << one;
          add(s, swapped ? *a : *b);
          EXPECT_EQ(warnings(s, rule.why), 1) << one << " " << other;
        }
        ++pairs;
      }
  }
  EXPECT_GE(pairs, 20);
}

Component<double> interpolation(int kernel) {
  auto c = Component<double>::make("interpolation");
  choose(c, "kernel", kernel);
  return c;
}

// Repeated samples are held samples; any other interpolator may well be shown by a display that holds.
TEST(DoubleCounting, only_the_interpolator_that_holds_beside_a_hold) {
  auto hold = Component<double>::make("sample_and_hold");
  set(hold, "width", 1.0, "px");
  for (int kernel = 0; kernel < 5; ++kernel)
    for (const bool hold_first : {false, true}) {
      System<double> s = mwir();
      s.add(Stage::postsample, hold_first ? hold : interpolation(kernel));
      s.add(Stage::postsample, hold_first ? interpolation(kernel) : hold);
      EXPECT_EQ(warnings(s, "held already"), kernel == 0 ? 1 : 0) << kernel << hold_first;
    }
}

// A statistic of the wavefront error belongs beside the plain pupil; beside the aberrations themselves it repeats them.
TEST(DoubleCounting, aberrations_by_coefficients_and_by_statistics) {
  for (const char* pupil : {"diffraction", "defocus", "wavefront"})
    for (const char* statistic : {"rms_wavefront", "random_wavefront"}) {
      System<double> s = mwir();
      s.list(Stage::presample).clear();
      s.add(Stage::presample, *example_of(pupil));
      s.add(Stage::presample, *example_of(statistic));
      const bool plain = std::string_view(pupil) == "diffraction";
      EXPECT_EQ(warnings(s, "the rms holds"), plain ? 0 : 1) << pupil << " " << statistic;
    }
}

TEST(DoubleCounting, names_the_other_and_the_remedy) {
  System<double> s = mwir();
  auto round = Component<double>::make("circular_footprint");
  set(round, "diameter", 10.0, "um");
  s.add(Stage::presample, round);
  std::string text;
  for (const auto& f : s.check())
    if (f.where == "presample[3].kind") text = f.problem.text;
  expect_says(text, {"\"circular_footprint\" beside \"footprint\"", "keep one"});
}

TEST(DoubleCounting, an_ordinary_sensor_counts_nothing_twice) { EXPECT_TRUE(mwir().check().empty()); }

}  // namespace
}  // namespace mtf::test
