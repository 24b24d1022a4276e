// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/field_modes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/engines/kernels.h"
#include "mtf/error.h"
#include "mtf/field/chebyshev.h"
#include "mtf/field/field_map.h"
#include "mtf/field/field_tables.h"
#include "mtf/field/radial_weights.h"
#include "mtf/math/special.h"
#include "mtf/otf/otf_series.h"
#include "mtf/parallel.h"
#include "mtf/words.h"

namespace mtf {
namespace {

// Points along an axis of the image, and along a line.
constexpr std::array<std::size_t, 5> kPoints{3, 5, 9, 17, 25};
constexpr std::size_t kLeastWithKinks = 9;
constexpr double kWithKinks = 4.0;  // times the error that is enough, which points of the image meet slowly
constexpr std::array<std::size_t, 6> kLinePoints{5, 9, 17, 33, 65, 129};
constexpr std::size_t kProbes = 12;     // places between the points
constexpr double kBetweenSafety = 4.0;  // few places are looked at, and errors of many pixels may add up
constexpr double kModulusSafety = 1.2;  // largest modulus between the frequencies that are looked at
constexpr double kNoise = 3e-8;         // of singular values by the squares of the matrix
constexpr double kNothing = 1e-3;       // of the error that is enough: a part of the mean that is left out

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Row = Eigen::RowVectorXd;
using Eigen::Index;

double evaluated(const std::vector<double>& series, std::size_t n, std::size_t rows, double tx, double ty) {
  const std::vector<double> x = chebyshev(n, tx), y = chebyshev(rows, ty);
  double sum = 0.0;
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < n; ++i) sum += series[j * n + i] * y[j] * x[i];
  return sum;
}

constexpr int kCells = SceneSpectrum::kCells;

}  // namespace

/// Frequencies at which OTFs are looked at. A quarter of the plane, as parts by parity tell of all: the corners of the
/// cells of a scene's spectrum, then some within the first cells, where OTFs are that are narrow against a cell.
struct FieldModes::Frequencies {
  std::vector<Freq<double>> f;
  Vector up, down;  ///< |C|^2 at (fx, fy) and at (fx, -fy)
  Index count() const { return static_cast<Index>(f.size()); }
  static Index corner(int i, int j) { return j * (kCells + 1) + i; }
  static constexpr Index kCorners = (kCells + 1) * (kCells + 1);
};

namespace {

using Frequencies = FieldModes::Frequencies;

Frequencies frequencies_of(const System<double>& system, const std::vector<std::size_t>& changing,
                           const SceneAperture& aperture, double fx_max, double fy_max) {
  Frequencies at;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i)
      at.f.push_back({SceneSpectrum::corner_cy_mm(i, fx_max), SceneSpectrum::corner_cy_mm(j, fy_max)});
  for (const double a : {0.03, 0.15, 0.27, 0.4, 0.48})
    for (double share = 0.7; share > 1e-3; share *= 0.6)
      at.f.push_back({share * cos_pi(a) * fx_max / kCells, share * sin_pi(a) * fy_max / kCells});
  // The components that are the same everywhere; those that cost much to evaluate count as 1.
  System<double> common = system.at({});
  common.band_nodes = 8;
  std::vector<Entry<double>>& list = common.list(Stage::presample);
  for (std::size_t i = list.size(); i-- > 0;) {
    const bool changes = std::find(changing.begin(), changing.end(), i) != changing.end();
    if (changes || list[i].component.is_slow()) list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
  }
  constexpr std::array stages{Stage::presample};
  const FactoredOtf otf(common, stages, aperture, {.fx_max = fx_max, .fy_max = fy_max});
  const auto square = [&](const Freq<double>& f) {
    const Complex<double> h = otf.at(f);
    return h.re * h.re + h.im * h.im;
  };
  at.up.resize(at.count());
  at.down.resize(at.count());
  for (Index i = 0; i < at.count(); ++i) {
    const Freq<double>& f = at.f[static_cast<std::size_t>(i)];
    at.up(i) = square(f);
    at.down(i) = square({f.x, -f.y});
  }
  return at;
}

