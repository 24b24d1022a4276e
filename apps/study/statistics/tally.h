// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts over the rows of a sweep: how many meet the constraints, which are best, which lie on the Pareto front, which
// is nearest to feasible where none is. Rows come piece by piece (row_table.h).

#include <functional>
#include <limits>
#include <optional>
#include <set>

#include "apps/study/rows/row_table.h"
#include "apps/study/statistics/pareto.h"
#include "apps/study/study.h"

namespace study {

struct TallyLimit {
  bool less = true;  ///< left < right, else left > right
  bool strict = true;
};

struct TallyGoal {
  std::size_t column = 0;
  bool maximize = false;
};

/// Which columns of a row hold what is counted.
struct TallyJob {
  std::size_t columns = 0;
  std::vector<TallyGoal> goals{};
  std::optional<std::size_t> feasible{}, error{}, yield{};
  std::vector<TallyLimit> limits{};
  /// ConstraintValues of every constraint of a row; called from several threads.
  std::function<void(std::span<const double> row, std::span<ConstraintValues> sides)> sides{};
};

struct TallyDesign {
  std::int64_t design = -1;  ///< number of the design; -1 = there is none
  double value = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> row{};
};

/// Designs that are never feasible, best or on the front: those that no sensor can be, and those with an objective or a
/// side of a constraint that is infinite or no number.
struct InvalidDesigns {
  std::int64_t designs = 0, first = -1;
  std::int64_t impossible = 0;                  ///< no sensor has these values
  std::vector<std::int64_t> by_goal, by_limit;  ///< of the others: what is not finite; a design may count twice
  void add(const InvalidDesigns& others);
};

/// Returns false where a side is not finite.
bool meets(const TallyLimit& limit, ConstraintValues sides);
/// True when the sides differ by at most `share` of the larger of them.
bool active(ConstraintValues sides, double share);
/// The distance of a constraint from being met, as a share of its larger side, 0 to 2; 0 where it is met, NaN where a
/// side is not finite.
double violation(const TallyLimit& limit, ConstraintValues sides);

class Tally {
 public:
  explicit Tally(TallyJob job);

  /// The work on a piece, for read_pieces() of row_table.h.
  std::function<void()> count(RowRange range, std::span<const double> rows);

  std::int64_t designs() const { return all_.designs; }
  /// Without constraints it is the number of designs that are not invalid.
  std::int64_t feasible() const { return all_.feasible; }
  const InvalidDesigns& invalid() const { return all_.invalid; }
  double worst_error() const { return all_.worst_error; }                    ///< NaN where no design has one
  const std::vector<std::int64_t>& met() const { return all_.met; }          ///< by constraint
  const std::vector<std::int64_t>& missing() const { return all_.missing; }  ///< NaN by column
  const std::vector<TallyDesign>& best() const { return all_.best; }  ///< feasible, by goal; the first of equal ones
  const TallyDesign& highest_yield() const { return all_.highest_yield; }
  /// The design of least violation (summed over the constraints; `value`; one that has no number counts 1000, and
  /// so does a design that no sensor can be or that has no number for an objective), the first of equal ones.
  const TallyDesign& nearest() const { return all_.nearest; }
  /// Feasible designs of the Pareto front in the order of their numbers, with their goals (negative where less is
  /// better); none with fewer than two goals.
  FrontPoints front() const;
  /// Sets of constraints that no design meets together though it meets any fewer of them; the smallest sets, of at most
  /// four constraints, the first ten. Empty when a design meets all.
  std::vector<std::vector<std::size_t>> contradictions() const;

  const TallyJob& job() const { return job_; }

 private:
  /// What is counted, in one piece or in all.
  struct Part {
    std::int64_t designs = 0, feasible = 0;
    double worst_error = std::numeric_limits<double>::quiet_NaN();
    InvalidDesigns invalid{};
    std::vector<std::int64_t> met, missing;
    std::vector<TallyDesign> best;
    TallyDesign nearest{}, highest_yield{};
    std::set<std::uint64_t> patterns{};  // of constraints met together; all of them unless too_many_
  };
  static Part nothing_of(const TallyJob& job);
  void add(Part part, const FrontPoints& front);

  TallyJob job_;
  Part all_;
  StreamingFront front_;
  bool too_many_ = false;
};

}  // namespace study
