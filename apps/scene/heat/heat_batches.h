// SPDX-License-Identifier: Apache-2.0
#pragma once

// The units of a scene as batches of the heat solver, one for each material, solved window by window.

#include <optional>

#include "apps/scene/heat/unit_flux.h"
#include "radiometry/heat/solver.h"

namespace apps::scene {

/// Of one material.
struct MaterialRun {
  std::string name;
  std::size_t units = 0, nodes = 0;
  radiometry::heat::Promise promised;
  radiometry::heat::StepCount steps;
  double start_residual_k = 0.0;
  double drift = 0.0;  ///< heat missing from the balance over the heat that was exchanged: rounding
};

/// Nodes [first, last] of the surroundings: a day, or what is left of the run.
struct Window {
  std::size_t first = 0, last = 0;
};
std::vector<Window> windows_of(const Surroundings& surroundings);

/// What the iteration of a window came to.
struct Relaxed {
  int iterations = 0;
  double error_k = 0.0;  ///< what further iterations would change, and lines between nodes leave out
};

class HeatBatches {
 public:
  /// All references have to live as long as this.
  HeatBatches(const HeatScene& scene, const Units& units, const GroundLight& ground, double tolerance_k, int threads);

  /// Solves a window, from the end of the one before or, the first one, from the state that repeats after it.
  /// `loss_w_m2_k`: what a surface gives off for each kelvin, at least. `ratio_bound`: by which an iteration makes a
  /// change of temperatures smaller, at least. Throws RuntimeError when the iteration does not converge to the
  /// tolerance.
  Relaxed solve(const Window& window, bool first, double tolerance_k, double loss_w_m2_k, double ratio_bound);

  /// The temperature of a receiver (Unit::receiver, and the next one for the back of a sheet) at a node of the window
  /// solved last.
  double receiver_k(std::size_t node, std::size_t receiver) const {
    return receiver_k_[(node - window_.first) * units_.exchange.receivers() + receiver];
  }

  /// Long-wave irradiance of a receiver by other surfaces at a node of that window.
  float longwave_w_m2(std::size_t node, std::size_t receiver) const { return longwave_.row(node)[receiver]; }

  std::vector<MaterialRun> materials() const;

 private:
  struct Batch {
    std::size_t first = 0, units = 0;  ///< in Units::unit
    std::size_t material = 0;
    radiometry::heat::Batch heat;
    radiometry::heat::Forcing forcing;
    std::optional<radiometry::heat::Plan> plan;
    double wanted_k = 0.0;          ///< the tolerance that the plan is made for
    radiometry::heat::State begin;  ///< at the begin of the window
    radiometry::heat::State end;    ///< at its end, by the last iteration, as the two below
    radiometry::heat::Promise promised;
    double drift = 0.0;
    MaterialRun run;
  };

  /// The state that repeats after the day, and the plan where there is none.
  void start(Batch& batch, const radiometry::heat::Timeline& day);
  /// The batch over the window, from batch.begin.
  void run(Batch& batch, const radiometry::heat::Timeline& timeline, bool first);
  void set_window(const Window& window, bool first);
  double& kelvin(std::size_t node, std::size_t receiver) {
    return receiver_k_[(node - window_.first) * units_.exchange.receivers() + receiver];
  }
  /// Long-wave exchange from the temperatures; the largest change of irradiance, W/m2.
  double update_exchange();
  /// What the straight lines between nodes are off by, W/m2: a quarter of the difference of a node from the line
  /// between its neighbours, the smaller one of the two ends of an interval, since a bend at a node is no error.
  double line_error() const;

  const HeatScene& scene_;
  const Units& units_;
  const GroundLight& ground_;
  double tolerance_k_;
  int threads_;
  ReceiverTable solar_, longwave_;
  std::vector<Batch> batches_;
  Window window_;
  std::vector<double> receiver_k_;  ///< [node of the window * receivers + receiver]
};

}  // namespace apps::scene
