// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks of the numbers on this machine and build: what `mtf check` runs, and the test suite too. A check compares many
// values with references that come from elsewhere (tables of high precision, slow sums in double) and holds each to the
// error that is promised for it. To add one: an entry in the list of its family, and its table in
// notebooks-data/reference.

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/device/device.h"

namespace apps::check {

// The CSV tables of notebooks-data/reference: comma separated, one header row, numbers in decimal or hexadecimal. All
// of them are part of the program (CMakeLists.txt turns the folder into a source), so that an installed binary checks
// itself without its source tree.

/// One row, by column name. `where` is "file:line" for messages.
struct Row {
  std::string where;
  std::map<std::string, std::string, std::less<>> cells;

  /// Throws UsageError when there is no such column.
  const std::string& at(std::string_view column) const;
};

/// A cell as a double. Throws UsageError when it is not a number.
double number(const Row& row, std::string_view column);
/// The same with the digits beyond double that a comparison can use.
long double precise(const Row& row, std::string_view column);

/// Rows of CSV text. Throws UsageError for rows of another length than the header, and when there are none.
std::vector<Row> parse_table(const std::string& name, std::string_view text);

struct BuiltInTable {
  std::string_view name;
  std::string_view text;
};
/// Every table of notebooks-data/reference at the time of the build, by name.
std::span<const BuiltInTable> built_in_tables();

/// The tables that a run of checks reads: the built-in ones, or files of the same names in a folder in their place.
class Tables {
 public:
  Tables() = default;
  /// Throws UsageError when the folder has no CSV file, or one that no check reads (with the name probably meant).
  explicit Tables(const std::string& folder);
  std::vector<Row> rows(const std::string& name) const;

 private:
  std::map<std::string, std::string> own_;  ///< text by name
};

struct CheckResult {
  std::string component;   ///< what was checked: "diffraction", "engine", ...
  std::string name;        ///< which case of it
  std::string promise;     ///< the error allowed, in words
  std::int64_t count = 0;  ///< comparisons made
  double worst_abs = 0.0;  ///< largest |value - exact|; infinity when a value was not finite
  double worst_rel = 0.0;  ///< largest |value - exact| / |exact| where |exact| is a normal double
  bool passed = true;      ///< every comparison within its own allowance, and at least one made
  std::string failure{};   ///< the worst one that was not, "" when there is none
};

/// Collects comparisons.
class Tally {
 public:
  /// |value - exact| <= allowed. NaN never passes. `where` names the comparison in a failure.
  void compare(double value, long double exact, long double allowed, std::string_view where);
  /// A comparison whose error was taken elsewhere: `scale` makes it relative.
  void error(long double error, long double scale, long double allowed, std::string_view where);

  std::int64_t count() const { return count_; }
  double worst_abs() const { return worst_abs_; }
  double worst_rel() const { return worst_rel_; }
  const std::string& failure() const { return failure_; }

  mtf::DeviceChoice device{};  ///< that checks of the engine are about; none: the processor

 private:
  bool note(long double error, long double scale, long double allowed);

  std::int64_t count_ = 0;
  double worst_abs_ = 0.0, worst_rel_ = 0.0;
  long double worst_excess_ = 1.0L;  ///< error / allowed of the failure shown
  std::string failure_;
};

struct Check {
  std::string component;
  std::string name;
  std::string promise;
  std::function<void(const Tables&, Tally&)> run;
};

/// All checks, in the order they are shown; of a device its engine.
std::vector<Check> all_checks(const mtf::DeviceChoice& device = {});

CheckResult run(const Check& check, const Tables& tables);

/// The lists of checks, one file a family; all_checks() joins them.
std::vector<Check> special_checks();     ///< sinc, Gaussian, Bessel functions
std::vector<Check> pupil_checks();       ///< diffraction
std::vector<Check> aberration_checks();  ///< defocus, wavefront by coefficients
std::vector<Check> turbulence_checks();  ///< Kolmogorov, both exposures
std::vector<Check> motion_checks();      ///< Fresnel integrals, accelerated motion
std::vector<Check> component_checks();   ///< golden values of each kind
std::vector<Check> radiometry_checks();  ///< blackbodies, where radiometry is built
/// Plans at the extremes of size, scale, contrast and OTF: of the processor, or of a device and what it can do.
std::vector<Check> engine_checks(const mtf::DeviceChoice& device = {});

}  // namespace apps::check
