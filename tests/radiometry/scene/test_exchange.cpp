// SPDX-License-Identifier: Apache-2.0

// Reciprocity, closure, and radiosity against a dense solve, closed forms and the isothermal enclosure.

#include "radiometry/scene/exchange.h"

#include <gtest/gtest.h>

#include <numeric>

#include "radiometry/light/constants.h"
#include "tests/expect_error.h"
#include "tests/radiometry/scene/scene_cases.h"

namespace radiometry::scene {
namespace {

/// A scene, its receivers and how these exchange radiation; receiver i belongs to patch i / `of_a_patch`.
struct Sampled {
  std::vector<double> area;
  Views seen;
  Exchange exchange;
};

Sampled sampled(const Mesh& mesh, int rays_each, std::uint32_t of_a_patch = 1) {
  const Rays rays(test::facets(mesh));
  const Receivers receivers = single_sides(rays.facets());
  std::vector<std::uint32_t> patch_of(receivers.size());
  for (std::uint32_t i = 0; i < patch_of.size(); ++i) patch_of[i] = i / of_a_patch;
  const std::size_t patches = patch_of.back() + 1;
  Sampled made{.area = areas_m2(rays.facets(), receivers), .seen = {}, .exchange = {}};
  made.seen =
      views(rays, receivers, patches_of_sides(rays.facets(), receivers, patch_of), patches, {.rays = rays_each});
  made.exchange = exchange_of(made.seen, made.area, patch_of, patches);
  return made;
}

/// A room of 2 x 3 x 1 m whose walls face inwards, with a box in it.
Mesh room(int n) {
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {0, 0, 0}, {2, 3, 1}, n, -1);
  test::add_box(mesh, {0.5, 0.6, 0.2}, {0.4, 0.9, 0.5}, 1);
  return mesh;
}

/// Things on the ground under the sky.
Mesh yard() {
  Mesh mesh = test::sphere({0.3, -0.2, 1.0}, 0.7, 6);
  test::add_plate(mesh, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 4, 4);
  test::add_plate(mesh, {-2, -2, 0}, {0, 4, 0}, {0, 0, 2}, 3, 2);
  test::add_box(mesh, {0.9, 0.9, 0.0}, {1, 0.5, 0.7}, 2);
  return mesh;
}

std::vector<std::vector<double>> dense(const SparseRows& rows) {
  std::vector<std::vector<double>> matrix(rows.rows(), std::vector<double>(rows.rows(), 0.0));
  for (std::size_t i = 0; i < rows.rows(); ++i)
    for (std::uint64_t e = rows.first[i]; e < rows.first[i + 1]; ++e) matrix[i][rows.column[e]] += rows.value[e];
  return matrix;
}

void expect_reciprocal_and_closed(const Exchange& exchange) {
  const auto f = dense(exchange.factors);
  for (std::size_t i = 0; i < exchange.patches(); ++i) {
    EXPECT_NEAR(std::accumulate(f[i].begin(), f[i].end(), exchange.leaving[i]), 1.0, 1e-12) << i;
    for (std::size_t j = 0; j < exchange.patches(); ++j) {
      EXPECT_GE(f[i][j], 0.0);
      EXPECT_NEAR(exchange.area_m2[i] * f[i][j], exchange.area_m2[j] * f[j][i], 1e-12 * exchange.area_m2[i]);
    }
  }
}

/// Gaussian elimination with pivots.
std::vector<double> solved(std::vector<std::vector<double>> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::abs(a[i][k]) > std::abs(a[pivot][k])) pivot = i;
    std::swap(a[k], a[pivot]), std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

TEST(Exchange, IsReciprocalAndClosed) {
  const Sampled closed = sampled(room(5), 128);
  EXPECT_EQ(closed.exchange.patches(), 156U);
  for (const double leaving : closed.exchange.leaving) EXPECT_EQ(leaving, 0.0);
  expect_reciprocal_and_closed(closed.exchange);
  EXPECT_LT(closed.exchange.own_view, 1e-12);
  expect_reciprocal_and_closed(sampled(yard(), 64).exchange);
  expect_reciprocal_and_closed(sampled(yard(), 64, 7).exchange);
}

TEST(Exchange, FewRaysAreClosedTooAtTheCostOfOwnView) {
  // One ray each: most factors are missing, some rows cannot be scaled to their area.
  const Sampled poor = sampled(room(3), 1);
  expect_reciprocal_and_closed(poor.exchange);
  EXPECT_GT(poor.exchange.change, 10 * sampled(room(3), 4096).exchange.change);
}

TEST(Exchange, FactorsOfACube) {
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {0, 0, 0}, {1, 1, 1}, 4, -1);
  const Sampled cube = sampled(mesh, 4096, 16);
  const auto f = dense(cube.exchange.factors);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_NEAR(f[i][j], i == j ? 0.0 : i / 2 == j / 2 ? 0.19982489569839 : 0.2000437760754, 3 * 0.0022 / 4);
}