/// A scene's power, times |C|^2, at each frequency and its mirror image: what a part of an OTF error counts there. The
/// same everywhere where the scene is not known.
Vector weights_of(const Frequencies& at, const SceneSpectrum* spectrum) {
  const auto power_about = [&](int column, int row) {  // in the cells about a corner
    if (spectrum == nullptr) return 1.0;
    double sum = 1e-9;  // no frequency is quite without
    for (int v = std::max(0, row - 1); v < std::min(2 * kCells, row + 1); ++v)
      for (int u = std::max(0, column - 1); u < std::min(kCells, column + 1); ++u)
        sum += spectrum->power()[static_cast<std::size_t>(v * kCells + u)];
    return sum;
  };
  Vector weight(at.count());
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const Index k = Frequencies::corner(i, j);
      weight(k) = power_about(i, kCells + j) * at.up(k) + power_about(i, kCells - j) * at.down(k);
    }
  for (Index k = Frequencies::kCorners; k < at.count(); ++k)
    weight(k) = power_about(0, kCells) * (at.up(k) + at.down(k));
  return weight;
}

/// |H|^2 of one part, first at all frequencies, then at their mirror images.
Vector squares_of(const Frequencies& at, const Row& part) {
  Vector squares(2 * at.count());
  squares << at.up.cwiseProduct(part.transpose().cwiseAbs2()), at.down.cwiseProduct(part.transpose().cwiseAbs2());
  return squares;
}

}  // namespace

/// rms error over the image, relative to the scene's std, of errors of one part of the OTF with such squares.
struct FieldModes::Rms {
  const FieldModesOptions& options;
  double part_gain = 1.0, ratio_x = 1.0, ratio_y = 1.0;

  double operator()(const Vector& squares) const {
    const Index count = squares.size() / 2;
    const double any = part_gain * options.worst_unit * std::sqrt(squares.maxCoeff());
    if (options.spectrum == nullptr) return any;
    std::vector<double> moduli(static_cast<std::size_t>(SceneSpectrum::kRows * SceneSpectrum::kColumns));
    const Index inner = count - Frequencies::kCorners;
    const double within =
        std::sqrt(std::max(squares.segment(Frequencies::kCorners, inner).maxCoeff(), squares.tail(inner).maxCoeff()));
    for (int j = -kCells; j <= kCells; ++j)
      for (int i = 0; i <= kCells; ++i) {
        const double there = std::sqrt(squares(Frequencies::corner(i, std::abs(j)) + (j < 0 ? count : 0)));
        const bool about_zero = std::abs(j) <= 1 && i <= 1;
        moduli[static_cast<std::size_t>((j + kCells) * SceneSpectrum::kColumns + i)] =
            about_zero ? std::max(there, within) : there;
      }
    return std::min(any, part_gain * options.spectrum_gain * options.spectrum->rms_error(moduli, ratio_x, ratio_y));
  }
};

namespace {

using Rms = FieldModes::Rms;

/// Of the components that are the same everywhere.
Parities common_parities(const System<double>& system, const std::vector<std::size_t>& changing) {
  Parities product;
  const std::vector<Entry<double>>& list = system.list(Stage::presample);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (std::find(changing.begin(), changing.end(), i) != changing.end()) continue;
    const Traits traits = list[i].component.traits(system.context());
    product = product * Parities(traits.real, traits.even_x, traits.even_y);
  }
  return product;
}

}  // namespace

/// A singular vector of the deviations of one part.
struct FieldModes::Mode {
  OtfPart part;
  double power = 0.0;    ///< of the deviations
  Vector sum;            ///< weights of the OTFs at the points in the mode,
  Row p;                 ///< which is this at the frequencies
  Vector a;              ///< its weights at the points,
  Vector take;           ///< the projection on it is the sum of this times an OTF, at the frequencies of some_of,
  double of_mean = 0.0;  ///< less that of the mean
  std::vector<double> series;
  Vector everywhere;  ///< on a grid over the image,
  Vector at_probes;
};

