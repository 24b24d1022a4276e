// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/raw/envi.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <utility>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEnviMark = "ENVI";
constexpr std::size_t kLargestHeader = std::size_t{16} << 20;

bool is_ordinary(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool is_envi_header(const std::string& path) {
  if (!is_ordinary(path)) return false;
  std::array<char, kEnviMark.size()> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == kEnviMark;
}

std::string capitals(std::string_view text) {
  std::string made(text);
  std::ranges::transform(made, made.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
  return made;
}

std::string without_ending(const std::string& path) { return fs::path(path).replace_extension().string(); }

/// The numbers that the header belongs to. Throws UsageError where several files may hold them.
std::string envi_numbers_of(const std::string& header) {
  const std::string name = without_ending(header);
  std::vector<std::string> found;
  if (is_ordinary(name)) found.push_back(name);
  for (const std::string_view ending : {".img", ".dat", ".raw", ".bin", ".bsq", ".bil", ".bip"})
    for (const std::string& file : {name + std::string(ending), name + capitals(ending)})
      if (is_ordinary(file)) found.push_back(file);
  if (found.empty())
    throw RuntimeError("cannot read " + header + ": the numbers that it describes are not beside it, as " + name +
                       ", " + name + ".img, .dat, .raw, .bin, .bsq, .bil or .bip; put them there");
  if (found.size() > 1)
    throw UsageError(header + ": may be the header of " + listed(found) + "; name the one that is meant");
  return found.front();
}

/// Keys and values of a header.
class EnviKeys {
 public:
  explicit EnviKeys(const std::string& path) : path_(path) {
    const std::string whole = read_file(path, kLargestHeader);
    std::string_view text = whole;
    static_cast<void>(take_text_line(text));  // ENVI
    for (int line = 2; !text.empty(); ++line) {
      std::string row(trimmed_cell(take_text_line(text)));
      if (row.empty() || row.starts_with(';')) continue;
      const std::size_t equals = row.find('=');
      const int first = line;
      if (equals == std::string::npos) fail(first, "\"" + printable(row, 40) + "\" is no line `key = value`");
      std::string value(trimmed_cell(std::string_view(row).substr(equals + 1)));
      if (value.starts_with('{')) {
        for (bool open = value.find('}') == std::string::npos; open; ++line) {
          if (text.empty()) fail(first, "the brace is never closed");
          const std::string_view more = trimmed_cell(take_text_line(text));
          value.append("\n").append(more);
          open = more.find('}') == std::string_view::npos;
        }
        value = trimmed_cell(std::string_view(value).substr(1, value.find('}') - 1));
      }
      std::string name(trimmed_cell(std::string_view(row).substr(0, equals)));
      const std::string key = lower_case(name);
      if (!values_.emplace(key, Value{std::move(name), std::move(value), first}).second)
        fail(first, "'" + key + "' is there twice");
    }
  }

  const std::string& path() const { return path_; }
  [[noreturn]] void fail(int line, const std::string& what) const {
    throw RuntimeError(path_ + ":" + std::to_string(line) + ": " + what + "; correct the header");
  }
  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    const auto found = values_.find(key);
    if (found != values_.end()) fail(found->second.line, key + " = " + printable(found->second.text, 40) + ": " + what);
    throw RuntimeError(path_ + ": the key '" + key + "' is missing: " + what + "; add it to the header");
  }

  /// The value, which is taken: attributes() has what is left. "" where there is none.
  std::string take(const std::string& key) {
    taken_.insert(key);
    const auto found = values_.find(key);
    return found == values_.end() ? std::string() : found->second.text;
  }
  bool has(const std::string& key) const { return values_.contains(key); }
  std::int64_t take_whole(const std::string& key, std::int64_t least, std::int64_t most) {
    const auto value = cell_number<std::int64_t>(take(key));
    if (!value || *value < least || *value > most)
      fail(key, "a whole number from " + std::to_string(least) + " to " + std::to_string(most) + " belongs here");
    return *value;
  }
  std::vector<std::string> take_list(const std::string& key, std::int64_t size) {
    std::string text = take(key);
    std::ranges::replace(text, '\n', ' ');
    std::vector<std::string> cells;
    for (const std::string_view cell : split_cells(text, ',', static_cast<std::size_t>(size))) cells.emplace_back(cell);
    if (std::ssize(cells) != size) fail(key, "one for each of the " + plural(size, "band") + " belongs here");
    return cells;
  }
  std::vector<double> take_numbers(const std::string& key, std::int64_t size) {
    std::vector<double> numbers;
    for (const std::string& cell : take_list(key, size)) {
      const auto number = cell_number(cell);
      if (!number || !std::isfinite(*number)) fail(key, "\"" + printable(cell, 20) + "\" is no number");
      numbers.push_back(*number);
    }
    return numbers;
  }
  std::map<std::string, std::string> attributes() const {
    std::map<std::string, std::string> rest;
    for (const auto& [key, value] : values_)
      if (!taken_.contains(key)) rest[value.name] = value.text;
    return rest;
  }

 private:
  struct Value {
    std::string name, text;
    int line;
  };
  std::string path_;
  std::map<std::string, Value> values_;
  std::set<std::string> taken_;
};

constexpr std::array kEnviTypes{std::pair{1, "|u1"},  std::pair{2, "<i2"},  std::pair{3, "<i4"},
                                std::pair{4, "<f4"},  std::pair{5, "<f8"},  std::pair{12, "<u2"},
                                std::pair{13, "<u4"}, std::pair{14, "<i8"}, std::pair{15, "<u8"}};

NumberType envi_type(EnviKeys& keys) {
  const std::int64_t number = keys.take_whole("data type", 1, 15);
  if (number == 6 || number == 9) keys.fail("data type", "complex numbers are not read; export real ones");
  const auto* found = std::ranges::find(kEnviTypes, number, &std::pair<int, const char*>::first);
  if (found == kEnviTypes.end()) keys.fail("data type", "no such type is known; 1 to 5 and 12 to 15 are read");
  NumberType type = *number_type(found->second);
  if (type.bytes > 1 || keys.has("byte order")) type.big_endian = keys.take_whole("byte order", 0, 1) == 1;
  return type;
}

/// Steps from sample to sample; `image.planes` are there.
void set_envi_steps(EnviKeys& keys, RawImage& image) {
  std::string interleave = lower_case(keys.take("interleave"));
  if (image.planes.size() == 1) interleave = "bsq";
  const std::int64_t row = image.type.bytes * image.info.width, bands = std::ssize(image.planes);
  image.pixel_step = image.type.bytes;
  if (interleave == "bip")
    interleave_pixels(image);
  else if (interleave == "bil")
    image.plane_step = row, image.row_step = row * bands;
  else if (interleave == "bsq")
    image.row_step = row, image.plane_step = row * image.info.height;
  else
    keys.fail("interleave", "bsq, bil or bip belongs here");
  image.info.storage = image.type.name() + ", " + interleave +
                       (image.type.bytes == 1   ? ""
                        : image.type.big_endian ? ", big-endian"
                                                : ", little-endian");
}

/// What a stored number means.
void set_envi_meaning(EnviKeys& keys, RawImage& image) {
  const std::int64_t bands = std::ssize(image.planes);
  const auto set = [&](const char* key, double Meaning::*to) {
    if (!keys.has(key)) return;
    const std::vector<double> numbers = keys.take_numbers(key, bands);
    if (to == &Meaning::gain && std::ranges::find(numbers, 0.0) != numbers.end())
      keys.fail(key, "a gain of 0 makes all values alike");
    for (std::size_t b = 0; b < numbers.size(); ++b) image.planes[b].*to = numbers[b];
    image.info.storage += std::string(", ") + key + " applied";
  };
  set("data gain values", &Meaning::gain);
  set("data offset values", &Meaning::offset);
  if (const std::string text = keys.take("data ignore value"); !text.empty()) {
    const auto value = cell_number(text);
    if (!value) keys.fail("data ignore value", "a number belongs here");
    set_no_data(image, *value, text + " (data ignore value)");
  }
}

/// By `wavelength`, in um; empty without them.
std::vector<double> envi_wavelengths(EnviKeys& keys, std::int64_t bands) {
  const std::string unit = plain_words(keys.take("wavelength units"));
  if (!keys.has("wavelength") || unit == "index") return {};
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> words{{{"nanometers", "nm"},
                                                                                {"micrometers", "um"},
                                                                                {"millimeters", "mm"},
                                                                                {"meters", "m"},
                                                                                {"angstroms", "angstrom"},
                                                                                {"nanometres", "nm"},
                                                                                {"micrometres", "um"},
                                                                                {"wavenumber", "cm_1"}}};
  const auto* word = std::ranges::find(words, unit, &std::pair<std::string_view, std::string_view>::first);
  const auto known = find_spectral_unit(word == words.end() ? std::string_view(unit) : word->second);
  if (!known)
    keys.fail("wavelength units",
              "Nanometers, Micrometers, Wavenumber or GHz belongs here, the unit of 'wavelength', or "
              "Index where its numbers are none");
  std::vector<double> wavelengths = keys.take_numbers("wavelength", bands);
  for (double& wavelength : wavelengths) {
    wavelength = known->to_um(wavelength);
    if (!std::isfinite(wavelength) || wavelength <= 0.0) keys.fail("wavelength", "each has to be above 0");
  }
  return wavelengths;
}

/// Those of `band names`, else the wavelengths, else the numbers; one band without a name is Y.
std::vector<std::string> envi_names(EnviKeys& keys, const std::vector<double>& wavelengths, std::int64_t bands) {
  std::vector<std::string> names;
  if (keys.has("band names"))
    names = keys.take_list("band names", bands);
  else if (!wavelengths.empty())
    for (const double um : wavelengths) names.push_back(significant(um, 7) + " um");
  else if (bands == 1)
    names = {"Y"};
  std::set<std::string> seen;
  names.resize(static_cast<std::size_t>(bands));
  for (std::size_t b = 0; b < names.size(); ++b) {
    std::ranges::replace(names[b], '\n', ' ');
    if (names[b].empty() || !seen.insert(names[b]).second) {
      names[b] += (names[b].empty() ? "band " : " of band ") + std::to_string(b + 1);
      seen.insert(names[b]);
    }
  }
  return names;
}

/// Sizes of pixels: the sixth and seventh item.
double envi_aspect(const FileInfo& info) {
  const auto found = info.attributes.find("map info");
  if (found == info.attributes.end()) return 1.0;
  const std::vector<std::string_view> cells = split_cells(found->second, ',');
  if (cells.size() < 7) return 1.0;
  const double x = cell_number(cells[5]).value_or(0.0), y = cell_number(cells[6]).value_or(0.0);
  return std::isfinite(x / y) && x > 0.0 && y > 0.0 ? x / y : 1.0;
}

/// Refuses what the numbers cannot be read with, and says what is not applied.
void check_envi_rest(EnviKeys& keys, FileInfo& info) {
  if (const std::string value = keys.take("file compression"); !value.empty() && value != "0")
    keys.fail("file compression", "compressed numbers are not read; export them without");
  if (const std::string value = keys.take("major frame offsets"); value.find_first_of("123456789") != std::string::npos)
    keys.fail("major frame offsets", "bytes between rows or planes are not read; export the image without");
  if (lower_case(keys.take("file type")) == "envi classification")
    info.notes.emplace_back("its values are numbers of classes, not measured ones (file type)");
  for (const char* key :
       {"reflectance scale factor", "data reflectance gain values", "data reflectance offset values", "bbl"})
    if (keys.has(key)) info.notes.push_back(std::string("'") + key + "' of its header is not applied");
}

}  // namespace

