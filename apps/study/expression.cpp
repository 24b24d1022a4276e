// SPDX-License-Identifier: Apache-2.0
#include "apps/study/expression.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/fit/system_jet.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace study {
namespace {

using calib::Jet4;

double value_of(double x) { return x; }
double value_of(const Jet4& x) { return x.a; }

/// f(x) from its value and derivative. A direction in which x does not change stays 0 where the derivative is
/// infinite.
double chain(double value, double, double) { return value; }
Jet4 chain(double value, double derivative, const Jet4& x) {
  Jet4 result(value);
  for (int i = 0; i < Jet4::DIMENSION; ++i)
    if (x.v[i] != 0.0) result.v[i] = derivative * x.v[i];
  return result;
}

double power(double base, double exponent) { return std::pow(base, exponent); }

/// d/d(base) = e b^(e-1), right at b = 0 for every e >= 0 (infinite for 0 < e < 1); d/d(exponent) = b^e log b, with its
/// limit 0 at b = 0 for e > 0, and none for b < 0.
Jet4 power(const Jet4& base, const Jet4& exponent) {
  const double b = base.a, e = exponent.a, value = std::pow(b, e);
  const double by_base = e == 0.0 ? 0.0 : e * std::pow(b, e - 1.0);
  const double by_exponent = b > 0.0               ? value * std::log(b)
                             : b == 0.0 && e > 0.0 ? 0.0
                                                   : std::numeric_limits<double>::quiet_NaN();
  return chain(value, by_base, base) + chain(0.0, by_exponent, exponent);
}

constexpr std::array<std::string_view, 7> kFunctions{"min", "max", "sqrt", "exp", "log", "log10", "abs"};
constexpr std::string_view kPi = "pi";

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Length of the name that `text` starts with: letters, digits, "_" and "." after a letter, and whole "[12]".
std::size_t name_length(std::string_view text) {
  if (text.empty() || !is_letter(text.front())) return 0;
  std::size_t at = 1;
  while (at < text.size()) {
    if (is_letter(text[at]) || is_digit(text[at]) || text[at] == '.') {
      ++at;
    } else if (text[at] == '[') {
      std::size_t close = at + 1;
      while (close < text.size() && is_digit(text[close])) ++close;
      if (close == at + 1 || close >= text.size() || text[close] != ']') break;
      at = close + 1;
    } else {
      break;
    }
  }
  return at;
}

/// Length of the number that `text` starts with, 0 for none.
std::size_t number_length(std::string_view text, double& value) {
  if (text.empty() || !(is_digit(text.front()) || text.front() == '.')) return 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc::result_out_of_range) value = std::numeric_limits<double>::infinity();
  return status == std::errc::invalid_argument ? 0 : static_cast<std::size_t>(end - text.data());
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

bool is_function(std::string_view name) { return std::ranges::find(kFunctions, name) != kFunctions.end(); }

}  // namespace

template <class S>
S Expression::evaluate(std::span<const S> slots) const {
  std::array<S, kMaxDepth> stack;
  std::size_t top = 0;  // number of values on it; the parser has seen to that it fits
  const auto replace_two = [&](const S& result) {
    stack[top - 2] = result;
    --top;
  };
  for (const Step& step : steps_) {
    if (step.op == Op::number) {
      stack[top++] = S(step.number);
      continue;
    }
    if (step.op == Op::slot) {
      stack[top++] = slots[static_cast<std::size_t>(step.slot)];
      continue;
    }
    S& last = stack[top - 1];
    const double x = value_of(last);
    switch (step.op) {
      case Op::add:
        replace_two(stack[top - 2] + last);
        break;
      case Op::subtract:
        replace_two(stack[top - 2] - last);
        break;
      case Op::multiply:
        replace_two(stack[top - 2] * last);
        break;
      case Op::divide:
        replace_two(stack[top - 2] / last);
        break;
      case Op::power:
        replace_two(power(stack[top - 2], last));
        break;
      case Op::min:  // of equals the first; a NaN stays one
        replace_two(x < value_of(stack[top - 2]) || std::isnan(x) ? last : stack[top - 2]);
        break;
      case Op::max:
        replace_two(x > value_of(stack[top - 2]) || std::isnan(x) ? last : stack[top - 2]);
        break;
      case Op::negate:
        last = -last;
        break;
      case Op::sqrt:
        last = chain(std::sqrt(x), 0.5 / std::sqrt(x), last);
        break;
      case Op::exp:
        last = chain(std::exp(x), std::exp(x), last);
        break;
      case Op::log:
        last = chain(std::log(x), 1.0 / x, last);
        break;
      case Op::log10:
        last = chain(std::log10(x), 1.0 / (x * std::log(10.0)), last);
        break;
      case Op::abs:
        last = chain(std::abs(x), x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0, last);
        break;
      case Op::number:
      case Op::slot:
        break;
    }
  }
  return stack[0];
}

