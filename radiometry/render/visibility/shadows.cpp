// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/visibility/shadows.h"

#include <algorithm>
#include <array>
#include <atomic>

#include "mtf/parallel.h"
#include "radiometry/scene/beam.h"

namespace radiometry::render {
namespace {

using scene::kBeamRays;
using scene::operator+, scene::operator*;

enum Light : std::uint8_t { dark = 1, bright = 2, mixed = 3 };

/// Gathers shadow rays into packets; `take(of, lit)` is told the answers.
template <class Take>
class ShadowRays {
 public:
  ShadowRays(const RenderScene& scene, const Camera& camera, const scene::Beam& beam, int n, Take take)
      : scene_(scene), camera_(camera), beam_(beam), n_(n), take_(take) {}

  void add(const SamplePart& part, std::size_t of) {
    const PlaceInScene place = place_of(scene_, camera_, part, n_);
    from_[count_] = place.point + beam_.lift_m() * place.normal;
    of_[count_++] = of;
    if (count_ == kBeamRays) trace();
  }
  void trace() {
    if (count_ == 0) return;
    const std::uint32_t blocked = beam_.blocked(std::span<const Point>(from_).first(count_));
    for (std::size_t k = 0; k < count_; ++k) take_(of_[k], (blocked >> k & 1U) == 0U);
    rays_ += count_;
    count_ = 0;
  }
  std::size_t rays() const { return rays_; }

 private:
  const RenderScene& scene_;
  const Camera& camera_;
  const scene::Beam& beam_;
  int n_;
  Take take_;
  std::array<Point, kBeamRays> from_;
  std::array<std::size_t, kBeamRays> of_{};
  std::size_t count_ = 0, rays_ = 0;
};

/// The light on squares of 2 x 2 samples; `mixed` where none was asked, as an outline may end there.
struct LightMap {
  std::int64_t width = 0, height = 0;
  std::vector<Light> light{};
  std::vector<std::uint32_t> shell{};  ///< that was asked; kSeveral where parts of several face the sun
  static constexpr std::uint32_t kSeveral = scene::kNone - 1;

  std::size_t of(const SamplePart& part) const {
    return static_cast<std::size_t>(part.row / 2 * width + part.column / 2);
  }
  /// What each square of rows [from, to) and its neighbours agree on; `mixed` where they do not.
  std::vector<Light> agreed(std::int64_t from, std::int64_t to) const {
    std::vector<Light> down(static_cast<std::size_t>(width)), out;
    const auto both = [](Light a, Light b) { return static_cast<Light>(a | b); };
    for (std::int64_t y = from; y < to; ++y) {
      const Light* const row = light.data() + y * width;
      const Light *const above = y > 0 ? row - width : row, *const below = y + 1 < height ? row + width : row;
      for (std::size_t x = 0; x < down.size(); ++x) down[x] = both(row[x], both(above[x], below[x]));
      for (std::size_t x = 0; x < down.size(); ++x)
        out.push_back(both(down[x], both(down[x > 0 ? x - 1 : x], down[x + 1 < down.size() ? x + 1 : x])));
    }
    return out;
  }
};
static_assert((dark | bright) == mixed);

}  // namespace

std::size_t find_shadows(const RenderScene& scene, const VisibleSides& sides, const SidesInSun* in_sun,
                         VisibleParts& parts, int threads) {
  const Camera& camera = parts.camera;
  const scene::Beam beam(*scene.rays, scene.sun->to_sun);
  const auto known = [&](std::uint32_t side) {
    if (side == scene::kNone) return InSun::nowhere;
    const std::uint32_t number = sides.number(side);
    if (in_sun != nullptr) return in_sun->of(number);
    return sides.sun_cosine(number) > 0.0F ? InSun::partly : InSun::nowhere;
  };
  const auto bands = static_cast<std::int64_t>(parts.band.size());
  const auto each_band = [&](const auto& work) {
    mtf::parallel_for(bands, 1, threads, [&](std::int64_t begin, std::int64_t end) {
      for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) work(b);
    });
  };
  std::atomic<std::size_t> rays = 0;
  LightMap map{(camera.width + 1) / 2, (camera.height + 1) / 2, {}};
  if (in_sun != nullptr) {
    map.light.assign(static_cast<std::size_t>(map.width * map.height), mixed);
    map.shell.assign(map.light.size(), scene::kNone);
  }
  std::vector<std::vector<std::uint32_t>> asking(parts.band.size());  // parts that rays are for
  each_band([&](std::size_t b) {
    std::vector<SamplePart>& band = parts.band[b];
    for (SampleRun& run : parts.runs[b]) {
      const InSun how = known(run.side);
      run.lit = how == InSun::wholly;
      for (std::uint32_t k = 0; how == InSun::partly && k < run.samples; ++k)
        band.push_back(sample_of(run, k, parts.camera, parts.n));
    }
    std::erase_if(parts.runs[b], [&](const SampleRun& run) { return known(run.side) == InSun::partly; });
    for (std::uint32_t i = 0; i < band.size(); ++i) {
      const InSun how = known(band[i].side);
      band[i].lit = how == InSun::wholly;
      if (how == InSun::partly) asking[b].push_back(i);
    }
    if (in_sun == nullptr) return;
    ShadowRays shadow(scene, camera, beam, parts.n,
                      [&](std::size_t square, bool lit) { map.light[square] = lit ? bright : dark; });
    for (const std::uint32_t i : asking[b]) {
      const SamplePart& part = band[i];
      const std::size_t square = map.of(part);
      const std::uint32_t shell = scene.facets().facet[part.side / 2].shell;
      if (map.shell[square] != scene::kNone) {
        if (map.shell[square] != shell) map.shell[square] = LightMap::kSeveral;
        continue;
      }
      map.shell[square] = shell;
      shadow.add(part, square);
    }
    shadow.trace();
    rays += shadow.rays();
  });
  each_band([&](std::size_t b) {
    if (asking[b].empty()) return;
    std::vector<SamplePart>& band = parts.band[b];
    const std::int64_t rows = Screen::kRows / parts.n / 2, first_row = static_cast<std::int64_t>(b) * rows;
    const std::vector<Light> agreed =
        in_sun == nullptr ? std::vector<Light>() : map.agreed(first_row, std::min(first_row + rows, map.height));
    const std::size_t first = static_cast<std::size_t>(first_row * map.width);
    ShadowRays shadow(scene, camera, beam, parts.n, [&](std::size_t part, bool lit) { band[part].lit = lit; });
    for (const std::uint32_t i : asking[b]) {
      const std::size_t square = map.of(band[i]);
      const Light light = in_sun == nullptr || map.shell[square] == LightMap::kSeveral ? mixed : agreed[square - first];
      if (light == mixed)
        shadow.add(band[i], i);
      else
        band[i].lit = light == bright;
    }
    shadow.trace();
    rays += shadow.rays();
  });
  return rays;
}

}  // namespace radiometry::render