std::string envi_header_of(const std::string& path) {
  for (const std::string& candidate :
       {path, path + ".hdr", path + ".HDR", without_ending(path) + ".hdr", without_ending(path) + ".HDR"})
    if (is_envi_header(candidate)) return candidate;
  return "";
}

std::vector<std::string> envi_files_of(const std::string& path) {
  const std::string header = envi_header_of(path);
  return {header, header == path ? envi_numbers_of(path) : path};
}

std::vector<RawImage> open_envi(const std::string& path, Part) {
  const std::vector<std::string> files = envi_files_of(path);
  const std::string& header = files[0];
  EnviKeys keys(header);
  RawImage image;
  FileInfo& info = image.info;
  info.format = Format::envi;
  image.file = files[1];
  info.width = keys.take_whole("samples", 1, max_plane_pixels);
  info.height = keys.take_whole("lines", 1, max_plane_pixels);
  const std::int64_t bands = keys.take_whole("bands", 1, kMostRawPlanes);
  image.type = envi_type(keys);
  image.begin = keys.has("header offset") ? keys.take_whole("header offset", 0, std::int64_t{1} << 60) : 0;
  const std::int64_t more = check_samples(header, image, image.begin, bands);
  if (more > 0)
    info.notes.push_back(plural(more, "byte") + " of " + one_line(image.file) +
                         " lie behind what its header describes, and are not read");
  image.planes.resize(static_cast<std::size_t>(bands));
  set_envi_steps(keys, image);
  set_envi_meaning(keys, image);
  check_envi_rest(keys, info);
  const std::vector<double> wavelengths = envi_wavelengths(keys, bands);
  name_channels(image, envi_names(keys, wavelengths, bands));
  for (std::size_t b = 0; b < wavelengths.size(); ++b) info.channels[b].wavelength_um = wavelengths[b];
  info.attributes = keys.attributes();
  info.pixel_aspect = envi_aspect(info);
  std::vector<RawImage> images;
  images.push_back(std::move(image));
  return images;
}

}  // namespace mtf::io
