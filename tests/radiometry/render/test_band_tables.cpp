// SPDX-License-Identifier: Apache-2.0
// Tables of a band against the integrals of spectral_signal.h, which take the product of all curves piece by piece and
// share no quadrature with them.

#include "radiometry/render/band_tables.h"

#include <gtest/gtest.h>

#include "radiometry/light/scene_radiance.h"
#include "render_cases.h"

namespace radiometry::render::test {
namespace {

namespace air = radiometry::atmosphere;

air::Air<double> summer() {
  return {.profile = air::model_profile(air::ModelAtmosphere::mid_latitude_summer),
          .haze = {.kind = air::HazeKind::rural, .visibility_m = 23e3}};
}
air::Air<double> station() { return {.profile = air::surface_air(101300.0, 295.0, 60.0)}; }

struct Place {
  air::Air<double> air;
  double altitude_m, camera_m;
  PathExtent extent;
};
const std::vector<Place>& places() {
  static const std::vector<Place> all{{summer(), 200.0, 5.0, {10.0, 3000.0, -2.0, 50.0}},
                                      {summer(), 0.0, 3000.0, {3050.0, 9000.0, 0.0, 200.0}},
                                      {summer(), 2317.0, 5.0, {2.0, 60.0, 0.0, 4.0}},
                                      {station(), 0.0, 2.0, {0.0, 5000.0, 0.0, 10.0}}};
  return all;
}

/// The path of those samples as the camera equation takes it: transmission and, of a blackbody of the air's
/// temperature, emissivity, straight lines between the wavenumbers of the model.
Path path_of(const BandNodes& nodes, const AirSamples& samples, double reference_k) {
  Path path;
  path.transmission = {"transmission", nodes.sample_um, samples.transmission};
  path.emissivity = {"emissivity", nodes.sample_um, samples.source};
  path.air_temperature_k = reference_k;
  return path;
}

class Tables : public ::testing::TestWithParam<int> {};

TEST_P(Tables, KeepTheirPromiseAtRandomPlaces) {
  const RenderBand band = GetParam() == 0 ? mwir() : lwir();
  const std::vector<Spectrum> emissivity{grey(1.0), grey(0.6), coloured()};
  const BandNodes nodes = band_nodes(band.curves, emissivity);
  std::vector<std::vector<double>> at;
  for (const Spectrum& curve : emissivity) at.push_back(at_nodes(nodes, curve));
  const std::vector<KelvinRange> ranges{{230.0, 380.0}, {280.0, 310.0}, {200.0, 450.0}};
  const EmissionFolds folds(nodes, at, ranges);
  scene::test::Uniform uniform(7);
  for (const Place& place : places()) {
    const AirView view(place.air, nodes, place.altitude_m, place.camera_m, place.extent.farthest_m);
    const PathGrid grid = path_grid(view, nodes, place.extent, 5e-6);
    const BandTables tables(nodes, folds, at, {}, grid, view.reference_k());
    const double promised = promised_error(band.curves, emissivity, folds, tables, grid, &view);
    const double black = scene_radiance(band.curves, {.temperature_k = view.reference_k()}, {});
    double realised = 0.0;
    for (int i = 0; i < 250; ++i) {
      const auto m = static_cast<std::size_t>(3.0 * uniform());
      const double kelvin = std::lerp(ranges[m].lo_k, ranges[m].hi_k, uniform());
      const double height = std::lerp(place.extent.lowest_m, place.extent.highest_m, uniform());
      const double range = std::max(std::lerp(place.extent.nearest_m, place.extent.farthest_m, std::pow(uniform(), 2)),
                                    std::abs(height - place.camera_m));
      const Path path = path_of(nodes, view.to(range, height), view.reference_k());
      const double direct = scene_radiance(band.curves, {.temperature_k = kelvin, .emissivity = emissivity[m]}, path) +
                            weighted_path_radiance(band.curves, path);
      const double root = std::sqrt(range);
      const PathGrid::Cell cell = grid.cell_at(root, height);
      const auto weights = grid.weights(cell, root, height);
      const SixValues emitted = tables.emitted(m, kelvin, grid.index(cell)), added = tables.path(grid.index(cell));
      double seen = 0.0;
      for (std::size_t k = 0; k < 6; ++k) seen += static_cast<double>(weights[k]) * (emitted[k] + added[k]);
      realised = std::max(realised, std::abs(seen - direct) / std::max(direct, black));
    }
    std::printf("%s: %zu cells, %zu layers, promised %.1e, realised %.1e\n", band.name.c_str(), grid.cells(),
                grid.layers(), promised, realised);
    EXPECT_LE(realised, promised);
    EXPECT_LE(promised, 1e-4);
  }
}
INSTANTIATE_TEST_SUITE_P(Bands, Tables, ::testing::Values(0, 1));

TEST(BandNodes, IntegrateProductsOfCurvesAndPlanck) {
  for (const RenderBand& band : {mwir(), lwir()})
    for (const double kelvin : {200.0, 300.0, 800.0}) {
      const Spectrum emissivity = coloured();
      const BandNodes nodes = band_nodes(band.curves, std::span(&emissivity, 1));
      const std::vector<double> eps = at_nodes(nodes, emissivity);
      std::vector<double> light = blackbody_at(nodes, kelvin);
      for (std::size_t k = 0; k < light.size(); ++k) light[k] *= eps[k];
      const double direct = scene_radiance(band.curves, {.temperature_k = kelvin, .emissivity = emissivity}, {});
      EXPECT_NEAR(integral(nodes, light) / direct, 1.0, 1e-10) << band.name << " " << kelvin;
      double folded = 0.0;
      for (const double part : fold(nodes, light)) folded += part;
      EXPECT_NEAR(folded / direct, 1.0, 1e-10);
    }
}

TEST(BandNodes, RefuseWhatIsNotThermal) {
  EXPECT_THROW(band_nodes(seeing({1.5, 1.8}), {}), mtf::UsageError);
  EXPECT_THROW(band_nodes(seeing({2.8, 4.0}), {}), mtf::UsageError);
  EXPECT_THROW(band_nodes(seeing({8.0, 15.0}), {}), mtf::UsageError);
}

/// The air of one temperature emits what it takes: source = 1 - transmission at every node and between them.
TEST(PathGrid, AirOfOneTemperatureEmitsWhatItTakes) {
  air::Profile<double> profile = air::model_profile(air::ModelAtmosphere::us_standard_1976);
  for (auto& level : profile.levels) level.temperature_k = 288.0;
  const BandNodes nodes = band_nodes(mwir().curves, {});
  const AirView view({.profile = profile}, nodes, 0.0, 100.0);
  const PathGrid grid = path_grid(view, nodes, {20.0, 4000.0, 0.0, 300.0}, 1e-4);
  for (const AirSamples& node : grid.node)
    for (std::size_t i = 0; i < node.source.size(); ++i) EXPECT_NEAR(node.source[i] + node.transmission[i], 1.0, 1e-10);
}

}  // namespace
}  // namespace radiometry::render::test
