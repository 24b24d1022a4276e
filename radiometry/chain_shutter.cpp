// SPDX-License-Identifier: Apache-2.0

// The light of the camera itself in the chain: warm optics and housing, and the closed shutter of a thermal camera over
// a sequence (stages/detector/shutter_events.h).

#include "mtf/parallel.h"
#include "radiometry/chain_impl.h"

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

/// An image of the size of another: value(i) at its pixel i.
template <class Value>
mtf::Image map_of(const mtf::Image& other, int threads, Value value) {
  constexpr std::int64_t kPixelsAtOnce = std::int64_t{1} << 16;
  mtf::Image map(other.width(), other.height());
  mtf::parallel_for(map.size(), kPixelsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) map.data()[i] = static_cast<float>(value(i));
  });
  return map;
}

double product(const mtf::Image& a, const mtf::Image& b, std::int64_t i) {
  const auto factor = [i](const mtf::Image& map) { return map.size() > 0 ? static_cast<double>(map.data()[i]) : 1.0; };
  return factor(a) * factor(b);
}

}  // namespace

Factor factor_of(double number, const mtf::Image& a, const mtf::Image& b, double added, int threads) {
  if (number == 0.0 || (a.size() == 0 && b.size() == 0)) return {number + added};
  const mtf::Image& some = a.size() > 0 ? a : b;
  return {.map = map_of(some, threads, [&](std::int64_t i) { return number * product(a, b, i) + added; })};
}

Factor glow_of(const CompiledChain& chain, const Directions<double>& light, const mtf::Image& corners,
               const mtf::Image& left, const mtf::Image& responsivity, double added, int threads) {
  if (corners.size() == 0 || !chain.settings.thermal || !chain.settings.thermal->shutter_k)
    return factor_of(light.total_e(), left, responsivity, added, threads);
  // v of the cone is left, and pi - v cone around it.
  const double cone = cone_sr(chain.camera), around = around_cone_sr(chain.camera);
  const double around_per_sr = around > 0.0 ? light.around_e / around : 0.0;
  const double always = mtf::kPi * around_per_sr, by_cone = light.cone_e - cone * around_per_sr;
  return {.map = map_of(corners, threads, [&](std::int64_t i) {
            return product(left, responsivity, i) * (always + by_cone * static_cast<double>(corners.data()[i])) + added;
          })};
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
