// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/renderer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <mutex>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/survey/statistics.h"
#include "radiometry/render/frame_layers.h"

namespace radiometry::render {
namespace {

using Times = std::vector<std::pair<std::string, double>>;

/// Adds the time since it was made, or since the last lap, to a named sum.
class Laps {
 public:
  explicit Laps(Times& times) : times_(times) {}
  void lap(const std::string& name) {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    for (auto& [known, sum] : times_)
      if (known == name) {
        sum += ms;
        return;
      }
    times_.emplace_back(name, ms);
  }

 private:
  Times& times_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void require_options(const RenderOptions& options, std::size_t bands) {
  const auto refuse = [](const std::string& what) { throw mtf::UsageError("render: " + what); };
  if (bands == 0) refuse("there is no band");
  if (options.further != 1 && options.further != 2 && options.further != 4)
    refuse(std::to_string(options.further) + " x " + std::to_string(options.further) +
           " rays of a sample; there are 1, 2 x 2 or 4 x 4");
  if (!(options.contrast >= 0.0)) refuse("a contrast below 0");
  if (!(options.tolerance > 0.0)) refuse("a tolerance that is not above 0");
}

bool reflects(const RenderScene& scene) {
  return has_angles(scene) || std::any_of(scene.finish.begin(), scene.finish.end(), [](const Finish& finish) {
           return std::any_of(finish.emissivity.value.begin(), finish.emissivity.value.end(),
                              [](double value) { return value < 1.0; });
         });
}

/// Ranges and heights of what the rays meet; facets alone.
struct Met {
  PathExtent extent{std::numeric_limits<double>::infinity(), 0.0, std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  std::size_t hits = 0;

  void add(const Met& other) {
    extent = {std::min(extent.nearest_m, other.extent.nearest_m), std::max(extent.farthest_m, other.extent.farthest_m),
              std::min(extent.lowest_m, other.extent.lowest_m), std::max(extent.highest_m, other.extent.highest_m)};
    hits += other.hits;
  }
};

Met met_by(const RayHits& hits, int threads) {
  Met all;
  std::mutex lock;
  mtf::parallel_for(static_cast<std::int64_t>(hits.side.size()), 1 << 16, threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      float near = 1e30F, far = 0.0F, low = 1e30F, high = -1e30F;
                      std::size_t count = 0;
                      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                        if (hits.side[i] == scene::kNone) continue;
                        near = std::min(near, hits.range_m[i]), far = std::max(far, hits.range_m[i]);
                        low = std::min(low, hits.height_m[i]), high = std::max(high, hits.height_m[i]);
                        ++count;
                      }
                      if (count == 0) return;
                      const std::scoped_lock guard(lock);
                      all.add({{near, far, low, high}, count});
                    });
  return all;
}

/// At the outline of a solid single precision now and then meets the inner side of a facet that faces away: it is taken
/// for the outer one. More than a hundredth of the rays do so where the camera stands in a solid, or sees into one.
void turn_insides(const RenderScene& scene, RayHits& hits, int threads) {
  constexpr std::size_t kMost = 100;
  std::atomic<std::size_t> turned = 0;
  std::atomic<std::uint32_t> facet = 0;
  mtf::parallel_for(static_cast<std::int64_t>(hits.side.size()), 1 << 16, threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      std::size_t here = 0;
                      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                        std::uint32_t& side = hits.side[i];
                        if (side == scene::kNone || side % 2 == 0 || !std::isnan(scene.temperature_k[side])) continue;
                        facet = side / 2;
                        side -= 1;
                        ++here;
                      }
                      turned += here;
                    });
  if (kMost * turned <= hits.side.size()) return;
  refuse_inside(scene, facet);
}

/// Marks samples that differ from a neighbour by more than `threshold`.
void mark_edges(const mtf::Image& image, double threshold, int threads, std::vector<std::uint8_t>& marked) {
  const std::int64_t width = image.width(), height = image.height();
  const auto most = static_cast<float>(threshold);
  mtf::parallel_for(height, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      const float* row = image.data() + y * width;
      std::uint8_t* mark = marked.data() + y * width;
      for (std::int64_t x = 0; x < width; ++x) {
        float difference = 0.0F;
        if (x > 0) difference = std::max(difference, std::abs(row[x] - row[x - 1]));
        if (x + 1 < width) difference = std::max(difference, std::abs(row[x] - row[x + 1]));
        if (y > 0) difference = std::max(difference, std::abs(row[x] - row[x - width]));
        if (y + 1 < height) difference = std::max(difference, std::abs(row[x] - row[x + width]));
        if (difference > most) mark[x] = 1;
      }
    }
  });
}

}  // namespace

