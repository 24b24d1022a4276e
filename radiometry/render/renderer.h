// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures of a scene in the bands of cameras: radiance at the aperture of every sample,
//   L = tau [eps B(T) + (1 - eps) (light of sky, ground and other surfaces + sun)] + L_path
// in one sum over the band (band_nodes.h, band_tables.h). Light is diffuse and constant over a side. Shadows of the sun
// are traced for every ray where the sun adds more than 1e-3 of what a blackbody of the air gives; else a side is lit
// by the share of it that is in the sun. A sample takes one ray through its middle, and further ones where it differs
// from a neighbour.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "radiometry/render/band_shader.h"

namespace radiometry::render {

/// Planes beside the radiance, of the ray through the middle of each sample.
struct LayerChoice {
  bool temperature = false;    ///< K; NaN where there is no facet
  bool emissivity = false;     ///< mean over the band; of each band
  bool range = false;          ///< m along the ray; infinite where it meets nothing
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
  int further = 2;          ///< n x n rays where a sample differs: 1 (never), 2 or 4
  double contrast = 0.02;   ///< that differ by more than this part of the picture's standard deviation
  bool everywhere = false;  ///< all samples take n x n rays
  double tolerance = 5e-6;  ///< of the tables of the air, relative
  int view_rays = 64;       ///< of each visible side that reflects
  int patch_rays = 256;     ///< of each patch
  int rings = 9;            ///< of the sky
  LayerChoice layers{};
  int threads = 0;  ///< 0: all cores; pictures do not depend on it
};

struct NamedLayer {
  std::string name{};
  mtf::Image plane{};
  std::optional<std::size_t> band{};  ///< nothing for those that are the same in all bands
};

struct RenderedFrame {
  std::vector<mtf::Image> radiance{};                  ///< of each band: W or photons s^-1, m^-2 sr^-1
  std::vector<NamedLayer> layers{};                    ///< as chosen, with the names of OpenEXR channels
  std::vector<double> promised{};                      ///< of each band: relative error of tables and quadrature
  std::size_t rays = 0, shadow_rays = 0, divided = 0;  ///< `divided`: samples with further rays
  std::size_t facet_hits = 0, sides = 0, shaded = 0;   ///< sides seen so far; worked out for this frame
  std::vector<std::pair<std::string, double>> timing_ms{};
};

class Renderer {
 public:
  /// `scene` is kept by reference, and its numbers may not change. Throws mtf::UsageError as require_valid and
  /// BandShader do, and for options out of range.
  Renderer(const RenderScene& scene, std::vector<RenderBand> bands, RenderOptions options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// What did not change since the last frame is not worked out again. Throws mtf::UsageError for a camera that sees no
  /// facet, or the inside of a solid.
  RenderedFrame render(const Camera& camera);

  const std::vector<std::pair<std::string, double>>& timing_ms() const;  ///< of making it

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace radiometry::render
