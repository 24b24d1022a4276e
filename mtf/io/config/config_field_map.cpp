// SPDX-License-Identifier: Apache-2.0

// Numbers of components by tables over the field: of one number, w131 = { table = "coma.csv" }, or of a component,
//   table = "zernike.csv"      each column is the number that it is called as: w020, rms, zernike[3] or Z4
// which is read as if each of these numbers were written with that table. Files stand for other members (kFileKeys):
// the samples of a psf at positions, as numbers of one table, as OTFs are linear in samples whose sum is 1; curves at
// positions, whose weights are numbers of a table with 1 at the position of each and 0 at the others; an image of the
// two parts of a shift.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "mtf/components/component_docs.h"
#include "mtf/error.h"
#include "mtf/field/field_map.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/csv/curve_csv.h"
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

std::shared_ptr<const FieldMap> samples_at(Reader& reader, const std::string& path, Taps<double>& rows) {
  FieldFiles files = read_field_files_csv(path);
  require_positions(files.positions);  // before that many files are read
  std::int64_t width = 0, height = 0;
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
  rows.assign(static_cast<std::size_t>(height), std::vector<double>(static_cast<std::size_t>(width)));
  return make_field_map(std::move(files.positions));
}

std::shared_ptr<const FieldMap> curves_at(Reader& reader, const std::string& path, CurveSum<double>& sum) {
  constexpr std::size_t kMost = 400, kFrequencies = 32;
  FieldFiles files = read_field_files_csv(path);
  require_positions(files.positions);
  const std::size_t n = files.file.size();
  if (n > kMost)
    throw UsageError(path + ": " + std::to_string(n) + " curves, at most " + std::to_string(kMost) +
                     " are interpolated over the field; keep every " + std::to_string(n / kMost + 1) + "th");
  double end = 0.0;
  for (const std::string& name : files.file) {
    auto curve = std::make_shared<const Curve>(read_curve_csv(reader.file(name)));
    if (const auto& first = sum.curves.empty() ? curve : sum.curves.front(); curve->unit != first->unit)
      throw UsageError(name + ": frequencies in " + std::string(curve->unit->name) + ", where " + files.file.front() +
                       " has " + std::string(first->unit->name) + "; give all in one unit");
    end = std::max(end, end_of(*curve));
    sum.curves.push_back(std::move(curve));
  }
  sum.weight.assign(n, 0.0);
  // What the sum misses at positions that are left out: that of the values at some frequencies, the most of them.
  FieldMap values = files.positions;
  values.column.resize(kFrequencies);
  for (std::size_t k = 0; k < kFrequencies; ++k)
    for (const auto& curve : sum.curves)
      values.column[k].value.push_back(evaluate(*curve, end * static_cast<double>(k + 1) / kFrequencies).value);
  std::optional<std::array<double, 2>> missed;
  for (const FieldMap::Column& column : make_field_map(std::move(values))->column)
    if (column.missed && (!missed || (*column.missed)[0] > (*missed)[0])) missed = column.missed;
  files.positions.column.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    files.positions.column[i].value.assign(n, 0.0);
    files.positions.column[i].value[i] = 1.0;
  }
  FieldMap map = *make_field_map(std::move(files.positions));
  for (FieldMap::Column& column : map.column) column.missed = missed;
  return std::make_shared<const FieldMap>(std::move(map));
}

