// SPDX-License-Identifier: Apache-2.0

// FITS (standard 4.0): header and data units one after another, each in blocks of 2880 bytes; a header is cards of 80
// characters, `KEYWORD = value / comment`, up to END. Read are images of two axes and more (primary unit and IMAGE
// extensions), planes along the further axes; numbers have the greatest byte first.
//   BITPIX            8 uint8, 16, 32, 64 with a sign, -32 float, -64 double
//   BSCALE, BZERO     applied: value = BZERO + BSCALE x stored; BZERO = 2^(bits - 1) makes numbers without a sign
//   BLANK             stored whole number of pixels without data: NaN
//   ROWORDER          the first row is the lowest one and images are turned over, but for 'TOP-DOWN'
// A table of PSFEx (PSF_MASK) is one vector of floats, an image of PSFAXIS1 x PSFAXIS2 samples for each term of its
// polynomials, and read as that. Compressed images (ZIMAGE) are tables; they and other tables are not read.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/raw/raw_image.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

constexpr std::int64_t kFitsBlock = 2880, kFitsCard = 80;
constexpr std::int64_t kMostFitsCards = 100'000;

std::int64_t whole_blocks(std::int64_t bytes) { return (bytes + kFitsBlock - 1) / kFitsBlock * kFitsBlock; }

/// Header and data unit.
struct FitsUnit {
  std::string where;  ///< "FILE, unit 2 of FITS", 0 being the primary one
  std::map<std::string, std::string> cards{};
  std::int64_t begin = 0, bytes = 0;  ///< of the data

  [[noreturn]] void fail(const std::string& why) const { throw RuntimeError(where + ": " + why); }
  std::string text(const std::string& key) const {
    const auto found = cards.find(key);
    return found == cards.end() ? std::string() : found->second;
  }
  std::optional<double> number(const std::string& key) const {
    std::string word = text(key);
    if (word.empty()) return std::nullopt;
    for (char& c : word)
      if (c == 'D' || c == 'd') c = 'E';  // exponents of Fortran
    const auto value = cell_number(word);
    if (!value || !std::isfinite(*value)) fail(key + " = " + printable(word, 40) + " is no number; correct the header");
    return value;
  }
  /// A size: 0 and above. Without a default the keyword has to be there.
  std::int64_t size(const std::string& key, std::optional<std::int64_t> missing = std::nullopt) const {
    const std::optional<double> value = number(key);
    if (!value && missing) return *missing;
    constexpr double most = 1e15;
    if (!value || *value < 0.0 || *value > most || *value != std::floor(*value))
      fail(key + (value ? " = " + text(key) : " is missing") + ": a whole number from 0 on belongs there; " +
           "export the file again");
    return static_cast<std::int64_t>(*value);
  }
  std::vector<std::int64_t> axes() const {
    std::vector<std::int64_t> sizes;
    const std::int64_t count = size("NAXIS");
    if (count > 999) fail("NAXIS = " + text("NAXIS") + ": at most 999 axes are possible; export the file again");
    for (std::int64_t i = 1; i <= count; ++i) sizes.push_back(size("NAXIS" + std::to_string(i)));
    return sizes;
  }
};

/// The value of a card, a text without its quotes.
std::string fits_value(std::string_view card) {
  std::string_view text = trimmed(card.substr(10));
  if (!text.starts_with('\'')) return std::string(trimmed(text.substr(0, text.find('/'))));
  std::string value;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '\'' && (i + 1 == text.size() || text[++i] != '\'')) break;
    value += text[i];
  }
  return value.substr(0, value.find_last_not_of(' ') + 1);
}

/// Reads cards up to END; the data begin at the next block.
void read_cards(std::ifstream& file, std::int64_t from, FitsUnit& unit) {
  std::array<char, kFitsCard> bytes{};
  file.seekg(from);
  for (std::int64_t count = 1; count <= kMostFitsCards && file.read(bytes.data(), kFitsCard); ++count) {
    const std::string_view card(bytes.data(), bytes.size());
    const std::string key(trimmed(card.substr(0, 8)));
    if (key == "END") {
      unit.begin = from + whole_blocks(count * kFitsCard);
      return;
    }
    if (card.substr(8, 2) == "= ") unit.cards.emplace(key, fits_value(card));
  }
  unit.fail("its header has no END; copy or export the file again");
}