template double Expression::evaluate(std::span<const double>) const;
template Jet4 Expression::evaluate(std::span<const Jet4>) const;

// Reading expressions:
//   sum     = product { ("+" | "-") product }
//   product = sign { ("*" | "/") sign }
//   sign    = [ "+" | "-" ] sign | power
//   power   = atom [ "^" sign ]
//   atom    = number [ unit ] | name | function "(" sum { "," sum } ")" | "(" sum ")"

std::vector<NameAt> names_in(std::string_view text) {
  std::vector<NameAt> names;
  text = text.substr(0, Expression::kMaxText);
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view rest = text.substr(at);
    double number = 0.0;
    if (const std::size_t digits = number_length(rest, number); digits > 0) {
      at += digits;
      std::size_t next = at;
      while (next < text.size() && is_blank(text[next])) ++next;
      if (const std::size_t unit = unit_length(text.substr(next)); unit > 0) at = next + unit;
    } else if (const std::size_t length = name_length(rest); length > 0) {
      const std::string_view name = rest.substr(0, length);
      if (!is_function(name) && name != kPi) names.push_back({std::string(name), static_cast<int>(at)});
      at += length;
    } else {
      ++at;
    }
  }
  return names;
}

bool is_identifier(std::string_view name) {
  const auto found = names_in(name);
  return found.size() == 1 && found[0].name == name && name.find_first_of(".[") == std::string_view::npos;
}

class ExpressionParser {
 public:
  ExpressionParser(std::string_view text, const FindSymbol& find, std::span<const std::string> names)
      : text_(text), find_(find), names_(names) {}

  Expression parse() {
    out_.text_ = std::string(text_);
    out_.steps_.clear();
    if (text_.size() > Expression::kMaxText)
      fail(0, "an expression has at most " + std::to_string(Expression::kMaxText) + " characters");
    skip_blanks();
    if (at_ == text_.size()) fail(at_, "empty; write an expression such as \"f_number * aperture\"");
    out_.dimensions_ = sum().dimensions;
    if (at_ < text_.size()) fail(at_, "expected an operator instead of " + here());
    std::sort(out_.slots_.begin(), out_.slots_.end());
    out_.slots_.erase(std::unique(out_.slots_.begin(), out_.slots_.end()), out_.slots_.end());
    return std::move(out_);
  }

 private:
  using Op = Expression::Op;
  using Step = Expression::Step;

  /// What has been read: its dimensions, where it starts, and its value when it is constant.
  struct Part {
    Dimensions dimensions;
    std::size_t start = 0;
    std::optional<double> constant;
  };

  [[noreturn]] static void fail(std::size_t at, std::string text) {
    throw ExpressionError{static_cast<int>(at), std::move(text)};
  }
  std::string here() const {
    return at_ < text_.size() ? "'" + mtf::printable(text_.substr(at_, 20)) + "'" : "the end";
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip_blanks() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    skip_blanks();
    return true;
  }
  void expect(char c, std::size_t opened) {
    if (take(c)) return;
    fail(at_, std::string("expected '") + c + "' for the '(' at column " + std::to_string(opened + 1) + " instead of " +
                  here());
  }

  /// Counts one level of nesting for as long as it lives.
  class Level {
   public:
    Level(int& depth, std::size_t at) : depth_(depth) {
      if (++depth_ > Expression::kMaxDepth) fail(at, "nested deeper than " + std::to_string(Expression::kMaxDepth));
    }
    ~Level() { --depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

   private:
    int& depth_;
  };

