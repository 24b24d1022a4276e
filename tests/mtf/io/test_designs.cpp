// SPDX-License-Identifier: Apache-2.0

// Listings of lens programs, in the layout that each has, with numbers made up here.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/designs/mtf_listing.h"
#include "mtf/io/designs/psf_listing.h"
#include "mtf/io/designs/zernike_listing.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace mtf::io {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// W at (x, y), +y up, of coefficients Z1, Z2, ... by the definition in polar coordinates: R_n^m as a sum of
/// factorials.
double by_definition(bool noll, const std::vector<double>& waves, double x, double y) {
  const double rho = std::hypot(x, y), angle = std::atan2(y, x);
  double sum = 0.0;
  for (int j = 1; j <= static_cast<int>(waves.size()); ++j) {
    int n = 0, m = 0;
    bool sine = false;
    if (noll) {
      while ((n + 1) * (n + 2) / 2 < j) ++n;
      m = n % 2 + 2 * ((j - n * (n + 1) / 2 - 1 + (n + 1) % 2) / 2);
      sine = j % 2 == 1;
    } else {
      const int g = static_cast<int>(std::ceil(std::sqrt(j))) - 1, place = j - g * g - 1;
      m = g - place / 2, n = 2 * g - m, sine = place % 2 == 1;
    }
    double radial = 0.0;
    for (int k = 0; k <= (n - m) / 2; ++k)
      radial += (k % 2 == 0 ? 1.0 : -1.0) * std::tgamma(n - k + 1) * std::pow(rho, n - 2 * k) /
                (std::tgamma(k + 1) * std::tgamma((n + m) / 2 - k + 1) * std::tgamma((n - m) / 2 - k + 1));
    const double norm = noll ? std::sqrt((m == 0 ? 1.0 : 2.0) * (n + 1)) : 1.0;
    sum += waves[static_cast<std::size_t>(j - 1)] * norm * radial *
           (m == 0 ? 1.0
            : sine ? std::sin(m * angle)
                   : std::cos(m * angle));
  }
  return sum;
}

std::string zernike_text(const std::vector<double>& waves, const std::string& kind = "Standard") {
  std::string text =
      "Listing of Zernike " + kind +
      " Coefficient Data\n\nFile : C:\\lens.zmx\n\n"
      "Field                        :\t0.0000, 7.0000 (deg)\nWavelength                   :\t0.5500 \xC2\xB5m\n\n";
  for (std::size_t i = 0; i < waves.size(); ++i)
    text += "Z " + std::string(i < 9 ? "  " : " ") + std::to_string(i + 1) + "\t    " + number_text(waves[i]) +
            "\t:\t   (p)\n";
  return text;
}

ZernikeListing zernike(const std::string& text, const DesignReading& reading = {}) {
  return read_zernike_listing(design_text(text, "z.txt"), reading);
}

std::string utf16(const std::string& latin1, bool big_endian) {
  std::string text;
  for (const char c : latin1) text += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
  return text;
}

TEST(Designs, OneTextInEveryEncoding) {
  const std::string utf8 = zernike_text({0.0, 0.0, 0.0, 0.25, -0.125});
  const std::string latin1 = replaced(utf8, "\xC2\xB5", "\xB5");
  std::string crlf = utf8, comma = replaced(replaced(latin1, "0.25", "0,25"), "0.125", "0,125");
  for (std::size_t at = 0; (at = crlf.find('\n', at)) != std::string::npos; at += 2) crlf.insert(at, 1, '\r');
  comma = replaced(replaced(comma, "0.0000, 7.0000", "0,0000, 7,0000"), "0.5500", "0,5500");
  const std::array<std::array<std::string, 2>, 9> texts{{{utf8, "UTF-8"},
                                                         {"\xEF\xBB\xBF" + utf8, "UTF-8"},
                                                         {crlf, "UTF-8"},
                                                         {latin1, "Latin-1"},
                                                         {comma, "Latin-1"},
                                                         {"\xFF\xFE" + utf16(latin1, false), "UTF-16"},
                                                         {"\xFE\xFF" + utf16(latin1, true), "UTF-16"},
                                                         {utf16(latin1, false), "UTF-16"},
                                                         {utf16(latin1, true), "UTF-16"}}};
  for (const auto& [text, encoding] : texts) {
    const DesignText read = design_text(text, "z.txt");
    EXPECT_EQ(read.encoding, encoding);
    EXPECT_EQ(read.decimal_comma, text == comma);
    const ZernikeField field = read_zernike_listing(read, {}).fields.at(0);
    EXPECT_EQ(field.waves, (std::vector<double>{0.0, 0.0, 0.0, 0.25, 0.125}));  // Z5 is a sine
    EXPECT_EQ(field.wavelength_um, 0.55);
    EXPECT_EQ(field.place->text(), "(0, -7) deg");
  }
  expect_refused({"b.zda", "encrypted", "text"}, [] { design_text(std::string("Z\0\1\x9F", 4), "b.zda"); });
}