/// Bytes of the data, whatever they are.
std::int64_t fits_bytes(const FitsUnit& unit) {
  const std::vector<std::int64_t> axes = unit.axes();
  if (axes.empty()) return 0;
  const bool groups = axes.front() == 0 && unit.text("GROUPS") == "T";
  double count = 1.0;
  for (std::size_t i = groups ? 1 : 0; i < axes.size(); ++i) count *= static_cast<double>(axes[i]);
  const double bytes = std::abs(unit.number("BITPIX").value_or(8.0)) / 8.0 *
                       static_cast<double>(unit.size("GCOUNT", 1)) *
                       (static_cast<double>(unit.size("PCOUNT", 0)) + count);
  constexpr double most = 1e18;
  if (!(bytes < most)) unit.fail("its header announces " + shown_bytes(bytes) + "; export the file again");
  return static_cast<std::int64_t>(bytes);
}

NumberType fits_type(const FitsUnit& unit) {
  for (const auto& [bits, word] :
       {std::pair{"8", "|u1"}, {"16", ">i2"}, {"32", ">i4"}, {"64", ">i8"}, {"-32", ">f4"}, {"-64", ">f8"}})
    if (unit.text("BITPIX") == bits) return *number_type(word);
  unit.fail("BITPIX = " + printable(unit.text("BITPIX"), 20) + ": 8, 16, 32, 64, -32 or -64 belongs there");
}

/// BZERO, BSCALE and BLANK.
void set_fits_meaning(const FitsUnit& unit, RawImage& image) {
  const Meaning meaning{unit.number("BSCALE").value_or(1.0), unit.number("BZERO").value_or(0.0)};
  if (meaning.gain == 0.0) unit.fail("BSCALE = 0 makes all values alike; correct the header");
  std::ranges::fill(image.planes, meaning);
  if (meaning.offset != 0.0 || meaning.gain != 1.0)
    image.info.storage +=
        ", BZERO " + number_text(meaning.offset) + " and BSCALE " + number_text(meaning.gain) + " applied";
  if (const auto blank = unit.number("BLANK"); blank && !image.type.is_float())
    set_no_data(image, *blank, unit.text("BLANK") + " (BLANK)");
}

/// The convention for whole numbers with a sign in place of those without, and the other way round.
bool is_other_sign(const RawImage& image) {
  const Meaning& meaning = image.planes.front();
  const double half = std::ldexp(1.0, 8 * image.type.bytes - 1);
  return !image.type.is_float() && meaning.gain == 1.0 && meaning.offset == (image.type.kind == 'u' ? -half : half);
}

/// The image of a unit whose data have pixels along two axes at least.
RawImage image_of(const std::string& path, const FitsUnit& unit, int number) {
  RawImage image;
  FileInfo& info = image.info;
  const std::vector<std::int64_t> axes = unit.axes();
  double planes = 1.0;
  for (std::size_t i = 2; i < axes.size(); ++i) planes *= static_cast<double>(axes[i]);
  info.format = Format::fits;
  image.file = path;
  image.type = fits_type(unit);
  info.width = axes[0];
  info.height = axes[1];
  if (planes > static_cast<double>(kMostRawPlanes))
    unit.fail(fixed(planes, 0) + " planes, more than the " + std::to_string(kMostRawPlanes) +
              " that are read; cut the cube into pieces");
  static_cast<void>(check_samples(path, image, unit.begin, static_cast<std::int64_t>(planes)));
  image.planes.resize(static_cast<std::size_t>(planes));
  image.pixel_step = image.type.bytes;
  image.row_step = image.pixel_step * info.width;
  image.plane_step = image.row_step * info.height;
  image.begin = unit.begin;
  const bool upwards = unit.text("ROWORDER") != "TOP-DOWN";
  if (upwards) {
    image.begin += image.plane_step - image.row_step;
    image.row_step = -image.row_step;
  }
  info.storage = image.type.name() + (upwards ? ", turned over: the first row is the lowest" : ", first row on top");
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= image.planes.size(); ++i) names.push_back("plane " + std::to_string(i));
  if (names.size() == 1) names = {"Y"};
  set_fits_meaning(unit, image);
  name_channels(image, names, number);
  for (ChannelInfo& channel : info.channels) {
    channel.part_name = unit.text("EXTNAME");
    if (is_other_sign(image)) channel.type = NumberType{image.type.kind == 'u' ? 'i' : 'u', image.type.bytes}.name();
  }
  info.attributes = unit.cards;
  return image;
}

