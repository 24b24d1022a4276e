// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading the tree of a sensor file: one Reader collects what is wrong, one Section is the table being read,
// and a function per type of value turns keys into numbers. Nothing here throws for what is in the file: a value that
// cannot be read is reported, its path is marked as failed, and reading continues.

#include <functional>
#include <map>
#include <set>
#include <span>

#include "mtf/io/config/config_schema.h"
#include "mtf/io/config/config_tree.h"

namespace mtf::io::cfg {

/// A number written as { 1 = -0.3, r2 = 0.5 } or { table = "coma.csv" }, without its value on the axis, or an angle
/// written as "field".
struct FieldTerms {
  std::string path;
  std::string written{};  ///< path of the key that the file has, where that is another
  Position position;
  bool angle = false;
  bool fit = false;  ///< some stand in fit tables, so that they stay terms where they are 0
  std::array<double, kFieldTerms.size()> coefficient{};
  std::shared_ptr<const FieldMap> map{};
  std::size_t column = 0;  ///< of the map
  double factor = 1.0;     ///< of its values
};

struct Reader {
  std::string folder;                 ///< of the sensor file, with a final slash; "" for the current one
  std::span<const TableInfo> schema;  ///< tables beyond those of the system
  std::vector<Diagnostic> diagnostics{};
  std::map<std::string, Position, std::less<>> positions{};  ///< of values, by path
  std::set<std::string, std::less<>> failed{};               ///< paths that were reported already
  std::vector<FitSpec> fits{};
  std::vector<FieldTerms> terms{};                                ///< numbers that change over the field
  std::map<std::string, std::shared_ptr<const FieldMap>> maps{};  ///< of tables that were read, by file; null: not good
  std::vector<std::string> files{};                               ///< that the text names, as `file` gave them

  /// The path of a file that the text names. It joins `files`.
  std::string file(const std::string& name);
  void error(Position position, std::string path, std::string text);
  void note(Position position, std::string path, std::string text, bool remark);
  /// True when the path or a table around it was reported.
  bool has_failed(std::string_view path) const;
  /// Position of the path, of its stem without _x or _y, or of the nearest table around it.
  Position position_of(std::string path) const;
};

/// A table being read. `title` is how messages call it: "[frame]", "[[presample]] jitter".
struct Section {
  Reader& reader;
  const Node& table;
  std::string path;
  std::string title;

