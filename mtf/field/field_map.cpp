// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/field_map.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mtf/error.h"
#include "mtf/math/barycentric.h"
#include "mtf/words.h"

namespace mtf {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kBeyond = 0.01;  // of the width of the positions: a corner lies half a pixel beyond its pixel's centre
constexpr double kRankFrom = 1e-9;    // of the largest pivot: positions that determine a polynomial to nine digits
constexpr double kReproduced = 1e-7;  // of the values
constexpr std::size_t kMostLeftOut = 200;

std::size_t term_count(const FieldMap& map) {
  const auto d = static_cast<std::size_t>(map.degree);
  return map.radial ? d + 1 : (d + 1) * (d + 2) / 2;
}

FieldPoint<double> scaled_place(const FieldMap& map, const FieldPoint<double>& place) {
  return {(place.x - map.middle.x) / map.scale, (place.y - map.middle.y) / map.scale};
}

/// Rows of positions, columns of terms.
MatrixXd polynomial_matrix(const FieldMap& map) {
  MatrixXd matrix(static_cast<Index>(map.position.size()), static_cast<Index>(term_count(map)));
  for (Index i = 0; i < matrix.rows(); ++i)
    map.each_term(scaled_place(map, map.position[static_cast<std::size_t>(i)]),
                  [&](std::size_t k, double term) { matrix(i, static_cast<Index>(k)) = term; });
  return matrix;
}

/// The largest degree whose polynomials the positions tell apart; degree 3 only where one more position is there.
int degree_of(FieldMap map) {
  for (map.degree = 3; map.degree > 0; --map.degree) {
    if (map.position.size() < term_count(map) + (map.degree == 3 ? 1 : 0)) continue;
    Eigen::ColPivHouseholderQR<MatrixXd> qr(polynomial_matrix(map));
    if (qr.setThreshold(kRankFrom).rank() == static_cast<Index>(term_count(map))) break;
  }
  return map.degree;
}

double cross(const FieldPoint<double>& a, const FieldPoint<double>& b, const FieldPoint<double>& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Corners of the convex hull, in the sense in which cross() is positive (Andrew's monotone chain).
std::vector<FieldPoint<double>> hull_of(std::vector<FieldPoint<double>> points) {
  std::ranges::sort(points, {}, [](const auto& p) { return std::pair(p.x, p.y); });
  std::vector<FieldPoint<double>> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const FieldPoint<double>& p : points) {
      while (hull.size() >= first + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0.0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();  // begins the other side
    std::ranges::reverse(points);
  }
  return hull;
}

}  // namespace

void require_positions(const FieldMap& map) {
  const auto fail = [&](const std::string& why) { return UsageError(map.source + ": " + why); };
  const std::size_t n = map.position.size(), least = map.radial ? 2 : 3;
  if (n < least)
    throw fail(std::to_string(n) + " position" + (n == 1 ? "" : "s") + ", at least " + std::to_string(least) +
               " are needed; what is the same everywhere is one number in the sensor file");
  if (n > kMostFieldPositions)
    throw fail(std::to_string(n) + " positions, at most " + std::to_string(kMostFieldPositions) + "; keep every " +
               std::to_string(n / kMostFieldPositions + 1) + "th, config check says what the rest is missed by");
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&](std::size_t i) { return std::pair(map.position[i].x, map.position[i].y); };
  std::ranges::sort(order, {}, key);
  for (std::size_t i = 1; i < n; ++i)
    if (key(order[i]) == key(order[i - 1]))
      throw fail("rows " + std::to_string(std::min(order[i], order[i - 1]) + 1) + " and " +
                 std::to_string(std::max(order[i], order[i - 1]) + 1) + " are of one position; leave one");
  if (map.radial && key(order.front()).first < 0.0)
    throw fail("a distance from the axis is negative; give x and y, or distances from 0 on");
  if (map.radial && key(order.front()).first > kBeyond * key(order.back()).first)
    throw fail("begins at r = " + format_double(key(order.front()).first) + "; add a row for the optical axis, r = 0");
}

bool FieldMap::covers(const FieldPoint<double>& place) const {
  if (is_image()) {
    const auto within = [](double x, int n) { return x >= -kBeyond * n && x <= (1.0 + kBeyond) * n; };
    return within(place.x, columns) && within(place.y, rows);
  }
  const FieldPoint<double> u = scaled_place(*this, place);
  // The scaled positions are 2 wide.
  if (radial) return u.x >= hull[0].x - 2.0 * kBeyond && u.x <= hull[1].x + 2.0 * kBeyond;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const FieldPoint<double>&a = hull[i], &b = hull[(i + 1) % hull.size()];
    if (!(cross(a, b, u) >= -2.0 * kBeyond * std::hypot(b.x - a.x, b.y - a.y))) return false;
  }
  return true;
}

