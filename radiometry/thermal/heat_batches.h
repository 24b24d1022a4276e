// SPDX-License-Identifier: Apache-2.0
#pragma once

// The units of a scene as batches of the heat solver, one for each material, solved window by window.
//
// Units exchange radiation by way of patches, and what patches emit follows from the temperatures of all units. A few
// units of each patch are its sample: they are solved again and again until what they emit no longer changes. Then all
// units are solved, and what they emit in the mean beyond the sample is kept as a difference: with it the sample is
// solved again. What that changes is measured for every unit; those for which it is too much are solved again.
//
// That is done first with a coarse plan, of long steps that take no notice of the nodes of the surroundings, for as
// long as it pays: the exchange needs what patches emit, and of that only what all units emit beyond the sample, in
// which the errors of long steps cancel.
//
// The sample also carries what the promise of the solver needs (Runs::three), the other units are carried once, in the
// steps of the second of the three runs. Its error is 4/3 of the difference to the first; the promise is twice the
// difference.
//
// Where only a part of the scene is asked for (HeatScene::seen), "all units" are those and the sample: a patch that is
// not asked for emits what its sample does (LeftOut).

#include <optional>

#include "radiometry/heat/periodic.h"
#include "radiometry/thermal/unit_flux.h"

namespace radiometry::thermal {

/// Of one material.
struct MaterialRun {
  std::string name;
  std::size_t units = 0, sample = 0, nodes = 0;
  heat::Promise promised;
  heat::StepCount steps;
  double drift = 0.0;  ///< of the sample: heat missing from the balance over the heat that was exchanged: rounding
};

/// Nodes [first, last] of the surroundings: a day, or what is left of the run.
struct Window {
  std::size_t first = 0, last = 0;
};
std::vector<Window> windows_of(const Surroundings& surroundings);

/// What the iteration of a window came to.
struct Relaxed {
  int iterations = 0;    ///< solutions of all units, or of some again
  double error_k = 0.0;  ///< what further iterations would change, and parabolas between nodes leave out
};

/// Units of one material at the end of a window.
struct SavedBatch {
  double wanted_k = 0.0;
  MaterialRun run;
  heat::Grid fine, coarse;
  heat::GridRequest request;
  double step_tolerance_k = 0.0, depth_k = 0.0;
  heat::State all, sample, promise;
};

struct SavedBatches {
  Window window;
  std::vector<double> emitted, beyond_sample;
  std::vector<SavedBatch> batch;
};

/// Throws RuntimeError.
[[noreturn]] void damaged_checkpoint();

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
  /// solved last; 0 where it is not solved.
  double receiver_k(std::size_t node, std::size_t receiver) const {
    return receiver_k_[2 * (node - window_.first) * units_.exchange.receivers() + receiver];
  }

  /// Long-wave radiosity of the patches at a node of that window, W/m2.
  std::vector<double> patch_radiosity(std::size_t node) const;

  std::vector<MaterialRun> materials() const;

  /// What the next window is solved from, to go on in another process (run/solve_units.h).
  SavedBatches save() const;
  /// Throws RuntimeError for what other units saved, or after another window.
  void restore(const SavedBatches& saved, const Window& window);

 private:
  /// Units of a batch, with what the solver needs for them.
  struct Group {
    std::vector<std::uint32_t> unit;  ///< in Units::unit
    heat::Batch heat;
    heat::GroupForcing forcing;  ///< within the window
    std::optional<heat::Plan> plan;
    heat::State begin;  ///< at the begin of the window
    heat::State end;    ///< at its end, by the last run
    heat::LossSlopes slopes{};
  };
  static constexpr double kStartShare = 0.2;  ///< of the tolerance: how far the start may be from what repeats

  /// Plans of the batch, or coarse ones.
  enum class Pace { fine, coarse };
  struct Batch {
    std::size_t material = 0;
    Group all, sample, promise;  ///< the last two of the same units
    double wanted_k = 0.0;       ///< the tolerance that the plan is made for
    MaterialRun run;
  };

  /// What the exchange has to keep: see `solve`.
  struct Exchange {
    double tolerance_k, loss_w_m2_k, ratio_bound;
  };

  void set_window(const Window& window, bool first);
  void set_forcing(Group& group, const Batch& batch);
  /// The plan and the promise of the window, from the sample.
  void promise(Batch& batch, bool first);
  heat::Plan make_plan_of(const Batch& batch);
  /// Of the batches that have none: each is tried on few units, so that batches share the threads.
  void make_plans();
  /// One group over the window: from its begin, or one that repeats (`days` at most).
  heat::Run run(Batch& batch, Group& group, int days, heat::Runs runs, Pace pace, const heat::OutputSink& sink = {});
  /// Adds what the units emit in a run of theirs, times their area, to the sums of their patches.
  void add_emitted(const Group& group, const heat::Run& run, std::vector<double>& emitted) const;
  /// What patches emit by a run of the sample, and by the temperatures of all units; [moment * patches + patch].
  std::vector<double> run_sample(int days, Pace pace);
  std::vector<double> emitted_by_all() const;
  /// Iterates the sample until the long-wave light hardly changes: by a share of the tolerance, or with coarse plans by
  /// one of what the first iteration changed.
  void relax_sample(bool first, const Exchange& exchange, Pace pace);
  /// What the light of each unit has changed by, W/m2, since the round in which it was solved last.
  std::vector<double> changes_of_units(const std::vector<PatchTable>& of_round,
                                       const std::vector<std::uint8_t>& round_of) const;
  void run_all(int days, Pace pace);
  /// All units with the coarse plans, again and again, until the next time would change less than the tolerance, or
  /// nothing comes nearer.
  void guess_exchange(bool first, const Exchange& exchange);
  /// Runs units again: those of each batch at the given places of Batch::all. `steps`: of a day that repeats itself,
  /// what the begin of all units lacks; else empty.
  void run_again(const std::vector<std::vector<std::uint32_t>>& places, const std::vector<heat::State>& steps);
  /// Where the temperatures of some units are kept.
  heat::OutputSink keeper_of(const std::vector<std::uint32_t>& units);
  heat::Timeline timeline(std::size_t first, std::size_t last, Pace pace) const;
  PatchScene patch_scene() const { return {&units_, &means_, &scene_.surroundings, &ground_, threads_}; }

  const HeatScene& scene_;
  const Units& units_;
  const GroundLight& ground_;
  double tolerance_k_;
  int threads_;
  PatchMeans means_;
  PatchLight light_;
  std::vector<Batch> batches_;
  Window window_;
  std::vector<double> receiver_k_;  ///< [moment of the window * receivers + receiver]
  int samples_ = 0;                 ///< runs of the sample in this window
  /// Of each receiver: epsilon sigma, times its area over that of its patch, or of what is solved of the patch; 0 for
  /// what is not solved.
  std::vector<double> emission_;
  /// The same without what is not solved, patch after patch.
  struct Emitting {
    std::vector<std::uint32_t> first, receiver;
    std::vector<double> emission;
  };
  Emitting emitting_;
  std::vector<std::uint32_t> sampled_receivers_;
  std::vector<std::uint32_t> solved_receivers_;  ///< also those that are the other end of a wall
  std::vector<double> sampled_share_;  ///< of each patch: the part of its area that the units of the sample have
  std::vector<double> given_;          ///< what patches of given temperature emit, times area / area of the patch
  std::vector<double> emitted_;        ///< [moment * patches + patch], W/m2
  std::vector<double> beyond_sample_;  ///< of all units less that of the sample
};

}  // namespace radiometry::thermal
