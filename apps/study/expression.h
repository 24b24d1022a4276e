// SPDX-License-Identifier: Apache-2.0
#pragma once

// Expressions of links, constraints and objectives: numbers ("2.5", "3 um"), names ("pitch", "optics.aperture",
// "presample[1].rms", "mtf_at_0.25_cy_px"), pi, + - * / ^, parentheses, and min, max, sqrt, exp, log, log10, abs. Every
// value is in SI units and has its dimensions, checked when the expression is read, so that "f_number * aperture" is a
// length whatever units the file uses and "pitch + f_number" is an error with its column. A power has a plain, constant
// exponent unless its base is plain; ^ binds closer than a sign before it and groups from the right. Evaluated by one
// body for double and ceres::Jet, without allocation.

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/study/dimensions.h"

namespace study {

/// What a name denotes: a slot among the values that an expression is evaluated with, and its dimensions.
struct Symbol {
  int slot = 0;
  Dimensions dimensions;
};
/// Null for an unknown name. May throw ExpressionError for a name that an expression cannot use; its
/// column counts within the name.
using FindSymbol = std::function<std::optional<Symbol>(std::string_view name)>;

/// An expression that cannot be read: `column` counts from 0 in its text.
struct ExpressionError {
  int column = 0;
  std::string text;
};

/// A name in an expression and where it starts.
struct NameAt {
  std::string name;
  int column = 0;
};

/// Every name in the text as often as it occurs, without functions and pi; what cannot be read is skipped.
std::vector<NameAt> names_in(std::string_view text);
/// Whether a number of the study's own can have that name.
bool is_identifier(std::string_view name);

class Expression {
 public:
  static constexpr std::size_t kMaxText = 2000;  ///< longest expression, in bytes
  static constexpr int kMaxDepth = 64;           ///< deepest nesting, and most values that wait for their operator

  /// The constant 0, for a place that has no expression yet.
  Expression() = default;

  /// Throws ExpressionError. `names` are offered for those that are misspelt.
  static Expression parse(std::string_view text, const FindSymbol& find, std::span<const std::string> names);

  /// The value in SI; `slots` hold the values of all symbols in SI.
  template <class S>
  S evaluate(std::span<const S> slots) const;

  const Dimensions& dimensions() const { return dimensions_; }
  /// The slots that it reads, each once, in rising order.
  const std::vector<int>& slots() const { return slots_; }
  const std::string& text() const { return text_; }
  /// The slot when the expression is nothing but one name.
  std::optional<int> only_slot() const {
    return steps_.size() == 1 && steps_[0].op == Op::slot ? std::optional(steps_[0].slot) : std::nullopt;
  }
  /// True when it reads no slot.
  bool constant() const { return slots_.empty(); }

 private:
  enum class Op { number, slot, add, subtract, multiply, divide, power, negate, min, max, sqrt, exp, log, log10, abs };
  struct Step {  // of a stack machine
    Op op = Op::number;
    double number = 0.0;
    int slot = 0;
  };
  friend class ExpressionParser;
  std::vector<Step> steps_{Step{}};
  std::vector<int> slots_;
  Dimensions dimensions_;
  std::string text_;
};

}  // namespace study
