// SPDX-License-Identifier: Apache-2.0
// What measuring learns outlives the plan that measured, as text too; other text is refused and changes nothing.
#include "mtf/plan/measured.h"

#include "mtf/math/word_hash.h"
#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

TEST(Measured, text_goes_out_and_back) {
  remember_ms("some work 3x4", 1.5);
  const std::string text = export_measured();
  expect_says(text, {"1.5 some work 3x4\n"});
  EXPECT_TRUE(import_measured(text));
  EXPECT_EQ(measured_ms("some work 3x4"), 1.5);
  EXPECT_FALSE(measured_ms("other work"));
}

/// With the checksum that belongs to it.
std::string whole(const std::string& text) {
  std::uint64_t hash = kWordHashStart;
  for (const char c : text) hash = mixed(hash, static_cast<unsigned char>(c));
  return "mtfkit measured 2 " + std::to_string(hash) + "\n" + text;
}

TEST(Measured, other_text_is_refused) {
  for (const std::string text : {"", "x y\nwisdom\n", "-1 work\nwisdom\n", "wisdom\nnot wisdom"}) {
    EXPECT_FALSE(import_measured(text)) << text;
    EXPECT_FALSE(import_measured(whole(text))) << text;
  }
  EXPECT_FALSE(import_measured("(fftw-3.3.10 fftwf_wisdom #x0 #x0 #x0 #x0\n)\n"));
}

TEST(Measured, a_byte_that_changed_is_found) {
  remember_ms("some work 3x4", 1.5);
  const std::string text = export_measured();
  ASSERT_TRUE(import_measured(text));
  for (std::size_t at = 0; at < text.size(); at += 1 + text.size() / 500) {
    std::string changed = text;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_FALSE(import_measured(changed)) << at;
  }
}

TEST(Measured, a_plan_measures_once_and_says_so) {
  const System<double> system = with(bare(15.0, 15.0), {gaussian(22.0)});
  const SampleGrid in = scene_grid(system, 131, 97, 1.0, 1.0);
  const Image scene = random_image(in.width, in.height, 5);
  PlanOptions options = options_for(scene, Border::reflect, 1e-2);
  options.rigor = Rigor::measure;
  const Plan first = compile(system, in, detector_grid(system, in), options);
  int measured = 0;
  for (const Candidate& c : first.report().candidates) measured += c.measured ? 1 : 0;
  EXPECT_GE(measured, 2);
  const Plan second = compile(system, in, detector_grid(system, in), options);
  for (std::size_t i = 0; i < first.report().candidates.size(); ++i)
    EXPECT_EQ(first.report().candidates[i].cost_ms, second.report().candidates[i].cost_ms);
}

}  // namespace
}  // namespace mtf::test
