// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/vehicle/vehicle.h"

#include "apps/scene/vehicle/vehicle_parts.h"
#include "mtf/error.h"

namespace apps::scene {
namespace {

constexpr std::size_t vertices = 178190;  // as many as the object of the paper
constexpr double cell = 0.0392;           // m: the parts have a few hundred vertices less

// Two aerials, rods of square section, take the vertices that are left: four on each layer.
void add_aerials(SolidBuilder& solids) {
  solids.set_group("others");
  solids.set_material("steel");
  const std::size_t left = vertices - solids.mesh().vertices.size();
  if (solids.mesh().vertices.size() + 16 > vertices || left % 4 != 0)
    throw mtf::Error("the vehicle has no room for its aerials: " + std::to_string(solids.mesh().vertices.size()) +
                     " vertices without them; change the size of the cells");
  const int layers = static_cast<int>(left / 4), first = layers / 2;
  int more = first;
  for (const double y : {-0.72, 0.72}) {
    const Section square = between_lines({{-1.506, y - 0.006, y + 0.006}, {-1.494, y - 0.006, y + 0.006}}, 1.0);
    solids.draw(square, Axis::z, {2.21, 3.40}, more - 1);
    more = layers - first;
  }
}

}  // namespace

radiometry::scene::Mesh make_vehicle() {
  SolidBuilder solids(cell);
  add_hull(solids);
  add_running_gear(solids);
  add_engine_deck(solids);
  add_turret(solids);
  add_aerials(solids);
  return solids.take();
}

}  // namespace apps::scene
