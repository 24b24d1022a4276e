// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/run/checkpoint.h"

#include "mtf/error.h"
#include "radiometry/heat/lanes.h"

namespace radiometry::thermal {
namespace {

/// A shortened chain has no depths (radiometry/heat/depth/short_chain.h); layers that generate heat need them.
bool is_whole(const heat::Grid& grid, const heat::Construction& construction) {
  const std::size_t nodes = grid.nodes();
  const bool chain = grid.depth_m.empty() && grid.layer_m.empty() && !construction.generates;
  return nodes > 0 && grid.conductance.size() + 1 == nodes &&
         (chain || (grid.depth_m.size() == nodes && grid.layer_m.size() == nodes * construction.layers.size()));
}

/// Whether a state is one of so many facets on the grids of its batch.
bool fits(const heat::State& state, const SavedBatch& batch, std::size_t facets) {
  const std::size_t fine = batch.fine.nodes() * facets, coarse = batch.coarse.nodes() * facets;
  const bool one = state.doubled.empty() && state.coarse.empty();
  return state.facets == facets && state.fine.size() == fine &&
         (one || (state.doubled.size() == fine && state.coarse.size() == coarse)) &&
         state.step_s.size() == (facets + heat::kLanes - 1) / heat::kLanes;
}

}  // namespace

void damaged_checkpoint() {
  throw mtf::RuntimeError("the state of an interrupted run is damaged; --anew begins again and replaces it");
}

SavedBatches HeatBatches::save() const {
  SavedBatches saved{window_, emitted_, beyond_sample_, {}};
  for (const Batch& batch : batches_) {
    const heat::Plan& plan = *batch.all.plan;
    saved.batch.push_back({batch.wanted_k, batch.run, plan.fine, plan.coarse, plan.request, plan.step_tolerance_k,
                           plan.depth_k, batch.all.begin, batch.sample.begin, batch.promise.begin});
  }
  return saved;
}

void HeatBatches::restore(const SavedBatches& saved, const Window& window) {
  const std::size_t moments = 2 * (window.last - window.first) + 1, size = moments * units_.exchange.patches();
  if (saved.batch.size() != batches_.size() || saved.window.first != window.first || saved.window.last != window.last ||
      saved.emitted.size() != size || saved.beyond_sample.size() != size)
    damaged_checkpoint();
  window_ = saved.window;
  emitted_ = saved.emitted;
  beyond_sample_ = saved.beyond_sample;
  for (std::size_t b = 0; b < batches_.size(); ++b) {
    Batch& batch = batches_[b];
    const SavedBatch& from = saved.batch[b];
    for (const heat::Grid* grid : {&from.fine, &from.coarse})
      if (!is_whole(*grid, batch.all.heat.construction)) damaged_checkpoint();
    if (!fits(from.all, from, batch.all.unit.size()) || !fits(from.sample, from, batch.sample.unit.size()) ||
        !fits(from.promise, from, batch.promise.unit.size()))
      damaged_checkpoint();
    batch.wanted_k = from.wanted_k;
    batch.run = from.run;
    for (Group* group : {&batch.all, &batch.sample, &batch.promise})
      group->plan = heat::Plan{group->heat, from.fine, from.coarse, from.request, from.step_tolerance_k, from.depth_k};
    batch.all.begin = from.all;
    batch.sample.begin = from.sample;
    batch.promise.begin = from.promise;
  }
}

}  // namespace radiometry::thermal