TEST(Designs, WavefrontsAreThoseOfTheDefinitionWithYDown) {
  for (const bool noll : {true, false}) {
    std::vector<double> waves{0.0, 0.0, 0.0};
    while (waves.size() < 36)  // of Fringe Z37 is out of the scheme
      waves.push_back(0.1 * std::sin(3.0 * static_cast<double>(waves.size())));
    const std::string text = zernike_text(waves, noll ? "Standard" : "Fringe");
    const ZernikeListing up = zernike(text), down = zernike(text, {.y_up = false, .sign = -1.0});
    EXPECT_EQ(up.numbering, noll ? ZernikeNumbering::noll : ZernikeNumbering::fringe);
    for (double x = -0.7; x < 0.75; x += 0.2)
      for (double y = -0.7; y < 0.75; y += 0.2) {
        const double w = by_definition(noll, waves, x, y);  // sums of terms below 20: 1e-12 is 500 roundings
        EXPECT_NEAR(zernike_sum(up.numbering, up.fields[0].waves)(x, -y), w, 1e-12);
        EXPECT_NEAR(zernike_sum(down.numbering, down.fields[0].waves)(x, y), -w, 1e-12);
      }
  }
}

TEST(Designs, SeidelSumsInBothOrders) {
  // Hand-made conversions: rho^4 = (Z9 + 3 Z4 + 2)/6, rho^3 cos = (Z7 + 2 Z2)/3, x^2 = Z5/2 + Z4/4 + 1/4 of Fringe
  // terms; a Noll term is a Fringe term over the root of the mean of its square.
  const double w040 = 0.7, w131 = -0.4, w222 = 0.9, w020 = 0.3;
  const std::vector<double> fringe{0, 0, 0, w020 / 2 + w040 / 2 + w222 / 4, w222 / 2, 0, w131 / 3, 0, w040 / 6};
  const std::vector<double> noll{0,
                                 0,
                                 0,
                                 fringe[3] / std::sqrt(3.0),
                                 0,
                                 fringe[4] / std::sqrt(6.0),
                                 0,
                                 fringe[6] / std::sqrt(8.0),
                                 0,
                                 0,
                                 fringe[8] / std::sqrt(5.0)};
  PupilPolynomial seidel;
  seidel.add(seidel_polynomial(SeidelTerm::w040), w040);
  seidel.add(seidel_polynomial(SeidelTerm::w131), w131);
  seidel.add(seidel_polynomial(SeidelTerm::w222), w222);
  seidel.add(seidel_polynomial(SeidelTerm::w020), w020);
  for (const auto& [waves, kind] : {std::pair(fringe, "Fringe"), std::pair(noll, "Standard")}) {
    const ZernikeListing listing = zernike(zernike_text(waves, kind));
    const PupilPolynomial w = zernike_sum(listing.numbering, listing.fields[0].waves);
    for (double x = -0.7; x < 0.75; x += 0.2)
      for (double y = -0.7; y < 0.75; y += 0.2)
        EXPECT_NEAR(w(x, y) - w(0, 0), seidel(x, y) - w131 * x * 2.0 / 3.0, 1e-12)
            << kind;  // less the tilt of the coma
  }
}

/// A PSF as its definition in zernike_listing.h has it, y up, as a listing of n by n samples.
std::string psf_text(const std::string& title, const std::string& centre, int row, int column,
                     const std::function<double(double x, double y)>& psf, int n = 64) {
  std::string text = "Listing of " + title +
                     " PSF Data\n\n0.5500 \xC2\xB5m at 0.0000, 7.0000 (deg).\nData spacing is 0.288 \xC2\xB5m.\n"
                     "Data area is 18.455 \xC2\xB5m wide.\nImage grid size: 64 by 64\nCenter point is: " +
                     centre + "\n\n";
  for (int j = 1; j <= n; ++j) {
    for (int i = 1; i <= n; ++i) text += "  " + number_text(psf(i - column, row - j)) + "\t";
    text += "\n";
  }
  return text;
}

