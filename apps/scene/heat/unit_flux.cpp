// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/unit_flux.h"

#include <algorithm>
#include <cmath>

#include "mtf/parallel.h"
#include "radiometry/light/constants.h"

namespace apps::scene {
namespace {

namespace geometry = radiometry::scene;
namespace heat = radiometry::heat;

/// A place in the interval after a node.
struct Between {
  std::size_t node = 0;
  double share = 0.0;  ///< 0 at the node, 1 at the next
};

Between place_of(const std::vector<double>& times, heat::Instant at) {
  const bool before = at.limit == heat::Instant::Limit::before;
  const auto above = before ? std::lower_bound(times.begin(), times.end(), at.time_s)
                            : std::upper_bound(times.begin(), times.end(), at.time_s);
  const auto next = std::clamp<std::ptrdiff_t>(above - times.begin(), 1, static_cast<std::ptrdiff_t>(times.size()) - 1);
  const auto node = static_cast<std::size_t>(next - 1);
  return {node, std::clamp((at.time_s - times[node]) / (times[node + 1] - times[node]), 0.0, 1.0)};
}

double between(const std::vector<double>& values, Between at) {
  return values[at.node] + at.share * (values[at.node + 1] - values[at.node]);
}

/// The direct light of an instant: direction, irradiance, and the entry of the table of shadows.
struct Beam {
  geometry::Vector to_sun{};
  double irradiance_w_m2 = 0.0;  ///< 0 while the sun is down
  std::size_t entry = 0;
  double share = 0.0;
};

Beam beam_at(const Surroundings& s, Between at, double time_s) {
  Beam beam;
  const int entry = s.shadow_entry[at.node];
  if (entry < 0) return beam;
  for (std::size_t axis = 0; axis < 3; ++axis)
    beam.to_sun[axis] = s.to_sun[at.node][axis] + at.share * (s.to_sun[at.node + 1][axis] - s.to_sun[at.node][axis]);
  const double size = geometry::length(beam.to_sun);
  for (double& component : beam.to_sun) component /= size;
  beam.irradiance_w_m2 = between(s.direct_w_m2, at);
  beam.entry = static_cast<std::size_t>(entry);
  const double begin = s.shadow_time_s[beam.entry], end = s.shadow_time_s[beam.entry + 1];
  beam.share = std::clamp((time_s - begin) / (end - begin), 0.0, 1.0);
  return beam;
}

double direct_w_m2(const UnitSide& side, const geometry::SunVisibility& sun, const Beam& beam) {
  if (beam.irradiance_w_m2 <= 0.0) return 0.0;
  const double cosine = geometry::dot(side.normal, beam.to_sun);
  if (cosine <= 0.0) return 0.0;
  const std::uint8_t* lit = sun.lit.data() + side.sun_row * sun.directions + beam.entry;
  return beam.irradiance_w_m2 * cosine * (lit[0] + beam.share * (lit[1] - lit[0])) / sun.points;
}

/// Of receivers, what comes from other surfaces: the whole irradiance without that from sky, ground and sun.
void solve_exchange(const Units& units, const geometry::ReceiverFluxes& fluxes, std::span<float> from_surfaces) {
  const std::vector<double> whole = irradiance_w_m2(units.exchange, fluxes, 1e-11);
  for (std::size_t i = 0; i < whole.size(); ++i)
    from_surfaces[i] = static_cast<float>(whole[i] - fluxes.environment[i] - fluxes.direct[i]);
}

/// The exchange is defined for reflectances below 1.
double reflectance_of(double absorbed_part) { return std::min(1.0 - absorbed_part, 1.0 - 1e-9); }

}  // namespace

ReceiverTable make_receiver_table(std::size_t first, std::size_t last, std::size_t receivers) {
  return {first, receivers, std::vector<float>((last + 1 - first) * receivers, 0.0F)};
}

void fill_solar_exchange(const Units& units, const Surroundings& s, const GroundLight& ground, int threads,
                         ReceiverTable& irradiance) {
  const std::size_t receivers = irradiance.receivers;
  std::vector<double> reflectance(receivers);
  for_receivers(units, [&](std::size_t i, const Unit&, const UnitSide& side) {
    reflectance[i] = reflectance_of(side.absorptance);
  });
  mtf::parallel_for(
      static_cast<std::int64_t>(irradiance.nodes()), 1, threads, [&](std::int64_t begin, std::int64_t end) {
        std::vector<double> none(receivers, 0.0), environment(receivers), direct(receivers);
        for (std::int64_t k = begin; k < end; ++k) {
          const std::size_t node = irradiance.first + static_cast<std::size_t>(k);
          if (s.global_w_m2[node] <= 0.0) continue;
          const bool from_before = node + 1 == s.nodes() || (node > 0 && s.shadow_entry[node] < 0);
          const Beam beam = beam_at(s, from_before ? Between{node - 1, 1.0} : Between{node, 0.0}, s.time_s[node]);
          for_receivers(units, [&](std::size_t i, const Unit&, const UnitSide& side) {
            direct[i] = direct_w_m2(side, units.sun, beam);
            environment[i] = side.sky * s.diffuse_w_m2[node] + side.ground * ground.solar_w_m2[node];
          });
          solve_exchange(units, {none, reflectance, environment, direct}, irradiance.row(node));
        }
      });
}

void longwave_exchange(const Units& units, const Surroundings& s, const GroundLight& ground, std::size_t node,
                       std::span<const double> receiver_k, std::span<float> irradiance) {
  const std::size_t receivers = units.exchange.receivers();
  std::vector<double> emitted(receivers), reflectance(receivers), environment(receivers), none(receivers, 0.0);
  for_receivers(units, [&](std::size_t i, const Unit&, const UnitSide& side) {
    emitted[i] = side.emissivity * radiometry::kStefanBoltzmann_w_m2_k4 * (receiver_k[i] * receiver_k[i]) *
                 (receiver_k[i] * receiver_k[i]);
    reflectance[i] = reflectance_of(side.emissivity);
    environment[i] = side.sky * s.sky_longwave_w_m2[node] + side.ground * ground.longwave_w_m2[node];
  });
  solve_exchange(units, {emitted, reflectance, environment, none}, irradiance);
}

heat::Forcing forcing_of(std::span<const Unit> batch, const Units& units, const Surroundings& s,
                         const GroundLight& ground, const ReceiverTable& solar, const ReceiverTable& longwave,
                         const heat::Schedule& inside, double start_s) {
  return [=, &units, &s, &ground, &solar, &longwave, &inside](heat::Instant at, std::size_t first,
                                                              heat::ForcingValues& values) {
    const Between place = place_of(s.time_s, at);
    const Beam beam = beam_at(s, place, at.time_s);
    const double diffuse = between(s.diffuse_w_m2, place), sky = between(s.sky_longwave_w_m2, place);
    const double ground_solar = between(ground.solar_w_m2, place), ground_warm = between(ground.longwave_w_m2, place);
    values.front.air_k = values.back.air_k = between(s.air_k, place);
    values.front.wind_m_s = values.back.wind_m_s = between(s.wind_m_s, place);
    if (!inside.value.empty()) values.inside = value_at(inside, start_s + at.time_s);
    // Beyond the window, where only plans are tried, the exchange is that of its end.
    const std::size_t last = solar.first + solar.nodes() - 1;
    const std::size_t row = std::min(place.node, last), next = std::min(place.node + 1, last);
    const auto exchanged = [&](const ReceiverTable& table, std::size_t receiver) {
      const double a = table.row(row)[receiver], b = table.row(next)[receiver];
      return a + place.share * (b - a);
    };
    const auto absorbed = [&](const UnitSide& side, std::size_t receiver) {
      return side.source_w_m2 +
             side.absorptance * (direct_w_m2(side, units.sun, beam) + side.sky * diffuse + side.ground * ground_solar +
                                 exchanged(solar, receiver)) +
             side.emissivity * (side.sky * sky + side.ground * ground_warm + exchanged(longwave, receiver));
    };
    for (std::size_t i = 0; i < values.front.absorbed_w_m2.size(); ++i) {
      const Unit& unit = batch[first + i];
      values.front.absorbed_w_m2[i] = absorbed(unit.front, unit.receiver);
      if (unit.back) values.back.absorbed_w_m2[i] = absorbed(*unit.back, unit.back_receiver);
    }
  };
}

}  // namespace apps::scene