namespace {

using Mode = FieldModes::Mode;

/// Of the frequencies some: modes are made, and projected on, by them.
std::vector<Index> some_of(Index count, int every) {
  std::vector<Index> some;
  for (int j = 0; j <= kCells; j += every)
    for (int i = 0; i <= kCells; i += every) some.push_back(Frequencies::corner(i, j));
  for (Index k = Frequencies::kCorners; k < count; ++k) some.push_back(k);
  return some;
}

/// The singular vectors of d, the deviations of a part at the points, with weights of the frequencies and the points.
std::vector<Mode> modes_of(OtfPart part, const Matrix& d, const Vector& weight, const Vector& frequency_weight,
                           const std::vector<Index>& some) {
  const Vector root = weight.cwiseSqrt();
  Matrix scaled(d.rows(), static_cast<Index>(some.size()));
  for (Index i = 0; i < scaled.cols(); ++i) {
    const Index at = some[static_cast<std::size_t>(i)];
    scaled.col(i) = std::sqrt(frequency_weight(at)) * root.cwiseProduct(d.col(at));
  }
  Matrix gram = Matrix::Zero(d.rows(), d.rows());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(gram);
  const auto& power = solver.eigenvalues();  // rising
  std::vector<Mode> modes;
  for (Index k = d.rows(); k-- > 0;) {
    if (!(power(k) > kNoise * kNoise * power(d.rows() - 1))) break;
    const Vector u = solver.eigenvectors().col(k);
    Mode& mode = modes.emplace_back();
    mode.part = part;
    mode.power = power(k);
    mode.sum = root.cwiseProduct(u);
    mode.p = mode.sum.transpose() * d;
    mode.a = u.cwiseQuotient(root);
    mode.take = (frequency_weight.cwiseProduct(mode.p.transpose()) / power(k))(some);
  }
  return modes;
}

/// Scales a mode so that the largest of its weights over the image is 1; returns by how much.
double scale_to_one(Mode& mode) {
  const double largest = 1.02 * std::max(mode.everywhere.cwiseAbs().maxCoeff(), 1e-300);
  mode.everywhere /= largest;
  mode.sum *= largest;
  mode.p *= largest;
  return largest;
}

/// Along an axis: from values at the points to a series, and its polynomials at places all along.
struct AxisBasis {
  Matrix transform, everywhere;

  explicit AxisBasis(std::size_t n) : transform(Matrix::Ones(1, 1)), everywhere(Matrix::Ones(1, 1)) {
    if (n == 1) return;
    const int places = n > kPoints.back() ? 4 * static_cast<int>(n) : 32;
    transform = to_series(n);
    everywhere.resize(static_cast<Index>(n), places + 1);
    for (int i = 0; i <= places; ++i)
      everywhere.col(i) = Eigen::Map<const Vector>(chebyshev(n, 2.0 * i / places - 1.0).data(), everywhere.rows());
  }
};

void complete(Mode& mode, const AxisBasis& x, const AxisBasis& y, std::span<const std::array<double, 2>> probes) {
  const Index n = x.transform.rows(), rows = y.transform.rows();
  const Matrix series = x.transform * Eigen::Map<const Matrix>(mode.a.data(), n, rows) * y.transform.transpose();
  mode.series.assign(series.data(), series.data() + series.size());
  const Matrix over = x.everywhere.transpose() * series * y.everywhere;
  mode.everywhere.resize(over.size() + mode.a.size());
  mode.everywhere << Eigen::Map<const Vector>(over.data(), over.size()), mode.a;
  const double largest = scale_to_one(mode);
  for (double& c : mode.series) c /= largest;
  mode.at_probes.resize(static_cast<Index>(probes.size()));
  for (std::size_t i = 0; i < probes.size(); ++i)
    mode.at_probes(static_cast<Index>(i)) =
        evaluated(mode.series, static_cast<std::size_t>(n), static_cast<std::size_t>(rows), probes[i][0], probes[i][1]);
}

/// The bound of a sum of modes that are left out, with three choices of c for weights of at most 1.
class Bound {
 public:
  Bound(Index places, Index squares) {
    for (std::size_t i = 0; i < 3; ++i) at_[i] = Vector::Zero(places), squares_[i] = Vector::Zero(squares);
  }
  void add(const Vector& weights, const Vector& squares) {
    const double singular = std::max(std::sqrt(squares.sum()), 1e-30);
    const std::array<double, 3> c{1.0, 1.0 / singular, 1.0 / (singular * singular)};
    for (std::size_t i = 0; i < 3; ++i) at_[i] += weights.cwiseAbs2() / c[i], squares_[i] += c[i] * squares;
  }
  double rms(const Rms& rms) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) least = std::min(least, std::sqrt(at_[i].maxCoeff()) * rms(squares_[i]));
    return least;
  }

 private:
  std::array<Vector, 3> at_, squares_;
};

}  // namespace