/// The table of PSFEx as the unit of an image; nothing for other tables.
std::optional<FitsUnit> psfex_image(const FitsUnit& table) {
  if (table.text("TTYPE1") != "PSF_MASK") return std::nullopt;
  FitsUnit image = table;
  image.cards["BITPIX"] = "-32";
  image.cards["NAXIS"] = table.text("PSFNAXIS");
  double count = 1.0;
  const std::int64_t axes = table.size("PSFNAXIS");
  for (std::int64_t i = 1; i <= std::min<std::int64_t>(axes, 999); ++i) {
    image.cards["NAXIS" + std::to_string(i)] = table.text("PSFAXIS" + std::to_string(i));
    count *= static_cast<double>(table.size("PSFAXIS" + std::to_string(i)));
  }
  if (axes < 2 || table.text("TFORM1") != fixed(count, 0) + "E" ||
      4.0 * count > static_cast<double>(table.size("NAXIS1")) || table.size("NAXIS2") != 1)
    table.fail("TFORM1 = " + printable(table.text("TFORM1"), 20) +
               " and PSFAXIS1, ... do not fit; PSFEx writes one row, which begins with as many floats (E) as they say");
  return image;
}

}  // namespace

std::vector<RawImage> open_fits(const std::string& path, Part) {
  const std::int64_t size = input_file_size(path);
  std::ifstream file(path, std::ios::binary);
  std::vector<RawImage> images;
  int compressed = 0, tables = 0, number = 0;
  std::int64_t planes = 0;
  const auto take = [&](const FitsUnit& unit) {
    planes += std::ssize(images.emplace_back(image_of(path, unit, number)).planes);
    if (planes > kMostRawPlanes)
      unit.fail("with it the file has more than the " + std::to_string(kMostRawPlanes) +
                " planes that are read; cut the file into pieces");
  };
  for (std::int64_t at = 0; number == 0 || at + kFitsBlock <= size; ++number) {
    FitsUnit unit{.where = path + ", unit " + std::to_string(number) + " of FITS"};
    read_cards(file, at, unit);
    unit.bytes = fits_bytes(unit);
    if (unit.begin > size || unit.bytes > size - unit.begin)
      unit.fail("its data end at byte " + std::to_string(unit.begin + unit.bytes) + " of " + std::to_string(size) +
                ": the file is cut off; copy or export it again");
    const std::string kind = unit.text("XTENSION");
    const std::vector<std::int64_t> axes = unit.axes();
    if (unit.text("ZIMAGE") == "T")
      ++compressed;
    else if (const std::optional<FitsUnit> psf = psfex_image(unit))
      take(*psf);
    else if (!kind.empty() && kind != "IMAGE")
      ++tables;
    else if (axes.size() >= 2 && unit.bytes > 0 && axes[0] > 0)
      take(unit);
    at = unit.begin + whole_blocks(unit.bytes);
  }
  if (images.empty() && compressed > 0)
    throw RuntimeError(path + ": its images are compressed (ZIMAGE), which is not read; expand them, as funpack does");
  if (images.empty()) throw RuntimeError(path + ": holds no image of two axes; export one as the primary unit");
  for (RawImage& image : images) {
    if (compressed > 0) image.info.notes.push_back(plural(compressed, "compressed image") + " of it not read");
    if (tables > 0) image.info.notes.push_back(plural(tables, "table") + " of it not read");
  }
  return images;
}

}  // namespace mtf::io