  void push(Step step, std::size_t at) {
    if (++waiting_ > Expression::kMaxDepth) fail(at, "too many values wait for their operator; add parentheses");
    out_.steps_.push_back(step);
  }
  /// The value of a step whose operands are constant.
  std::optional<double> apply(Op op, const std::optional<double>& a, const std::optional<double>& b = 0.0) {
    out_.steps_.push_back({.op = op});
    if (!a || !b) return std::nullopt;
    Expression alone;
    alone.steps_ = {{.op = Op::number, .number = *a}};
    const bool unary =
        op == Op::negate || op == Op::sqrt || op == Op::exp || op == Op::log || op == Op::log10 || op == Op::abs;
    if (!unary) alone.steps_.push_back({.op = Op::number, .number = *b});
    alone.steps_.push_back({.op = op});
    return alone.evaluate<double>({});
  }

  /// A constant is what it is for every design: one that is not finite can only be a mistake.
  void require_finite(const Part& part) const {
    if (part.constant && !std::isfinite(*part.constant))
      fail(part.start, "'" + source(part, at_) + "' is no finite number, whatever the design; correct it");
  }
  void require_same(const Part& a, const Part& b, const std::string& verb) {
    if (a.dimensions == b.dimensions) return;
    fail(a.start, "cannot " + verb + " " + describe(a.dimensions) + " (" + source(a, b.start) + ") and " +
                      describe(b.dimensions) + " (" + source(b, at_) + ")");
  }
  std::string source(const Part& part, std::size_t end) const {
    std::string text(text_.substr(part.start, end - part.start));
    while (!text.empty() && std::string_view(" \t\n\r+-*/^<>,").find(text.back()) != std::string_view::npos)
      text.pop_back();
    return mtf::printable(text, 60);
  }

  Part sum() {
    Part left = product_of();
    for (;;) {
      const bool plus = peek() == '+';
      if (!plus && peek() != '-') return left;
      take(peek());
      const Part right = product_of();
      require_same(left, right, plus ? "add" : "subtract");
      --waiting_;
      left.constant = apply(plus ? Op::add : Op::subtract, left.constant, right.constant);
      require_finite(left);
    }
  }

  Part product_of() {
    Part left = sign();
    for (;;) {
      const bool times = peek() == '*';
      if (!times && peek() != '/') return left;
      take(peek());
      const Part right = sign();
      const auto both = product(left.dimensions, right.dimensions, times ? 1 : -1);
      if (!both) fail(left.start, "a power of a unit beyond 100");
      left.dimensions = *both;
      --waiting_;
      left.constant = apply(times ? Op::multiply : Op::divide, left.constant, right.constant);
      require_finite(left);
    }
  }

  Part sign() {
    const Level level(depth_, at_);
    const std::size_t start = at_;
    if (take('+')) return sign();
    if (!take('-')) return power_of();
    Part part = sign();
    part.start = start;
    part.constant = apply(Op::negate, part.constant);
    return part;
  }

  Part power_of() {
    Part base = atom();
    if (peek() != '^') return base;
    if (after_unit_)
      fail(base.start, "write (" + source(base, at_) + ") ^ ..., so that it is clear whether the unit is raised too");
    take('^');
    const Part exponent = sign();
    if (!exponent.dimensions.plain())
      fail(exponent.start, "an exponent is a plain number, not " + describe(exponent.dimensions));
    if (!base.dimensions.plain()) {
      if (!exponent.constant)
        fail(exponent.start, "the exponent of " + describe(base.dimensions) + " has to be constant: the unit of the " +
                                 "power would change with it");
      const auto raised = power(base.dimensions, *exponent.constant);
      if (!raised)
        fail(base.start,
             describe(base.dimensions) + " to the power " + mtf::format_double(*exponent.constant) + " has no unit");
      base.dimensions = *raised;
    }
    --waiting_;
    base.constant = apply(Op::power, base.constant, exponent.constant);
    require_finite(base);
    after_unit_ = false;
    return base;
  }