System<double> with_field_radius(System<double> system, const SampleGrid& out) {
  if (!(system.field_radius_um() > 0.0))
    system.half_diagonal_um = 0.5 * std::hypot(static_cast<double>(out.width) * out.step_x_um,
                                               static_cast<double>(out.height) * out.step_y_um);
  return system;
}

std::array<double, 2> detector_um(const Frame<double>& frame, const SampleGrid& detector) {
  if (frame.columns > 0 && frame.rows > 0) return {frame.columns * frame.pitch_x_um, frame.rows * frame.pitch_y_um};
  return {static_cast<double>(detector.width) * detector.step_x_um,
          static_cast<double>(detector.height) * detector.step_y_um};
}

FieldModes::FieldModes(const System<double>& given, const SampleGrid& in, const SampleGrid& out,
                       const FieldModesOptions& options) {
  const System<double> system = with_field_radius(given, out);
  const Frame<double>& frame = system.frame;
  const double radius = system.field_radius_um();
  const auto axis = [radius](std::int64_t count, double step_um, double size_um, double axis_um) {
    return Line{(0.5 * step_um - 0.5 * size_um - axis_um) / radius, step_um / radius, count};
  };
  const auto [width, height] = detector_um(frame, out);
  x_ = axis(out.width, out.step_x_um, width, system.field.axis_x_px * frame.pitch_x_um);
  y_ = axis(out.height, out.step_y_um, height, system.field.axis_y_px * frame.pitch_y_um);
  for (std::size_t i = 0; i < kProbes; ++i) {
    const auto k = static_cast<double>(i);
    probes_.push_back({2.0 * std::fmod(0.5 + k * 0.7548776662466927, 1.0) - 1.0,
                       2.0 * std::fmod(0.5 + k * 0.5698402909980532, 1.0) - 1.0});
  }
  const std::vector<std::size_t> points =
      options.line ? std::vector(kLinePoints.begin(), kLinePoints.end()) : std::vector(kPoints.begin(), kPoints.end());
  const auto rows_of = [&](std::size_t n) { return options.line ? 1 : n; };
  std::vector<FieldPoint<double>> outline = places(points.back(), rows_of(points.back()));
  const std::vector<FieldPoint<double>> others = places(points[points.size() - 2], rows_of(points[points.size() - 2]));
  outline.insert(outline.end(), others.begin(), others.end());
  for (const FieldPoint<double>& q : outline) try {
      require_valid(system.at(q));
    } catch (const UsageError& error) {
      throw UsageError(std::string(error.what()) + " at the field point (" + significant(q.x, 3) + ", " +
                       significant(q.y, 3) + ")");
    }
  const double fx_max = 500.0 / in.step_x_um, fy_max = 500.0 / in.step_y_um;
  FieldTables tables(system, outline, options.reach * std::hypot(fx_max, fy_max) * (1.0 + 1e-9), options);
  const std::vector<std::size_t>& changing = tables.factor().entries;
  const Frequencies at = frequencies_of(tables.system(), changing, options.aperture, fx_max, fy_max);
  const bool one_part = common_parities(system, changing).is_one();
  const Rms rms{options, one_part ? options.part_gain : 1.0, out.step_x_um / in.step_x_um,
                out.step_y_um / in.step_y_um};
  // Where OTFs have kinks, what the weights miss there.
  if (tables.is_parted() && options.line) throw UsageError("modes along a line take OTFs without kinks");
  if (tables.is_parted()) grid_x_ = WeightAxis(out.width), grid_y_ = WeightAxis(out.height);
  for (const double kink : tables.kinks())
    for (std::size_t i = 0; i < kProbes; ++i) {
      const double a = 2.0 * std::fmod(static_cast<double>(i) * 0.6180339887498949, 1.0);
      const double tx = x_.place_of(kink * cos_pi(a)), ty = y_.place_of(kink * sin_pi(a));
      if (std::abs(tx) <= 1.0 && std::abs(ty) <= 1.0) probes_.push_back({tx, ty});
    }
  // Where images of numbers are far from smooth.
  for (const FieldNumber<double>& number : system.field.numbers) {
    if (!number.map || !number.map->is_image() || x_.count < 2 || y_.count < 2) continue;
    const auto corner = [&](double t) {  // in samples
      const double x = x_.at(t) * radius / frame.pitch_x_um + system.field.axis_x_px + 0.5 * frame.columns,
                   y = y_.at(t) * radius / frame.pitch_y_um + system.field.axis_y_px + 0.5 * frame.rows;
      return FieldPoint<double>{x * number.map->columns / frame.columns, y * number.map->rows / frame.rows};
    };
    for (const std::size_t n : points)
      for (const auto& [i, j] :
           hardest_pixels(*number.map, number.column, n, corner(-1.0), corner(1.0), {x_.count, y_.count})) {
        const std::array place{x_.place(static_cast<double>(i)), y_.place(static_cast<double>(j))};
        if (std::ranges::find(probes_, place) == probes_.end()) probes_.push_back(place);
      }
  }
  if (tables.is_parted())  // between the nodes of a grid there may be no pixels
    for (auto& [tx, ty] : probes_) tx = x_.place(std::round(x_.pixel(tx))), ty = y_.place(std::round(y_.pixel(ty)));
  for (const std::size_t n : points)
    if (n >= (tables.is_parted() ? kLeastWithKinks : 0) && make(tables, at, rms, n, n == points.back())) break;
}

