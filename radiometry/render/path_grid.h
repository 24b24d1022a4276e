// SPDX-License-Identifier: Apache-2.0
#pragma once

// The air between a camera and what it sees, over the range and the height of the end point, for the height that the
// camera has: transmission tau and source s (band_nodes.h) at the wavenumbers of the air model.
//
// Between the nodes of the grid tau and s of every wavenumber are interpolated with the same weights, which sum to 1:
// so is every integral over the band, and tau B + (1 - tau) B = B holds between nodes as at them. The weights are those
// of a parabola through three nodes in the square root of the range (strong lines take exp(-(C W)^a) with a about 1/2:
// tau falls as the root of a short range), and of a straight line in the height. Cells are halved until integrals over
// the band, of tau and of s, are within the tolerance at the places between nodes where a parabola is worst.

#include <array>
#include <cmath>
#include <optional>

#include "radiometry/atmosphere/range_table.h"
#include "radiometry/render/band_nodes.h"

namespace radiometry::render {

/// Transmission and source at the samples of BandNodes.
struct AirSamples {
  std::vector<double> transmission{}, source{};
};

/// The air of a scene, seen from one height. The model takes the humidity of haze from the part of a layer below the
/// camera for lines that go down and from the part above for those that go up, so that its transmission has a step of
/// some 1e-4 between them (of the optical depth of the haze, a few per cent). Lines that end within `level_m` of the
/// camera's height are interpolated between those that end there; level_m is what the earth's curvature makes of a
/// level line.
class AirView {
 public:
  /// `altitude_m`: of height 0. Throws mtf::UsageError as require_valid does.
  AirView(atmosphere::Air<double> air, const BandNodes& nodes, double altitude_m, double camera_height_m,
          double farthest_m = 0.0);

  /// To a point of that height at that range. Beyond the horizon it is a horizontal line. Where heights are farther
  /// apart than the range there is no line, but the grid has such corners: a straight line of the height goes on there,
  /// from the level line through the one straight up or down.
  AirSamples to(double range_m, double height_m) const;
  /// The source of the line to space; nothing for air that is known at one level alone.
  std::optional<AirSamples> to_space(double zenith_rad) const;
  bool layered() const { return air_.profile.levels.size() > 1; }
  double camera_height_m() const { return camera_height_m_; }
  double level_m() const { return level_m_; }
  /// Whether there is a line of that range to that height.
  bool reaches(double range_m, double height_m) const {
    return !layered() || std::abs(height_m - camera_height_m_) <= range_m;
  }
  double reference_k() const { return reference_k_; }  ///< temperature of the air at the camera
  const atmosphere::Air<double>& air() const { return air_; }
  double sensor_altitude_m() const { return altitude_of(camera_height_m_); }

 private:
  AirSamples samples_of(const atmosphere::Sight<double>& sight) const;
  double altitude_of(double height_m) const;

  atmosphere::Air<double> air_;
  std::vector<double> sample_um_, blackbody_;  ///< of reference_k_ at the samples, W m^-2 sr^-1 per cm^-1
  AirSamples line_to(double range_m, double height_m) const;

  double altitude_m_, camera_height_m_, level_m_, reference_k_;
};

/// What a grid has to cover.
struct PathExtent {
  double nearest_m = 0.0, farthest_m = 0.0;  ///< ranges
  double lowest_m = 0.0, highest_m = 0.0;    ///< heights of end points
  bool covers(const PathExtent& other) const {
    return nearest_m <= other.nearest_m && farthest_m >= other.farthest_m && lowest_m <= other.lowest_m &&
           highest_m >= other.highest_m;
  }
};

struct PathGrid {
  PathExtent extent{};
  std::vector<double> root{};      ///< square roots of ranges, m^(1/2): ends of cells and their middles
  std::vector<double> height_m{};  ///< two or more
  std::vector<AirSamples> node{};  ///< [height * root.size() + root]
  double error = 0.0;  ///< largest seen between nodes, of integrals over the band, relative to a blackbody's

  std::size_t roots() const { return root.size(); }
  std::size_t cells() const { return (root.size() - 1) / 2; }
  std::size_t layers() const { return height_m.size() - 1; }

  /// A cell, whose six nodes are index(cell) + 0, 1, 2 and roots() more.
  struct Cell {
    std::uint16_t root = 0, layer = 0;
    bool operator==(const Cell&) const = default;
  };
  std::size_t index(Cell cell) const { return cell.layer * roots() + 2 * std::size_t{cell.root}; }
  Cell cell_at(double root_m, double height) const;
  /// Of its six nodes; a place outside of the cell takes its nearest point.
  std::array<float, 6> weights(Cell cell, double root_m, double height) const;
  /// The value there of what its six nodes have.
  double between(Cell cell, double root_m, double height, const std::array<double, 6>& of_nodes) const;
};

/// Without air: one cell that takes and adds nothing, whatever the range.
PathGrid no_air(const BandNodes& nodes);
/// `tolerance`: of integrals over the band, relative to those of a blackbody at the temperature of the air; `error` is
/// above it where 64 cells a layer or 16 layers did not do.
PathGrid path_grid(const AirView& view, const BandNodes& nodes, const PathExtent& extent, double tolerance);
/// The same nodes, seen from another height.
PathGrid seen_from(const AirView& view, const PathGrid& grid, int threads);

}  // namespace radiometry::render
