// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading a study file, part by part: what the parts share. As with sensor files nothing throws for what is in the
// text, everything wrong is collected with its place.

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "apps/study/study.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/config/config_reader.h"

namespace study {

// Which value of a sensor file a name in a study denotes: where it is, whether it is a number that can be set without
// reading the file again, in which unit it is held, and its range.

namespace cfg = mtf::io::cfg;
using cfg::Node;

/// A sensor file in which names are searched.
struct SensorView {
  mtf::io::SensorConfig sensor;
  Node tree;
  cfg::Targets targets;
};

/// The places of a sensor that was read without errors.
SensorView view_of(mtf::io::SensorConfig sensor);

struct Place {
  enum class Kind {
    number,  ///< calib::parameter_site has it, or it is a number of another table of the file
    level    ///< anything else: a value that has to be written into the file
  };
  cfg::Target target;
  Kind kind = Kind::level;
  std::string what{};     ///< what a level is, with its article: "a whole number"
  bool file = false;      ///< true: a text in its place names a file
  mtf::FieldInfo info{};  ///< of numbers: unit as held ("" for plain ones; of an Extent as written), range, example
  double value = 0.0;     ///< value of a number
};

/// A place, or why there is none: a sentence that says what to write.
struct Found {
  std::optional<Place> place;
  std::string problem{};
  bool unknown = false;  ///< true: no sensor file has a value of that name
};

/// "owner.key", "owner.key[3]", or the key alone where one owner has it. A number that the sensor file does not give is
/// not found: its problem says what to write there. Nor is one that a map of the sensor file replaces.
Found find_place(const SensorView& view, std::string_view name);

/// True when setting one changes the other, or what it does: "frame.pitch" and "frame.pitch_x", a list and its element,
/// a map of [nonuniformity] and the number that it replaces.
bool overlap(std::string_view path, std::string_view other);

using cfg::Section;

inline constexpr std::int64_t kMostDesigns = 1'000'000'000;
inline constexpr std::int64_t kMostVariants = 10'000;
inline constexpr std::size_t kMostAxes = 100;
inline constexpr std::size_t kMostExpressions = 1000;  // links, constraints, objectives, [[as_built]], each

/// An expression of the file and where its text starts.
struct Source {
  std::string text;
  mtf::io::Position position;  ///< position of the string
  std::string path;            ///< "constraints[0]"
  int column = 0;              ///< column of the text within the string
};

/// A link as written.
struct LinkSource {
  std::string target;
  mtf::io::Position target_at;
  Source source;
  int parameter = -1;
  bool own = false;  ///< target is a number of the study's own
};

struct StudyReader {
  cfg::Reader reader;
  Node tree{};
  Study study{};
  std::vector<SensorView> views{};                        ///< the base, then the levels of the axis over `sensor`
  int sensor_axis = -1;                                   ///< index of the [[axis]] table, and of the axis
  std::map<std::string, int, std::less<>> by_name{};      ///< parameters, by every name that the study uses
  std::map<std::string, std::string, std::less<>> why{};  ///< why a name cannot stand in an expression
  std::set<std::string, std::less<>> own{};               ///< names of the study's own numbers
  std::vector<LinkSource> links{};
  std::vector<std::string> metric_names{};  ///< names of Study::metrics
  bool axes_good = true;

  Section root() { return {reader, tree, "", ""}; }
  void error(mtf::io::Position position, std::string path, std::string text) {
    reader.error(position, std::move(path), std::move(text));
  }
  void warn(mtf::io::Position position, std::string path, std::string text) {
    reader.note(position, std::move(path), std::move(text), false);
  }
  /// An error at a column of an expression.
  void error_in(const Source& source, int column, std::string text);
};

/// Unknown keys, as for sensor files; those of the top level below a table with where they belong.
void check_study_keys(const Section& section, std::span<const mtf::FieldInfo> keys);

/// `sensor` and the levels of an axis over it. False when there is no base sensor to continue with.
bool read_sensors(StudyReader& s);
/// schema, name, tolerance, seed; [yield]; [conditions].
void read_settings(StudyReader& s);
/// That [conditions] and the air of the sensors do not say the same twice, or two different things.
void check_conditions(StudyReader& s);
/// [[axis]] and [sampling].
void read_axes(StudyReader& s);
void read_sampling(StudyReader& s);
void read_as_built(StudyReader& s);
/// The targets of [links]; their expressions once all names are known.
void read_links(StudyReader& s);
void read_link_expressions(StudyReader& s);
/// [metrics], constraints and objectives: first what they name, then the expressions.
void read_metrics(StudyReader& s);
void register_names(StudyReader& s, const std::vector<Source>& sources);
std::vector<Source> goal_sources(StudyReader& s);
void read_goals(StudyReader& s);
/// Refuses constraints and objectives over metrics that no design can have.
void check_gaps(StudyReader& s);
/// Refuses numbers of the study's own with the name of a column that the tables of this study have for themselves.
void check_column_names(StudyReader& s);

/// Index of the parameter that `name` denotes, made when it is not there yet; -1 with a problem when there is none.
int parameter_named(StudyReader& s, const std::string& name, std::string& problem);
/// A new parameter of a place in the sensor file.
Parameter parameter_of(const std::string& name, const Place& place);
/// Reads an expression over the names that are known; null when it is wrong (reported).
std::optional<Expression> read_expression(StudyReader& s, const Source& source, bool metrics);

/// A number within the range of `info`, in its unit, which is that of the field as held. `given` says by what, for
/// units that do not fit.
std::optional<double> read_held(StudyReader& s, const Node& node, const mtf::FieldInfo& info, const std::string& path,
                                const std::string& given = "in the sensor file");

/// The sensor file with levels, -1 for as it is; `tree` is that of the study.
mtf::io::ConfigResult with_levels(const Study& study, const Node& tree, const SensorView& view,
                                  std::span<const int> levels);
/// Every level of every discrete axis by itself in the base sensor, and that all sensors have what is varied.
void check_levels(StudyReader& s);
/// Level as text.
std::string level_text(const Node& node);

/// 'designs' of a grid in full, whatever its size: "1000000000000".
std::string exact_product(std::span<const std::int64_t> factors);
/// The product, or `limit` + 1 when it is larger.
std::int64_t bounded_product(std::span<const std::int64_t> factors, std::int64_t limit);

/// Why [conditions] extinction cannot stand beside the air of a sensor file, "" where that has none.
std::string extinction_problem(const mtf::io::SensorConfig& sensor);

}  // namespace study
