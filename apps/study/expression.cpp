// SPDX-License-Identifier: Apache-2.0
#include "apps/study/expression.h"

#include <array>
#include <cmath>
#include <limits>

#include "calib/fit/system_jet.h"

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

}  // namespace study
