// SPDX-License-Identifier: Apache-2.0
#pragma once

// Expressions of links, constraints and objectives: numbers ("2.5", "3 um"), names, + - * / ^, parentheses, and min,
// max, sqrt, exp, log, log10, abs. Every value is in SI units and has its dimensions, checked when the expression is
// read, so that "f_number * aperture" is a length whatever units the file uses and "pitch + f_number" is an error with
// its column. A power has a plain, constant exponent unless its base is plain. Evaluated by one body for double and
// ceres::Jet, without allocation.

#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/study/dimensions.h"

namespace study {

/// What a name stands for: a slot among the values that an expression is evaluated with, and its dimensions.
struct Symbol {
  int slot = 0;
  Dimensions dimensions;
};
/// Null for a name that nothing has.
using FindSymbol = std::function<std::optional<Symbol>(std::string_view name)>;

/// An expression that cannot be read: `column` counts from 0 in its text.
struct ExpressionError {
  int column = 0;
  std::string text;
};

class Expression {
 public:
  /// Throws ExpressionError. `names` are offered for those that are misspelt.
  static Expression parse(std::string_view text, const FindSymbol& find, std::span<const std::string> names);

  /// In SI; `slots` hold the values of all symbols in SI.
  template <class S>
  S evaluate(std::span<const S> slots) const;

  const Dimensions& dimensions() const { return dimensions_; }
  /// Slots that it reads, each once, rising.
  const std::vector<int>& slots() const { return slots_; }
  const std::string& text() const { return text_; }

 private:
  enum class Op { number, slot, add, subtract, multiply, divide, power, negate, min, max, sqrt, exp, log, log10, abs };
  struct Step {  // of a stack machine
    Op op;
    double number = 0.0;
    int slot = 0;
  };
  friend struct ExpressionParser;
  std::vector<Step> steps_;
  std::vector<int> slots_;
  Dimensions dimensions_;
  std::string text_;
};

}  // namespace study