std::complex<double> otf_of(const PsfListing& psf, double fx, double fy) {  // cycles a sample
  std::complex<double> sum = 0.0;
  double light = 0.0;
  for (std::size_t j = 0; j < psf.samples.size(); ++j)
    for (std::size_t i = 0; i < psf.samples[j].size(); ++i) {
      const double x = static_cast<double>(i) - static_cast<double>(psf.samples[j].size() / 2),
                   y = static_cast<double>(j) - static_cast<double>(psf.samples.size() / 2);
      sum += psf.samples[j][i] * std::polar(1.0, -kTwoPi * (fx * x + fy * y));
      light += psf.samples[j][i];
    }
  return sum / light;
}

PsfListing psf_of(const std::string& text, const DesignReading& reading = {}) {
  return read_psf_listing(design_text(text, "psf.txt"), reading);
}

TEST(Designs, TheCentreOfAnEvenGridKeepsItsPhase) {
  const auto point = [](double x, double y) { return x == 0.0 && y == 0.0 ? 2.5 : 0.0; };
  // 33, 33 of Huygens is column 33, row 33 from the bottom: row 32 from the top.
  for (const std::string& text :
       {psf_text("FFT", "row 33, column 32", 33, 32, point), psf_text("Huygens", "33, 33", 32, 33, point)}) {
    const PsfListing psf = psf_of(text);
    EXPECT_EQ(psf.samples.size(), 65U);
    EXPECT_EQ(psf.samples.at(32).at(32), 2.5);
    EXPECT_NEAR(std::abs(otf_of(psf, 0.3, -0.2) - 1.0), 0.0, 1e-14);
    EXPECT_NEAR(psf.step_um, 18.455 / 64.0, 1e-15);  // 0.288 is that, rounded
    EXPECT_EQ(psf.place->text(), "(0, -7) deg");
  }
}

TEST(Designs, PsfAndZernikeListingsOfOneLensAgree) {
  const std::vector<double> waves{0, 0, 0, 0.05, -0.06, 0.03, 0.1, -0.07, 0.08, 0.02, 0.06};
  const int samples = 32;
  const double a = 0.2;  // cycles a sample at the rim of the pupil: cutoff 0.4
  std::vector<std::array<double, 3>> pupil;
  for (int i = 0; i < samples; ++i)
    for (int j = 0; j < samples; ++j) {
      const double p = (2.0 * i + 1.0) / samples - 1.0, q = (2.0 * j + 1.0) / samples - 1.0;
      if (p * p + q * q < 1.0) pupil.push_back({p, q, by_definition(true, waves, p, q)});
    }
  const auto psf = [&](double x, double y) {
    std::complex<double> u = 0.0;
    for (const auto& [p, q, w] : pupil) u += std::polar(1.0, kTwoPi * (w + a * (p * x + q * y)));
    return std::norm(u);
  };
  const PsfListing grid = psf_of(psf_text("Huygens", "33, 33", 32, 33, psf));
  const ZernikeListing terms = zernike(zernike_text(waves));
  const PupilPolynomial w = zernike_sum(terms.numbering, terms.fields[0].waves);
  double phase = 0.0;
  for (const auto& [fx, fy] : {std::pair(0.1, 0.0), std::pair(0.0, 0.1), std::pair(0.12, -0.08), std::pair(0.2, 0.1)}) {
    const Complex<double> h = wavefront_pupil_otf(w, {fx / (2.0 * a), fy / (2.0 * a)}, 0.0);
    // A pupil of 32 samples, and 1 % of the light beyond the grid; a wrong sign or side turns phases round.
    EXPECT_NEAR(std::abs(otf_of(grid, fx, fy) - std::complex<double>(h.re, h.im)), 0.0, 0.02) << fx << " " << fy;
    phase = std::max(phase, std::abs(std::atan2(h.im, h.re)));
  }
  EXPECT_GT(phase, 0.2);
}

TEST(Designs, AnAnnulusIsNoDisc) {
  const std::string rms =
      "From integration of the rays:\nRMS (to chief) : 0.0600 waves\n\n"
      "From integration of the fitted coefficients:\nRMS (to chief) : 0.50000000 waves\n\n";
  const std::string text = replaced(zernike_text({0.1, 0.0, 0.3, 0.4}), "Z   1", rms + "Z   1");
  EXPECT_TRUE(says(zernike(text).remarks.warnings, "annulus"));
  EXPECT_FALSE(says(zernike(replaced(text, "0.0600", "0.5001")).remarks.warnings, "annulus"));
  EXPECT_TRUE(says(zernike(text).remarks.notes, "0.66 um x f-number"));  // tilt: 2 x 0.55 um x 2 x 0.3
  expect_refused({"z.txt:11:", "edited"}, [&] { zernike(replaced(text, "0.50000000", "0.50100000")); });
}