std::vector<FieldPoint<double>> FieldModes::places(std::size_t n, std::size_t rows) const {
  std::vector<FieldPoint<double>> list;
  const std::vector<double> nodes = Barycentric::with_ends(n).x;
  for (const double ty : rows == 1 ? std::vector{0.0} : nodes)
    for (const double tx : nodes) list.push_back({x_.at(tx), y_.at(ty)});
  for (const auto& [tx, ty] : probes_) list.push_back({x_.at(tx), y_.at(ty)});
  list.push_back({});  // the axis
  return list;
}

std::vector<float> FieldModes::grid_row(std::span<const float> values, double y) const {
  const auto [first, weight] = grid_y_.at(y);
  std::vector<float> row(grid_x_.nodes());
  for (std::size_t j = 0; j < weight.size(); ++j)
    for (std::size_t i = 0; i < row.size(); ++i) row[i] += weight[j] * values[(first + j) * row.size() + i];
  return row;
}

/// Weights of the modes on the grid over the image, which the image will be given, and at the probes.
void FieldModes::project(std::vector<Mode>& modes, const FieldTables& tables, const Frequencies& at,
                         std::span<const std::ptrdiff_t> some, int threads) const {
  std::vector<Freq<double>> f;
  for (const Index i : some) f.push_back(at.f[static_cast<std::size_t>(i)]);
  std::vector<Projection> take;
  for (const Mode& mode : modes) take.push_back({mode.part, mode.take});
  std::vector<FieldPoint<double>> nodes;
  for (std::size_t j = 0; j < grid_y_.nodes(); ++j)
    for (std::size_t i = 0; i < grid_x_.nodes(); ++i)
      nodes.push_back({x_.at(x_.place(grid_x_.pixel(i))), y_.at(y_.place(grid_y_.pixel(j)))});
  const Matrix weights = radial_weights(tables, f, take, nodes, threads);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    Mode& mode = modes[k];
    mode.everywhere = weights.col(static_cast<Index>(k)).array() - mode.of_mean;
    scale_to_one(mode);
    const Eigen::VectorXf values = mode.everywhere.cast<float>();
    mode.at_probes.resize(std::ssize(probes_));
    for (std::size_t i = 0; i < probes_.size(); ++i)
      mode.at_probes(static_cast<Index>(i)) =
          grid_x_.at(x_.pixel(probes_[i][0]))
              .of(grid_row({values.data(), values.data() + values.size()}, y_.pixel(probes_[i][1])));
  }
}

