// SPDX-License-Identifier: Apache-2.0
#pragma once

// A chart of edges over a detector whose OTF changes over the field: every patch has one edge, and a pixel sees the
// step response of the isoplanatic sensor of its place along the edge, System::at. The response is a sum over Gauss
// nodes of the double OTF along the normal, phase and all, at each pixel: no table, no derivative and nothing of calib
// is in it.

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "mtf/math/quadrature.h"
#include "tests/calib/fit_cases.h"
#include "tests/mtf/field_systems.h"

namespace field_chart {

using mtf::Stage;
using mtf::System;

inline constexpr int kPatch = 32;  // pixels a side
inline constexpr double kDark = 0.2, kBright = 0.8;

/// 1/2 + 1/pi integral of [Re H sin(2 pi f d) + Im H cos(2 pi f d)] / f df along a direction.
class Step {
 public:
  Step(const System<double>& sensor, double angle_rad) {
    constexpr int kNodes = 192;
    const double c = std::cos(angle_rad), s = std::sin(angle_rad);
    const double top =
        sensor.list(Stage::presample)[0].component.cutoff_cy_mm(sensor.context()) * sensor.frame.pitch_x_um * 1e-3;
    const mtf::GaussRule rule = mtf::mean_rule(0.0, top, kNodes);
    for (int i = 0; i < kNodes; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double f = rule.node[k], mm = 1e3 / sensor.frame.pitch_x_um;
      const mtf::Complex<double> h = sensor.otf({f * c * mm, f * s * mm});
      const double weight = rule.weight[k] * top / (std::numbers::pi * f);
      nodes_.push_back({2.0 * std::numbers::pi * f, weight * h.re, weight * h.im});
    }
  }
  double at(double d_px) const {
    double sum = 0.5;
    for (const Node& n : nodes_) sum += n.re * std::sin(n.turns * d_px) + n.im * std::cos(n.turns * d_px);
    return sum;
  }

 private:
  struct Node {
    double turns, re, im;
  };
  std::vector<Node> nodes_;
};

struct Patch {
  int column = 0, row = 0;
  double angle_deg = 0.0;
  double x() const { return kPatch * (column + 0.5); }
  double y() const { return kPatch * (row + 0.5); }
};

/// Edges near to the columns and near to the rows in turns, at as many angles.
inline std::vector<Patch> patches(int columns, int rows) {
  std::vector<Patch> all;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) all.push_back({i, j, (i + j) % 2 == 0 ? 5.0 + 0.1 * i : 95.0 + 0.1 * j});
  return all;
}

/// A lens of waves at |q| = 1, f/5.6 and a square pixel: astigmatism, coma, field curvature, a tilted detector.
struct Lens {
  double w040 = 0.2, w131 = 0.5, w222 = 0.6, curvature = 0.4, focus = -0.25, tilt_x = 0.1, tilt_y = -0.07;
};
inline System<double> sensor_of(const Lens& lens, int columns, int rows, double more_focus = 0.0) {
  System<double> s = fit_cases::camera(5.6);
  s.frame.columns = kPatch * columns, s.frame.rows = kPatch * rows;
  mtf::Wavefront<double> w;
  w.w020 = lens.focus, w.w040 = lens.w040, w.w131 = 0.0, w.w222 = 0.0;
  w.zernike = {0.0, 0.0, 0.0, 0.5 * more_focus};
  s.stages[0][0].component = w;
  mtf::test::let_vary(s, 0, "w020", "r2", lens.curvature);
  mtf::test::let_vary(s, 0, "w020", "x", lens.tilt_x);
  mtf::test::let_vary(s, 0, "w020", "y", lens.tilt_y);
  mtf::test::let_vary(s, 0, "w131", "r", lens.w131);
  mtf::test::let_vary(s, 0, "w222", "r2", lens.w222);
  mtf::test::turn_with_field(s, 0, "orientation");
  return s;
}
inline std::vector<double> values_of(const Lens& lens) {
  return {lens.focus, lens.curvature, lens.tilt_x, lens.tilt_y, lens.w040, lens.w131, lens.w222};
}
inline std::vector<calib::FitParameter> parameters_of_lens() {
  std::vector<calib::FitParameter> all;
  for (const char* name : {"w020.1", "w020.r2", "w020.x", "w020.y", "w040", "w131.r", "w222.r2"})
    all.push_back(fit_cases::parameter(std::string("presample[0].") + name, name));
  return all;
}

/// The image without noise.
inline mtf::Image image_of(const System<double>& sensor, const std::vector<Patch>& all) {
  mtf::Image image(sensor.frame.columns, sensor.frame.rows);
  std::fill_n(image.data(), image.size(), static_cast<float>(kDark));
  for (const Patch& patch : all) {
    const double angle = patch.angle_deg * std::numbers::pi / 180.0, c = std::cos(angle), s = std::sin(angle);
    constexpr double kEnd = 0.5 * kPatch;
    std::vector<Step> steps;  // at both ends of the edge and in the middle, between which a parabola is exact enough
    for (const double along : {-kEnd, 0.0, kEnd})
      steps.emplace_back(sensor.at(sensor.field_point(patch.x() - s * along, patch.y() + c * along)), angle);
    for (int y = kPatch * patch.row; y < kPatch * (patch.row + 1); ++y)
      for (int x = kPatch * patch.column; x < kPatch * (patch.column + 1); ++x) {
        const double dx = x + 0.5 - patch.x(), dy = y + 0.5 - patch.y();
        const double d = c * dx + s * dy, t = (c * dy - s * dx) / kEnd;
        const double e = 0.5 * t * (t - 1.0) * steps[0].at(d) + (1.0 - t * t) * steps[1].at(d) +
                         0.5 * t * (t + 1.0) * steps[2].at(d);
        image.at(x, y) = static_cast<float>(kDark + (kBright - kDark) * e);
      }
  }
  return image;
}

inline mtf::Image with_noise(const mtf::Image& image, double sd, std::uint64_t seed) {
  mtf::Image noisy(image.width(), image.height());
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal(0.0, sd);
  for (std::int64_t i = 0; i < noisy.size(); ++i) noisy.data()[i] = image.data()[i] + static_cast<float>(normal(bits));
  return noisy;
}

/// The edges of an image, as a measurement finds them: a little off. `image` has to stay where it is.
inline void add_edges(calib::FitData& data, const mtf::Image& image, const std::vector<Patch>& all, double sd,
                      std::size_t condition = 0) {
  for (const Patch& patch : all) {
    made::Scene scene{.width = kPatch, .height = kPatch, .angle_deg = patch.angle_deg};
    scene.x = patch.x(), scene.y = patch.y();
    scene.half_length_px = 0.5 * kPatch;
    scene.noise_sd = sd;
    calib::EdgeData edge =
        fit_cases::edge_of(image, scene, std::to_string(patch.column) + "," + std::to_string(patch.row));
    edge.roi = edge.start.roi = {kPatch * patch.column, kPatch * patch.row, kPatch, kPatch};
    edge.condition = condition;
    data.edges.push_back(edge);
  }
}

}  // namespace field_chart