TEST(Exchange, ASmallPatchIsNotSpoiledByTheFewRaysOfALargeOne) {
  // A plate of 1 dm2 that faces the middle of a square of 1 a, 1 m below: one ray of the square, if any, hits the
  // plate.
  Mesh mesh = test::empty_mesh();
  test::add_plate(mesh, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0});
  test::add_plate(mesh, {-0.05, -0.05, 1}, {0, 0.1, 0}, {0.1, 0, 0});
  for (const int rays_each : {64, 256, 1024}) {
    const Sampled made = sampled(mesh, rays_each);
    expect_reciprocal_and_closed(made.exchange);
    // A small plate above the middle of a rectangle (Howell, B-3), four times its corner.
    const double x = 5.0, root = std::sqrt(1 + x * x);
    const double factor = 4.0 / std::numbers::pi * x / root * std::atan(x / root);
    EXPECT_NEAR(dense(made.exchange.factors)[1][0], factor, 3 * 0.033 * std::sqrt(64.0 / rays_each) * 0.5);
  }
}

TEST(Exchange, FacetsInsideASolidExchangeNothing) {
  // Two boxes that overlap, on a ground: some facets of each are inside the other.
  Mesh mesh = test::empty_mesh();
  test::add_box(mesh, {0, 0, 0.5}, {2, 2, 2}, 5);
  test::add_box(mesh, {1.03, 0.97, 1.01}, {2, 2, 2}, 5);
  test::add_plate(mesh, {-3, -3, 0}, {8, 0, 0}, {0, 8, 0}, 8, 8);
  const Sampled made = sampled(mesh, 256);
  expect_reciprocal_and_closed(made.exchange);
  const auto f = dense(made.exchange.factors);
  int inside = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (f[i][i] < 1.0 - 1e-12) continue;
    ++inside;
    for (std::size_t j = 0; j < f.size(); ++j) EXPECT_NEAR(f[j][i], i == j ? 1.0 : 0.0, 1e-12);
  }
  EXPECT_GT(inside, 10);
  EXPECT_LT(made.exchange.change, 0.05);
}

TEST(Radiosity, IsThatOfADenseSolve) {
  for (const Sampled& made : {sampled(room(5), 256), sampled(yard(), 64)}) {
    const std::size_t n = made.exchange.patches();
    ASSERT_LE(n, 200U);
    test::Uniform random(8);
    std::vector<double> emitted(n), reflectance(n), outside(n);
    for (std::size_t i = 0; i < n; ++i) {
      emitted[i] = 500 * random();
      reflectance[i] = i % 5 == 0 ? 0.0 : 0.98 * random();
      outside[i] = 1000 * random();
    }
    // (1 - rho F) J = E + rho H0
    const auto f = dense(made.exchange.factors);
    auto matrix = f;
    std::vector<double> right(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) matrix[i][j] = (i == j ? 1.0 : 0.0) - reflectance[i] * f[i][j];
      right[i] = emitted[i] + reflectance[i] * outside[i];
    }
    const std::vector<double> truth = solved(matrix, right);
    const Radiosity got = radiosity(made.exchange, emitted, reflectance, outside);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(got.radiosity_w_m2[i], truth[i], 1e-12 * truth[i]);
      const double received = outside[i] + std::inner_product(f[i].begin(), f[i].end(), truth.begin(), 0.0);
      EXPECT_NEAR(got.irradiance_w_m2[i], received, 1e-12 * received);
    }
  }
}

