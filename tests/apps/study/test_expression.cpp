// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "apps/study/expression.h"
#include "calib/fit/system_jet.h"
#include "tests/expect_error.h"

namespace study {
namespace {

using calib::Jet4;

// pitch 5 um, focal_length 2 m, f_number 8, time 3 ms, in SI; zero is a plain 0.
const std::vector<std::string> kNames{"pitch", "focal_length", "f_number", "frame.integration_time", "zero"};
const std::vector<double> kValues{5e-6, 2.0, 8.0, 3e-3, 0.0};

std::optional<Symbol> find(std::string_view name) {
  const std::vector<Dimensions> dimensions{{.metre = 1}, {.metre = 1}, {}, {.second = 1}, {}};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (kNames[i] == name) return Symbol{static_cast<int>(i), dimensions[i]};
  return std::nullopt;
}

Expression parsed(std::string_view text) { return Expression::parse(text, find, kNames); }
double value(std::string_view text) { return parsed(text).evaluate<double>(kValues); }

/// Column and text of the error; column -1 when there is none.
ExpressionError failure(std::string_view text) {
  try {
    parsed(text);
  } catch (const ExpressionError& error) {
    return error;
  }
  return {-1, ""};
}

TEST(Expression, ValuesArePlainArithmetic) {
  struct Case {
    const char* text;
    double value;
  };
  for (const Case& c : {Case{"1 + 2 * 3", 7.0},
                        Case{"(1 + 2) * 3", 9.0},
                        Case{"-2^2", -4.0},
                        Case{"2^3^2", 512.0},
                        Case{"2^-1", 0.5},
                        Case{"(-2)^2", 4.0},
                        Case{"--3", 3.0},
                        Case{"8 / 4 / 2", 1.0},
                        Case{"7 - 2 - 1", 4.0},
                        Case{"2 * -3", -6.0},
                        Case{"sqrt(16)", 4.0},
                        Case{"exp(0)", 1.0},
                        Case{"log(1)", 0.0},
                        Case{"log10(1000)", 3.0},
                        Case{"abs(-2.5)", 2.5},
                        Case{"min(3, 1, 2)", 1.0},
                        Case{"max(3, 1, 2)", 3.0},
                        Case{"1e-3*2E2", 0.2},
                        Case{".5 + 1.", 1.5},
                        Case{"2 * pi", 2.0 * std::numbers::pi},
                        Case{"f_number^2", 64.0},
                        Case{"f_number^zero", 1.0},
                        Case{" 50 % ", 0.5},
                        Case{"30 deg / (1 rad)", std::numbers::pi / 6.0},
                        Case{"+1", 1.0}})
    EXPECT_NEAR(value(c.text), c.value, 1e-15 * std::abs(c.value)) << c.text;
}

TEST(Expression, UnitsGoIntoSi) {
  EXPECT_DOUBLE_EQ(value("5 um"), 5e-6);
  EXPECT_DOUBLE_EQ(value("5um + 3 nm"), 5.003e-6);
  EXPECT_DOUBLE_EQ(value("20 cy/mm * pitch"), 0.1);
  EXPECT_DOUBLE_EQ(value("10 mm/pitch"), 2000.0);
  EXPECT_DOUBLE_EQ(value("6 m/s"), 6.0);
  EXPECT_DOUBLE_EQ(value("50 e- / (2 ms)"), 25000.0);
  EXPECT_DOUBLE_EQ(value("focal_length / f_number"), 0.25);
  EXPECT_DOUBLE_EQ(value("(3 um)^2"), 9e-12);
}

TEST(Expression, DimensionsFollowTheOperators) {
  struct Case {
    const char *text, *dimensions;
  };
  for (const Case& c :
       {Case{"pitch * f_number", "m"}, Case{"pitch / focal_length", "a plain number"}, Case{"pitch ^ 2", "m^2"},
        Case{"(pitch^2)^0.5", "m"}, Case{"sqrt(pitch * focal_length)", "m"},
        Case{"pitch / frame.integration_time", "m s^-1"}, Case{"focal_length ^ -(1 + 1)", "m^-2"},
        Case{"min(pitch, 3 um)", "m"}, Case{"abs(-pitch)", "m"}, Case{"2 e-/s", "s^-1 e-"}, Case{"20 cy/mm", "m^-1"},
        Case{"4 deg", "a plain number"}, Case{"pitch^0", "a plain number"}, Case{"sqrt(pitch)", "m^0.5"},
        Case{"focal_length^2.7", "m^2.7"}, Case{"focal_length ^ 2.5 / (1 m)^0.5", "m^2"}})
    EXPECT_EQ(describe(parsed(c.text).dimensions()), c.dimensions) << c.text;
}

TEST(Expression, ErrorsHaveTheirColumn) {
  struct Case {
    const char* text;
    int column;
    const char* says;
  };
  for (const Case& c : {
           Case{"", 0, "empty"},
           Case{"   ", 3, "empty"},
           Case{"1 +", 3, "the end"},
           Case{"1 + * 2", 4, "'* 2'"},
           Case{"(1 + 2", 6, "')'"},
           Case{"1 + 2)", 5, "')'"},
           Case{"2 pitch", 2, "write *"},
           Case{"pitch pitch", 6, "operator"},
           Case{"pitch + f_number", 0, "add m (pitch)"},
           Case{"1 + (pitch - 2)", 5, "subtract m (pitch)"},
           Case{"f_number + pich", 11, "did you mean pitch?"},
           Case{"focal_lenght * 2", 0, "did you mean focal_length?"},
           Case{"log(pitch)", 4, "plain number, not m"},
           Case{"2 ^ pitch", 4, "exponent"},
           Case{"pitch ^ f_number", 8, "constant"},
           Case{"pitch ^ 0.123456789", 0, "has no unit"},
           Case{"3 um ^ 2", 0, "(3 um)"},
           Case{"sqr(4)", 0, "did you mean sqrt?"},
           Case{"min(3)", 5, "two values"},
           Case{"max(pitch, 3)", 4, "compare m (pitch)"},
           Case{"abs 3", 4, "'('"},
           Case{"1 $ 2", 2, "'$ 2'"},
           Case{"1e999", 0, "range"},
           Case{"pitch^60 * pitch^60", 0, "beyond 100"},
       }) {
    const ExpressionError error = failure(c.text);
    EXPECT_EQ(error.column, c.column) << c.text << ": " << error.text;
    EXPECT_TRUE(says(error.text, c.says)) << c.text << ": " << error.text;
  }
}

TEST(Expression, ConstantsThatAreNotFiniteAreErrorsWithTheirPlace) {
  for (const auto& [text, column, quoted] : {std::tuple{"f_number * (2 - 1/0)", 16, "'1/0'"},
                                             {"0^-1", 0, "'0^-1'"},
                                             {"f_number + log(0) + 1", 11, "'log(0)'"},
                                             {"exp(1e3)", 0, "'exp(1e3)'"},
                                             {"-(1e300 m * 1e300 s)", 2, "'1e300 m * 1e300 s'"}}) {
    const study::ExpressionError error = failure(text);
    EXPECT_EQ(error.column, column) << text;
    expect_says(error.text, {std::string(quoted) + " is no finite number"});
  }
  EXPECT_EQ(value("1 / 3 * 3"), 1.0);
}

TEST(Expression, DepthAndLengthAreBounded) {
  const auto repeated = [](const std::string& text, int n) {
    std::string result;
    for (int i = 0; i < n; ++i) result += text;
    return result;
  };
  EXPECT_EQ(value(repeated("(", 40) + "7" + repeated(")", 40)), 7.0);
  expect_says(failure(repeated("(", 70) + "7" + repeated(")", 70)).text, {"deeper"});
  expect_says(failure(repeated("-", 1000) + "7").text, {"deeper"});
  expect_says(failure(repeated("2^", 500) + "2").text, {"deeper"});
  expect_says(failure(repeated("abs(", 300) + "2").text, {"deeper"});
  expect_says(failure(repeated("1 + ", 5000) + "2").text, {"2000 characters"});
  EXPECT_EQ(value(repeated("1+", 999) + "1"), 1000.0);
  // As many values wait as the stack holds, never more.
  EXPECT_EQ(value(repeated("1+1^(", 20) + "0" + repeated(")", 20)), 2.0);
  EXPECT_NE(failure(repeated("1+2^(", 33) + "0" + repeated(")", 33)).column, -1);
}

TEST(Expression, SlotsAndNamesAreListed) {
  const Expression e = parsed("focal_length / pitch + focal_length / (2 m)");
  EXPECT_EQ(e.slots(), (std::vector<int>{0, 1}));
  EXPECT_FALSE(e.only_slot());
  EXPECT_EQ(parsed(" (f_number) ").only_slot(), 2);
  EXPECT_TRUE(parsed("3 um").constant());
  const auto names = names_in("min(a.b, presample[1].rms) * 3 um / mtf_at_0.25_cy_px + pi ^ $ x[");
  ASSERT_EQ(names.size(), 4u);
  EXPECT_EQ(names[0].name, "a.b");
  EXPECT_EQ(names[0].column, 4);
  EXPECT_EQ(names[1].name, "presample[1].rms");
  EXPECT_EQ(names[2].name, "mtf_at_0.25_cy_px");
  EXPECT_EQ(names[3].name, "x");
}

/// d/df_number at f_number = x, and the value, through Jet4; the other slots do not vary.
Jet4 derivative(std::string_view text, double x) {
  std::vector<Jet4> slots;
  for (const double v : kValues) slots.emplace_back(v);
  slots[2] = Jet4(x, 1);
  return parsed(text).evaluate<Jet4>(slots);
}

TEST(Expression, DerivativesAreThoseOfTheFormula) {
  // Closed forms.
  const double x = 1.7;
  struct Case {
    const char* text;
    double slope;
  };
  for (const Case& c :
       {Case{"f_number^3", 3 * x * x}, Case{"sqrt(f_number)", 0.5 / std::sqrt(x)},
        Case{"exp(-f_number)", -std::exp(-x)}, Case{"log(f_number)", 1 / x},
        Case{"log10(f_number)", 1 / (x * std::numbers::ln10)}, Case{"2 ^ f_number", std::exp2(x) * std::numbers::ln2},
        Case{"f_number ^ f_number", std::pow(x, x) * (std::log(x) + 1)}, Case{"abs(1 - f_number)", 1.0},
        Case{"max(f_number, 1)", 1.0}, Case{"min(f_number, 1)", 0.0}, Case{"1 / f_number", -1 / (x * x)},
        Case{"(-f_number) ^ 2", 2 * x}}) {
    const Jet4 result = derivative(c.text, x);
    EXPECT_NEAR(result.v[1], c.slope, 1e-14 * std::max(1.0, std::abs(c.slope))) << c.text;
    EXPECT_EQ(result.v[0], 0.0) << c.text;  // a direction in which nothing changes
  }
}

TEST(Expression, DerivativesAtZero) {
  EXPECT_EQ(derivative("f_number ^ 2", 0.0).v[1], 0.0);
  EXPECT_EQ(derivative("f_number ^ 1", 0.0).v[1], 1.0);
  EXPECT_EQ(derivative("f_number ^ 0", 0.0).v[1], 0.0);
  EXPECT_EQ(derivative("f_number ^ 0", 0.0).a, 1.0);
  EXPECT_EQ(derivative("f_number ^ 1.5", 0.0).v[1], 0.0);
  EXPECT_EQ(derivative("abs(f_number)", 0.0).v[1], 0.0);
  EXPECT_EQ(derivative("zero ^ f_number", 2.0).v[1], 0.0);
  EXPECT_EQ(derivative("(-2) ^ (f_number / f_number * 2)", 3.0).a, 4.0);
  const Jet4 root = derivative("sqrt(f_number)", 0.0);
  EXPECT_EQ(root.a, 0.0);
  EXPECT_EQ(root.v[1], std::numeric_limits<double>::infinity());
  EXPECT_EQ(root.v[0], 0.0);  // not 0 x infinity
  const Jet4 still = derivative("sqrt(zero) + f_number", 2.0);
  EXPECT_EQ(still.a, 2.0);
  EXPECT_EQ(still.v[1], 1.0);
}

TEST(Expression, NotANumberIsNotHidden) {
  EXPECT_TRUE(std::isnan(value("sqrt(-1 * f_number)")));
  EXPECT_TRUE(std::isnan(value("min(sqrt(-f_number), 1)")));
  EXPECT_TRUE(std::isnan(value("max(1, sqrt(-f_number))")));
  EXPECT_TRUE(std::isinf(value("1 / zero")));
}

TEST(Expression, RandomTextNeverCrashes) {
  const std::vector<std::string> pieces{"pitch", "f_number", "(",  ")",    "+",    "-",    "*",  "/", "^",
                                        "min",   "sqrt",     ",",  "2",    "3 um", "1e-3", "[",  "]", ".",
                                        " ",     "%",        "e-", "\xff", "\"",   "log",  "\t", "_", "0.5"};
  std::mt19937 random(7);
  int good = 0;
  for (int i = 0; i < 50'000; ++i) {
    std::string text;
    const auto n = random() % 12;
    for (std::uint32_t k = 0; k < n; ++k) text += pieces[random() % pieces.size()];
    static_cast<void>(names_in(text));
    try {
      const Expression e = parsed(text);
      static_cast<void>(e.evaluate<double>(kValues));
      ++good;
    } catch (const ExpressionError& error) {
      ASSERT_GE(error.column, 0) << text;
      ASSERT_LE(static_cast<std::size_t>(error.column), text.size()) << text;
    }
  }
  EXPECT_GT(good, 500);  // the loop reaches more than the first token
}

}  // namespace
}  // namespace study
