// SPDX-License-Identifier: Apache-2.0
#pragma once

// Conjugate gradients (Hestenes and Stiefel, J. Res. NBS 49, 1952) for A x = b with A symmetric and positive definite,
// or semidefinite with b in its range.

#include <cmath>
#include <numeric>
#include <vector>

namespace radiometry::scene {

struct LinearSolution {
  std::vector<double> x;
  int iterations = 0;
  double residual = 0.0;  ///< relative, in the Euclidean norm
};

/// `multiply(p)` returns A p. Ends at the relative residual `tolerance`, after `most` iterations, or where A is not
/// positive.
template <class Multiply>
LinearSolution conjugate_gradients(const Multiply& multiply, std::vector<double> b, double tolerance, int most) {
  const auto product = [](const std::vector<double>& p, const std::vector<double>& q) {
    return std::inner_product(p.begin(), p.end(), q.begin(), 0.0);
  };
  LinearSolution solution{.x = std::vector<double>(b.size(), 0.0)};
  const double start = product(b, b);
  if (start == 0.0) return solution;
  std::vector<double> residual = std::move(b), direction = residual;
  double squares = start;
  while (squares > tolerance * tolerance * start && solution.iterations < most) {
    const std::vector<double> image = multiply(direction);
    const double curvature = product(direction, image);
    if (!(curvature > 0.0)) break;  // b is not in the range of A
    const double step = squares / curvature;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      solution.x[i] += step * direction[i];
      residual[i] -= step * image[i];
    }
    const double next = product(residual, residual), ratio = next / squares;
    for (std::size_t i = 0; i < residual.size(); ++i) direction[i] = residual[i] + ratio * direction[i];
    squares = next;
    ++solution.iterations;
  }
  solution.residual = std::sqrt(squares / start);
  return solution;
}

}  // namespace radiometry::scene