TEST(Designs, ZernikeListingsThatAreRefused) {
  const std::string text = zernike_text({0.0, 0.0, 0.0, 0.25, 0.125});
  const auto refused = [&](const std::string& from, const std::string& to,
                           std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] { zernike(replaced(text, from, to)); });
  };
  refused("Standard", "Annular", {"z.txt:1:", "Zernike Standard"});
  refused("0.25", "nan", {"z.txt:11:", "Z4", "finite"});
  refused("Z   4", "Z   6", {"z.txt:11:", "Z4", "missing"});
  EXPECT_EQ(zernike(replaced(text, "Z   5", "Z5")).fields[0].waves.size(), 5U);  // as Z10 has no blank in some
  refused("Z   5", "Z6", {"z.txt:12:", "Z5", "missing"});
  refused("\xC2\xB5m", "", {"wavelength", "unit"});
  refused("0.25", "12.5", {"Z4", "refocus", "at most 10"});
  expect_refused({"--order fringe", "Standard"}, [&] { zernike(text, {.order = "fringe"}); });
  std::vector<double> many(95, 0.0);
  many[93] = 0.01;
  expect_refused({"Z91", "0.01 waves rms", "0.126", "PSF"}, [&] { zernike(zernike_text(many)); });
  many[93] = 1e-5;
  EXPECT_TRUE(says(zernike(zernike_text(many)).remarks.warnings, "0.000126"));
}

TEST(Designs, TablesOfCoefficients) {
  const std::string text =
      "# made by hand\nname;x (deg);y (deg);wavelength (nm);Z4 (waves);Z6 "
      "(waves)\na;0;0;550;0,1;0\nb;0;7;550;0,2;0,3\n";
  const ZernikeListing table = zernike(text, {.order = "fringe"});
  ASSERT_EQ(table.fields.size(), 2U);
  EXPECT_EQ(table.fields[1].waves, (std::vector<double>{0.0, 0.0, 0.0, 0.2, 0.0, -0.3}));  // Z6 is a sine
  EXPECT_EQ(table.fields[1].place->text(), "(0, -7) deg");
  EXPECT_NEAR(table.fields[1].wavelength_um, 0.55, 1e-15);
  EXPECT_TRUE(says(table.remarks.notes, "left out: name"));
  expect_refused({"z.txt", "--order noll"}, [&] { zernike(text); });
  expect_refused({"z.txt:2:", "Z4", "waves"}, [&] { zernike(replaced(text, "Z4 (waves)", "Z4"), {.order = "noll"}); });
  expect_refused({"z.txt:2:", "wavelength (um)"}, [&] { zernike(replaced(text, " (nm)", ""), {.order = "noll"}); });
}

TEST(Designs, PsfListingsThatAreRefused) {
  const std::string text =
      psf_text("FFT", "row 33, column 32", 33, 32, [](double x, double y) { return std::exp(-x * x - y * y); });
  const auto refused = [&](const std::string& from, const std::string& to,
                           std::initializer_list<std::string_view> parts) {
    expect_refused(parts, [&] { psf_of(replaced(text, from, to)); });
  };
  refused("0.288 \xC2\xB5m", "0.288", {"psf.txt:4:", "unit"});
  refused("64 by 64", "64 by 65", {"64 rows", "65"});
  refused("64 by 64", "63 by 64", {"psf.txt:9:", "64 values"});
  refused("row 33", "row 65", {"psf.txt:7:", "64"});
  refused("  1\t", "  nan\t", {"psf.txt:41:", "finite"});
  refused("Center point", "Centre", {"Center point"});
}

const std::string kCodeV =
    "  POSITION  1         DIFFRACTION MTF\n"
    "   FIELD (X,Y)=( 0.00, 0.70)MAX, (  0.00, 14.00)DEG      656.3 NM       1       864\n"
    "   RELATIVE ILLUMINATION = 61.4 PER CENT                 546.1 NM       2      1240\n\n"
    "      DIFFRACTION LIMIT    FOCUS POSITION\n"
    "       Formula  Actual     -0.05000    0.00000    0.05000\n"
    "  L/MM f/4.500 RAD  TAN    RAD  TAN   RAD  TAN   RAD  TAN\n"
    "  ---- ----------------   ---------  ---------  ---------\n"
    "     0 .999   .999 .999   .999 .999  .999 .999  .999 .999\n"
    "    10 .974   .974 .960   .600 .500  .815 .710  .400 .300\n"
    "    20 .949   .947 .921   .300 .200  .614 .512  .200 .100\n\n";