std::shared_ptr<const FieldMap> displacements_in(const std::string& path, AxisPair<double>& shift) {
  const std::string remedy = "; give OpenEXR channels x and y, or NPY of 2 x rows x columns or rows x columns x 2";
  FieldMap map;
  map.source = path;
  for (const char* name : {"x", "y"}) map.column.push_back({name, find_unit("px"), {}});
  const auto begin = [&](std::uint64_t columns, std::uint64_t rows) {
    constexpr std::uint64_t kLongest = 1 << 14, kMostSamples = 1 << 25;
    if (std::min(columns, rows) < 2 || std::max(columns, rows) > kLongest || columns * rows > kMostSamples)
      throw UsageError(
          path + ": " + size_text(columns, rows) +
          " samples; an image of displacements has 2 to 2^14 along each axis and 2^25 at most, which may be "
          "of blocks of pixels");
    map.columns = static_cast<int>(columns), map.rows = static_cast<int>(rows);
  };
  if (path.ends_with(".npy")) {
    NpyReader file(path);
    const std::vector<std::uint64_t>& shape = file.shape();
    const bool planes = shape.size() == 3 && shape[0] == 2;
    if (!file.is_float() || shape.size() != 3 || (!planes && shape[2] != 2))
      throw UsageError(path + ": no two planes of floats" + remedy);
    begin(planes ? shape[2] : shape[1], planes ? shape[1] : shape[0]);
    std::vector<float> values(static_cast<std::size_t>(shape[0] * shape[1] * shape[2]));
    file.read(0, values);
    const std::size_t half = values.size() / 2;
    for (std::size_t i = 0; i < values.size(); ++i)
      map.column[planes ? i / half : i % 2].value.push_back(static_cast<double>(values[i]));
  } else {
    const FileInfo info = read_info(path);
    begin(static_cast<std::uint64_t>(info.width), static_cast<std::uint64_t>(info.height));
    for (FieldMap::Column& column : map.column) {
      const auto same = [&](const ChannelInfo& one) { return lower_case(one.name) == column.name; };
      const auto found = std::ranges::find_if(info.channels, same);
      if (found == info.channels.end()) throw UsageError(path + ": no channel " + column.name + remedy);
      const ImageFile file = read_image(path, {.channel = found->name});
      const Image& plane = file.planes.front();
      if (file.integer || file.missing_pixels > 0)
        throw UsageError(path + ": channel " + column.name + " is no image of floats that fills its window" + remedy);
      column.value.assign(plane.data(), plane.data() + plane.size());
    }
  }
  for (const FieldMap::Column& column : map.column) {
    const auto bad = std::ranges::find_if_not(column.value, [](double value) { return std::isfinite(value); });
    if (bad == column.value.end()) continue;
    const auto at = bad - column.value.begin();
    throw UsageError(path + ": the displacement along " + column.name + " is not finite in column " +
                     std::to_string(at % map.columns) + ", row " + std::to_string(at / map.columns) +
                     "; fill such places from their neighbours");
  }
  shift = {{0.0, find_unit("px")}, {0.0, find_unit("px")}, true};
  return make_field_image(std::move(map));
}

void note_map(Reader& reader, const System<double>& system, std::size_t entry, const FieldMap* map, Position position,
              const std::string& path) {
  struct Missed {
    double share = 0.0;
    std::string text;
  };
  std::vector<Missed> missed;
  double otf = 0.0;  // of samples: no more than the sum of what each is missed by; of curves what all are
  const auto fields = system.list(Stage::presample).at(entry).component.fields();
  for (const FieldNumber<double>& number : system.field.numbers) {
    if (number.entry != entry || number.map.get() != map) continue;
    const FieldMap::Column& column = map->column[number.column];
    if (!column.missed)
      return reader.note(position, path,
                         map->source + " has so few positions that nothing tells what lies between them", false);
    const auto [rms, most] = *column.missed;
    if (fields[number.field].info->type == FieldType::rows) otf += rms;
    if (fields[number.field].info->type == FieldType::file) otf = rms;
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
              "numbers between the " +
                  (map->is_image() ? size_text(map->columns, map->rows) + " samples"
                                   : std::to_string(map->position.size()) + " positions") +
                  " of " + map->source + " are interpolated; where a position is left out, that misses " +
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

std::optional<bool> read_file_over_field(const Section& section, const FieldRef<double>& field) {
  const Node* kind = section.find("kind");
  const auto key = std::ranges::find_if(kFileKeys, [&](const FileKey& one) {
    return kind != nullptr && one.kind == kind->text && one.member == field.info->name;
  });
  const Node* file = key == kFileKeys.end() ? nullptr : section.find(key->key);
  if (file == nullptr) return std::nullopt;
  Reader& reader = section.reader;
  reader.positions[section.at(key->key)] = file->position;
  const auto fail = [&](const std::string& text) {
    section.error(key->key, printable(text, 600));
    reader.failed.insert(section.path);
    return false;
  };
  for (const std::string& own : keys_of(*field.info))
    if (section.find(own) != nullptr) return fail("given together with " + own + "; remove one of them");
  if (file->kind != Node::Kind::string) return fail("the name of a file belongs here: " + std::string(key->doc));
  try {
    const std::string path = reader.file(file->text);
    auto* const* rows = std::get_if<Taps<double>*>(&field.value);
    auto* const* curves = std::get_if<CurveSum<double>*>(&field.value);
    const bool pair = rows == nullptr && curves == nullptr;
    const auto map = rows != nullptr     ? samples_at(reader, path, **rows)
                     : curves != nullptr ? curves_at(reader, path, **curves)
                                         : displacements_in(path, *std::get<AxisPair<double>*>(field.value));
    for (std::size_t i = 0; i < map->column.size(); ++i)
      reader.terms.push_back(
          {.path = section.at(key->member) + (pair ? "_" + map->column[i].name : "[" + std::to_string(i) + "]"),
           .written = section.at(key->key),
           .position = file->position,
           .coefficient = {},
           .map = map,
           .column = i});
    return true;
  } catch (const Error& error) {
    return fail(error.what());
  }
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