  std::string at(std::string_view key) const { return path.empty() ? std::string(key) : path + "." + std::string(key); }
  const Node* find(std::string_view key) const { return table.find(key); }
  /// Reports at the value of `key`, or at the table when the key is absent.
  void error(std::string_view key, std::string text) const;
};

/// Reports every key that is not known, with the nearest and the known ones.
void check_keys(const Section& section, std::span<const std::string_view> known);
void check_keys(const Section& section, const std::vector<std::string>& known);

/// The table under `key` of `parent`; null when absent, and when it is no table (reported).
const Node* find_table(const Section& parent, std::string_view key);

/// The list of tables [[key]] of `parent`; null when absent, and when it is none (reported).
const Node* find_tables(const Section& parent, std::string_view key);

/// A number in `unit`; unit is null for plain numbers.
struct Scalar {
  double value = 0.0;
  const Unit* unit = nullptr;
};

/// The value in info.unit; in the unit it was written in where info.unit is empty. No table.
std::optional<Scalar> read_plain(Reader& reader, const Node& node, const FieldInfo& info, const std::string& path);

/// A value or a table { value, fit, min, max, prior, stderr, interval }, which leaves a FitSpec.
std::optional<Scalar> read_scalar(const Section& section, const FieldInfo& info, std::string_view key);

/// Such a table alone; the value of it when usable.
std::optional<Scalar> read_fit(Reader& reader, const Node& table, const FieldInfo& info, const std::string& path);

/// A value within the range of `info`, no table: for what is never fitted.
std::optional<double> read_number(const Section& section, const FieldInfo& info, std::string_view key);

/// `name`, or `name_x` and `name_y`. False when absent or reported. `fittable`: tables allowed.
bool read_axis_pair(const Section& section, const FieldInfo& info, AxisPair<double>& pair, bool fittable);

std::optional<std::string> read_string(const Section& section, std::string_view key);
/// Index into `names`.
std::optional<int> read_word(const Section& section, std::string_view key, std::span<const std::string_view> names);
std::optional<int> read_whole(const Section& section, const FieldInfo& info);
std::optional<Taps<double>> read_taps(const Section& section, std::string_view key);
/// A list of plain numbers or fit tables, which leave a FitSpec of the path name[i].
std::optional<Coefficients<double>> read_coefficients(const Section& section, const FieldInfo& info);
/// A word of mtf/io/codecs/encoding.h, or the name of a table file.
std::optional<Encoding> read_encoding(const Section& section, std::string_view key);
std::shared_ptr<const Curve> read_curve(const Section& section, std::string_view key);

/// What a text that has errors is, when it is a file of another kind: it has the key that marks that one ("frame" of a
/// sensor, "mesh" of a 3-D scene, "sensor" of a study), and not the key `ours`. "" when it is not.
std::string another_kind(const std::vector<Diagnostic>& diagnostics, const std::string& text, std::string_view ours);

/// Errors by their place, then warnings.
void sort_diagnostics(std::vector<Diagnostic>& diagnostics);

/// Throws UsageError with every error of a file, a line each, where there is one.
void require_no_errors(const std::vector<Diagnostic>& diagnostics, const std::string& file);

/// The fields as lines of a component's table. In config_write.cpp.
std::string write_fields(std::span<const FieldRef<double>> fields);

/// A number as sensor files have it: 8.0, or "8 urad". In config_write.cpp.
std::string toml_scalar(const Scalar& scalar);

/// A number that stands under `key`, read as the value of the same table is.
using ReadNumber =
    std::function<std::optional<double>(const Section& section, std::string_view key, const Node& number)>;

// A table { value, fit, min, max, prior, stderr, interval }, whose value its reader knows.
/// The value; null when there is none (reported). Checks the keys.
const Node* find_value(const Section& table, const FieldInfo& info);
/// All other keys, into a spec whose value is there. `spread`: of standard errors and deviations.
void read_beside_value(const Section& table, FitSpec& spec, const ReadNumber& like, const ReadNumber& spread);

/// A table of terms over the field, or the word that lets an angle turn with the field point: its value on the axis,
/// when usable. Null for what is neither. In config_components.cpp.
bool is_over_field(const Node& node, const FieldInfo& info);
/// One of kFieldTerms, or "1" for the value on the optical axis.
bool is_field_term(std::string_view key);
std::optional<Scalar> read_over_field(Reader& reader, const Node& node, const FieldInfo& info, const std::string& path);
/// Reports terms of numbers that are no component's, such as the focal length.
void refuse_over_field(Reader& reader);
/// How a sensor file has the number at that path: { 1 = "2 urad", r2 = "0.5 urad" }; "" where it is one number.
/// `text`: a term's number at its own path, or nothing where it need not be written. `file`: the name of a table's file
/// there.
std::string over_field_text(const System<double>& system, std::string_view path, const Scalar& on_axis,
                            const std::function<std::string(const std::string& path, const Scalar& number)>& text,
                            const std::function<std::string(const std::string& source)>& file);

// Tables over the field. In config_field_map.cpp.
inline constexpr std::string_view kTableKey = "table";
/// A key of a presample component whose file stands for a member over the field.
struct FileKey {
  std::string_view kind, key, member, doc;
};
inline constexpr std::array kFileKeys{
    FileKey{"psf", "positions", "samples",
            "CSV file of positions, each with an OpenEXR or NPY file of the samples there"},
    FileKey{"curve", "positions", "file", "CSV file of positions, each with a CSV file of the curve there"},
    FileKey{"flow", "displacements", "shift",
            "image of the whole detector with the shift of each place in px: OpenEXR channels x and y, or NPY"}};
/// The map that stands for the member at that path, "presample[0].samples"; null where its numbers are its own.
std::shared_ptr<const FieldMap> map_for_member(const System<double>& system, std::string_view path, const FileKey& key);
/// The column of the table `file` for the number at `terms.path`; 0 in the unit of the number, when usable.
std::optional<Scalar> read_column(Reader& reader, const Node& file, const FieldInfo& info, FieldTerms& terms);
/// A component whose `table` gives numbers over the field as one with { table = ... } for each of them; nothing where
/// it has no `table`.
std::optional<Node> with_columns(const Section& section, std::span<const FieldRef<double>> fields);
/// A member from the file that its key in kFileKeys names: sized, as nothing on the axis but with terms, which bring
/// it. Nothing where there is no such key; false where it was reported.
std::optional<bool> read_file_over_field(const Section& section, const FieldRef<double>& field);
/// Says how well the tables of a component are interpolated.
void note_maps(Reader& reader, const System<double>& system, std::size_t entry, Position position,
               const std::string& path);

/// `missing; write rms = "8 urad" (rms displacement of one axis, one sigma)`
std::string missing_text(const FieldInfo& info);
/// Of a bare number where a quantity belongs: which unit was meant is not known, so the example is the row's.
std::string lacks_unit_text(const Node& node, const FieldInfo& info);
/// "did you mean …" and the list of what is known.
std::string suggestion(std::string_view word, std::span<const std::string_view> known);

/// `origin[stage][i]` is the place in the file of list(stage)[i].
using Origin = std::array<std::vector<std::size_t>, 3>;

/// [frame], [optics], [band], [scene] into the configuration. In config_sections.cpp.
void read_sections(const Section& root, SensorConfig& config);

/// The values of a component's table, key by key; reports those that are missing or unknown. In config_components.cpp.
void read_fields(const Section& section, std::span<const FieldRef<double>> fields);

/// [[presample]], [[readout]], [[postsample]]. In config_components.cpp.
Origin read_components(const Section& root, System<double>& system);

/// The whole tree of a sensor file into system, scene and fits of `result`, with everything that is wrong in it; the
/// file's name has to be there already. In config.cpp.
void interpret(const Node& tree, ConfigResult& result);

/// Names of all tables; the keys of one, with those that the schema adds to it. In config_sections.cpp.
std::vector<std::string_view> known_tables(std::span<const TableInfo> schema);
std::vector<std::string> known_keys(std::span<const TableInfo> schema, std::string_view table);

/// The tables that hold for this file: of those of one name the one whose condition the file fulfils. In
/// config_sections.cpp.
std::vector<TableInfo> schema_of(const Node& root, std::vector<TableInfo> schema);
/// The tables of the schema that are in the file. In config_sections.cpp.
std::vector<SettingsTable> read_settings(const Section& root);

/// Labels of a list of components, explicit where given: the kind, numbered from the second one.
std::vector<std::string> complete_labels(const std::vector<std::string>& kinds,
                                         const std::vector<std::optional<std::string>>& labels);

/// Curve file as written in a sensor file, to a path.
std::string beside(const std::string& folder, const std::string& name);
std::string folder_of(const std::string& file);

}  // namespace mtf::io::cfg
