// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/path_grid.h"

#include <algorithm>
#include <map>

#include "mtf/error.h"
#include "mtf/parallel.h"

namespace radiometry::render {
namespace {

/// W m^-2 sr^-1 per cm^-1.
double planck_of_wavenumber(double wavelength_um, double temperature_k) {
  return planck(Flux::watts, wavelength_um, temperature_k) * wavelength_um * wavelength_um * 1e-4;
}

/// What integrals over the band make of the samples of the air.
struct BandWeights {
  std::vector<double> of_sample;
  double sum = 0.0;

  BandWeights(const BandNodes& nodes, double temperature_k)
      : of_sample(fold(nodes, blackbody_at(nodes, temperature_k))) {
    for (const double weight : of_sample) sum += weight;
  }
  /// The larger one of transmission and source; relative.
  double difference(const AirSamples& a, const AirSamples& b) const {
    double transmission = 0.0, source = 0.0;
    for (std::size_t i = 0; i < of_sample.size(); ++i) {
      transmission += of_sample[i] * (a.transmission[i] - b.transmission[i]);
      source += of_sample[i] * (a.source[i] - b.source[i]);
    }
    return std::max(std::abs(transmission), std::abs(source)) / sum;
  }
};

AirSamples mixed(std::initializer_list<std::pair<double, const AirSamples*>> parts) {
  AirSamples out{std::vector<double>(parts.begin()->second->transmission.size(), 0.0), {}};
  out.source = out.transmission;
  for (const auto& [weight, part] : parts)
    for (std::size_t i = 0; i < out.source.size(); ++i) {
      out.transmission[i] += weight * part->transmission[i];
      out.source[i] += weight * part->source[i];
    }
  return out;
}

/// Weights of a parabola through 0, 1/2 and 1.
std::array<double, 3> parabola(double t) {
  return {(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)};
}

/// Of the range, how far up or down a line goes at most.
constexpr double kUpright = 1.0 - 1e-6;

/// Where t (t - 1/2) (t - 1) has its extremes.
constexpr std::array kWorst{0.21132486540518713, 0.78867513459481287};

/// Lines that are computed once.
class KnownLines {
 public:
  explicit KnownLines(const AirView& view) : view_(view) {}
  const AirSamples& at(double root, double height_m) {
    const auto [found, fresh] = known_.try_emplace({root, height_m});
    if (fresh) found->second = view_.to(root * root, height_m);
    return found->second;
  }

