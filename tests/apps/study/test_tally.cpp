// SPDX-License-Identifier: Apache-2.0
// What a sweep says about rows that are counted by hand.

#include <gtest/gtest.h>

#include "apps/study/statistics/tally.h"

namespace {

using study::ConstraintValues;
using study::Tally;
using study::TallyJob;

// Columns: x, y, feasible, error. Constraints: x < 5, y > 1 (strict) and x + y <= 9.
constexpr std::size_t kColumns = 4;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TallyJob job() {
  return {.columns = kColumns,
          .goals = {{0, true}, {1, false}},
          .feasible = 2,
          .error = 3,
          .limits = {{true, true}, {false, true}, {true, false}},
          .sides = [](std::span<const double> row, std::span<ConstraintValues> sides) {
            sides[0] = {row[0], 5.0};
            sides[1] = {row[1], 1.0};
            sides[2] = {row[0] + row[1], 9.0};
          }};
}

std::vector<double> row_of(double x, double y, double error = 1e-6) {
  const bool good = x < 5.0 && y > 1.0 && x + y <= 9.0;
  return {x, y, good ? 1.0 : 0.0, error};
}

/// The rows in pieces of `piece`, the counting in order.
Tally tally_of(const std::vector<std::vector<double>>& rows, std::size_t piece) {
  Tally tally(job());
  std::vector<std::function<void()>> counts;
  for (std::size_t first = 0; first < rows.size(); first += piece) {
    std::vector<double> numbers;
    const std::size_t end = std::min(rows.size(), first + piece);
    for (std::size_t i = first; i < end; ++i) numbers.insert(numbers.end(), rows[i].begin(), rows[i].end());
    counts.push_back(tally.count({static_cast<std::int64_t>(first), static_cast<std::int64_t>(end - first)}, numbers));
  }
  for (const auto& count : counts) count();
  return tally;
}

const std::vector<std::vector<double>> kRows{
    row_of(4.0, 2.0, 3e-6),     // 0 feasible
    row_of(6.0, 3.0),           // 1 x too large; the sum is at its limit
    row_of(4.5, 4.5),           // 2 feasible: the largest x, the sum at its limit
    row_of(4.0, 2.0),           // 3 as 0
    row_of(kNone, 2.0, kNone),  // 4 no x
    row_of(3.0, 1.0),           // 5 y at a strict limit: not met
    row_of(1.0, 1.004),         // 6 feasible: the smallest y, within 1 % of its limit
};

TEST(TallyOfRows, CountsBestAndFrontAreThoseByHand) {
  for (const std::size_t piece : {1U, 2U, 7U}) {
    const Tally tally = tally_of(kRows, piece);
    EXPECT_EQ(tally.designs(), 7);
    EXPECT_EQ(tally.feasible(), 4);
    EXPECT_EQ(tally.met(), (std::vector<std::int64_t>{5, 6, 6}));
    EXPECT_EQ(tally.missing(), (std::vector<std::int64_t>{1, 0, 0, 1}));
    EXPECT_EQ(tally.worst_error(), 3e-6);
    EXPECT_EQ(tally.best()[0].design, 2);
    EXPECT_EQ(tally.best()[0].value, 4.5);
    EXPECT_EQ(tally.best()[1].design, 6);
    EXPECT_EQ(tally.front().designs, (std::vector<std::int64_t>{0, 2, 6}));
    EXPECT_TRUE(tally.contradictions().empty());
  }
}

TEST(TallyOfRows, ActiveIsWithinAShareOfTheLimit) {
  EXPECT_TRUE(study::active({9.0, 9.0}, 0.01));
  EXPECT_TRUE(study::active({1.004, 1.0}, 0.01));
  EXPECT_FALSE(study::active({4.0, 5.0}, 0.01));
  EXPECT_TRUE(study::active({0.0, 0.0}, 0.01));
  EXPECT_FALSE(study::active({kNone, 1.0}, 0.01));
}

TEST(TallyOfRows, NearestIsOfLeastScaledViolation) {
  // Violations: 0: (10-5)/10 + (11-9)/11 = 0.682; 1: (1-0.5)/1 = 0.5; 2 as 1; 3 has no number.
  const std::vector<std::vector<double>> rows{row_of(10.0, 1.0001), row_of(1.0, 0.5), row_of(1.0, 0.5),
                                              row_of(kNone, 0.9)};
  for (const std::size_t piece : {1U, 3U, 4U}) {
    const Tally tally = tally_of(rows, piece);
    EXPECT_EQ(tally.feasible(), 0);
    EXPECT_EQ(tally.nearest().design, 1);
    EXPECT_DOUBLE_EQ(tally.nearest().value, 0.5);
    EXPECT_EQ(tally.best()[0].design, -1);
    EXPECT_TRUE(tally.front().designs.empty());
  }
  // A design that meets more, but has no number for an objective, is no design to go to.
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(tally_of({row_of(-infinite, 2.0), row_of(6.0, 3.0)}, 1).nearest().design, 1);
  EXPECT_EQ(tally_of({row_of(kNone, 0.9), row_of(kNone, 2.0)}, 1).nearest().design, 1);
  EXPECT_EQ(tally_of({row_of(kNone, kNone), row_of(kNone, 0.9)}, 1).nearest().design, 1);
}

TEST(TallyOfRows, ContradictionsAreTheSmallestSetsThatNoDesignMeets) {
  using Sets = std::vector<std::vector<std::size_t>>;
  EXPECT_EQ(tally_of({row_of(6.0, 2.0), row_of(7.0, 0.5)}, 1).contradictions(), (Sets{{0}}));
  // x < 5 and y > 1 are each met, never by one design.
  EXPECT_EQ(tally_of({row_of(1.0, 0.5), row_of(6.0, 2.0)}, 1).contradictions(), (Sets{{0, 1}}));
  // Every two are met, never all three.
  EXPECT_EQ(tally_of({row_of(1.0, 0.5), row_of(6.0, 2.0), row_of(4.0, 9.0)}, 2).contradictions(), (Sets{{0, 1, 2}}));
  EXPECT_TRUE(tally_of({}, 1).contradictions() == (Sets{{0}, {1}, {2}}));
}

}  // namespace
