// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/heat_scene.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/words.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/scene/rays.h"
#include "radiometry/scene/views.h"
#include "radiometry/weather/instant.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;
using geometry::Point, geometry::Vector;
using geometry::operator-, geometry::operator+, geometry::operator*;

// What a camera sees.
// Lines go to seven points of every triangle that may face the camera: its middle, three near its corners and three
// near the middles of its edges. Every facet that one of them meets first is seen, whichever it was sent to. Of a facet
// that is hidden but for less than the distance of these points nothing may be met, so that facets which share a corner
// with a seen one, and may face the camera, count as seen too. A facet of a closed shell may face the camera where the
// camera lies in front of its plane, or within the box around the shell. The facet on the other side of a wall belongs
// to what is seen, because it is the other end of the same column.

constexpr std::array<std::array<double, 3>, 7> kPoints{{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                        {0.9, 0.05, 0.05},
                                                        {0.05, 0.9, 0.05},
                                                        {0.05, 0.05, 0.9},
                                                        {0.48, 0.48, 0.04},
                                                        {0.04, 0.48, 0.48},
                                                        {0.48, 0.04, 0.48}}};

/// Whether the camera lies within the box around each shell: then it may stand inside of it.
std::vector<bool> shells_around(const geometry::Facets& facets, const Point& camera) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<Point> low(facets.shells.size(), {kFar, kFar, kFar}), high(facets.shells.size(), {-kFar, -kFar, -kFar});
  for (std::size_t t = 0; t < facets.triangles.size(); ++t)
    for (const std::uint32_t v : facets.triangles[t])
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t shell = facets.facet[facets.facet_of[t]].shell;
        low[shell][axis] = std::min(low[shell][axis], facets.vertices[v][axis]);
        high[shell][axis] = std::max(high[shell][axis], facets.vertices[v][axis]);
      }
  std::vector<bool> around(facets.shells.size(), true);
  for (std::size_t s = 0; s < around.size(); ++s)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (camera[axis] < low[s][axis] || camera[axis] > high[s][axis]) around[s] = false;
  return around;
}

/// Which facets may turn a side to the camera.
std::vector<bool> facing_facets(const geometry::Facets& facets, const Point& camera) {
  const std::vector<bool> around = shells_around(facets, camera);
  std::vector<bool> may_face(facets.size());
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const geometry::Facet& facet = facets.facet[f];
    may_face[f] = !facets.shells[facet.shell].closed || around[facet.shell] ||
                  geometry::dot(facet.normal, camera - facet.centre) > 0.0;
  }
  return may_face;
}

/// What lines from the camera to some facets meet first.
void trace(const HeatScene& scene, const Point& camera, std::span<const std::uint32_t> targets,
           std::vector<geometry::Hit>& met) {
  const geometry::Facets& facets = scene.facets();
  std::vector<geometry::Ray> rays;
  for (const std::uint32_t f : targets)
    for (std::uint64_t t = facets.first[f]; t < facets.first[f + 1]; ++t) {
      const auto& [a, b, c] = facets.triangles[t];
      for (const auto& at : kPoints) {
        const Vector to = at[0] * facets.vertices[a] + at[1] * facets.vertices[b] + at[2] * facets.vertices[c] - camera;
        if (geometry::length(to) > 0.0) rays.push_back({camera, to});
      }
    }
  met.resize(rays.size());
  scene.rays.first_hits(rays, met, 1);
}

/// Adds facets that share a corner with a seen one.
void add_neighbours(const geometry::Facets& facets, const std::vector<bool>& may_face, std::vector<bool>& seen) {
  std::vector<bool> corner(facets.vertices.size(), false);
  for (std::size_t t = 0; t < facets.triangles.size(); ++t)
    if (seen[facets.facet_of[t]])
      for (const std::uint32_t v : facets.triangles[t]) corner[v] = true;
  for (std::size_t t = 0; t < facets.triangles.size(); ++t)
    if (const std::uint32_t f = facets.facet_of[t]; may_face[f] && !seen[f])
      seen[f] = std::ranges::any_of(facets.triangles[t], [&](std::uint32_t v) { return corner[v]; });
}

// Walls of closed shells, inside.kind = "pair": heat passes from a facet through the layers to the opposite facet,
// whose sun, sky, surroundings and wind are those of the other end. Every facet has a column of its own, of which its
// own end is its temperature; the column of the facet opposite has the other. Facets without an opposite one within the
// distance, as at the rims of a plate, are solved as adiabatic inside, and counted.

double thickness_m(const Material& surface) {
  double sum = 0.0;
  for (const heat::Layer& layer : surface.construction.layers) sum += layer.thickness_m;
  return sum;
}

std::vector<std::uint32_t> solved_facets(const HeatScene& scene, std::size_t material) {
  std::vector<std::uint32_t> facets;
  for (std::uint32_t f = 0; f < scene.facets().size(); ++f) {
    const Region& region = scene.region_of(f);
    if (region.material == material && region.is_solved()) facets.push_back(f);
  }
  return facets;
}