 private:
  const AirView& view_;
  std::map<std::pair<double, double>, AirSamples> known_;
};

}  // namespace

AirView::AirView(atmosphere::Air<double> air, const BandNodes& nodes, double altitude_m, double camera_height_m,
                 double farthest_m)
    : air_(std::move(air)),
      sample_um_(nodes.sample_um),
      altitude_m_(altitude_m),
      camera_height_m_(camera_height_m),
      level_m_(0.1 + farthest_m * farthest_m / (2.0 * atmosphere::kEarthRadius_m)),
      reference_k_(0.0) {
  require_valid(air_);
  reference_k_ = level_at(air_.profile, altitude_of(camera_height_m)).temperature_k;
  for (const double um : sample_um_) blackbody_.push_back(planck_of_wavenumber(um, reference_k_));
}

double AirView::altitude_of(double height_m) const {
  if (!layered()) return 0.0;
  return std::max({altitude_m_ + height_m, air_.profile.levels.front().altitude_m, 0.0});
}

AirSamples AirView::samples_of(const atmosphere::Sight<double>& sight) const {
  const auto path = spectral_path(air_, sight, {.band = {sample_um_.front(), sample_um_.back()}});
  if (path.radiance.size() != sample_um_.size())
    throw mtf::RuntimeError("render: the air model has " + std::to_string(path.radiance.size()) +
                            " wavenumbers in the band, the picture " + std::to_string(sample_um_.size()));
  AirSamples out{{path.transmission.rbegin(), path.transmission.rend()},
                 {path.radiance.rbegin(), path.radiance.rend()}};
  for (std::size_t i = 0; i < out.source.size(); ++i) out.source[i] /= blackbody_[i];
  return out;
}

AirSamples AirView::to(double range_m, double height_m) const {
  const double above = height_m - camera_height_m_;
  if (range_m > 0.0 && !reaches(range_m, height_m)) {
    const double reach = std::copysign(kUpright * range_m, above);
    const AirSamples level = to(range_m, camera_height_m_), upright = to(range_m, camera_height_m_ + reach);
    return mixed({{1.0 - above / reach, &level}, {above / reach, &upright}});
  }
  if (!layered() || std::abs(above) >= level_m_) return line_to(range_m, height_m);
  const AirSamples low = line_to(range_m, camera_height_m_ - level_m_),
                   high = line_to(range_m, camera_height_m_ + level_m_);
  const double share = 0.5 * (1.0 + above / level_m_);
  return mixed({{1.0 - share, &low}, {share, &high}});
}

AirSamples AirView::line_to(double range_m, double height_m) const {
  if (range_m <= 0.0) return {std::vector<double>(sample_um_.size(), 1.0), std::vector<double>(sample_um_.size(), 0.0)};
  if (!layered()) return samples_of(atmosphere::Horizontal<double>{.altitude_m = 0.0, .range_m = range_m});
  const double from = altitude_of(camera_height_m_), apart = kUpright * range_m;
  const double to = std::max(std::clamp(altitude_of(height_m), from - apart, from + apart), altitude_of(-1e9));
  if (range_m >= horizon_range_m(air_, from, to))
    return samples_of(atmosphere::Horizontal<double>{.altitude_m = 0.5 * (from + to), .range_m = range_m});
  return samples_of(
      atmosphere::Between<double>{.sensor_altitude_m = from, .object_altitude_m = to, .range_m = range_m});
}

std::optional<AirSamples> AirView::to_space(double zenith_rad) const {
  if (!layered()) return std::nullopt;
  return samples_of(
      atmosphere::ToSpace<double>{.sensor_altitude_m = altitude_of(camera_height_m_), .zenith_rad = zenith_rad});
}

PathGrid::Cell PathGrid::cell_at(double root_m, double height) const {
  Cell cell;
  while (cell.root + 1U < cells() && root_m > root[2 * (cell.root + 1U)]) ++cell.root;
  while (cell.layer + 1U < layers() && height > height_m[cell.layer + 1U]) ++cell.layer;
  return cell;
}

std::array<float, 6> PathGrid::weights(Cell cell, double root_m, double height) const {
  const std::size_t r = 2 * std::size_t{cell.root};
  const double t = std::clamp((root_m - root[r]) / (root[r + 2] - root[r]), 0.0, 1.0);
  const double u =
      std::clamp((height - height_m[cell.layer]) / (height_m[cell.layer + 1U] - height_m[cell.layer]), 0.0, 1.0);
  const auto [a, b, c] = parabola(t);
  return {static_cast<float>(a * (1.0 - u)), static_cast<float>(b * (1.0 - u)), static_cast<float>(c * (1.0 - u)),
          static_cast<float>(a * u),         static_cast<float>(b * u),         static_cast<float>(c * u)};
}

double PathGrid::between(Cell cell, double root_m, double height, const std::array<double, 6>& of_nodes) const {
  const std::array<float, 6> weight = weights(cell, root_m, height);
  double sum = 0.0;
  for (std::size_t k = 0; k < weight.size(); ++k) sum += static_cast<double>(weight[k]) * of_nodes[k];
  return sum;
}

PathGrid no_air(const BandNodes& nodes) {
  constexpr double kAnywhere_m = 1e12;
  PathGrid grid{.extent = {0.0, kAnywhere_m, -kAnywhere_m, kAnywhere_m},
                .root = {0.0, 5e5, 1e6},
                .height_m = {-kAnywhere_m, kAnywhere_m}};
  grid.node.assign(6, {std::vector<double>(nodes.samples(), 1.0), std::vector<double>(nodes.samples(), 0.0)});
  return grid;
}

PathGrid path_grid(const AirView& view, const BandNodes& nodes, const PathExtent& extent, double tolerance) {
  constexpr std::size_t kMostCells = 64, kMostLayers = 16;
  constexpr int kRoots = 6;
  constexpr double kLeastHeight_m = 1e-3;
  const BandWeights weights(nodes, view.reference_k());
  KnownLines lines(view);
  PathGrid grid{.extent = extent};
  const double near = std::sqrt(extent.nearest_m), far = std::max(std::sqrt(extent.farthest_m), near + kLeastHeight_m);
  const double low = extent.lowest_m, high = std::max(extent.highest_m, low + kLeastHeight_m);

  // Layers: straight lines of the height, at ranges from the nearest to the farthest.
  grid.height_m = {low};
  for (const double level : {view.camera_height_m() - view.level_m(), view.camera_height_m() + view.level_m()})
    if (view.layered() && level > low && level < high) grid.height_m.push_back(level);
  grid.height_m.push_back(high);
  const auto layer_error = [&](double from, double to) {
    double worst = 0.0;
    for (int i = 0; i <= kRoots; ++i) {
      const double root = std::lerp(near, far, static_cast<double>(i) / kRoots);
      if (view.reaches(root * root, 0.5 * (from + to)))
        worst = std::max(worst, weights.difference(mixed({{0.5, &lines.at(root, from)}, {0.5, &lines.at(root, to)}}),
                                                   lines.at(root, 0.5 * (from + to))));
    }
    return worst;
  };
  for (std::size_t i = 0; i + 1 < grid.height_m.size();) {
    const double off = layer_error(grid.height_m[i], grid.height_m[i + 1]);
    if (off > tolerance && grid.layers() < kMostLayers) {
      grid.height_m.insert(grid.height_m.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                           0.5 * (grid.height_m[i] + grid.height_m[i + 1]));
      continue;
    }
    grid.error = std::max(grid.error, off);
    ++i;
  }

  // Cells: parabolas of the root of the range, at every height.
  std::vector<double> ends{near, far};
  const auto cell_error = [&](double from, double to) {
    double worst = 0.0;
    for (const double height : grid.height_m)
      for (const double t : kWorst) {
        if (!view.reaches(std::pow(std::lerp(from, to, t), 2), height)) continue;
        const auto [a, b, c] = parabola(t);
        worst = std::max(worst, weights.difference(mixed({{a, &lines.at(from, height)},
                                                          {b, &lines.at(0.5 * (from + to), height)},
                                                          {c, &lines.at(to, height)}}),
                                                   lines.at(std::lerp(from, to, t), height)));
      }
    return worst;
  };
  for (std::size_t i = 0; i + 1 < ends.size();) {
    const double off = cell_error(ends[i], ends[i + 1]);
    if (off > tolerance && ends.size() <= kMostCells) {
      ends.insert(ends.begin() + static_cast<std::ptrdiff_t>(i) + 1, 0.5 * (ends[i] + ends[i + 1]));
      continue;
    }
    grid.error = std::max(grid.error, off);
    ++i;
  }
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    grid.root.push_back(ends[i]);
    grid.root.push_back(0.5 * (ends[i] + ends[i + 1]));
  }
  grid.root.push_back(ends.back());
  for (const double height : grid.height_m)
    for (const double root : grid.root) grid.node.push_back(lines.at(root, height));
  return grid;
}

PathGrid seen_from(const AirView& view, const PathGrid& grid, int threads) {
  PathGrid out = grid;
  mtf::parallel_for_each(static_cast<std::int64_t>(grid.node.size()), 1, threads, [&](std::size_t i) {
    out.node[i] = view.to(std::pow(grid.root[i % grid.roots()], 2), grid.height_m[i / grid.roots()]);
  });
  return out;
}

}  // namespace radiometry::render