std::string FieldMap::outside_text(const FieldPoint<double>& place) const {
  if (is_image())
    return source + " covers the detector with " + size_text(columns, rows) + " samples, and (" +
           significant(place.x, 4) + ", " + significant(place.y, 4) +
           ") samples from its corner is beyond it; ask for places on the detector, on which the optical axis must lie";
  const auto shown = [&](double value) {
    const double given = unit == FieldUnit::slope ? std::atan(value) * 180.0 / std::numbers::pi : value;
    return significant(given, 4);
  };
  const std::string_view of = unit == FieldUnit::millimetre ? " mm"
                              : unit == FieldUnit::slope    ? " deg"
                              : unit == FieldUnit::pixel    ? " px"
                                                            : " half diagonals of the detector";
  const auto range = [&](auto coordinate) {
    const auto [lo, hi] = std::ranges::minmax(position, {}, coordinate);
    return shown(std::invoke(coordinate, lo)) + " to " + shown(std::invoke(coordinate, hi));
  };
  const std::string text =
      radial ? "r = " + range(&FieldPoint<double>::x) + std::string(of) + ", and the image has r = " + shown(place.x)
             : "the area that its positions span, x = " + range(&FieldPoint<double>::x) +
                   " and y = " + range(&FieldPoint<double>::y) + std::string(of) + ", and the image has (" +
                   shown(place.x) + ", " + shown(place.y) + ")";
  return source + " covers " + text + "; add positions out to there";
}

void FieldMap::require_shape_of(int detector_columns, int detector_rows) const {
  if (static_cast<std::int64_t>(columns) * detector_rows == static_cast<std::int64_t>(rows) * detector_columns) return;
  throw UsageError(source + " has " + size_text(columns, rows) + " samples, which is not the shape of frame.format, " +
                   size_text(detector_columns, detector_rows) + "; give a value for each pixel, or for blocks of them");
}

std::shared_ptr<const FieldMap> make_field_image(FieldMap map) {
  map.unit = FieldUnit::pixel;
  const auto width = static_cast<std::size_t>(map.columns), height = static_cast<std::size_t>(map.rows);
  for (FieldMap::Column& column : map.column) {
    double squares = 0.0, most = 0.0;
    std::size_t count = 0;
    const auto leave_out = [&](std::size_t step, std::size_t i, std::size_t n, std::size_t at) {
      if (i < 3 || i + 3 >= n) return;  // the cubic through the four at odd distances
      const auto v = [&](std::size_t k) { return column.value[at + k * step - 3 * step]; };
      const double by = std::abs(v(3) - (9.0 * (v(2) + v(4)) - v(0) - v(6)) / 16.0);
      squares += by * by, most = std::max(most, by), ++count;
    };
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x)
        leave_out(1, x, width, y * width + x), leave_out(width, y, height, y * width + x);
    if (count > 0) column.missed = {std::sqrt(squares / static_cast<double>(count)), most};
  }
  return std::make_shared<const FieldMap>(std::move(map));
}

std::vector<std::array<std::int64_t, 2>> hardest_pixels(const FieldMap& image, std::size_t column, std::size_t n,
                                                        const FieldPoint<double>& low, const FieldPoint<double>& high,
                                                        const std::array<std::int64_t, 2>& pixels) {
  constexpr std::int64_t kParts = 3;  // along an axis
  constexpr double kCounts = 0.1;
  const Barycentric points = Barycentric::with_ends(n);
  const auto at = [](double lo, double hi, double t) { return 0.5 * ((1.0 - t) * lo + (1.0 + t) * hi); };
  const auto m = static_cast<Index>(n);
  MatrixXd value(m, m);
  for (Index j = 0; j < m; ++j)
    for (Index i = 0; i < m; ++i) {
      const FieldPoint<double> u{at(low.x, high.x, points.x[static_cast<std::size_t>(i)]),
                                 at(low.y, high.y, points.x[static_cast<std::size_t>(j)])};
      value(j, i) = image.of_image(column, u, u.x, u.y);
    }
  // The pixels next to the samples along an axis, their places in samples, and the weights of the points.
  struct Axis {
    std::vector<std::int64_t> pixel;
    std::vector<double> place;
    MatrixXd weight;
  };
  const auto axis = [&](double lo, double hi, int samples, std::int64_t count) {
    Axis all;
    const auto last = static_cast<double>(count - 1);
    for (int k = 0; k < samples; ++k) {
      const double pixel = std::round((k + 0.5 - lo) / (hi - lo) * last);
      if (!(pixel >= 0.0 && pixel <= last)) continue;
      const auto one = static_cast<std::int64_t>(pixel);
      if (all.pixel.empty() || one != all.pixel.back())
        all.pixel.push_back(one), all.place.push_back(lo + pixel / last * (hi - lo));
    }
    all.weight.resize(m, std::ssize(all.pixel));
    for (Index k = 0; k < all.weight.cols(); ++k)
      points.weights_at(2.0 * static_cast<double>(all.pixel[static_cast<std::size_t>(k)]) / last - 1.0,
                        all.weight.col(k).data());
    return all;
  };
  const Axis x = axis(low.x, high.x, image.columns, pixels[0]), y = axis(low.y, high.y, image.rows, pixels[1]);
  const MatrixXd along = value * x.weight;
  struct Missed {
    double by = -1.0;
    std::array<std::int64_t, 2> pixel{};
  };
  std::array<Missed, kParts * kParts> part;
  for (std::size_t j = 0; j < y.pixel.size(); ++j) {
    const Eigen::RowVectorXd row = y.weight.col(static_cast<Index>(j)).transpose() * along;
    for (std::size_t i = 0; i < x.pixel.size(); ++i) {
      const FieldPoint<double> u{x.place[i], y.place[j]};
      const double by = std::abs(row[static_cast<Index>(i)] - image.of_image(column, u, u.x, u.y));
      const std::int64_t of = y.pixel[j] * kParts / pixels[1] * kParts + x.pixel[i] * kParts / pixels[0];
      if (Missed& most = part[static_cast<std::size_t>(of)]; by > most.by) most = {by, {x.pixel[i], y.pixel[j]}};
    }
  }
  const double least = kCounts * std::ranges::max(part, {}, &Missed::by).by;
  std::vector<std::array<std::int64_t, 2>> all;
  for (const Missed& one : part)
    if (one.by >= std::max(0.0, least)) all.push_back(one.pixel);
  return all;
}