struct Renderer::Parts {
  const RenderScene& scene;
  RenderOptions options;
  Times timing{};
  Patches patches{};
  scene::Views patch_views{};
  std::vector<BandShader> shader{};
  std::vector<BandShader> surface{};  ///< of each band without air, where layers need it; else none
  std::unique_ptr<VisibleSides> sides{};
  RayHits hits{};
  bool angles = false;   ///< some finish depends on the angle, or is glossy
  MirrorRays mirrors{};  ///< of those hits
  std::vector<std::vector<float>> radiance{};

  void make(std::vector<RenderBand> bands);
  void trace(const Camera& camera, const RayPlan& plan, std::size_t first, std::size_t count, RenderedFrame& frame,
             Laps& laps);
  void shade(const Camera& camera, RenderedFrame& frame, Laps& laps);
  void divide(const Camera& camera, std::vector<std::uint32_t> samples, RenderedFrame& frame, Laps& laps);
  bool shadows_matter() const;
  std::vector<std::uint32_t> differing(const RenderedFrame& frame) const;
};

void Renderer::Parts::make(std::vector<RenderBand> bands) {
  Laps laps(timing);
  const bool light = reflects(scene);
  angles = has_angles(scene);
  patch_views.rings = options.rings;
  if (light) {
    patches = patches_by_temperature(scene);
    patch_views = scene::views(
        *scene.rays, patches.sides, patches.patch_of, patches.size(),
        {.rings = options.rings, .rays = options.patch_rays, .threads = options.threads, .rays_of_side = true});
  }
  laps.lap("views of patches");
  if (options.layers.surface || options.layers.transmittance)
    for (const RenderBand& band : bands)
      surface.emplace_back(band, scene, patches, patch_views, options.tolerance, false);
  for (RenderBand& band : bands)
    shader.emplace_back(std::move(band), scene, patches, patch_views, options.tolerance, true);
  sides = std::make_unique<VisibleSides>(
      scene, patches,
      VisibleSides::Options{
          .rings = options.rings, .rays = options.view_rays, .views = light, .threads = options.threads});
  radiance.resize(shader.size());
  laps.lap("light and emission");
}

void Renderer::Parts::trace(const Camera& camera, const RayPlan& plan, std::size_t first, std::size_t count,
                            RenderedFrame& frame, Laps& laps) {
  hits.resize(count, options.layers.range);
  trace_rays(*scene.rays, camera, plan, first, hits, options.threads);
  frame.rays += hits.side.size();
  turn_insides(scene, hits, options.threads);
  laps.lap("rays");
  sides->add(hits);
  if (angles) {
    mirrors = mirror_rays(scene, camera, plan, first, hits, options.threads);
    sides->add(mirrors.met);
  }
  laps.lap("views of visible sides");
}

void Renderer::Parts::shade(const Camera& camera, RenderedFrame& frame, Laps& laps) {
  for (BandShader& one : shader) frame.shaded += one.shade(*sides, camera.position, options.threads);
  laps.lap("visible sides");
}

/// Where the sun adds next to nothing, as in the long-wave window, the share of each side in the sun will do.
bool Renderer::Parts::shadows_matter() const {
  constexpr double kSunlight = 1e-3;
  return std::any_of(shader.begin(), shader.end(), [](const BandShader& one) { return one.sunlight() > kSunlight; });
}

/// Samples that differ from a neighbour in any band, in tiles of 4 x 4 so that their rays stay together.
std::vector<std::uint32_t> Renderer::Parts::differing(const RenderedFrame& frame) const {
  const mtf::Image& first = frame.radiance.front();
  std::vector<std::uint8_t> marked(static_cast<std::size_t>(first.size()), options.everywhere ? 1 : 0);
  if (!options.everywhere)
    for (const mtf::Image& image : frame.radiance)
      mark_edges(image, options.contrast * mtf::statistics(image.view()).std, options.threads, marked);
  std::vector<std::uint32_t> samples;
  for (std::int64_t y = 0; y < first.height(); y += 4)
    for (std::int64_t x = 0; x < first.width(); x += 4)
      for (std::int64_t v = y; v < std::min(y + 4, first.height()); ++v)
        for (std::int64_t u = x; u < std::min(x + 4, first.width()); ++u)
          if (marked[static_cast<std::size_t>(v * first.width() + u)] != 0)
            samples.push_back(static_cast<std::uint32_t>(v * first.width() + u));
  return samples;
}

