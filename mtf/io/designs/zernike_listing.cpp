// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/zernike_listing.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/csv_numbers.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/math/quadrature.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

/// What is left out may change the OTF by so much: |d OTF| <= mean of |exp(2 pi i D) - 1| <= 4 pi rms.
constexpr double kMostLeftOut = 0.01;

const std::string kHeader = "x (deg), y (deg), wavelength (um), Z4 (waves), Z5 (waves)";

/// The mean over the disc of a product of two polynomials, exact: 26 azimuths and 13 nodes in r^2 for a degree of 24.
double disc_mean(const PupilPolynomial& p, const PupilPolynomial& q) {
  static const GaussRule radii = mean_rule(0.0, 1.0, PupilPolynomial::kMaxDegree + 1);
  constexpr int azimuths = 2 * PupilPolynomial::kMaxDegree + 2;
  double mean = 0.0;
  for (std::size_t i = 0; i < radii.node.size(); ++i)
    for (int k = 0; k < azimuths; ++k) {
      const double r = std::sqrt(radii.node[i]), t = 2.0 * std::numbers::pi * k / azimuths;
      const double x = r * std::cos(t), y = r * std::sin(t);
      mean += radii.weight[i] * p(x, y) * q(x, y) / azimuths;
    }
  return mean;
}

/// A sine term: W(x, -y) = -W(x, y).
bool is_odd_in_y(const PupilPolynomial& term) {
  return std::ranges::any_of(term.a, [](const auto& row) {
    for (std::size_t j = 1; j < row.size(); j += 2)
      if (row[j] != 0.0) return true;
    return false;
  });
}

std::string numbering_text(ZernikeNumbering numbering) {
  return numbering == ZernikeNumbering::noll ? "Noll (unit rms over the full disc)" : "Fringe (unit peak)";
}

/// The coefficients of a file as the component has them.
void take(ZernikeListing& listing, ZernikeField field, const DesignReading& reading, const std::string& where) {
  const auto most = static_cast<std::size_t>(zernike_count(listing.numbering));
  double beyond = 0.0;  // such terms have an rms of 1 at the most
  for (std::size_t i = most; i < field.waves.size(); ++i) beyond = std::hypot(beyond, field.waves[i]);
  const double change = 4.0 * std::numbers::pi * beyond;
  const std::string size = "the terms beyond Z" + std::to_string(most) + ", the last that `wavefront` has, hold " +
                           three_digits(beyond) + " waves rms, which changes the OTF by up to " + three_digits(change);
  if (change > kMostLeftOut) throw UsageError(where + size + "; import a PSF of this field in their place");
  if (change > 0.0) listing.remarks.warnings.push_back(where + size + ": they are left out");
  field.waves.resize(std::min(most, field.waves.size()));
  for (std::size_t i = 0; i < field.waves.size(); ++i) {
    const bool turned = reading.y_up && is_odd_in_y(zernike_polynomial(listing.numbering, static_cast<int>(i) + 1));
    field.waves[i] = field.waves[i] == 0.0 ? 0.0 : field.waves[i] * (turned ? -reading.sign : reading.sign);
    if (std::abs(field.waves[i]) > 10.0)
      throw UsageError(where + "Z" + std::to_string(i + 1) + " is " + format_double(field.waves[i]) +
                       " waves, and `wavefront` takes at most 10; refocus, or import a PSF of this field");
  }
  if (field.place && reading.y_up) field.place->y = 0.0 - field.place->y;
  if (field.waves.size() < 4) field.waves.resize(4);
  const double slope = listing.numbering == ZernikeNumbering::noll ? 2.0 : 1.0;
  const double shift_um = 2.0 * slope * field.wavelength_um * std::hypot(field.waves[1], field.waves[2]);
  if (shift_um > 0.0)
    listing.remarks.notes.push_back(where + "piston and tilt are left out; the tilt moves the image by " +
                                    three_digits(shift_um) + " um x f-number, which belongs to [distortion]");
  std::fill_n(field.waves.begin(), 3, 0.0);
  while (!field.waves.empty() && field.waves.back() == 0.0) field.waves.pop_back();
  listing.fields.push_back(std::move(field));
}

/// The number of "RMS (to chief) : 0.31 waves" below a heading.
std::optional<double> stated_rms(const DesignText& text, std::string_view heading) {
  const std::size_t at = text.find("RMS (to chief)", text.find(heading));
  if (at == text.lines.size()) return std::nullopt;
  for (const std::string& word : design_words(text.lines[at]))
    if (const auto value = design_number(word)) return value;
  return std::nullopt;
}

