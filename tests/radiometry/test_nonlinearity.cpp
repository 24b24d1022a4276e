// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "radiometry/stages/detector/nonlinearity.h"
#include "tests/expect_error.h"
#include "tests/radiometry/frames.h"

namespace radiometry {
namespace {

TEST(Nonlinearity, polynomial_and_its_inverse) {
  for (const double well : {1.0, 3e4, 1e12})
    for (const Nonlinearity& shape :
         {Nonlinearity{-0.05, 0.0}, Nonlinearity{0.1, -0.2}, Nonlinearity{-1.0, 0.5}, Nonlinearity{10.0, 10.0},
          Nonlinearity{-1.0, 1.0, -0.2}, Nonlinearity{.a4 = -0.02}}) {
      const Response response(shape, well);
      double before = -1.0;
      for (int i = 0; i <= 1000; ++i) {
        const double u = i / 1000.0,
                     expected = well * (u + shape.a2 * u * u + shape.a3 * u * u * u + shape.a4 * u * u * u * u);
        EXPECT_NEAR(response(u * well), expected, 1e-14 * well);
        EXPECT_GT(response(u * well), before);
        EXPECT_NEAR(response.inverse(response(u * well)), u * well, 1e-13 * well);
        before = response(u * well);
      }
    }
}

// Without a3 the inverse is the root of a quadratic: u = 2 v / (1 + sqrt(1 + 4 a2 v)).
TEST(Nonlinearity, inverse_in_closed_form) {
  for (const double a2 : {-0.2, -0.01, 0.03, 2.0}) {
    const Response response({.a2 = a2}, 1000.0);
    for (const double v : {1e-9, 0.1, 0.5, 0.79})
      EXPECT_NEAR(response.inverse(1000.0 * v) / (2000.0 * v / (1.0 + std::sqrt(1.0 + 4.0 * a2 * v))), 1.0, 1e-14);
  }
}

TEST(Nonlinearity, beyond_the_ends_and_on_frames) {
  const Response response({.a2 = -0.1}, 1000.0);
  EXPECT_EQ(response(-50.0), -50.0);
  EXPECT_EQ(response.inverse(-50.0), -50.0);
  EXPECT_NEAR(response(1000.0), 900.0, 1e-12);
  EXPECT_NEAR(response(1500.0), 900.0 + 500.0 * 0.8, 1e-12);  // along the last slope
  EXPECT_NEAR(response.inverse(1300.0), 1500.0, 1e-12);
  mtf::Image image(5, 1);
  const float values[] = {-3.0F, 250.0F, 2000.0F, std::numeric_limits<float>::infinity(), std::nanf("")};
  std::copy_n(values, 5, image.data());
  apply_response(image.view(), response, 2);
  EXPECT_FLOAT_EQ(image.at(1, 0), 250.0F * (1.0F - 0.025F));
  EXPECT_EQ(image.at(3, 0), std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(image.at(4, 0)));
  linearise(image.view(), response, 2);
  for (int i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(image.at(i, 0), values[i]);
  EXPECT_TRUE(std::isnan(image.at(4, 0)));
  const Response none({}, 1e5);
  for (const double e : {0.0, 1e-3, 7.0, 1e5, 1e9}) EXPECT_EQ(none(e), e);
}

TEST(Nonlinearity, refusals) {
  expect_refused({"a2 = -0.5", "does not rise"}, [] { Response({.a2 = -0.5}, 1e5); });
  // Falls in between only: 1 - 4 u + 3.6 u^2 is -0.11 at 0.56 and 0.6 at 1.
  expect_refused({"a2 = -2", "does not rise"}, [] { Response({.a2 = -2.0, .a3 = 1.2}, 1e5); });
  // 1 - 6 u + 9 u^2 - 3.6 u^3 is -0.2 at 0.5, and above 0 at both ends.
  expect_refused({"a4 = -0.9", "does not rise"}, [] { Response({.a2 = -3.0, .a3 = 3.0, .a4 = -0.9}, 1e5); });
  expect_refused({"nonlinearity.a2 = 11"}, [] { Response({.a2 = 11.0}, 1e5); });
  expect_refused({"full well of inf"}, [] { Response({}, INFINITY); });
  expect_refused({"full well of 0"}, [] { Response({}, 0.0); });
}

}  // namespace
}  // namespace radiometry