void Renderer::Parts::divide(const Camera& camera, std::vector<std::uint32_t> samples, RenderedFrame& frame,
                             Laps& laps) {
  constexpr std::size_t kPackets = std::size_t{1} << 16;  // at once
  const auto each = static_cast<std::size_t>(options.further * options.further);
  frame.divided = samples.size();
  const RayPlan plan = RayPlan::further(camera, samples, options.further);
  const bool shadows = shadows_matter();
  for (std::size_t first = 0; first < plan.packets(); first += kPackets) {
    trace(camera, plan, first, std::min(kPackets, plan.packets() - first), frame, laps);
    if (shadows) {
      trace_shadows(*scene.rays, camera, plan, first, scene.sun->to_sun, hits, options.threads);
      laps.lap("shadows");
    }
    shade(camera, frame, laps);
    for (std::size_t b = 0; b < shader.size(); ++b) {
      shader[b].radiance(hits, *sides, radiance[b], options.threads);
      if (angles) shader[b].add_angles(mirrors, hits, *sides, radiance[b], options.threads);
      for (std::size_t i = 0; i + each <= radiance[b].size(); i += each) {
        const std::size_t sample = (first * scene::kPencilRays + i) / each;
        if (sample >= samples.size()) break;
        double sum = 0.0;
        for (std::size_t k = 0; k < each; ++k) sum += static_cast<double>(radiance[b][i + k]);
        frame.radiance[b].data()[samples[sample]] = static_cast<float>(sum / static_cast<double>(each));
      }
    }
    laps.lap("further rays");
  }
}

Renderer::Renderer(const RenderScene& scene, std::vector<RenderBand> bands, RenderOptions options) {
  require_valid(scene);
  require_options(options, bands.size());
  parts_.reset(new Parts{.scene = scene, .options = options});  // made in place
  parts_->make(std::move(bands));
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;

const Times& Renderer::timing_ms() const { return parts_->timing; }

RenderedFrame Renderer::render(const Camera& camera) {
  Parts& parts = *parts_;
  const RenderOptions& options = parts.options;
  RenderedFrame frame;
  Laps laps(frame.timing_ms);
  const RayPlan plan = RayPlan::tiles(camera);
  parts.trace(camera, plan, 0, plan.packets(), frame, laps);
  const Met met = met_by(parts.hits, options.threads);
  if (met.hits == 0) throw mtf::UsageError("the camera sees no facet of the scene: turn it, or move it nearer");
  frame.facet_hits = met.hits;
  for (BandShader& one : parts.shader) {
    one.prepare(camera.position[2], met.extent);
    frame.promised.push_back(one.promised());
  }
  for (BandShader& one : parts.surface) one.prepare(camera.position[2], met.extent);
  laps.lap("tables of the air");
  if (parts.shadows_matter()) {
    trace_shadows(*parts.scene.rays, camera, plan, 0, parts.scene.sun->to_sun, parts.hits, options.threads);
    laps.lap("shadows");
  }
  parts.shade(camera, frame, laps);
  for (std::size_t b = 0; b < parts.shader.size(); ++b) {
    parts.shader[b].radiance(parts.hits, *parts.sides, parts.radiance[b], options.threads);
    if (parts.angles)
      parts.shader[b].add_angles(parts.mirrors, parts.hits, *parts.sides, parts.radiance[b], options.threads);
    frame.radiance.push_back(image_of(camera, parts.radiance[b], options.threads));
  }
  laps.lap("pixels");
  if (options.layers.any()) {
    for (BandShader& one : parts.surface) one.shade(*parts.sides, camera.position, options.threads);
    const auto add = [&](std::size_t b, const LayerChoice& choice, std::optional<std::size_t> band) {
      const BandShader* surface = choice.surface || choice.transmittance ? &parts.surface[b] : nullptr;
      for (NamedLayer& layer : layers_of({parts.scene, camera, parts.hits, parts.mirrors, *parts.sides, parts.shader[b],
                                          surface, parts.radiance[b], choice, options.threads})) {
        layer.band = band;
        frame.layers.push_back(std::move(layer));
      }
    };
    add(0, options.layers.of_all(), std::nullopt);
    for (std::size_t b = 0; b < parts.shader.size(); ++b) add(b, options.layers.of_band(), b);
    laps.lap("layers");
  }
  if (options.further > 1) parts.divide(camera, parts.differing(frame), frame, laps);
  frame.sides = parts.sides->size();
  return frame;
}

}  // namespace radiometry::render
