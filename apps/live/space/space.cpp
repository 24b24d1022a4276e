// SPDX-License-Identifier: Apache-2.0
#include "apps/live/space/space.h"

#include <cmath>

#include "mtf/error.h"

namespace apps::live {
namespace {

constexpr double kFarthest_m = 1e6;
constexpr double kNearest_m = 1e-3;

std::array<double, 3> point_of(const Json& request, const char* key, const std::array<double, 3>& otherwise) {
  const Json* found = request.find(key);
  if (!found || found->is_null()) return otherwise;
  std::array<double, 3> point{};
  bool good = found->is_array() && found->size() == 3;
  for (std::size_t i = 0; good && i < 3; ++i) {
    good = (*found)[i].is_number();
    if (good) point[i] = (*found)[i].get<double>();
    good = good && std::abs(point[i]) <= kFarthest_m;  // NaN is not
  }
  if (!good) throw mtf::UsageError(std::string(key) + ": three numbers of at most 1e6 m belong here");
  return point;
}

}  // namespace

Viewpoint viewpoint_of(const Json& request, const Space& space) {
  Viewpoint from{.position_m = point_of(request, "position", space.start.position_m),
                 .look_at_m = point_of(request, "look_at", space.start.look_at_m),
                 .utc_s = space.start.utc_s};
  const double range = std::hypot(from.position_m[0] - from.look_at_m[0], from.position_m[1] - from.look_at_m[1],
                                  from.position_m[2] - from.look_at_m[2]);
  if (!(range >= kNearest_m)) throw mtf::UsageError("position: the camera looks at its own position");
  const Json* time = request.find("utc_s");
  if (!time || time->is_null()) return from;
  if (!time->is_number() || !(time->get<double>() >= space.begin_s && time->get<double>() <= space.end_s))
    throw mtf::UsageError("utc_s: a time that the temperatures have belongs here, from " +
                          std::to_string(std::llround(space.begin_s)) + " to " +
                          std::to_string(std::llround(space.end_s)) + " s");
  from.utc_s = std::clamp(std::round(time->get<double>()), space.begin_s, space.end_s);
  return from;
}

}  // namespace apps::live