MtfListing mtf_of(const std::string& text) { return read_mtf_listing(design_text(text, "mtf.txt"), {}); }

TEST(Designs, CodeVAtTheNominalFocus) {
  const MtfListing listing = mtf_of(kCodeV + replaced(kCodeV, "14.00)", "20.00)"));
  ASSERT_EQ(listing.fields.size(), 2U);
  EXPECT_EQ(listing.unit, "cy/mm");
  EXPECT_EQ(listing.fields[0].frequency, (std::vector<double>{0.0, 10.0, 20.0}));
  EXPECT_EQ(listing.fields[0].sagittal, (std::vector<double>{1.0, 0.815, 0.614}));  // RAD
  EXPECT_EQ(listing.fields[0].tangential, (std::vector<double>{1.0, 0.71, 0.512}));
  EXPECT_EQ(listing.fields[1].place->text(), "(0, -20) deg");
  EXPECT_TRUE(says(listing.remarks.notes, "position 0 of -0.05, 0, 0.05"));
  EXPECT_TRUE(says(listing.remarks.warnings, "no phase"));
  expect_refused({"mtf.txt:7:", "nominal focus"}, [&] { mtf_of(replaced(kCodeV, " 0.00000 ", " 0.01000 ")); });
  expect_refused({"mtf.txt:7:", "unit"}, [&] { mtf_of(replaced(kCodeV, "L/MM", "FREQ")); });
  expect_refused({"mtf.txt:10:", "columns"}, [&] { mtf_of(replaced(kCodeV, " .400 .300", "")); });
  expect_refused({"mtf.txt:7:", "rows are missing"}, [&] { mtf_of(replaced(kCodeV, "    20 .9", "    30 .9")); });
}

TEST(Designs, MtfTextOfOpticStudioAndTables) {
  const std::string rows =
      " Spatial frequency     Tangential     Sagittal\n 0,000000 1,000000 1,000000\n 10,000000 0,710000 0,815000\n"
      " 20,000000 0,512000 0,614000\n\n";
  const MtfListing listing = mtf_of(
      "Polychromatic Diffraction MTF\n\nData for 0,4861 to 0,6563 \xC2\xB5m.\n"
      "Spatial frequency units are cycles per mm.\n\nField: Diffraction limit\n" +
      rows + "Field: 0,0000, 14,0000 (deg)\n" + rows);
  ASSERT_EQ(listing.fields.size(), 1U);
  EXPECT_EQ(listing.fields[0].tangential, (std::vector<double>{1.0, 0.71, 0.512}));
  EXPECT_EQ(listing.fields[0].place->text(), "(0, -14) deg");
  const std::string head = "Spatial frequency units are cycles per mm.\nField: 0, 14 (deg)\n";
  EXPECT_EQ(mtf_of(head + replaced(rows, " 20,0", "\n# page 2\n 20,0")).fields.at(0).tangential,
            listing.fields[0].tangential);
  expect_refused({"mtf.txt:6:", "***"}, [&] { mtf_of(head + replaced(rows, "20,000000", "***")); });
  expect_refused({"mtf.txt:9:", "columns above"}, [&] { mtf_of(head + rows + "Page 2\n 30 0,4 0,5\n"); });
  for (const char* unit : {"mrad", "cycle"})
    expect_refused({"mtf.txt:8:", "cy/mm"}, [&] { mtf_of(head + rows + replaced(head, "mm", unit) + rows); });
  const MtfListing table = mtf_of("frequency (cy/mm),sagittal,tangential\n0,1,1\n10,0.815,0.71\n20,0.614,0.512\n");
  EXPECT_EQ(table.fields.at(0).tangential, listing.fields[0].tangential);
  const std::string places =
      "x (deg),y (deg),tangential (10 cy/mm),sagittal (10 cy/mm),tangential (30 cy/mm),sagittal (30 cy/mm)\n"
      "0,14,0.71,0.815,0.3,0.4\n";
  EXPECT_EQ(mtf_of(places).fields.at(0).frequency, (std::vector<double>{0.0, 10.0, 30.0}));
  expect_refused({"mtf.txt:1:", "cy/mm"}, [&] { mtf_of(replaced(places, "(30 cy/mm)", "(30 cy/mrad)")); });
}

}  // namespace
}  // namespace mtf::io