/// Also where one moment is dark, and moments need different numbers of iterations.
TEST(Radiosity, OfManyMomentsIsThatOfEach) {
  const Sampled made = sampled(room(5), 256);
  const std::size_t n = made.exchange.patches(), columns = 19;
  test::Uniform random(9);
  std::vector<double> reflectance(n), emitted(n * columns), outside(n * columns);
  for (double& value : reflectance) value = 0.9 * random();
  for (std::size_t e = 0; e < n * columns; ++e) {
    if (e % columns == 4) continue;
    emitted[e] = e % columns == 7 ? 0.0 : 500 * random();
    outside[e] = e / columns == 2 ? 1000 * random() : 0.0;
  }
  const Radiosity all = radiosity(made.exchange, emitted, reflectance, outside, 1e-14, columns);
  for (std::size_t c = 0; c < columns; ++c) {
    std::vector<double> own_emitted(n), own_outside(n);
    for (std::size_t p = 0; p < n; ++p) {
      own_emitted[p] = emitted[p * columns + c];
      own_outside[p] = outside[p * columns + c];
    }
    const Radiosity one = radiosity(made.exchange, own_emitted, reflectance, own_outside);
    for (std::size_t p = 0; p < n; ++p) {
      EXPECT_NEAR(all.radiosity_w_m2[p * columns + c], one.radiosity_w_m2[p], 1e-12 * one.radiosity_w_m2[p]);
      EXPECT_NEAR(all.irradiance_w_m2[p * columns + c], one.irradiance_w_m2[p], 1e-12 * one.irradiance_w_m2[p]);
    }
    EXPECT_EQ(one.irradiance_w_m2[0] > 0.0, c != 4);
  }
}

TEST(Radiosity, OfTwoInfinitePlates) {
  Views seen{.rings = 1,
             .sky = {0, 0},
             .ground = {0, 0},
             .surfaces = {1, 1},
             .rays = {64, 64},
             .patches = {{0, 1, 2}, {1, 0}, {1, 1}}};
  const std::vector<double> area{1, 1};
  const std::vector<std::uint32_t> patch_of{0, 1};
  const Exchange exchange = exchange_of(seen, area, patch_of, 2);
  const auto emitted = [](double emissivity, double t) {
    return emissivity * kStefanBoltzmann_w_m2_k4 * std::pow(t, 4);
  };
  const Radiosity plates = radiosity(exchange, std::vector<double>{emitted(0.9, 400), emitted(0.3, 300)},
                                     std::vector<double>{0.1, 0.7}, std::vector<double>{0, 0});
  EXPECT_NEAR(plates.radiosity_w_m2[0] - plates.irradiance_w_m2[0], 288.091603546, 1e-10 * 288);
  EXPECT_NEAR(plates.radiosity_w_m2[1] - plates.irradiance_w_m2[1], -288.091603546, 1e-10 * 288);
}

TEST(Radiosity, AlmostMirrorsConverge) {
  const Sampled made = sampled(room(3), 256);
  const std::size_t n = made.exchange.patches();
  const double flux = kStefanBoltzmann_w_m2_k4 * std::pow(300.0, 4);
  const Radiosity got = radiosity(made.exchange, std::vector<double>(n, 1e-3 * flux), std::vector<double>(n, 0.999),
                                  std::vector<double>(n, 0.0));
  for (const double h : got.irradiance_w_m2) EXPECT_NEAR(h, flux, 1e-10 * flux);
  EXPECT_LT(got.iterations, 200);
}

