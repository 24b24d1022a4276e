// SPDX-License-Identifier: Apache-2.0

// From temperatures of units to what patches emit.

#include "apps/scene/heat/heat_batches.h"
#include "mtf/parallel.h"
#include "radiometry/light/constants.h"

namespace apps::scene {

namespace heat = radiometry::heat;

void HeatBatches::add_emitted(const Group& group, const heat::Run& run, std::vector<double>& emitted) const {
  const radiometry::scene::Exchange& exchange = units_.exchange;
  const std::size_t patches = exchange.patches(), units = group.unit.size();
  mtf::parallel_for(
      static_cast<std::int64_t>(light_.moments()), 8, threads_, [&](std::int64_t begin, std::int64_t end) {
        for (auto m = static_cast<std::size_t>(begin); m < static_cast<std::size_t>(end); ++m)
          for (std::size_t i = 0; i < units; ++i) {
            const Unit& unit = units_.unit[group.unit[i]];
            const auto side = [&](const UnitSide& of, std::size_t r, double kelvin_here) {
              const double square = kelvin_here * kelvin_here;
              emitted[m * patches + exchange.patch_of[r]] +=
                  exchange.receiver_area_m2[r] * of.emissivity * radiometry::kStefanBoltzmann_w_m2_k4 * square * square;
            };
            side(unit.front, unit.receiver, run.front_k[m * units + i]);
            if (unit.has_own_back()) side(*unit.back, unit.back_receiver, run.back_k[m * units + i]);
          }
      });
}

void HeatBatches::keep_temperatures(const std::vector<std::uint32_t>& units, const heat::Run& run) {
  const std::size_t receivers = units_.exchange.receivers(), count = units.size();
  mtf::parallel_for(static_cast<std::int64_t>(light_.moments()), 8, threads_,
                    [&](std::int64_t begin, std::int64_t end) {
                      for (auto m = static_cast<std::size_t>(begin); m < static_cast<std::size_t>(end); ++m)
                        for (std::size_t i = 0; i < count; ++i) {
                          const Unit& unit = units_.unit[units[i]];
                          receiver_k_[m * receivers + unit.receiver] = run.front_k[m * count + i];
                          if (unit.has_own_back())
                            receiver_k_[m * receivers + unit.back_receiver] = run.back_k[m * count + i];
                        }
                    });
}

std::vector<double> HeatBatches::emitted_by_all() const {
  const radiometry::scene::Exchange& exchange = units_.exchange;
  const std::size_t patches = exchange.patches();
  std::vector<double> emitted(light_.moments() * patches, 0.0);
  mtf::parallel_for(
      static_cast<std::int64_t>(light_.moments()), 8, threads_, [&](std::int64_t begin, std::int64_t end) {
        for (auto m = static_cast<std::size_t>(begin); m < static_cast<std::size_t>(end); ++m)
          for_receivers(units_, [&](std::size_t r, const Unit&, const UnitSide& side) {
            const double kelvin = receiver_k_[m * exchange.receivers() + r], square = kelvin * kelvin;
            emitted[m * patches + exchange.patch_of[r]] += exchange.receiver_area_m2[r] /
                                                           exchange.area_m2[exchange.patch_of[r]] * side.emissivity *
                                                           radiometry::kStefanBoltzmann_w_m2_k4 * square * square;
          });
      });
  return emitted;
}

std::vector<double> HeatBatches::patch_radiosity(std::size_t node) const {
  const PatchTable& table = light_.longwave;
  const std::size_t moment = 2 * (node - window_.first);
  std::vector<double> radiosity;
  for (std::size_t p = 0; p < units_.exchange.patches(); ++p)
    radiosity.push_back(table.reference_w_m2[moment] +
                        static_cast<double>(table.radiosity[p * table.moments + moment]));
  return radiosity;
}

}  // namespace apps::scene