/// Pairs of one material; how many have none is said, and walls that are not as thick as the layers.
void pair_material(HeatScene& scene, std::size_t material, int threads) {
  constexpr double kUnlike = 1.5;
  const Material& surface = scene.material[material];
  const std::vector<std::uint32_t> facets = solved_facets(scene, material);
  const geometry::OppositeFacets found = opposite_facets(scene.rays, facets, surface.pair_m, threads);
  std::size_t without = 0;
  std::vector<double> distance;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const std::uint32_t opposite = found.opposite[i];
    const bool like = opposite != geometry::kNone && scene.region_of(opposite).material == material &&
                      scene.region_of(opposite).is_solved();
    if (!like) {
      ++without;
      continue;
    }
    scene.opposite[facets[i]] = opposite;
    distance.push_back(found.distance_m[i]);
  }
  const std::string where = "material '" + mtf::one_line(surface.name) + "': ";
  if (without > 0)
    scene.warnings.push_back(where + std::to_string(without) + " of " +
                             mtf::plural(static_cast<std::int64_t>(facets.size()), "facet") +
                             " have no opposite face of that material within " + mtf::significant(surface.pair_m, 3) +
                             " m; they are solved as adiabatic inside");
  if (distance.empty()) return;
  std::nth_element(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2),
                   distance.end());
  const double median = distance[distance.size() / 2], layers = thickness_m(surface);
  if (median > kUnlike * layers || layers > kUnlike * median)
    scene.warnings.push_back(where + "its layers are " + mtf::significant(layers, 3) +
                             " m thick, the walls of the mesh " + mtf::significant(median, 3) +
                             " m (median); the layers count");
}

/// Sets scene.opposite, and puts an adiabatic twin of each pair's material at the end of scene.material. Facets of
/// another material and of given temperature are no opposite ones.
void pair_walls(HeatScene& scene, int threads) {
  const std::size_t materials = scene.input.materials.size();
  for (std::size_t m = 0; m < materials; ++m) {
    if (scene.material[m].pair_m == 0.0) continue;
    if (scene.opposite.empty()) scene.opposite.assign(scene.facets().size(), geometry::kNone);
    Material twin = scene.material[m];
    twin.name += " (no opposite face)";
    twin.construction.inside = heat::Adiabatic{};
    twin.pair_m = 0.0;
    twin.source_w_m2 += twin.back_source_w_m2;  // what no longer comes out of the back
    pair_material(scene, m, threads);
    scene.material.push_back(std::move(twin));
  }
}

/// The place of the twin of a material, which has pairs.
std::size_t adiabatic_twin(const HeatScene& scene, std::size_t material) {
  std::size_t twin = scene.input.materials.size();
  for (std::size_t m = 0; m < material; ++m) twin += scene.material[m].pair_m > 0.0;
  return twin;
}

/// The backs of open surfaces that are no sheets are not solved: they stand in the light and at the temperature of
/// their fronts. That is no matter where nothing sees them, as under terrain; else it is said.
void warn_of_seen_backs(HeatScene& scene, int threads) {
  constexpr std::size_t kFacets = 2000;
  constexpr int kRays = 8;
  constexpr double kSeen = 0.01;
  const geometry::Facets& facets = scene.facets();
  std::vector<std::uint32_t> patch_of;  // of each side: its region for such a back, else a patch of what is solved
  const auto solved = static_cast<std::uint32_t>(scene.input.regions.size());
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const bool unsolved =
        !facets.shells[facets.facet[f].shell].closed && !scene.is_sheet(f) && scene.region_of(f).is_solved();
    patch_of.insert(patch_of.end(), {solved, unsolved ? scene.input.region_of[f] : solved});
  }
  std::vector<geometry::Side> sides;
  const std::size_t step = std::max<std::size_t>(1, facets.size() / kFacets);
  for (std::size_t f = step / 2; f < facets.size(); f += step) sides.push_back({static_cast<std::uint32_t>(f), false});
  const geometry::Views seen = views(scene.rays, geometry::single_sides(std::move(sides)), patch_of, solved + 1,
                                     {.rays = kRays, .threads = threads});
  std::vector<double> share(solved + 1, 0.0);
  for (std::size_t e = 0; e < seen.patches.value.size(); ++e)
    share[seen.patches.column[e]] += seen.patches.value[e] / static_cast<double>(seen.size());
  for (std::uint32_t r = 0; r < solved; ++r)
    if (share[r] > kSeen)
      scene.warnings.push_back("region '" + mtf::one_line(scene.input.regions[r].name) +
                               "': " + mtf::significant(100.0 * share[r], 2) +
                               " % of what surfaces see are backs of its open surfaces, which are taken to be lit and "
                               "warm as their fronts are; with inside.kind = \"sheet\" they are solved");
}