void compare_rms(const DesignText& text, std::vector<double> waves, ZernikeListing& listing) {
  if (waves.size() > static_cast<std::size_t>(zernike_count(listing.numbering))) return;
  waves.front() = 0.0;
  const double own = disc_rms(zernike_sum(listing.numbering, waves));
  const auto fitted = stated_rms(text, "of the fitted coefficients"), rays = stated_rms(text, "of the rays");
  if (fitted && std::abs(*fitted - own) > 1e-6 * (1.0 + own))  // of eight decimals
    throw UsageError(text.where(text.find("of the fitted coefficients")) + "the file states an rms of " +
                     three_digits(*fitted) + " waves for coefficients that have " + three_digits(own) +
                     " in the order that it states; was it edited? Export it anew");
  if (rays && std::abs(*rays - own) > 0.05 * own + 1e-3)
    listing.remarks.warnings.push_back(
        text.source + ": the coefficients have an rms of " + three_digits(own) +
        " waves over the full disc, the rays " + three_digits(*rays) +
        ": the pupil is an annulus or vignetted. Only the sum of the terms within it is the "
        "wavefront: [optics] needs the lens's obscuration; vignetting is not in this component");
}

/// As the file states it, else as --order does.
ZernikeNumbering order_of(const std::optional<std::string>& stated, const DesignReading& reading,
                          const std::string& where) {
  if (!stated && !reading.order)
    throw UsageError(where + "a table does not say its order of terms; give --order noll or --order fringe");
  const std::string& order = stated ? *stated : *reading.order;
  if (order != reading.order.value_or(order))
    throw UsageError(where + "--order " + *reading.order + ", but the file says " +
                     (order == "fringe" ? "Fringe" : "Standard") + "; leave --order out");
  return order == "noll" ? ZernikeNumbering::noll : ZernikeNumbering::fringe;
}

ZernikeListing read_opticstudio(const DesignText& text, const DesignReading& reading) {
  const std::size_t title = text.find("Listing of Zernike");
  const std::string kind = lower_case(text.lines[title]);
  const bool fringe = kind.find("fringe") != std::string::npos;
  if (!fringe && kind.find("standard") == std::string::npos)
    throw UsageError(
        text.where(title) + "\"" + printable(text.lines[title], 80) +
        "\" is not read; export Zernike Standard coefficients of the field: their sum is the same wavefront");
  ZernikeListing listing{.numbering = order_of(fringe ? "fringe" : "noll", reading, text.where(title))};
  ZernikeField field;
  for (std::size_t i = title; i < text.lines.size(); ++i) {
    std::vector<std::string> words = design_words(text.lines[i]);
    if (words.empty()) continue;
    if (words[0].size() > 1 && words[0][0] == 'Z' && std::isdigit(static_cast<unsigned char>(words[0][1]))) {
      words.insert(words.begin() + 1, words[0].substr(1));  // "Z10" without a blank
      words[0] = "Z";
    }
    if (words[0] == "Field") field.place = design_field(text.lines[i]);
    if (words[0] == "Wavelength") field.wavelength_um = design_length_um(text.lines[i]).value_or(0.0);
    if (words[0] != "Z") continue;
    const auto number = words.size() > 1 ? cell_number<int>(words[1]) : std::nullopt;
    if (number != static_cast<int>(field.waves.size()) + 1)
      throw UsageError(text.where(i) + "Z" + std::to_string(field.waves.size() + 1) +
                       " belongs here; rows are missing or out of order, export the listing anew");
    const auto value = words.size() > 2 ? design_number(words[2]) : std::nullopt;
    if (!value || !std::isfinite(*value))
      throw UsageError(text.where(i) + "Z" + words[1] + " has no finite number; export the listing anew");
    field.waves.push_back(*value);
  }
  if (field.waves.empty()) throw UsageError(text.source + ": no lines Z 1, Z 2, ...; export the listing anew");
  if (!(field.wavelength_um > 0.0))
    throw UsageError(text.source + ": the unit of the wavelength is missing; a line says Wavelength : 0.5500 µm");
  compare_rms(text, field.waves, listing);
  listing.remarks.notes.push_back(text.source + ": order of the terms: " + numbering_text(listing.numbering) +
                                  ", as the file says");
  take(listing, std::move(field), reading, text.source + ": ");
  return listing;
}

/// 4 of "Z4 (waves)" or "z4_waves", 0 of other columns. Throws UsageError for another unit.
int term_of(std::string_view header, const std::string& where) {
  const std::string name = plain_words(header), number = name.substr(0, name.find('_'));
  const auto term = number.starts_with('z') ? cell_number<int>(number.substr(1)) : std::nullopt;
  if (!term || *term < 1 || *term > 1000) return 0;
  if (name != number + "_waves")
    throw UsageError(where + "column " + printable(header, 40) + " needs its unit, which is waves: Z" +
                     std::to_string(*term) + " (waves); divide a length by the wavelength");
  return *term;
}

std::string table_text(const DesignText& text) {
  const auto header = std::ranges::find_if_not(text.lines, is_comment);
  std::string table = joined(text.lines, "\n");
  // A comma that does not separate columns is a decimal one.
  if (header != text.lines.end() && separator_of(*header) != ',') std::ranges::replace(table, ',', '.');
  return table;
}