  Part atom() {
    after_unit_ = false;
    const std::size_t start = at_;
    double number = 0.0;
    if (const std::size_t length = number_length(text_.substr(at_), number); length > 0) return literal(length, number);
    if (const std::size_t length = name_length(text_.substr(at_)); length > 0) return name(length);
    if (!take('(')) fail(at_, "expected a number, a name or '(' instead of " + here());
    Part part = sum();
    expect(')', start);
    after_unit_ = false;
    part.start = start;
    return part;
  }

  Part literal(std::size_t length, double number) {
    const std::size_t start = at_;
    if (!std::isfinite(number)) fail(start, "number out of range");
    at_ += length;
    skip_blanks();
    UnitScale scale;
    if (const std::size_t unit = unit_length(text_.substr(at_)); unit > 0) {
      scale = unit_scale(text_.substr(at_, unit));
      at_ += unit;
      skip_blanks();
      after_unit_ = true;
    } else if (is_letter(peek())) {
      fail(at_, here() + " after a number is no unit; for a product write *");
    }
    const Part part{scale.dimensions, start, number * scale.si};
    require_finite(part);
    push({.op = Op::number, .number = *part.constant}, start);
    return part;
  }

  Part name(std::size_t length) {
    const std::size_t start = at_;
    const std::string name(text_.substr(at_, length));
    at_ += length;
    skip_blanks();
    if (is_function(name)) return function(name, start);
    if (name == kPi) {
      push({.op = Op::number, .number = std::numbers::pi}, start);
      return {{}, start, std::numbers::pi};
    }
    if (peek() == '(') {
      const auto guess = mtf::nearest(name, kFunctions);
      fail(start, "unknown function '" + mtf::printable(name, 60) + "'" +
                      (guess ? "; did you mean " + *guess + "?" : "; there are min, max, sqrt, exp, log, log10, abs"));
    }
    std::optional<Symbol> symbol;
    try {
      symbol = find_(name);
    } catch (const ExpressionError& error) {
      fail(start + static_cast<std::size_t>(error.column), error.text);
    }
    if (!symbol) {
      const auto guess = name.size() <= 64 ? mtf::nearest(name, names_) : std::nullopt;
      fail(start, "unknown name '" + mtf::printable(name, 60) + "'" + (guess ? "; did you mean " + *guess + "?" : ""));
    }
    push({.op = Op::slot, .slot = symbol->slot}, start);
    out_.slots_.push_back(symbol->slot);
    return {symbol->dimensions, start, std::nullopt};
  }

  Part function(const std::string& name, std::size_t start) {
    const Level level(depth_, start);
    const std::size_t opened = at_;
    if (!take('(')) fail(at_, "expected '(' after " + name + " instead of " + here());
    Part part = sum();
    const bool least = name == "min";
    if (least || name == "max") {
      if (peek() != ',') fail(at_, name + " takes two values or more, with commas between them");
      while (take(',')) {
        const Part next = sum();
        require_same(part, next, "compare");
        --waiting_;
        part.constant = apply(least ? Op::min : Op::max, part.constant, next.constant);
      }
    } else if (name == "sqrt") {
      const auto root = power(part.dimensions, 0.5);
      if (!root) fail(part.start, "the square root of " + describe(part.dimensions) + " has no unit");
      part.dimensions = *root;
      part.constant = apply(Op::sqrt, part.constant);
    } else if (name == "abs") {
      part.constant = apply(Op::abs, part.constant);
    } else {
      if (!part.dimensions.plain())
        fail(part.start,
             name + " takes a plain number, not " + describe(part.dimensions) + "; divide by a unit: x / (1 m)");
      part.constant = apply(name == "exp" ? Op::exp : name == "log" ? Op::log : Op::log10, part.constant);
    }
    expect(')', opened);
    after_unit_ = false;
    part.start = start;
    require_finite(part);
    return part;
  }

  std::string_view text_;
  const FindSymbol& find_;
  std::span<const std::string> names_;
  Expression out_;
  std::size_t at_ = 0;
  int depth_ = 0, waiting_ = 0;
  bool after_unit_ = false;  ///< the atom just read is a number with unit
};

Expression Expression::parse(std::string_view text, const FindSymbol& find, std::span<const std::string> names) {
  return ExpressionParser(text, find, names).parse();
}

}  // namespace study
