// SPDX-License-Identifier: Apache-2.0
// Every header opens with its physics: a formula, prose around it, and the source last.
#include <gtest/gtest.h>

#include "mtf/component.h"
#include "mtf/components/component_docs.h"
#include "tests/expect_error.h"

namespace mtf {
namespace {

TEST(ComponentDocs, every_kind_has_a_formula_and_a_source) {
  for (const std::string_view kind : component_kinds()) {
    const std::string_view notes = component_notes(kind);
    EXPECT_FALSE(notes.empty()) << kind;
    EXPECT_FALSE(notes.starts_with(" ")) << kind << ": opens with a sentence";
    EXPECT_TRUE(says(component_formula(kind), "otf = "))
        << kind << ": its formula stands on a line of its own, indented by two spaces: otf = ...";
    EXPECT_FALSE(component_source(kind).empty()) << kind << ": ends with its source in parentheses";
  }
  EXPECT_EQ(all_component_notes().size(), component_kinds().size());
  EXPECT_EQ(component_notes("jiter"), "");
  EXPECT_EQ(component_source("jiter"), "");
}

TEST(ComponentDocs, kinds_of_one_header_have_their_own_formulas) {
  EXPECT_TRUE(component_formula("rc_lowpass").starts_with("otf = 1/(1 + i f/f0)")) << component_formula("rc_lowpass");
  EXPECT_FALSE(says(component_formula("rc_lowpass"), "sqrt"));
  expect_says(component_formula("butterworth"), {"sqrt"});
  EXPECT_EQ(component_notes("rc_lowpass"), component_notes("butterworth"));
}

TEST(ComponentDocs, source_is_the_last_parenthesis_with_those_inside_it) {
  EXPECT_EQ(component_source("crosstalk"), "Moore, Ninkov, Forrest, Opt. Eng. 45, 076402 (2006).");
}

}  // namespace
}  // namespace mtf