/// Emitted flux and reflectance of receivers at one temperature, of emissivities that belong to their patches.
struct Isothermal {
  double flux = kStefanBoltzmann_w_m2_k4 * std::pow(300.0, 4);
  std::vector<double> emitted, reflectance;
  explicit Isothermal(const Exchange& exchange) {
    for (const std::uint32_t patch : exchange.patch_of) {
      const double emissivity = 0.05 + 0.95 * ((patch * 37) % 100) / 100.0;
      emitted.push_back(emissivity * flux);
      reflectance.push_back(1.0 - emissivity);
    }
  }
};

TEST(Irradiance, IsothermalEnclosureAndYard) {
  for (const Sampled& made :
       {sampled(room(4), 64), sampled(room(4), 32, 5), sampled(yard(), 64), sampled(yard(), 64, 6)}) {
    const Isothermal uniform(made.exchange);
    std::vector<double> environment, direct(made.area.size(), 0.0);
    for (std::size_t i = 0; i < made.area.size(); ++i)
      environment.push_back((made.seen.sky_share(i) + made.seen.ground[i]) * uniform.flux);
    const std::vector<double> h =
        irradiance_w_m2(made.exchange, {uniform.emitted, uniform.reflectance, environment, direct});
    for (const double value : h) EXPECT_NEAR(value, uniform.flux, 1e-12 * uniform.flux);
  }
}

TEST(Irradiance, AnEnclosureKeepsItsEnergy) {
  const Sampled made = sampled(room(6), 64, 4);
  const Isothermal uniform(made.exchange);
  test::Uniform random(6);
  std::vector<double> emitted = uniform.emitted, direct(made.area.size()), none(made.area.size(), 0.0);
  for (double& flux : emitted) flux *= 0.2 + random();
  for (double& flux : direct) flux = 900 * random();
  const std::vector<double> h = irradiance_w_m2(made.exchange, {emitted, uniform.reflectance, none, direct});
  double balance = 0.0, exchanged = 0.0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    balance += made.area[i] * ((1 - uniform.reflectance[i]) * h[i] - emitted[i] - direct[i]);
    exchanged += made.area[i] * h[i];
  }
  EXPECT_NEAR(balance, 0.0, 1e-12 * exchanged);
}

TEST(Irradiance, SunReachesWhatItDoesNotShineOnByReflection) {
  const Sampled made = sampled(yard(), 256);
  const std::size_t n = made.area.size();
  std::vector<double> none(n, 0.0), reflectance(n, 0.5), direct(n, 0.0);
  direct[100] = 800.0;
  const std::vector<double> h = irradiance_w_m2(made.exchange, {none, reflectance, none, direct});
  const auto f = dense(made.exchange.factors);
  for (std::size_t i = 0; i < n; ++i) EXPECT_GE(h[i], direct[i] + 0.5 * 800.0 * f[i][100] - 1e-9);
  EXPECT_LT(std::accumulate(h.begin(), h.end(), 0.0), 2.0 * 800.0);
}

TEST(Exchange, Refusals) {
  const Sampled made = sampled(room(1), 16);
  const std::size_t n = made.exchange.patches();
  const std::vector<double> none(n, 0.0), mirror(n, 1.0), few(2, 0.0);
  expect_refused({"patch 0 is 1"}, [&] { (void)radiosity(made.exchange, none, mirror, none); });
  expect_refused({"2 values"}, [&] { (void)radiosity(made.exchange, few, none, none); });
  std::vector<std::uint32_t> patch_of(n, 0);
  expect_refused({"patch 3", "receiver"}, [&] {
    std::vector<std::uint32_t> other = made.exchange.patch_of;
    other[3] = 2;
    (void)exchange_of(made.seen, made.area, other, n);
  });
  expect_refused({"patch 0 of 0"}, [&] { (void)exchange_of(made.seen, made.area, patch_of, 0); });
}

}  // namespace
}  // namespace radiometry::scene
