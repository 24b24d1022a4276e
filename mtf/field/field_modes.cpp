// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/field_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/error.h"
#include "mtf/field/field_tables.h"
#include "mtf/math/special.h"
#include "mtf/words.h"

namespace mtf {
namespace {

using namespace field;

// Points along an axis of the image.
constexpr std::array<std::size_t, 5> kPoints{3, 5, 9, 17, 25};
constexpr std::size_t kProbes = 12;     // places between the points
constexpr double kBetweenSafety = 4.0;  // few places are looked at, and errors of many pixels may add up
constexpr double kModulusSafety = 1.2;  // largest modulus between the frequencies that are looked at
constexpr double kLeastPiece = 0.02;    // of the end of a table
constexpr double kNoise = 3e-8;         // of singular values by the squares of the matrix

using Matrix = Eigen::MatrixXd;

/// Weights of the mean over -1 .. 1 of values at Chebyshev points (Clenshaw and Curtis).
std::vector<double> mean_weights(std::size_t n) {
  const std::size_t last = n - 1;
  std::vector<double> weight(n);
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 1.0;
    for (std::size_t k = 1; k <= last / 2; ++k) {
      const double b = 2 * k == last ? 1.0 : 2.0, order = static_cast<double>(k);
      sum -= b / (4.0 * order * order - 1.0) *
             std::cos(2.0 * kPi * order * static_cast<double>(i) / static_cast<double>(last));
    }
    weight[i] = (i == 0 || i == last ? 0.5 : 1.0) * sum / static_cast<double>(last);
  }
  return weight;
}

/// Chebyshev coefficients of values at those points, every `stride`-th of `value`, in place.
void to_series(double* value, std::size_t n, std::size_t stride) {
  const std::size_t last = n - 1;
  std::vector<double> series(n, 0.0);
  for (std::size_t m = 0; m < n; ++m) {
    for (std::size_t i = 0; i < n; ++i)
      series[m] += (i == 0 || i == last ? 0.5 : 1.0) * value[i * stride] *
                   std::cos(kPi * static_cast<double>(m * (last - i)) / static_cast<double>(last));
    series[m] *= (m == 0 || m == last ? 1.0 : 2.0) / static_cast<double>(last);
  }
  for (std::size_t m = 0; m < n; ++m) value[m * stride] = series[m];
}

/// T_0 .. T_(n-1) at t.
std::vector<double> chebyshev(std::size_t n, double t) {
  std::vector<double> value(n, 1.0);
  if (n > 1) value[1] = t;
  for (std::size_t m = 2; m < n; ++m) value[m] = 2.0 * t * value[m - 1] - value[m - 2];
  return value;
}

double evaluated(const std::vector<double>& series, std::size_t n, double tx, double ty) {
  const std::vector<double> x = chebyshev(n, tx), y = chebyshev(n, ty);
  double sum = 0.0;
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) sum += series[j * n + i] * y[j] * x[i];
  return sum;
}

/// Power of a scene in the cells about a corner of its spectrum; the same everywhere where it is not known.
double power_about(const SceneSpectrum* spectrum, int column, int row) {
  constexpr int kCells = SceneSpectrum::kCells;
  if (spectrum == nullptr) return 1.0;
  double sum = 1e-9;  // no frequency is quite without
  for (int v = std::max(0, row - 1); v < std::min(2 * kCells, row + 1); ++v)
    for (int u = std::max(0, column - 1); u < std::min(kCells, column + 1); ++u)
      sum += spectrum->power()[static_cast<std::size_t>(v * kCells + u)];
  return sum;
}

/// |C| at the frequencies; components that cost much to evaluate count as 1.
std::vector<double> common_moduli(const System<double>& system, const Parts& parts, const SceneAperture& aperture,
                                  std::span<const Freq<double>> f, double fx_max, double fy_max) {
  System<double> common = system.at({});
  common.band_nodes = 8;
  Entries& list = common.list(Stage::presample);
  for (std::size_t i = list.size(); i-- > 0;) {
    const bool changes = std::find(parts.changing.begin(), parts.changing.end(), i) != parts.changing.end();
    if (changes || list[i].component.is_slow()) list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
  }
  constexpr std::array stages{Stage::presample};
  const FactoredOtf otf(common, stages, aperture, {.fx_max = fx_max, .fy_max = fy_max});
  std::vector<double> moduli;
  for (const Freq<double>& one : f) {
    const Complex<double> h = otf.at(one);
    moduli.push_back(std::hypot(h.re, h.im));
  }
  return moduli;
}

}  // namespace

