// SPDX-License-Identifier: Apache-2.0

// The light of the camera itself in the chain: warm optics and housing, and the closed shutter of a thermal camera over
// a sequence (stages/detector/shutter_events.h).

#include "radiometry/chain/chain_impl.h"

namespace radiometry {
namespace {

Directions<double> difference(const Directions<double>& a, const Directions<double>& b) {
  return {a.cone_e - b.cone_e, a.around_e - b.around_e};
}

Directions<double> open_at(const CompiledChain& chain, const CameraEmission& camera) {
  return own_light(chain.camera, chain.pixel, own_radiances(chain.curves, camera));
}

Directions<double> closed_at(const CompiledChain& chain, const CameraEmission& camera) {
  return closed_shutter(chain.camera, chain.pixel, own_radiances(chain.curves, camera));
}

}  // namespace

Linear glow_of(const CompiledChain& chain, const Directions<double>& light, const Linear& corners,
               const SharedMap& sensitivity, double added, int threads) {
  const bool shutter = chain.settings.thermal && chain.settings.thermal->shutter_k;
  if (!shutter || (!corners.map && corners.number == 1.0)) return {light.total_e(), sensitivity, added};
  // v of the cone is left, and pi - v cone around it.
  const double cone = cone_sr(chain.camera), around = around_cone_sr(chain.camera);
  const double around_per_sr = around > 0.0 ? light.around_e / around : 0.0;
  const double always = mtf::kPi * around_per_sr, by_cone = light.cone_e - cone * around_per_sr;
  if (!corners.map) return {always + by_cone * corners.number, sensitivity, added};
  mtf::Image seen = corners.map->clone();
  multiply_add(seen, {by_cone * corners.number}, {always}, threads);
  multiply_add(seen, {1.0, sensitivity}, {added}, threads);
  return {1.0, std::make_shared<const mtf::Image>(std::move(seen))};
}

Directions<double> warming_of(const CompiledChain& chain, std::uint32_t frame) {
  const double by_k = chain.events->warming_k(frame);
  if (by_k == 0.0) return {};
  return difference(open_at(chain, warmed(chain.emission, by_k)), open_at(chain, chain.emission));
}

Directions<double> last_closed(const CompiledChain& chain, std::uint32_t frame, ChainState* state) {
  const std::uint32_t last = chain.events->closing_before(frame);
  const ShutterClosing now{last, warmed(chain.emission, chain.events->warming_k(last))};
  if (state != nullptr && (!state->closing || state->closing->frame != last)) state->closing = now;
  return closed_at(chain, state != nullptr ? state->closing->camera : now.camera);
}

}  // namespace radiometry
