// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/render/visibility/sides_in_sun.h"
#include "radiometry/scene/rays.h"

namespace radiometry::render {
namespace {

// Planes beside the radiance of a frame, of the middle of each sample.

struct LayerInputs {
  const RenderScene& scene;
  const Camera& camera;
  const VisibleParts& middles;  ///< n = 1
  const MirrorRays& mirrors;    ///< of them
  const VisibleSides& sides;
  const BandShader& shader;
  const BandShader* surface;   ///< the same band without air; null where neither layer asks for it
  const mtf::Image& radiance;  ///< of the middles
  const LayerChoice& choice;
  bool shadows;  ///< SamplePart::lit is known
  int threads;
};

using scene::kNone;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// An image of value(part).
template <class Value>
mtf::Image made(const LayerInputs& in, const Value& value) {
  mtf::Image image(in.camera.width, in.camera.height);
  mtf::parallel_for_each(static_cast<std::int64_t>(in.middles.band.size()), 1, in.threads, [&](std::int64_t b) {
    for (const SamplePart& part : in.middles.band[static_cast<std::size_t>(b)])
      image.at(part.column, part.row) = value(part);
  });
  return image;
}

/// Along the ray through the middle of a sample to the plane of the facet that it shows.
double range_of(const LayerInputs& in, const SamplePart& part) {
  using scene::operator-;
  return scene::length(place_of(in.scene, in.camera, part, 1).point - in.camera.position);
}

/// The emissivity of each visible side, where it was asked for.
std::vector<float> emissivities(const LayerInputs& in) {
  std::vector<float> out(in.sides.size());
  for (std::size_t n = 0; n < out.size(); ++n) {
    const std::uint32_t side = in.sides.side(n);
    out[n] = static_cast<float>(
        in.shader.emissivity(in.scene.finish_of[side], static_cast<double>(in.scene.temperature_k[side])));
  }
  return out;
}

/// Names are those of OpenEXR channels: temperature, emissivity, Z, facet, material, normal.X, surface ...
std::vector<NamedLayer> layers_of(const LayerInputs& in) {
  std::vector<NamedLayer> layers;
  using Part = SamplePart;
  const auto add = [&](const std::string& name, float otherwise, const auto& of_facet) {
    layers.push_back(
        {name, made(in, [&](const Part& part) { return part.side == kNone ? otherwise : of_facet(part); })});
  };
  if (in.choice.temperature)
    add("temperature", kNan, [&](const Part& part) { return in.scene.temperature_k[part.side]; });
  if (in.choice.emissivity) {
    const std::vector<float> value = emissivities(in);
    add("emissivity", kNan, [&](const Part& part) {
      const float along_normal = value[in.sides.number(part.side)];
      const AngularEmissivity& curve = in.scene.finish[in.scene.finish_of[part.side]].by_angle;
      if (curve.empty()) return along_normal;
      const Vector d = in.camera.direction(part.column + 0.5, part.row + 0.5);
      const double cosine = std::abs(scene::dot(d, in.scene.facets().facet[part.side / 2].normal)) / scene::length(d);
      return static_cast<float>(relative_emissivity(curve, cosine)) * along_normal;
    });
  }
  if (in.choice.range)
    layers.push_back({"Z", made(in, [&](const Part& part) {
                        return static_cast<float>(part.side == kNone
                                                      ? in.shader.backdrop().range_m(static_cast<double>(part.height_m))
                                                      : range_of(in, part));
                      })});
  if (in.choice.facet) add("facet", -1.0F, [&](const Part& part) { return static_cast<float>(part.side / 2); });
  if (in.choice.finish)
    add("material", -1.0F, [&](const Part& part) { return static_cast<float>(in.scene.finish_of[part.side]); });
  for (std::size_t axis = 0; in.choice.normal && axis < 3; ++axis)
    add(std::string("normal.") + "XYZ"[axis], 0.0F, [&](const Part& part) {
      const double value = in.scene.facets().facet[part.side / 2].normal[axis];
      return static_cast<float>(part.side % 2 == 1 ? -value : value);
    });
  if (in.surface == nullptr) return layers;
  mtf::Image before(in.camera.width, in.camera.height);
  in.surface->radiance(in.middles, in.sides, in.mirrors, in.shadows, before, in.threads);
  const auto above = [&](const Part& part) { return part.side == kNone && part.height_m >= 0.0F; };
  if (in.choice.surface)
    layers.push_back(
        {"surface", made(in, [&](const Part& part) { return above(part) ? 0.0F : before.at(part.column, part.row); })});
  if (in.choice.transmittance)
    layers.push_back({"transmittance", made(in, [&](const Part& part) {
                        if (above(part)) return 0.0F;
                        const auto height = static_cast<double>(part.height_m);
                        const double path = part.side == kNone
                                                ? in.shader.backdrop().path_radiance(height)
                                                : in.shader.path_radiance(static_cast<double>(part.range_m), height);
                        return static_cast<float>((static_cast<double>(in.radiance.at(part.column, part.row)) - path) /
                                                  static_cast<double>(before.at(part.column, part.row)));
                      })});
  return layers;
}

using Times = std::vector<std::pair<std::string, double>>;

/// Adds the time since it was made, or since the last lap, to a named sum.
class Laps {
 public:
  explicit Laps(Times& times) : times_(times) {}
  void lap(const std::string& name) {
    const double ms = std::exchange(watch_, {}).ms();
    for (auto& [known, sum] : times_)
      if (known == name) {
        sum += ms;
        return;
      }
    times_.emplace_back(name, ms);
  }