System<double> with_field_radius(System<double> system, const SampleGrid& out) {
  if (!(system.field_radius_um() > 0.0))
    system.half_diagonal_um = 0.5 * std::hypot(static_cast<double>(out.width) * out.step_x_um,
                                               static_cast<double>(out.height) * out.step_y_um);
  return system;
}

FieldModes::FieldModes(const System<double>& given, const SampleGrid& in, const SampleGrid& out,
                       const FieldModesOptions& options)
    : in_x_(500.0 / in.step_x_um),
      in_y_(500.0 / in.step_y_um),
      ratio_x_(out.step_x_um / in.step_x_um),
      ratio_y_(out.step_y_um / in.step_y_um) {
  const System<double> system = with_field_radius(given, out);
  const Frame<double>& frame = system.frame;
  const double radius = system.field_radius_um();
  const auto axis = [radius](std::int64_t count, double step_um, double size_um, double axis_um) {
    return Line{(0.5 * step_um - 0.5 * size_um - axis_um) / radius, step_um / radius, count};
  };
  const bool known = frame.columns > 0 && frame.rows > 0;
  const double width = known ? frame.columns * frame.pitch_x_um : static_cast<double>(out.width) * out.step_x_um,
               height = known ? frame.rows * frame.pitch_y_um : static_cast<double>(out.height) * out.step_y_um;
  x_ = axis(out.width, out.step_x_um, width, system.field.axis_x_px * frame.pitch_x_um);
  y_ = axis(out.height, out.step_y_um, height, system.field.axis_y_px * frame.pitch_y_um);
  for (const std::size_t n : kPoints)
    if (make(system, options, n)) break;
}