ZernikeListing read_zernike_table(const DesignText& text, const DesignReading& reading) {
  ZernikeListing listing{.numbering = order_of(text.order, reading, text.source + ": ")};
  std::vector<int> terms;  // of the columns after those of the wavelength and the place
  std::string place_unit, left_out;
  double to_um = 0.0;
  const auto choose = [&](const std::vector<std::string_view>& cells, const std::string& where) {
    std::array<std::optional<std::size_t>, 3> known;
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string name = plain_words(cells[i]), first = name.substr(0, name.find('_'));
      const std::string unit = name.substr(std::min(name.size(), first.size() + 1));
      const std::size_t k = first == "wavelength" ? 0 : first == "x" ? 1 : first == "y" ? 2 : 3;
      if (k < 3) known[k] = i;
      if (const auto length = find_spectral_unit(unit);
          k == 0 && length && length->kind == SpectralUnit::Kind::wavelength)
        to_um = length->factor;
      if (k == 1) place_unit = unit;
      if (k == 2 && unit != place_unit) throw UsageError(where + "y follows x and has the same unit: x (deg), y (deg)");
      if (k < 3) continue;
      terms.push_back(term_of(cells[i], where));
      if (terms.back() == 0) {
        terms.pop_back();
        append_word(left_out, cells[i], ',');
      } else if (std::ranges::count(terms, terms.back()) > 1) {
        throw UsageError(where + "two columns are Z" + std::to_string(terms.back()) + "; leave one");
      } else {
        chosen.push_back(i);
      }
    }
    if (terms.empty()) throw UsageError(where + "no column of a term; " + kHeader);
    if (!known[0] || to_um == 0.0)
      throw UsageError(where + "waves are of one wavelength; its column or its unit is missing: wavelength (um)");
    if (known[1].has_value() != known[2].has_value() || (known[1] && place_unit.empty()))
      throw UsageError(where + "a place is two columns with their unit, such as x (deg) and y (deg)");
    if (known[1]) chosen.insert(chosen.begin(), {*known[1], *known[2]});
    chosen.insert(chosen.begin(), *known[0]);
    return chosen;
  };
  const CsvNumbers table =
      read_csv_numbers(table_text(text), text.source, "name columns like this: " + kHeader, choose);
  for (std::size_t row = 0; row < table.line.size(); ++row) {
    ZernikeField field{.wavelength_um = to_um * table.column[0][row]};
    if (!place_unit.empty()) field.place = {table.column[1][row], table.column[2][row], place_unit};
    field.waves.resize(static_cast<std::size_t>(std::ranges::max(terms)));
    for (std::size_t i = 0; i < terms.size(); ++i)
      field.waves[static_cast<std::size_t>(terms[i] - 1)] = table.column[table.column.size() - terms.size() + i][row];
    take(listing, std::move(field), reading, text.where(table.line[row] - 1));
  }
  listing.remarks.notes.push_back(text.source + ": order of the terms: " + numbering_text(listing.numbering) +
                                  (text.order ? ", as the title says" : ", as --order says") +
                                  "; taken as terms of the full disc" +
                                  (left_out.empty() ? "" : "; columns left out: " + printable(left_out)));
  return listing;
}

}  // namespace

bool is_zernike_listing(const DesignText& text) {
  if (text.has("Listing of Zernike")) return true;
  const auto header = std::ranges::find_if_not(text.lines, is_comment);
  if (header == text.lines.end()) return false;
  const auto cells = split_cells(*header, separator_of(*header));
  return std::ranges::any_of(cells, [](std::string_view cell) {
    const std::string name = plain_words(cell);
    return name.size() > 1 && name[0] == 'z' && std::isdigit(static_cast<unsigned char>(name[1]));
  });
}

ZernikeListing read_zernike_listing(const DesignText& text, const DesignReading& reading) {
  ZernikeListing listing =
      text.has("Listing of Zernike") ? read_opticstudio(text, reading) : read_zernike_table(text, reading);
  listing.remarks.notes.push_back(text.source + ": y of the file points " + (reading.y_up ? "up" : "down") +
                                  (reading.y_up ? ", turned to down" : "") + "; the sign of W is " +
                                  (reading.sign > 0.0 ? "kept" : "turned"));
  return listing;
}

PupilPolynomial zernike_sum(ZernikeNumbering numbering, const std::vector<double>& waves) {
  PupilPolynomial sum;
  for (std::size_t i = 0; i < waves.size(); ++i)
    sum.add(zernike_polynomial(numbering, static_cast<int>(i) + 1), waves[i]);
  return sum;
}

std::vector<double> zernike_terms(ZernikeNumbering numbering, const PupilPolynomial& wavefront) {
  std::vector<double> waves;
  for (int number = 1; number <= zernike_count(numbering); ++number) {
    const PupilPolynomial& term = zernike_polynomial(numbering, number);
    waves.push_back(disc_mean(wavefront, term) / disc_mean(term, term));
  }
  return waves;
}

double disc_rms(const PupilPolynomial& wavefront) { return std::sqrt(disc_mean(wavefront, wavefront)); }

}  // namespace mtf::io