/// True when more points of the image are not needed, or there are none.
bool FieldModes::make(FieldTables& tables, const Frequencies& at, const Rms& rms, std::size_t n, bool last) {
  const FieldModesOptions& options = rms.options;
  const std::size_t rows = options.line ? 1 : n;
  n_ = n;
  const std::vector<FieldPoint<double>> places = this->places(n, rows);
  points_ = places.size();
  tables.prepare(places);
  const auto count = static_cast<Index>(n * rows), all = static_cast<Index>(places.size());
  std::array<Matrix, 4> d;  // parts at the places
  for (Matrix& part : d) part.resize(all, at.count());
  parallel_for(all, 1, options.threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t j = begin; j < end; ++j) {
      const PolarTable table = tables.at(static_cast<std::size_t>(j));
      for (Index i = 0; i < at.count(); ++i) {
        const std::array<double, 4> parts = table.parts_at(at.f[static_cast<std::size_t>(i)]);
        for (std::size_t p = 0; p < d.size(); ++p) d[p](j, i) = parts[p];
      }
    }
  });

  // Deviations from the mean over the image.
  const std::vector<double> one = mean_weights(n), other = rows == 1 ? std::vector{1.0} : one;
  Vector weight(count);
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < n; ++i) weight(static_cast<Index>(j * n + i)) = one[i] * other[j];
  std::array<Row, 4> mean;
  for (std::size_t p = 0; p < d.size(); ++p) {
    mean[p] = weight.transpose() * d[p].topRows(count);
    d[p].rowwise() -= mean[p];
  }

  const Vector frequency_weight = weights_of(at, options.spectrum);
  const std::vector<Index> some = some_of(at.count(), tables.is_parted() ? 4 : 2);
  std::vector<Mode> modes;
  for (std::size_t p = 0; p < d.size(); ++p)
    if (tables.factor().all.has(kOtfParts[p])) {
      std::vector<Mode> more = modes_of(kOtfParts[p], d[p].topRows(count), weight, frequency_weight, some);
      for (Mode& mode : more) mode.of_mean = mean[p](some).dot(mode.take);
      std::move(more.begin(), more.end(), std::back_inserter(modes));
    }
  std::stable_sort(modes.begin(), modes.end(), [](const Mode& a, const Mode& b) { return a.power > b.power; });
  while (modes.size() > 1 && !(modes.back().power > kNoise * kNoise * modes.front().power)) modes.pop_back();
  if (tables.is_parted()) {
    project(modes, tables, at, some, options.threads);
  } else {
    const AxisBasis in_x(n), in_y(rows);
    for (Mode& mode : modes) complete(mode, in_x, in_y, probes_);
  }

  // What it costs to leave modes out, from the least on, or all of them and the mean as well.
  const Index grid = modes.empty() ? 1 : modes.front().everywhere.size();
  Bound bound(grid, 2 * at.count());
  error_.assign(modes.size() + 1, 0.0);
  for (std::size_t k = modes.size(); k-- > 0;) {
    bound.add(modes[k].everywhere, squares_of(at, modes[k].p));
    error_[k] = bound.rms(rms);
  }
  for (std::size_t p = 0; p < d.size(); ++p)
    if (tables.factor().all.has(kOtfParts[p])) bound.add(Vector::Ones(grid), squares_of(at, d[p].row(all - 1)));
  axis_error_ = bound.rms(rms);
  between_ = 0.0;
  for (Index row = 0; row < std::ssize(probes_); ++row) {
    double error = 0.0;
    for (std::size_t p = 0; p < d.size(); ++p) {
      Row missed = d[p].row(count + row);
      for (const Mode& mode : modes)
        if (mode.part == kOtfParts[p]) missed -= mode.at_probes(row) * mode.p;
      error += rms(squares_of(at, missed));
    }
    between_ = std::max(between_, kBetweenSafety * error);
  }
  band_ = options.worst_unit * tables.band_error();
  between_ += options.worst_unit * (tables.is_parted() ? 1.0 : lebesgue(n) * lebesgue(rows)) * tables.error() + band_;
  const bool done = between_ <= (tables.is_parted() ? kWithKinks : 1.0) * options.enough || last ||
                    tables.is_dear(options.line ? 2 * n : 4 * n * n);
  if (!done) return false;

  // The tables of the mean and of the modes that may be asked for.
  const auto made = [&](const Vector& sum, const Parities& parts, double largest) {
    auto factor = std::make_shared<GivenFactor>(tables.factor());
    factor->table = std::make_shared<const PolarTable>(
        tables.sum(std::span(sum.data(), static_cast<std::size_t>(sum.size()))).parts(parts));
    factor->parities = parts;
    factor->largest = largest + 1e-300;
    factors_.push_back(std::move(factor));
  };
  Parities of_mean;  // parts that are next to nothing, as those of a lens about the centre are, are left out
  double left_out = 0.0, largest_of_mean = mean[0].cwiseAbs().maxCoeff();
  for (std::size_t p = 1; p < mean.size(); ++p) {
    const double largest = mean[p].cwiseAbs().maxCoeff();
    const bool none = !tables.factor().all.has(kOtfParts[p]);
    if (none || options.worst_unit * largest <= kNothing * options.enough)
      left_out += options.worst_unit * largest;
    else
      of_mean = of_mean + Parities(kOtfParts[p]), largest_of_mean += kModulusSafety * largest;
  }
  between_ += left_out;
  made(weight, of_mean, std::max(1.0, largest_of_mean));  // above 1 where it amplifies
  for (std::size_t k = 0; k < modes.size() && error_[k] > options.enough; ++k) {
    // p_k = sum over j of sum_kj (E_j - mean).
    const Mode& mode = modes[k];
    made(mode.sum - mode.sum.sum() * weight, Parities(mode.part), kModulusSafety * mode.p.cwiseAbs().maxCoeff());
  }
  modes.erase(modes.begin() + static_cast<std::ptrdiff_t>(this->count()), modes.end());
  if (!has_kinks())
    for (const Mode& mode : modes) series_.push_back(mode.series);
  for (const double power : {0.0, 0.5, 1.0, 1.5, 2.0}) {
    Measure& measure = measures_.emplace_back();
    Vector squares = Vector::Zero(2 * at.count());
    for (const Mode& mode : modes) {
      const Vector own = squares_of(at, mode.p);
      const double c = std::pow(std::max(rms(own), 1e-30), -power);
      squares += c * own;
      measure.scale.push_back(1.0 / std::sqrt(c));
    }
    measure.rms = rms(squares);
  }
  if (has_kinks()) {
    for (const Mode& mode : modes) {
      const Eigen::VectorXf values = mode.everywhere.cast<float>();
      rows_.emplace_back(values.begin(), values.end());
    }
    for (std::int64_t x = 0; x < x_.count; ++x) columns_.push_back(grid_x_.at(static_cast<double>(x)));
    return true;
  }
  for (std::size_t k = 1; k < factors_.size(); ++k) {
    std::vector<float>& along = rows_.emplace_back(n * static_cast<std::size_t>(y_.count));
    for (std::int64_t y = 0; y < y_.count; ++y) {
      const std::vector<double> values = chebyshev(rows, place_y(static_cast<double>(y)));
      for (std::size_t i = 0; i < n; ++i) {
        double sum = 0.0;
        for (std::size_t j = 0; j < rows; ++j) sum += series(k)[j * n + i] * values[j];
        along[static_cast<std::size_t>(y) * n + i] = static_cast<float>(sum);
      }
    }
  }
  along_x_.resize(n * static_cast<std::size_t>(x_.count));
  for (std::int64_t x = 0; x < x_.count; ++x) {
    const std::vector<double> values = chebyshev(n, place_x(static_cast<double>(x)));
    for (std::size_t k = 0; k < n; ++k)
      along_x_[k * static_cast<std::size_t>(x_.count) + static_cast<std::size_t>(x)] = static_cast<float>(values[k]);
  }
  return true;
}

