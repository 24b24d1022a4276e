// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures of a scene in the bands of cameras: radiance at the aperture of every sample,
//   L = tau [eps B(T) + (1 - eps) (light of sky, ground and other surfaces + sun)] + L_path
// in one sum over the band (band_nodes.h, band_tables.h). Light is diffuse and constant over a side; the first frame
// takes as many rays for it as bring their error below half of the noise of each camera, as far as RenderOptions
// allows, and the error is told. Shadows of the sun are traced where the sun adds more than 1e-3 of what a blackbody of
// the air gives; else a side is lit by the share of it that is in the sun. A sample is the mean of n x n points
// (visibility/screen.h).

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "radiometry/render/band_shader.h"

namespace radiometry::render {

/// Planes beside the radiance, of the middle of each sample.
struct LayerChoice {
  bool temperature = false;    ///< K; NaN where there is no facet
  bool emissivity = false;     ///< mean over the band; of each band
  bool range = false;          ///< m along the line of sight; infinite where it meets nothing
  bool facet = false;          ///< number; -1 where there is none
  bool finish = false;         ///< number; -1 where there is no facet
  bool normal = false;         ///< of the side that is seen: x, y, z; 0 where there is no facet
  bool surface = false;        ///< radiance before the air, of each band; 0 for the sky
  bool transmittance = false;  ///< of the air, for the light of facet or ground, of each band; 0 for the sky

  /// Those that differ from band to band, and the others.
  LayerChoice of_band() const {
    LayerChoice choice;
    choice.emissivity = emissivity, choice.surface = surface, choice.transmittance = transmittance;
    return choice;
  }
  LayerChoice of_all() const {
    LayerChoice choice = *this;
    choice.emissivity = choice.surface = choice.transmittance = false;
    return choice;
  }
  bool any() const {
    return temperature || emissivity || range || facet || finish || normal || surface || transmittance;
  }
};

struct RenderOptions {
  int points = 2;            ///< n x n of a sample: 1, 2 or 4
  bool ray_shadows = false;  ///< by a ray for everything that faces the sun: slower, to check SidesInSun by
  double tolerance = 5e-6;   ///< of the tables of the air, relative; kBetweenHeights once the camera changes its height
  int view_rays = 64;        ///< of each visible side that reflects, at least
  int most_view_rays = 4096;  ///< the first frame decides how many are taken, a power of two times view_rays
  int patch_rays = 256;       ///< of each patch
  int rings = 9;              ///< of the sky
  bool empty_views = false;   ///< pictures of sky and ground alone are made; else refused
  LayerChoice layers{};
  int threads = 0;  ///< 0: all cores; pictures do not depend on it
};

struct NamedLayer {
  std::string name{};
  mtf::Image plane{};
  std::optional<std::size_t> band{};  ///< nothing for those that are the same in all bands
};

struct RenderedFrame {
  std::vector<mtf::Image> radiance{};  ///< of each band: W or photons s^-1, m^-2 sr^-1
  std::vector<NamedLayer> layers{};    ///< as chosen, with the names of OpenEXR channels
  std::vector<double> promised{};      ///< of each band: relative error of tables and quadrature
  /// Of each band: rms error of the light that sides reflect, K of a blackbody of 300 K, as of the last measurement: at
  /// the first frame in a light, and whenever twice as many sides are shown.
  std::vector<double> reflected_k{};
  int view_rays = 0;
  std::size_t divided = 0;  ///< samples that show more than one side
  std::size_t shadow_rays = 0;
  std::size_t sides = 0, shaded = 0;  ///< sides seen so far; worked out for this frame
  std::vector<std::pair<std::string, double>> timing_ms{};
};

class Renderer {
 public:
  /// `scene` is kept by reference, and its numbers may not change. Throws mtf::UsageError as require_valid and
  /// BandShader do, and for options out of range.
  Renderer(const RenderScene& scene, std::vector<RenderBand> bands, RenderOptions options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// What a renderer knows of a scene that does not depend on light, air and bands: which sides were seen, what they
  /// see of each other. A copy, for a renderer of the same facets and finishes at another time or in other bands.
  struct Known;
  std::shared_ptr<const Known> known() const;
  /// With tables ready for the camera that `known` saw last. Where temperatures have become others than those that
  /// surfaces were put together by, only facets are taken over. May run beside render() of another renderer. Throws
  /// mtf::UsageError as above, and for other facets.
  Renderer(const RenderScene& scene, std::vector<RenderBand> bands, const Known& known);

  /// Takes over the views of sides that another renderer has seen, so that frames do not wait for them; pictures are
  /// the same without. Does nothing where facets, patches, the sun or the number of rays are others.
  void learn(const Known& other);

  /// To be called when `temperature_k` of the scene has changed. What surfaces reflect stays that of the temperatures
  /// at the start.
  void temperatures_changed();

  /// What did not change since the last frame is not worked out again. `points`: of a sample of this frame, in place of
  /// RenderOptions::points. Throws mtf::UsageError for a camera that sees no facet, or the inside of a solid, and for
  /// other numbers of points.
  RenderedFrame render(const Camera& camera, std::optional<int> points = std::nullopt);

  const std::vector<std::pair<std::string, double>>& timing_ms() const;  ///< of making it

 private:
  void add_layers(const Camera& camera, bool shadows, RenderedFrame& frame);

  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace radiometry::render