 private:
  Times& times_;
  mtf::Stopwatch watch_;
};

[[noreturn]] void refuse(const std::string& what) { throw mtf::UsageError("render: " + what); }

void require_points(int points) {
  if (points != 1 && points != 2 && points != 4)
    refuse(std::to_string(points) + " x " + std::to_string(points) +
           " points of a sample; there are 1, 2 x 2 or 4 x 4");
}

void require_options(const RenderOptions& options, std::size_t bands) {
  if (bands == 0) refuse("there is no band");
  require_points(options.points);
  if (!(options.tolerance > 0.0)) refuse("a tolerance that is not above 0");
}

bool reflects(const RenderScene& scene) {
  return has_angles(scene) || std::ranges::any_of(scene.finish, [](const Finish& finish) {
           return std::ranges::any_of(finish.emissivity.value, [](double value) { return value < 1.0; });
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
  std::optional<SidesInSun> in_sun{};                   ///< where shadows matter
  Screen screen{};                                      ///< of both of these, one after the other
  VisibleParts parts{}, middles{};                      ///< of the frame, and of its layers
  double camera_height_m = 0.0, height_before_m = 0.0;  ///< of the last two frames
  bool angles = false;                                  ///< some finish depends on the angle, or is glossy
  std::vector<double> reflected_k{};                    ///< RenderedFrame::reflected_k
  std::size_t measured = 0;                             ///< sides that were shown then; 0: not yet in this light
  bool rays_chosen = false;                             ///< as many as the first frame asked for

  void make(std::vector<RenderBand> bands, const Known* known);
  bool shadows_matter() const;
  void measure_reflected(const Point& camera);
  void find_sides_in_sun();
  std::size_t shadows_on(VisibleParts& of);
  MirrorRays mirrors_of(const Camera& camera, const VisibleParts& of);
};

struct Renderer::Known {
  RenderOptions options;
  Patches patches;
  scene::Views patch_views;
  PathExtent extent;                        ///< of the last frame
  double camera_height_m, height_before_m;  ///< of the last two
  RenderScene scene;                        ///< of `sides`, with its sun alone
  std::optional<VisibleSides> sides{};
  std::optional<SidesInSun> in_sun{};
  bool rays_chosen;
};

void Renderer::Parts::make(std::vector<RenderBand> bands, const Known* known) {
  Laps laps(timing);
  const bool light = reflects(scene);
  angles = has_angles(scene);
  patch_views.rings = options.rings;
  if (known != nullptr) {
    patches = known->patches;
    patch_views = known->patch_views;
  } else if (light) {
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
  reflected_k.assign(shader.size(), 0.0);
  rays_chosen = known != nullptr && known->rays_chosen;
  if (known != nullptr)
    sides = std::make_unique<VisibleSides>(scene, patches, *known->sides);
  else
    sides = std::make_unique<VisibleSides>(
        scene, patches,
        VisibleSides::Options{
            .rings = options.rings, .rays = options.view_rays, .views = light, .threads = options.threads});
  laps.lap("light and emission");
}

/// The sides that mirrors show are among `sides` afterwards.
MirrorRays Renderer::Parts::mirrors_of(const Camera& camera, const VisibleParts& of) {
  if (!angles) return {};
  MirrorRays mirrors = mirror_rays(scene, camera, of, options.threads);
  sides->add(mirrors.side);
  return mirrors;
}

void Renderer::Parts::find_sides_in_sun() {
  if (!in_sun)
    in_sun.emplace(scene.facets(), scene.sun->to_sun, scene::Beam(*scene.rays, scene.sun->to_sun).lift_m(),
                   options.threads);
  in_sun->add(*sides, options.threads);
}

/// Returns the number of rays.
std::size_t Renderer::Parts::shadows_on(VisibleParts& of) {
  if (!options.ray_shadows) find_sides_in_sun();
  return find_shadows(scene, *sides, options.ray_shadows ? nullptr : &*in_sun, of, options.threads);
}

/// The error of the light that sides reflect, in each light anew; the first time with as many rays as bring it below
/// half of the noise.
void Renderer::Parts::measure_reflected(const Point& camera) {
  constexpr std::size_t kChecked = 256;
  constexpr double kOfNoise = 0.5, kPower = 1.5;  // rays for an error that falls as rays^-0.65 (views.h)
  const std::size_t shown = sides->shown_now();
  if (shown == 0 || !reflects(scene) || shown < 2 * measured) return;
  while (true) {
    const VisibleSides::OtherViews other = sides->other_views(kChecked);
    double worst = 0.0;
    for (std::size_t b = 0; b < shader.size(); ++b) {
      reflected_k[b] = shader[b].reflected_error_k(*sides, other, camera);
      worst = std::max(worst, reflected_k[b] / (kOfNoise * shader[b].band().noise_k));
    }
    int rays = sides->rays();
    const double wanted = std::min(rays * std::pow(worst, kPower), static_cast<double>(options.most_view_rays));
    while (2 * rays <= options.most_view_rays && rays < wanted) rays *= 2;
    if (rays_chosen || worst <= 1.0 || rays == sides->rays()) break;
    sides->trace_again(rays);
  }
  measured = shown;
  rays_chosen = true;
}

/// Where the sun adds next to nothing, as in the long-wave window, the share of each side in the sun will do.
bool Renderer::Parts::shadows_matter() const {
  constexpr double kSunlight = 1e-3;
  return std::ranges::any_of(shader, [](const BandShader& one) { return one.sunlight() > kSunlight; });
}

Renderer::Renderer(const RenderScene& scene, std::vector<RenderBand> bands, RenderOptions options) {
  require_valid(scene);
  require_options(options, bands.size());
  parts_.reset(new Parts{.scene = scene, .options = options});  // made in place
  parts_->make(std::move(bands), nullptr);
}

Renderer::Renderer(const RenderScene& scene, std::vector<RenderBand> bands, const Known& known) {
  require_valid(scene);
  require_options(known.options, bands.size());
  if (known.scene.rays != scene.rays)
    throw mtf::UsageError("render: what is known of views is of other facets than those of the scene");
  parts_.reset(new Parts{.scene = scene, .options = known.options});
  const bool alike = known.patches.size() == 0 || still_alike(scene, known.patches);
  parts_->make(std::move(bands), alike ? &known : nullptr);
  if (known.extent.farthest_m <= 0.0) return;
  for (BandShader& one : parts_->shader)
    for (const double height_m : {known.height_before_m, known.camera_height_m})
      one.prepare(height_m, known.extent, known.options.threads);
  if (!parts_->shadows_matter() || known.options.ray_shadows) return;
  // The same sides, as they are kept where patches are.
  if (alike && known.in_sun && known.in_sun->picture().to_sun() == scene.sun->to_sun) parts_->in_sun = known.in_sun;
  parts_->find_sides_in_sun();
}

std::shared_ptr<const Renderer::Known> Renderer::known() const {
  const Parts& my = *parts_;
  const auto copy = std::make_shared<Known>(Known{.options = my.options,
                                                  .patches = my.patches,
                                                  .patch_views = my.patch_views,
                                                  .extent = my.parts.extent,
                                                  .camera_height_m = my.camera_height_m,
                                                  .height_before_m = my.height_before_m,
                                                  .scene = {.rays = my.scene.rays, .sun = my.scene.sun},
                                                  .rays_chosen = my.rays_chosen});
  copy->sides.emplace(copy->scene, copy->patches, *my.sides);
  copy->in_sun = my.in_sun;
  return copy;
}

void Renderer::learn(const Known& other) {
  const RenderScene& mine = parts_->scene;
  if (other.scene.rays != mine.rays || !same_direction(other.scene.sun, mine.sun) ||
      other.patches.patch_of != parts_->patches.patch_of || other.sides->rays() != parts_->sides->rays())
    return;
  parts_->sides->take_over(*other.sides);
}

void Renderer::temperatures_changed() {
  for (BandShader& one : parts_->shader) one.temperatures_changed();
  for (BandShader& one : parts_->surface) one.temperatures_changed();
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;

const Times& Renderer::timing_ms() const { return parts_->timing; }

RenderedFrame Renderer::render(const Camera& camera, std::optional<int> points) {
  Parts& my = *parts_;
  RenderOptions options = my.options;
  options.points = points.value_or(options.points);
  require_points(options.points);
  RenderedFrame frame;
  Laps laps(frame.timing_ms);
  my.height_before_m = my.parts.extent.farthest_m > 0.0 ? my.camera_height_m : camera.position[2];
  my.camera_height_m = camera.position[2];
  require_outside(my.scene, camera.position);
  const PathExtent before = my.parts.extent;
  find_parts(
      my.scene, camera,
      {.n = options.points, .runs = !options.ray_shadows, .likely = my.sides->numbers(), .threads = options.threads},
      my.screen, my.parts);
  if (my.parts.on_facets == 0) {
    my.parts.extent = before.farthest_m > 0.0 ? before : PathExtent{1.0, 2.0, 0.0, 1.0};  // so that tables stay
    if (!options.empty_views)
      throw mtf::UsageError("the camera sees no facet of the scene: turn it, or move it nearer");
  }
  frame.divided = my.parts.divided;
  laps.lap("what is seen");
  my.sides->add(my.parts);
  const MirrorRays mirrors = my.mirrors_of(camera, my.parts);
  laps.lap("views of visible sides");
  for (BandShader& one : my.shader) {
    one.prepare(camera.position[2], my.parts.extent, options.threads);
    frame.promised.push_back(one.promised());
  }
  laps.lap("tables of the air");
  my.measure_reflected(camera.position);
  frame.reflected_k = my.reflected_k;
  frame.view_rays = my.sides->rays();
  laps.lap("error of reflected light");
  const bool shadows = my.shadows_matter();
  if (shadows) {
    frame.shadow_rays = my.shadows_on(my.parts);
    laps.lap("shadows");
  }
  for (BandShader& one : my.shader) frame.shaded += one.shade(*my.sides, camera.position, options.threads);
  laps.lap("visible sides");
  for (const BandShader& one : my.shader) {
    frame.radiance.emplace_back(camera.width, camera.height);
    one.radiance(my.parts, *my.sides, mirrors, shadows, frame.radiance.back(), options.threads);
  }
  laps.lap("pixels");
  if (options.layers.any()) {
    add_layers(camera, shadows, frame);
    laps.lap("layers");
  }
  frame.sides = my.sides->size();
  return frame;
}

/// Layers are of middles of samples, which may show sides that no other point does.
void Renderer::add_layers(const Camera& camera, bool shadows, RenderedFrame& frame) {
  Parts& my = *parts_;
  const int threads = my.options.threads;
  find_parts(my.scene, camera, {.n = 1, .runs = false, .likely = my.sides->numbers(), .threads = threads}, my.screen,
             my.middles);
  my.sides->add(my.middles);
  const MirrorRays mirrors = my.mirrors_of(camera, my.middles);
  if (shadows) my.shadows_on(my.middles);
  const auto add = [&](std::size_t b, const LayerChoice& choice, std::optional<std::size_t> band) {
    BandShader& shader = my.shader[b];
    mtf::Image radiance;
    BandShader* surface = nullptr;
    if (choice.surface || choice.transmittance) {
      if (my.middles.on_facets > 0) shader.prepare(camera.position[2], my.middles.extent, threads);
      shader.shade(*my.sides, camera.position, threads);
      radiance = mtf::Image(camera.width, camera.height);
      shader.radiance(my.middles, *my.sides, mirrors, shadows, radiance, threads);
      surface = &my.surface[b];
      surface->prepare(camera.position[2], my.parts.extent, threads);
      surface->shade(*my.sides, camera.position, threads);
    }
    for (NamedLayer& layer : layers_of(
             {my.scene, camera, my.middles, mirrors, *my.sides, shader, surface, radiance, choice, shadows, threads})) {
      layer.band = band;
      frame.layers.push_back(std::move(layer));
    }
  };
  add(0, my.options.layers.of_all(), std::nullopt);
  for (std::size_t b = 0; b < my.shader.size(); ++b) add(b, my.options.layers.of_band(), b);
}

}  // namespace radiometry::render