void FieldModes::add(std::size_t mode, std::int64_t y, std::int64_t x, std::span<const float> filtered,
                     float* image) const {
  if (has_kinks()) {
    const std::vector<float> row = grid_row(rows_.at(mode - 1), static_cast<double>(y));
    std::vector<float> weight(filtered.size());
    for (std::size_t i = 0; i < weight.size(); ++i) weight[i] = columns_[static_cast<std::size_t>(x) + i].of(row);
    const kernels::Scaled whole{1.0F, weight.data()};
    kernels::add_weighted(filtered.data(), static_cast<std::int64_t>(filtered.size()), {&whole, 1}, image + x);
    return;
  }
  constexpr float kRounding = 1e-9F;  // of a weight of 1: weights that are even or odd lack every other polynomial
  const float* const row = rows_.at(mode - 1).data() + static_cast<std::size_t>(y) * n_;
  std::array<kernels::Scaled, kPoints.back()> terms;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n_; ++i)
    if (std::abs(row[i]) > kRounding)
      terms[count++] = {row[i], along_x_.data() + i * static_cast<std::size_t>(x_.count) + static_cast<std::size_t>(x)};
  kernels::add_weighted(filtered.data(), static_cast<std::int64_t>(filtered.size()), std::span(terms).first(count),
                        image + x);
}

}  // namespace mtf
