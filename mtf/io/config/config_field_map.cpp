// SPDX-License-Identifier: Apache-2.0

// Numbers of components by tables over the field: of one number, w131 = { table = "coma.csv" }, or of a component,
//   table = "zernike.csv"      each column is the number that it is called as: w020, rms, zernike[3] or Z4
// which is read as if each of these numbers were written with that table. The samples of a psf come from files at
// positions, positions = "psfs.csv", as numbers of one table: OTFs are linear in samples whose sum is 1.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "mtf/components/component_docs.h"
#include "mtf/error.h"
#include "mtf/field/field_map.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/csv/field_map_csv.h"
#include "mtf/io/image_io.h"
#include "mtf/io/npy.h"
#include "mtf/words.h"

namespace mtf::io::cfg {
namespace {

constexpr std::size_t kMostElements = 256;  // of a list
constexpr std::size_t kMostNoted = 4;       // numbers of a component
constexpr double kDoubtful = 0.05;          // of the range of a number over the field

std::shared_ptr<const FieldMap> read_map(Reader& reader, const Node& file, const std::string& path) {
  reader.positions[path] = file.position;
  const auto fail = [&](const std::string& text) {
    reader.error(file.position, path, text);
    return nullptr;
  };
  if (file.kind != Node::Kind::string || file.text.empty() || file.text.find('\0') != std::string::npos)
    return fail("the name of a CSV file belongs here, such as \"coma.csv\"");
  const auto [known, is_new] = reader.maps.try_emplace(file.text);
  if (!known->second && !is_new) reader.failed.insert(path);
  if (is_new) try {
      known->second = read_field_map_csv(reader.file(file.text));
    } catch (const Error& error) {
      return fail(printable(error.what(), 600));
    }
  return known->second;
}

/// Member and element of a number.
struct ColumnKey {
  std::string member;
  std::optional<std::size_t> element{};
  bool operator==(const ColumnKey&) const = default;
};

/// Of "w131", "rms_x", "zernike[3]" or "z4", its other name.
ColumnKey column_key(std::string_view name) {
  std::size_t number = 0;
  const auto whole = [&](std::string_view text) {
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
    return status == std::errc{} && end == text.data() + text.size();
  };
  if (name.starts_with('z') && whole(name.substr(1)) && number > 0) return {"zernike", number - 1};
  const std::size_t open = name.find('[');
  if (open != std::string_view::npos && name.ends_with(']') && whole(name.substr(open + 1, name.size() - open - 2)))
    return {std::string(name.substr(0, open)), number};
  return {std::string(name)};
}

bool takes_map(const FieldInfo& info) {
  return info.type == FieldType::number || info.type == FieldType::size || info.type == FieldType::frequency ||
         info.type == FieldType::numbers;
}

/// The number itself, made where it is not there.
Node& number_node(Node& component, const ColumnKey& key, Position position) {
  const Node zero{.kind = Node::Kind::real, .position = position, .text = {}, .items = {}, .members = {}};
  auto found = std::ranges::find(component.members, key.member, &Member::key);
  if (found == component.members.end()) {
    component.members.push_back({key.member, position, zero});
    found = component.members.end() - 1;
    if (key.element) found->value.kind = Node::Kind::array;
  }
  if (!key.element) return found->value;
  std::vector<Node>& items = found->value.items;
  if (items.size() <= *key.element) items.resize(*key.element + 1, zero);
  return items[*key.element];
}

constexpr std::uint64_t kMostSide = 257;  // of a point spread, in samples

void require_pixels(const std::string& path, std::uint64_t columns, std::uint64_t rows) {
  if (std::max(columns, rows) > kMostSide)
    throw UsageError(path + ": " + size_text(columns, rows) + " samples, at most " + size_text(kMostSide, kMostSide) +
                     " are interpolated over the field; cut the point spread where it has ended");
}

/// Samples of a point spread.
Image read_samples(const std::string& path) {
  Image samples;
  if (path.ends_with(".npy")) {
    NpyReader file(path);
    if (file.shape().size() != 2 || !file.is_float())
      throw UsageError(path + ": rows and columns of floats belong here; it has " +
                       std::to_string(file.shape().size()) + " dimensions of the type " + file.type());
    require_pixels(path, file.shape()[1], file.shape()[0]);
    samples = Image(static_cast<std::int64_t>(file.shape()[1]), static_cast<std::int64_t>(file.shape()[0]));
    file.read(0, {samples.data(), static_cast<std::size_t>(samples.size())});
  } else {
    ImageFile file = read_image(path, {});
    if (file.planes.size() != 1 || file.integer)
      throw UsageError(path + ": a point spread is one channel of floats (OpenEXR or NPY)");
    samples = std::move(file.planes.front());
    require_pixels(path, static_cast<std::uint64_t>(samples.width()), static_cast<std::uint64_t>(samples.height()));
  }
  return samples;
}

void note_map(Reader& reader, const System<double>& system, std::size_t entry, const FieldMap* map, Position position,
              const std::string& path) {
  struct Missed {
    double share = 0.0;
    std::string text;
  };
  std::vector<Missed> missed;
  double otf = 0.0;  // of samples: no more than the sum of what each is missed by
  const auto fields = system.list(Stage::presample).at(entry).component.fields();
  for (const FieldNumber<double>& number : system.field.numbers) {
    if (number.entry != entry || number.map.get() != map) continue;
    const FieldMap::Column& column = map->column[number.column];
    if (!column.missed)
      return reader.note(position, path,
                         map->source + " has so few positions that nothing tells what lies between them", false);
    const auto [rms, most] = *column.missed;
    if (fields[number.field].info->type == FieldType::rows) otf += rms;
    const auto [low, high] = std::ranges::minmax(column.value);
    const std::string_view unit = column.unit != nullptr ? column.unit->name : "";
    if (high > low && otf == 0.0)
      missed.push_back({rms / (high - low), column.name + " by " + mtf::with_unit(significant(rms, 2), unit) +
                                                " rms, " + mtf::with_unit(significant(most, 2), unit) + " at most"});
  }
  if (otf > 0.0) missed = {{otf, "the OTF by no more than " + significant(otf, 2) + " rms"}};
  if (missed.empty()) return;
  std::ranges::stable_sort(missed, std::ranges::greater{}, &Missed::share);
  const bool doubtful = missed.front().share > kDoubtful;
  const std::size_t shown = std::min(missed.size(), kMostNoted);
  reader.note(position, path,
              "numbers between the " + std::to_string(map->position.size()) + " positions of " + map->source +
                  " are interpolated; where a position is left out, that misses " +
                  joined(
                      std::span(missed).first(shown), [](const Missed& number) { return number.text; }, "; ") +
                  (missed.size() > shown ? ", the others by smaller shares" : "") +
                  (doubtful ? "; give positions that are closer together" : ""),
              !doubtful);
}

}  // namespace

std::optional<Scalar> read_column(Reader& reader, const Node& file, const FieldInfo& info, FieldTerms& terms) {
  const auto fail = [&](const std::string& text) {
    reader.error(file.position, terms.path, text);
    return std::nullopt;
  };
  terms.map = read_map(reader, file, terms.path + "." + std::string(kTableKey));
  if (!terms.map) return std::nullopt;
  const std::vector<FieldMap::Column>& columns = terms.map->column;
  const std::string key = terms.path.substr(terms.path.rfind('.') + 1);
  const auto named = std::ranges::find_if(
      columns, [&](const FieldMap::Column& column) { return column_key(column.name) == column_key(key); });
  if (named == columns.end() && columns.size() > 1)
    return fail(terms.map->source + " has no column " + key +
                " (found: " + printable(joined(columns, [](const auto& column) { return column.name; }), 200) + ")");
  terms.column = named == columns.end() ? 0 : static_cast<std::size_t>(named - columns.begin());
  const Unit* unit = columns[terms.column].unit;
  const std::string header = terms.map->source + ": the column " + columns[terms.column].name;
  if (info.dimension == Dimension::none) {
    if (unit != nullptr) return fail(header + " has a unit, and " + key + " is a plain number");
    return Scalar{};
  }
  const auto units = units_of(info.dimension);
  if (unit == nullptr || std::ranges::find(units, unit->name) == units.end())
    return fail(header + (unit == nullptr ? " has no unit" : " is in " + std::string(unit->name)) +
                "; write the unit behind its name, such as " + key + " (" + std::string(units.front()) + ")");
  if (info.unit.empty()) return Scalar{0.0, unit};
  terms.factor = convert({1.0, unit}, info.unit);
  return Scalar{0.0, find_unit(info.unit)};
}

std::optional<Node> with_columns(const Section& section, std::span<const FieldRef<double>> fields) {
  const Node* file = section.find(kTableKey);
  if (file == nullptr) return std::nullopt;
  Node component = section.table;
  std::erase_if(component.members, [](const Member& member) { return member.key == kTableKey; });
  const auto map = read_map(section.reader, *file, section.at(kTableKey));
  if (!map) {
    section.reader.failed.insert(section.path);  // what it would have given is not missing
    return component;
  }
  std::vector<std::string> keys;
  for (const FieldRef<double>& field : fields)
    if (takes_map(*field.info))
      for (std::string& key : keys_of(*field.info)) keys.push_back(std::move(key));
  for (const FieldMap::Column& column : map->column) {
    const ColumnKey key = column_key(column.name);
    const auto field = std::ranges::find(fields, key.member, [](const auto& one) { return one.info->name; });
    const bool is_list = field != fields.end() && field->info->type == FieldType::numbers;
    if (std::ranges::find(keys, key.member) == keys.end() || is_list != key.element.has_value() ||
        key.element.value_or(0) >= kMostElements) {
      section.error(kTableKey, map->source + ": the column " + printable(column.name, 40) + " is no number of " +
                                   section.title + " (numbers: " + joined(keys) + "); leave it out or rename it");
      continue;
    }
    Node& number = number_node(component, key, file->position);
    if (number.is_number() && number.number == 0.0)
      number = {.kind = Node::Kind::table, .position = file->position, .text = {}, .items = {}, .members = {}};
    if (number.kind == Node::Kind::table && number.find(kTableKey) != nullptr)
      section.error(key.member, "is a column of " + map->source + ", too; remove its own table or one of the columns");
    else if (number.kind == Node::Kind::table)
      number.members.push_back({std::string(kTableKey), file->position, *file});
    else
      section.error(key.member, "is a column of " + map->source + ", too; to add to that write { 1 = " + shown(number) +
                                    " }, or remove one of them");
  }
  return component;
}

std::optional<Node> with_samples(const Section& section, std::span<const FieldRef<double>> fields) {
  const auto rows_field =
      std::ranges::find(fields, FieldType::rows, [](const auto& field) { return field.info->type; });
  const Node* list = section.find(kPositionsKey);
  if (list == nullptr || rows_field == fields.end()) return std::nullopt;
  Node component = section.table;
  std::erase_if(component.members, [](const Member& member) { return member.key == kPositionsKey; });
  Reader& reader = section.reader;
  const std::string key(rows_field->info->name), path = section.at(kPositionsKey);
  reader.positions[path] = list->position;
  const auto fail = [&](const std::string& text) {
    section.error(kPositionsKey, printable(text, 600));
    reader.failed.insert(section.path);
    return component;
  };
  if (section.find(key) != nullptr) return fail("given together with " + key + "; remove one of them");
  if (list->kind != Node::Kind::string) return fail("the name of a CSV file with columns x, y and file belongs here");
  std::int64_t width = 0, height = 0;
  try {
    FieldFiles files = read_field_files_csv(reader.file(list->text));
    require_positions(files.positions);  // before that many files are read
    for (const std::string& name : files.file) {
      const Image samples = read_samples(reader.file(name));
      if (width == 0) width = samples.width(), height = samples.height();
      if (samples.width() != width || samples.height() != height)
        throw UsageError(name + ": " + size_text(samples.width(), samples.height()) + " samples, where " +
                         files.file.front() + " has " + size_text(width, height) + "; give all one size");
      const std::span values(samples.data(), static_cast<std::size_t>(samples.size()));
      const double sum = std::accumulate(values.begin(), values.end(), 0.0);
      if (!(sum > 0.0) || !std::isfinite(sum))
        throw UsageError(name + ": the sum of the samples, by which they are divided, is " + format_double(sum) +
                         "; a point spread is positive but for noise and rings");
      files.positions.column.resize(values.size());
      for (std::size_t i = 0; i < values.size(); ++i) files.positions.column[i].value.push_back(values[i] / sum);
    }
    const auto map = make_field_map(std::move(files.positions));
    for (std::size_t i = 0; i < map->column.size(); ++i)
      reader.terms.push_back({.path = section.at(key) + "[" + std::to_string(i) + "]",
                              .position = list->position,
                              .coefficient = {},
                              .map = map,
                              .column = i});
  } catch (const Error& error) {
    return fail(error.what());
  }
  // Their values on the axis come with their terms.
  const auto node = [&](Node::Kind kind) {
    return Node{.kind = kind, .position = list->position, .text = {}, .items = {}, .members = {}};
  };
  Node row = node(Node::Kind::array), all = row;
  row.items.assign(static_cast<std::size_t>(width), node(Node::Kind::real));
  all.items.assign(static_cast<std::size_t>(height), row);
  component.members.push_back({key, list->position, std::move(all)});
  return component;
}

void note_maps(Reader& reader, const System<double>& system, std::size_t entry, Position position,
               const std::string& path) {
  std::vector<const FieldMap*> maps;
  for (const FieldNumber<double>& number : system.field.numbers)
    if (number.entry == entry && number.map && std::ranges::find(maps, number.map.get()) == maps.end())
      maps.push_back(number.map.get());
  for (const FieldMap* map : maps) note_map(reader, system, entry, map, position, path);
}

}  // namespace mtf::io::cfg
