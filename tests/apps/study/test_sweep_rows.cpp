// SPDX-License-Identifier: Apache-2.0
// Yield of what is built, and what rows say through constraints and objectives.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/study/result_columns.h"
#include "apps/study/rows/sweep_rows.h"
#include "apps/study/statistics/accuracy.h"
#include "tests/apps/study/small_study.h"

namespace apps_test {
namespace {

using study::Column;

/// A study in which the only thing that decides is the pitch as built.
std::shared_ptr<const study::Study> pitch_study(const Scratch& scratch, const std::string& variation, int draws) {
  scratch.add_sensor();
  write_file(scratch / "study.toml",
             "schema = 1\nsensor = \"sensor.toml\"\nseed = 5\nconstraints = [\"frame.pitch < 15 um\"]\n"
             "objectives = [\"maximize frame.pitch\"]\n"
             "[[axis]]\nparameter = \"frame.pitch\"\nvalues = [\"12 um\", \"14 um\", \"15 um\", \"16 um\"]\n"
             "[[as_built]]\nparameter = \"frame.pitch\"\n" +
                 variation + "\n[yield]\ndraws = " + std::to_string(draws) + "\n[metrics]\nlist = [\"mtf_nyquist\"]\n");
  return study::load_study((scratch / "study.toml").string());
}

std::vector<double> yields_of(const std::shared_ptr<const study::Study>& study) {
  const auto columns = study::columns_of(*study);
  const auto maker = study::row_makers(study)();
  std::vector<double> yields, row(columns.size());
  for (std::int64_t design = 0; design < study->designs; ++design) {
    maker(design, row);
    yields.push_back(row[study::column_of(columns, Column::Role::yield).value()]);
  }
  return yields;
}

TEST(Yield, OfANormalVariationIsTheNormalIntegral) {
  const Scratch scratch;
  constexpr int kDraws = 4000;
  const auto yields = yields_of(pitch_study(scratch, "sd = \"1 um\"", kDraws));
  const std::vector<double> pitch{12.0, 14.0, 15.0, 16.0};
  for (std::size_t i = 0; i < pitch.size(); ++i) {
    const double truth = 0.5 * std::erfc((pitch[i] - 15.0) / std::sqrt(2.0));
    EXPECT_NEAR(yields[i], truth, 4.0 * study::yield_error(truth, kDraws) + 1e-12) << pitch[i];
  }
}

TEST(Yield, OfAUniformVariationIsTheShareOfItsRange) {
  const Scratch scratch;
  constexpr int kDraws = 4000;
  // 25 % of 12, 14, 15 and 16 um to either side.
  const auto yields = yields_of(pitch_study(scratch, "plus_minus = \"25 %\"", kDraws));
  const std::vector<double> pitch{12.0, 14.0, 15.0, 16.0};
  for (std::size_t i = 0; i < pitch.size(); ++i) {
    const double half = 0.25 * pitch[i], truth = std::min(1.0, (15.0 - pitch[i] + half) / (2.0 * half));
    EXPECT_NEAR(yields[i], truth, 4.0 * study::yield_error(truth, kDraws) + 1e-12) << pitch[i];
  }
}

// A pitch below 0 is none: of a normal law of 12 +- 12 um it is Phi(-1) of the draws, of 12 +- 1 um none.
TEST(Yield, TellsDrawsThatNoSensorCanBe) {
  constexpr int kDraws = 2000;
  const double truth = 0.5 * std::erfc(1.0 / std::sqrt(2.0));
  const Scratch wide, narrow;
  EXPECT_NEAR(study::impossible_share(pitch_study(wide, "sd = \"12 um\"", kDraws), 0), truth,
              4.0 * study::yield_error(truth, kDraws));
  EXPECT_EQ(study::impossible_share(pitch_study(narrow, "sd = \"1 um\"", kDraws), 0), 0.0);
}

TEST(Yield, DrawsAreCommonToAllDesigns) {
  // The pitch at limits that are one apart: with common draws the yield falls from design to design without fail.
  const Scratch scratch;
  const auto yields = yields_of(pitch_study(scratch, "sd = \"3 um\"", 100));
  for (std::size_t i = 1; i < yields.size(); ++i) EXPECT_LE(yields[i], yields[i - 1]);
}

// Half of Wilson's interval at one standard deviation, which solves |p - p0| = sqrt(p0 (1 - p0) / n) for p0, is never
// more than it, and the same at a half; for many draws it is the binomial sqrt(p (1 - p) / n).
TEST(Yield, StandardErrorIsThatOfAgrestiAndCoull) {
  EXPECT_DOUBLE_EQ(study::yield_error(1.0, 20), std::sqrt(20.5 * 0.5 / (21.0 * 21.0 * 21.0)));
  EXPECT_DOUBLE_EQ(study::yield_error(0.0, 20), study::yield_error(1.0, 20));
  for (const int n : {1, 2, 20, 400})
    for (int k = 0; k <= n; ++k) {
      const double p = static_cast<double>(k) / n;
      const double wilson = std::sqrt(p * (1.0 - p) / n + 0.25 / n / n) / (1.0 + 1.0 / n);
      EXPECT_GE(study::yield_error(p, n), wilson * (1.0 - 1e-12)) << k << " of " << n;
      EXPECT_EQ(std::abs(study::yield_error(p, n) / wilson - 1.0) < 1e-12, 2 * k == n) << k << " of " << n;
    }
  EXPECT_NEAR(study::yield_error(0.9, 1'000'000) / 3e-4, 1.0, 1e-5);
}

TEST(RowsOfAStudy, ConstraintsReadFromARowAreThoseOfTheEvaluator) {
  const Scratch scratch;
  study_test::add_study(scratch);
  const auto study = study::load_study((scratch / "study.toml").string());
  const auto columns = study::columns_of(*study);
  const study::TallyJob job = study::tally_job(study, columns);
  study::Evaluator evaluator(study);
  std::vector<double> row(columns.size());
  std::vector<study::ConstraintValues> sides(job.limits.size());
  std::int64_t feasible = 0;
  for (std::int64_t design = 0; design < study->designs; ++design) {
    evaluator.evaluate(design, row);
    job.sides(row, sides);
    bool all = true;
    for (std::size_t k = 0; k < sides.size(); ++k) all = all && study::meets(job.limits[k], sides[k]);
    EXPECT_EQ(row[*job.feasible], all ? 1.0 : 0.0) << design;
    feasible += all ? 1 : 0;
  }
  EXPECT_GT(feasible, 0);
  EXPECT_LT(feasible, study->designs);
  EXPECT_EQ(columns[job.goals[0].column].name, "mtf_nyquist");
  EXPECT_EQ(columns[job.goals[1].column].name, "frame.pitch");
}

TEST(RowsOfAStudy, TheirKeyIsThatOfStudyAndTolerance) {
  const Scratch scratch;
  study_test::add_study(scratch);
  const auto study = study::load_study((scratch / "study.toml").string());
  const auto columns = study::columns_of(*study);
  study::Study other = *study;
  EXPECT_EQ(study::layout_of(other, columns), study::layout_of(*study, columns));
  other.tolerance = 1e-5;
  EXPECT_NE(study::layout_of(other, columns), study::layout_of(*study, columns));
  write_file(scratch / "sensor.toml", read_file(scratch / "sensor.toml") + "# more\n");
  EXPECT_NE(study::layout_of(*study::load_study((scratch / "study.toml").string()), columns),
            study::layout_of(*study, columns));
}

TEST(Accuracy, ErrorsCountAsATolerancesDo) {
  const double none = std::nan("");
  EXPECT_DOUBLE_EQ(study::metric_error(0.25, 0.5, true), 0.25);
  EXPECT_DOUBLE_EQ(study::metric_error(3.0, 4.0, true), 0.25);
  EXPECT_DOUBLE_EQ(study::metric_error(0.25, 0.5, false), 0.5);
  EXPECT_EQ(study::metric_error(none, none, true), 0.0);
  EXPECT_EQ(study::metric_error(0.0, 0.0, false), 0.0);
  EXPECT_EQ(study::metric_error(none, 1.0, true), std::numeric_limits<double>::infinity());
}

TEST(Accuracy, APromiseIsBrokenByMoreThanBothSidesAllow) {
  study::AccuracyTable table;
  table.reference_error = 1e-10;
  EXPECT_FALSE(study::broken(table, {.tolerance = 1e-7, .promised = 7e-8, .realised = 7e-8}));
  EXPECT_FALSE(study::broken(table, {.tolerance = 1e-7, .promised = 7e-8, .realised = 7.005e-8}));
  EXPECT_TRUE(study::broken(table, {.tolerance = 1e-7, .promised = 7e-8, .realised = 2.6e-7}));
  EXPECT_FALSE(study::broken(table, {.tolerance = 1e-7, .promised = std::nan(""), .realised = 0.0}));
  EXPECT_TRUE(study::broken(table, {.tolerance = 1e-7, .promised = 7e-8, .realised = HUGE_VAL}));
}

// The rise of the edge of the README's satellite, with the wavelength outside and the frequency inside (numpy, the same
// to 2e-15 with other numbers of nodes).
TEST(Accuracy, TheSatelliteIsAsTheOtherOrderOfIntegralsSays) {
  const auto study = study::load_study(MTFKIT_SOURCE_DIR "/notebooks-data/studies/aperture_against_pitch.toml");
  const auto columns = study::columns_of(*study);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(columns.begin(), columns.end(), [&](const auto& c) { return c.name == name; }) - columns.begin());
  };
  for (int decade = 2; decade <= 10; ++decade) {
    study::Study copy = *study;
    copy.tolerance = std::pow(10.0, -decade);
    study::Evaluator evaluator(std::make_shared<const study::Study>(copy));
    std::vector<double> row(columns.size());
    for (const auto& [aperture_mm, pitch_um, rer] :
         {std::array{300.0, 4.0, 0.229548717252939}, std::array{425.0, 8.0, 0.316979003089328},
          std::array{1200.0, 12.0, 0.556254625746971}}) {
      evaluator.evaluate_at(std::array{aperture_mm, pitch_um}, row);
      EXPECT_LE(std::abs(row[column("rer_x")] - rer), row[column("error")] + 1e-13) << decade << " " << aperture_mm;
      EXPECT_LE(row[column("error")], 1.01 * copy.tolerance) << decade << " " << aperture_mm;
    }
  }
}

TEST(Accuracy, TheTableHoldsWhatItPromises) {
  const Scratch scratch;
  study_test::add_study(scratch);
  const auto study = study::load_study((scratch / "study.toml").string());
  const study::AccuracyTable table = study::accuracy_table(*study, 5.0);
  ASSERT_EQ(table.rows.size(), 8U);
  EXPECT_GE(table.designs, 2);
  EXPECT_LE(table.designs, 64);
  for (const study::AccuracyRow& row : table.rows) {
    EXPECT_LE(row.promised, row.tolerance * (1.0 + 1e-9)) << row.tolerance;
    // The reference is itself within 1e-10.
    EXPECT_LE(row.realised, row.tolerance + table.reference) << row.tolerance;
    EXPECT_GT(row.us_per_design, 0.0);
  }
}

}  // namespace
}  // namespace apps_test