/// True when more points of the image are not needed.
bool FieldModes::make(const System<double>& asked, const FieldModesOptions& options, std::size_t n) {
  const Parts parts = parts_of(asked);
  n_ = n;
  std::vector<FieldPoint<double>> places;
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) places.push_back({x_.at(point_at(i, n)), y_.at(point_at(j, n))});
  const std::size_t nodes = places.size();
  std::vector<std::array<double, 2>> probes;
  for (std::size_t i = 0; i < kProbes; ++i) {
    const auto k = static_cast<double>(i);
    probes.push_back({2.0 * std::fmod(0.5 + k * 0.7548776662466927, 1.0) - 1.0,
                      2.0 * std::fmod(0.5 + k * 0.5698402909980532, 1.0) - 1.0});
    places.push_back({x_.at(probes.back()[0]), y_.at(probes.back()[1])});
  }
  places.push_back({});  // the axis
  points_ = places.size();
  const double end = std::hypot(in_x_, in_y_) * (1.0 + 1e-9);
  System<double> system = asked;
  const BandNodes band = band_nodes_for(asked, parts, std::array{places.front(), places[nodes - 1], places.back()}, end,
                                        options.band_error);
  system.band_nodes = band.count;

  if (n == kPoints.front())
    for (const FieldPoint<double>& q : places) try {
        require_valid(asked.at(q));
      } catch (const UsageError& error) {
        throw UsageError(std::string(error.what()) + " at the field point (" + significant(q.x, 3) + ", " +
                         significant(q.y, 3) + ")");
      }
  // The same breaks for all.
  std::vector<ChangingPart> here;
  std::vector<double> breaks;
  auto factor = std::make_shared<GivenFactor>();
  double cutoff = 0.0;
  for (const FieldPoint<double>& q : places) {
    const ChangingPart& place = here.emplace_back(system, parts, q);
    cutoff = std::max(cutoff, place.cutoff());
    factor->real = factor->real && place.is_real();
    factor->even_x = factor->even_x && place.is_even_x();
    factor->even_y = factor->even_y && place.is_even_y();
    breaks.insert(breaks.end(), place.kinks().begin(), place.kinks().end());
  }
  factor->entries = parts.changing;
  factor->cutoff_cy_mm = cutoff;
  std::erase_if(breaks, [&](double r) { return !(r < std::min(end, cutoff)); });
  breaks.push_back(std::min(end, cutoff));
  std::sort(breaks.begin(), breaks.end());
  // Kinks that move over the field lie close together: one of them, and the table says what that costs.
  std::vector<double> apart{breaks.back()};
  for (std::size_t i = breaks.size() - 1; i-- > 0;)
    if (apart.back() - breaks[i] > kLeastPiece * apart.front()) apart.push_back(breaks[i]);
  breaks.assign(apart.rbegin(), apart.rend());
  constexpr double kQuick = 0.01;  // of the time of a slow component
  const double wavelengths = std::max(1, band.count) * (parts.slow ? 1.0 : kQuick);
  const auto most = static_cast<std::int64_t>(kMostInAll / (wavelengths * static_cast<double>(places.size())));
  const TableMaker maker{system, parts, breaks, std::min(end, cutoff), std::clamp<std::int64_t>(most, 500, kMostValues),
                         options};
  const TableMaker::Tables made_tables = maker.all(places, here);
  const std::vector<PolarTable>& tables = made_tables.at;

  // Deviations from the mean at the corners of the cells of a scene's spectrum, real parts before imaginary ones.
  constexpr int kCells = SceneSpectrum::kCells;
  std::vector<Freq<double>> f;
  for (int j = -kCells; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i)
      f.push_back({SceneSpectrum::corner_cy_mm(i, in_x_), SceneSpectrum::corner_cy_mm(j, in_y_)});
  const auto corners = static_cast<Eigen::Index>(f.size());
  // An OTF that is narrow against a cell is seen by frequencies within the first ones.
  for (const double a : {0.05, 0.3, 0.55, 0.8, 1.05, 1.3, 1.55, 1.8})
    for (double share = 0.7; share > 1e-3; share *= 0.6)
      f.push_back({share * cos_pi(a) * in_x_ / kCells, share * sin_pi(a) * in_y_ / kCells});
  const std::vector<double> common = common_moduli(system, parts, options.aperture, f, in_x_, in_y_);
  const auto columns = static_cast<Eigen::Index>(f.size()), count = static_cast<Eigen::Index>(nodes);
  Matrix d(static_cast<Eigen::Index>(places.size()), 2 * columns);
  for (Eigen::Index j = 0; j < d.rows(); ++j)
    for (Eigen::Index i = 0; i < columns; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Complex<double> h = tables[static_cast<std::size_t>(j)].at(f[k]);
      d(j, i) = common[k] * h.re, d(j, columns + i) = common[k] * h.im;
    }
  const std::vector<double> one = mean_weights(n);
  Eigen::VectorXd weight(count);
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) weight(static_cast<Eigen::Index>(j * n + i)) = one[i] * one[j];
  const Eigen::RowVectorXd mean = weight.transpose() * d.topRows(count);
  d.rowwise() -= mean;

  // Singular vectors, with the power of the scene where it is known; for these every other frequency will do. Modes of
  // less than a rounding of the largest are noise.
  std::vector<Eigen::Index> some;
  Eigen::VectorXd root_power(2 * columns);
  for (int j = 0; j <= 2 * kCells; j += 2)
    for (int i = 0; i <= kCells; i += 2) {
      const Eigen::Index at = j * SceneSpectrum::kColumns + i;
      root_power(at) = root_power(columns + at) = std::sqrt(power_about(options.spectrum, i, j));
      some.push_back(at), some.push_back(columns + at);
    }
  for (Eigen::Index at = corners; at < columns; ++at) {
    root_power(at) = root_power(columns + at) = std::sqrt(power_about(options.spectrum, 0, kCells));
    some.push_back(at), some.push_back(columns + at);
  }
  const Eigen::VectorXd root = weight.cwiseSqrt();
  Matrix scaled(count, static_cast<Eigen::Index>(some.size()));
  for (Eigen::Index i = 0; i < scaled.cols(); ++i) {
    const Eigen::Index at = some[static_cast<std::size_t>(i)];
    scaled.col(i) = root_power(at) * root.cwiseProduct(d.col(at).head(count));
  }
  Matrix gram = Matrix::Zero(count, count);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(gram);
  const auto& power = solver.eigenvalues();  // rising
  Eigen::Index modes = 1;
  while (modes < count && power(count - 1 - modes) > kNoise * kNoise * power(count - 1)) ++modes;
  const Matrix u = solver.eigenvectors().rightCols(modes).rowwise().reverse();  // the largest first
  Matrix p = (root.asDiagonal() * u).transpose() * d.topRows(count);            // modes at the frequencies
  Matrix a = root.cwiseInverse().asDiagonal() * u;                              // their weights at the points

  // The weights as series, their largest values over the image, and the modes scaled so that these are 1.
  series_.assign(static_cast<std::size_t>(modes), {});
  Eigen::VectorXd scale(modes);
  Matrix at_probes(static_cast<Eigen::Index>(kProbes), modes);
  constexpr int kGrid = 32;
  Matrix everywhere((kGrid + 1) * (kGrid + 1), modes);
  Matrix basis(static_cast<Eigen::Index>(n), kGrid + 1);
  for (int i = 0; i <= kGrid; ++i)
    basis.col(i) = Eigen::Map<const Eigen::VectorXd>(chebyshev(n, 2.0 * i / kGrid - 1.0).data(), basis.rows());
  for (Eigen::Index k = 0; k < modes; ++k) {
    std::vector<double>& series = series_[static_cast<std::size_t>(k)];
    series.resize(nodes);
    for (std::size_t j = 0; j < nodes; ++j) series[j] = a(static_cast<Eigen::Index>(j), k);
    for (std::size_t j = 0; j < n; ++j) to_series(series.data() + j * n, n, 1);
    for (std::size_t i = 0; i < n; ++i) to_series(series.data() + i, n, n);
    const Matrix over = basis.transpose() * Eigen::Map<const Matrix>(series.data(), basis.rows(), basis.rows()) * basis;
    everywhere.col(k) = Eigen::Map<const Eigen::VectorXd>(over.data(), over.size());
    const double largest =
        1.02 * std::max({everywhere.col(k).cwiseAbs().maxCoeff(), a.col(k).cwiseAbs().maxCoeff(), 1e-300});
    scale(k) = largest;
    for (double& c : series) c /= largest;
    everywhere.col(k) /= largest;
    a.col(k) /= largest;
    p.row(k) *= largest;
    for (std::size_t i = 0; i < kProbes; ++i)
      at_probes(static_cast<Eigen::Index>(i), k) = evaluated(series, n, probes[i][0], probes[i][1]);
  }

  // rms error over the image of an OTF error with these squared moduli, relative to the scene's std.
  const auto rms_of = [&](const Eigen::VectorXd& squares) {
    const double any = options.worst_unit * std::sqrt(squares.maxCoeff());
    if (options.spectrum == nullptr) return any;
    std::vector<double> moduli(static_cast<std::size_t>(corners));
    for (Eigen::Index i = 0; i < corners; ++i) moduli[static_cast<std::size_t>(i)] = std::sqrt(squares(i));
    const double within = std::sqrt(squares.tail(columns - corners).maxCoeff());
    for (const int j : {kCells - 1, kCells, kCells + 1})
      for (const int i : {0, 1}) {
        double& about = moduli[static_cast<std::size_t>(j * SceneSpectrum::kColumns + i)];
        about = std::max(about, within);
      }
    return std::min(any, options.spectrum_gain * options.spectrum->rms_error(moduli, ratio_x_, ratio_y_));
  };
  const auto squares_of = [&](const Eigen::RowVectorXd& row) -> Eigen::VectorXd {
    return (row.head(columns).array().square() + row.tail(columns).array().square()).matrix().transpose();
  };
  // Modes are left out from the least on, with three choices of c for weights of at most 1.
  Eigen::VectorXd singular(modes);
  for (Eigen::Index k = 0; k < modes; ++k)
    singular(k) = std::max(std::sqrt(squares_of(p.row(k)).sum()), k > 0 ? 1e-12 * singular(0) : 1e-30);
  std::array<Eigen::VectorXd, 3> places_sum, squares_sum;
  for (auto& sum : places_sum) sum = Eigen::VectorXd::Zero(everywhere.rows() + count);
  for (auto& sum : squares_sum) sum = Eigen::VectorXd::Zero(columns);
  error_.assign(static_cast<std::size_t>(modes) + 1, 0.0);
  const auto bound = [&](const std::array<Eigen::VectorXd, 3>& at, const std::array<Eigen::VectorXd, 3>& squares) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < 3; ++c) least = std::min(least, std::sqrt(at[c].maxCoeff()) * rms_of(squares[c]));
    return least;
  };
  const auto add = [&](auto& at, auto& squares, const Eigen::VectorXd& here2, const Eigen::VectorXd& there2, double s,
                       double largest) {
    const std::array<double, 3> c{1.0, s, largest};
    for (std::size_t i = 0; i < 3; ++i) at[i] += here2 / c[i], squares[i] += c[i] * there2;
  };
  for (Eigen::Index k = modes; k-- > 0;) {
    Eigen::VectorXd here2(everywhere.rows() + count);
    here2 << everywhere.col(k).cwiseAbs2(), a.col(k).cwiseAbs2();
    add(places_sum, squares_sum, here2, squares_of(p.row(k)), 1.0 / singular(k), 1.0 / (singular(k) * singular(k)));
    error_[static_cast<std::size_t>(k)] = bound(places_sum, squares_sum);
  }
  auto axis_places = places_sum, axis_squares = squares_sum;
  const Eigen::RowVectorXd of_axis = d.row(d.rows() - 1);
  const double norm = std::sqrt(squares_of(of_axis).sum()) + 1e-30;
  add(axis_places, axis_squares, Eigen::VectorXd::Ones(everywhere.rows() + count), squares_of(of_axis), 1.0 / norm,
      1.0 / (norm * norm));
  axis_error_ = bound(axis_places, axis_squares);
  between_ = 0.0;
  for (std::size_t i = 0; i < kProbes; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Eigen::RowVectorXd missed = d.row(count + row) - at_probes.row(row) * p;
    between_ = std::max(between_, kBetweenSafety * rms_of(squares_of(missed)));
  }
  // Tables and the average over the band, as errors of all OTFs alike.
  between_ += options.worst_unit * (std::pow(lebesgue(n), 2) * made_tables.error + band.error);
  const double next = 4.0 * made_tables.values * static_cast<double>(nodes) * wavelengths;  // about twice the points
  const bool done = between_ <= options.enough || n == kPoints.back() || next > kMostInAll;
  if (!done) return false;

  // The tables of the modes that may be asked for.
  std::vector<const PolarTable*> at_points;
  for (std::size_t j = 0; j < nodes; ++j) at_points.push_back(&tables[j]);
  const auto made = [&](const Eigen::VectorXd& sum, double largest) {
    auto mode = std::make_shared<GivenFactor>(*factor);
    mode->table = std::make_shared<const PolarTable>(
        PolarTable::combination(at_points, std::span(sum.data(), static_cast<std::size_t>(sum.size()))));
    mode->largest = largest;
    return mode;
  };
  const auto largest_of = [&](const PolarTable& table) {
    double largest = 0.0;
    for (const Freq<double>& one_f : f) {
      const Complex<double> h = table.at(one_f);
      largest = std::max(largest, std::hypot(h.re, h.im));
    }
    return kModulusSafety * largest + 1e-300;
  };
  auto mean_mode = made(weight, 1.0);
  mean_mode->largest = std::max(1.0, largest_of(*mean_mode->table) / kModulusSafety);  // above 1 where it amplifies
  factors_ = {mean_mode};
  std::size_t needed = 0;
  while (needed < series_.size() && error_[needed] > options.enough) ++needed;
  for (std::size_t k = 0; k < needed; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    // p_k = sum over j of u_kj sqrt(w_j) (E_j - mean), times its scale.
    Eigen::VectorXd sum = scale(column) * (u.col(column).array() * root.array()).matrix();
    sum -= weight * sum.sum();
    auto mode = made(sum, 1.0);
    mode->largest = largest_of(*mode->table);
    factors_.push_back(std::move(mode));
  }
  return true;
}

void FieldModes::weights(std::size_t mode, std::int64_t row, std::span<float> weight) const {
  if (mode == 0) return std::fill(weight.begin(), weight.end(), 1.0F);
  const std::vector<double>& series = series_.at(mode - 1);
  const auto t = [](std::int64_t i, std::int64_t count) {
    return count > 1 ? 2.0 * static_cast<double>(i) / static_cast<double>(count - 1) - 1.0 : 0.0;
  };
  const std::vector<double> y = chebyshev(n_, t(row, y_.count));
  std::vector<double> along(n_, 0.0);
  for (std::size_t j = 0; j < n_; ++j)
    for (std::size_t i = 0; i < n_; ++i) along[i] += series[j * n_ + i] * y[j];
  for (std::size_t x = 0; x < weight.size(); ++x) {
    const double at = t(static_cast<std::int64_t>(x), x_.count);
    double next = 0.0, after = 0.0;  // Clenshaw's recurrence
    for (std::size_t i = n_ - 1; i > 0; --i) {
      const double value = along[i] + 2.0 * at * next - after;
      after = next;
      next = value;
    }
    weight[x] = static_cast<float>(along[0] + at * next - after);
  }
}

}  // namespace mtf