std::shared_ptr<const FieldMap> make_field_map(FieldMap map) {
  require_positions(map);
  const auto [left, right] = std::ranges::minmax(map.position, {}, &FieldPoint<double>::x);
  const auto [top, bottom] = std::ranges::minmax(map.position, {}, &FieldPoint<double>::y);
  map.middle = {0.5 * (left.x + right.x), 0.5 * (top.y + bottom.y)};
  map.scale = 0.5 * std::max(right.x - left.x, bottom.y - top.y);
  std::vector<FieldPoint<double>> places;
  for (const FieldPoint<double>& p : map.position) places.push_back(scaled_place(map, p));
  map.degree = degree_of(map);
  if (map.degree == 0)
    throw UsageError(map.source +
                     ": all positions lie on one line; give their distances from the axis, r, in place of x "
                     "and y, where the lens is the same all around");
  map.hull = map.radial ? std::vector<FieldPoint<double>>{{-1.0, 0.0}, {1.0, 0.0}} : hull_of(places);

  const auto n = static_cast<Index>(places.size()), m = static_cast<Index>(term_count(map));
  MatrixXd matrix = MatrixXd::Zero(n + m, n + m);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const FieldPoint<double>&a = places[static_cast<std::size_t>(i)], &b = places[static_cast<std::size_t>(j)];
      matrix(i, j) = map.kernel((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
    }
  matrix.topRightCorner(n, m) = polynomial_matrix(map);
  matrix.bottomLeftCorner(m, n) = matrix.topRightCorner(n, m).transpose();
  const Eigen::PartialPivLU<MatrixXd> lu(matrix);

  // Without position i the value there is missed by weight[i] over the i-th diagonal element of the inverse.
  std::vector<std::pair<Index, double>> left_out;
  const Index step = (n - 1) / static_cast<Index>(kMostLeftOut) + 1;
  for (Index i = 0; i < n && n > m; i += step) {
    if (map.radial && std::abs(places[static_cast<std::size_t>(i)].x) > 1.0 - kRankFrom) continue;
    const double diagonal = lu.solve(VectorXd::Unit(n + m, i))(i);
    if (std::abs(diagonal) > kRankFrom) left_out.emplace_back(i, diagonal);  // else the others determine nothing there
  }
  for (FieldMap::Column& column : map.column) {
    VectorXd values = VectorXd::Zero(n + m);
    values.head(n) = Eigen::Map<const VectorXd>(column.value.data(), n);
    const VectorXd solution = lu.solve(values);
    if (!((matrix * solution - values).norm() <= kReproduced * values.norm()))
      throw UsageError(map.source +
                       ": some positions are too close together, against the others, to interpolate between; "
                       "leave one of each two");
    column.weight.assign(solution.data(), solution.data() + n);
    std::copy_n(solution.data() + n, m, column.polynomial.begin());
    if (left_out.empty()) continue;
    std::array<double, 2>& missed = column.missed.emplace();
    for (const auto& [i, diagonal] : left_out) {
      const double by = std::abs(solution(i) / diagonal);
      missed[0] += by * by / static_cast<double>(left_out.size());
      missed[1] = std::max(missed[1], by);
    }
    missed[0] = std::sqrt(missed[0]);
  }
  return std::make_shared<const FieldMap>(std::move(map));
}

}  // namespace mtf