void find_seen(HeatScene& scene, int threads) {
  const mtf::Stopwatch watch;
  const std::string where = mtf::one_line(scene.input.name) + ": what the camera sees is asked for, ";
  if (!scene.input.camera_m) throw mtf::UsageError(where + "and there is no [camera]");
  scene.seen = seen_facets(scene, *scene.input.camera_m, threads);
  if (std::ranges::find(scene.seen, true) == scene.seen.end())
    throw mtf::UsageError(where + "and [camera] sees no facet from its position");
  scene.timing_ms.emplace_back("seen", watch.ms());
}

std::string number(double value, std::string_view unit) { return mtf::significant(value, 5) + " " + std::string(unit); }

/// Winds of the weather that a closure of convection was not made for: each is said once.
std::vector<std::string> wind_limits(const ThermalScene& scene, const Surroundings& s) {
  std::vector<std::string> texts;
  std::set<std::string> seen;  // closures
  for (const Material& one : scene.materials) {
    const auto validity = heat::wind_validity(one.construction.convection);
    if (!validity || !seen.insert(name_of(one.construction.convection)).second) continue;
    heat::Beyond beyond;
    for (std::size_t k = 0; k < s.nodes(); ++k) beyond.see(*validity, s.wind_m_s[k], s.time_s[k]);
    if (beyond.values > 0) texts.push_back(text_of(*validity, beyond, scene.start_s, ""));
  }
  return texts;
}

}  // namespace

std::vector<bool> seen_facets(const HeatScene& scene, const Point& camera_m, int threads) {
  constexpr std::int64_t kAtOnce = 1024;
  const geometry::Facets& facets = scene.facets();
  const auto count = static_cast<std::uint32_t>(facets.size());
  const std::vector<bool> may_face = facing_facets(facets, camera_m);
  std::vector<std::uint32_t> targets;
  for (std::uint32_t f = 0; f < count; ++f)
    if (may_face[f]) targets.push_back(f);
  std::vector<std::vector<geometry::Hit>> met(targets.size() / kAtOnce + 1);
  mtf::parallel_for(
      static_cast<std::int64_t>(targets.size()), kAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
        trace(scene, camera_m,
              std::span(targets).subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)),
              met[static_cast<std::size_t>(begin / kAtOnce)]);
      });
  std::vector<bool> seen(count, false);
  for (const std::vector<geometry::Hit>& some : met)
    for (const geometry::Hit& hit : some)
      if (geometry::hits(hit)) seen[hit.facet] = true;
  add_neighbours(facets, may_face, seen);
  const std::vector<bool> fronts = seen;
  for (std::uint32_t f = 0; f < count; ++f)
    if (const std::uint32_t opposite = scene.opposite_of(f); fronts[f] && opposite != geometry::kNone)
      seen[opposite] = true;
  return seen;
}

std::string text_of(const heat::Validity& validity, const heat::Beyond& beyond, double start_s,
                    const std::string& where) {
  return std::string(validity.closure) + ": " + where + "the " + std::string(validity.quantity) + " is outside of " +
         number(validity.lo, validity.unit) + " ... " + number(validity.hi, validity.unit) + ", first at " +
         heat::instant_text(start_s + beyond.first_s) + ", and comes to " + number(beyond.extreme, validity.unit) +
         ": " + std::string(validity.beyond);
}

bool HeatScene::is_sheet(std::uint32_t facet) const {
  const Region& of = region_of(facet);
  return of.is_solved() && material[*of.material].is_sheet();
}

std::uint32_t HeatScene::opposite_of(std::uint32_t facet) const {
  return opposite.empty() ? geometry::kNone : opposite[facet];
}

std::size_t HeatScene::material_of(std::uint32_t facet) const {
  const std::size_t of = *region_of(facet).material;
  return material[of].pair_m > 0.0 && opposite_of(facet) == geometry::kNone ? adiabatic_twin(*this, of) : of;
}

HeatScene prepare_heat(ThermalScene input, const HeatOptions& options) {
  require_valid(input);
  const mtf::Stopwatch weather;
  Surroundings surroundings = surroundings_of(input, options.directions, options.tolerance_k);
  const double weather_ms = weather.ms();
  const mtf::Stopwatch tree;
  scene::Rays rays(std::exchange(input.facets, {}));
  std::vector<std::string> warnings = surroundings.warnings;
  for (std::string& text : wind_limits(input, surroundings)) warnings.push_back(std::move(text));
  for (const heat::Schedule* schedule : input.schedules())
    if (std::string text = held_beyond(*schedule, input.start_s, input.last_s());
        !text.empty() && std::ranges::find(warnings, text) == warnings.end())
      warnings.push_back(std::move(text));
  warnings.insert(warnings.end(), rays.facets().warnings.begin(), rays.facets().warnings.end());
  std::vector<Material> materials = input.materials;
  HeatScene scene{std::move(input),
                  std::move(surroundings),
                  std::move(materials),
                  std::move(rays),
                  {{"weather", weather_ms}, {"tree", tree.ms()}},
                  std::move(warnings)};
  pair_walls(scene, options.threads);
  warn_of_seen_backs(scene, options.threads);
  if (options.seen) find_seen(scene, options.threads);
  return scene;
}

}  // namespace radiometry::thermal
