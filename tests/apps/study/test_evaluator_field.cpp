// SPDX-License-Identifier: Apache-2.0

// Metrics over the image of a lens that changes over the field: their mean and their worst, against curves of the OTF
// at each place.

#include <gtest/gtest.h>

#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_chain.h"
#include "mtf/field/image_places.h"
#include "tests/apps/study/evaluated.h"
#include "tests/expect_error.h"
#include "tests/replaced.h"

namespace {

using study_test::Evaluated;
using study_test::evaluated;
using study_test::Folder;

/// The camera with astigmatism and coma that grow to the corners, which turn with the field point.
std::string lens(const std::string& terms) {
  return replaced(study_test::kCamera, "zernike = [0.0, 0.0, 0.0, 0.05]", terms);
}
const std::string kTerms =
    "wavelength = \"0.57 um\"\norientation = \"field\"\nw222 = { r2 = 0.5 }\nw131 = { r = 0.4 }\nw020 = { 1 = 0.1, x = "
    "0.1 }";

std::string study_of(const std::string& axis, const std::string& metrics) {
  return "schema = 1\nsensor = \"camera.toml\"\ntolerance = 1e-9\n" + axis + "[metrics]\nlist = [" + metrics + "]\n";
}
const std::string kPitches = "[[axis]]\nparameter = \"frame.pitch\"\nfrom = \"6 um\"\nto = \"10 um\"\ncount = 3\n";

/// The MTF at Nyquist along a direction, or MTF50, on the axis and over the image.
struct OverImage {
  double axis = 0.0, mean = 0.0, every_other = 0.0, worst = 1.0;
};
OverImage over_image(const mtf::System<double>& system, double angle_deg, bool mtf50) {
  const apps::Direction direction = apps::make_direction(system.frame, "cy/px", angle_deg);
  const auto value = [&](const mtf::FieldPoint<double>& q) {
    const mtf::System<double> here = apps::system_at(system, q);
    if (mtf50) return apps::mtf50(here, apps::otf_curves(here, {}, direction)).value();
    const auto h = apps::otf_curves(here, {0.5}, direction).system.otf.front();
    return std::hypot(h.re, h.im);
  };
  OverImage all{.axis = value({})};
  for (const mtf::ImagePlace& place : mtf::image_places(system.frame.columns, system.frame.rows)) {
    const double here = value(system.field_point(place.x_px, place.y_px));
    all.mean += place.weight * here;
    all.every_other += place.every_other * here;
    all.worst = std::min(all.worst, here);
  }
  return all;
}

TEST(EvaluatorField, MeanAndWorstAreThoseOfThePlaces) {
  const Folder folder;
  folder.write("camera.toml", lens(kTerms));
  Evaluated e = evaluated(folder, study_of(kPitches, R"("mtf_nyquist_x", "mtf_nyquist_x.axis", "mtf_nyquist_x.mean",
    "mtf_nyquist_x.worst", "mtf50_y.worst", "fwhm_x.worst", "fwhm_x")"));
  for (const std::int64_t design : {0, 2}) {
    e.at(design);
    std::vector<double> axes(1);
    study::design_at(*e.study, design, axes);
    const mtf::io::SensorConfig config = e.evaluator->sensor_at(axes);
    ASSERT_FALSE(config.system.is_isoplanatic());
    const mtf::System<double> system = apps::with_electron_rate(config.system, apps::load_chain(config));
    const OverImage x = over_image(system, 0.0, false);
    EXPECT_NEAR(e["mtf_nyquist_x"], x.axis, 1e-8);
    EXPECT_EQ(e["mtf_nyquist_x.axis"], e["mtf_nyquist_x"]);
    EXPECT_NEAR(e["mtf_nyquist_x.mean"], x.mean, 1e-8);
    EXPECT_NEAR(e["mtf_nyquist_x.worst"], x.worst, 1e-8);
    EXPECT_NEAR(e["mtf50_y.worst"], over_image(system, 90.0, true).worst, 1e-4);
    EXPECT_GT(e["fwhm_x.worst"], 1.01 * e["fwhm_x"]);  // the widest
    EXPECT_LT(e["mtf_nyquist_x.worst"], e["mtf_nyquist_x.mean"]);
    EXPECT_GE(e["error"], std::abs(x.mean - x.every_other) - 1e-8);
  }
  const std::vector<std::string> said = e.evaluator->skipped();
  EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const std::string& one) {
    return one.find("without .mean or .worst are those of the optical axis") != std::string::npos;
  }));
}

TEST(EvaluatorField, DerivativesGoOverTheImage) {
  const Folder folder;
  folder.write("camera.toml", lens(kTerms));
  study_test::expect_gradient(
      folder, study_of(kPitches, R"("mtf_nyquist_x.mean", "mtf_nyquist_y.worst", "rer_x.mean")"), 1, 1e-5);
  // The worst alone follows its place.
  study_test::expect_gradient(folder, study_of(kPitches, R"("mtf_nyquist_y.worst", "fwhm_x.worst")"), 1, 1e-5);
}

// An axis may be a term, whose values are those of files with them.
TEST(EvaluatorField, TermsAreParameters) {
  const Folder folder;
  folder.write("camera.toml", lens(kTerms));
  const std::string terms = "[[axis]]\nparameter = \"wavefront.w131.r\"\nfrom = 0.2\nto = 0.6\ncount = 3\n";
  Evaluated e = evaluated(folder, study_of(terms, R"("mtf_nyquist_x", "mtf_nyquist_x.worst")"));
  double before = 1.0;
  for (const auto& [design, text] :
       {std::pair{std::int64_t{0}, "{ r = 0.2 }"}, std::pair{std::int64_t{2}, "{ r = 0.6 }"}}) {
    e.at(design);
    const auto result =
        mtf::io::parse_config(replaced(lens(kTerms), "{ r = 0.4 }", text), "s.toml", apps::sensor_schema());
    const mtf::System<double> system = apps::with_electron_rate(result.config.system, apps::load_chain(result.config));
    EXPECT_NEAR(e["mtf_nyquist_x.worst"], over_image(system, 0.0, false).worst, 1e-8);
    EXPECT_NEAR(e["mtf_nyquist_x"], over_image(system, 0.0, false).axis, 1e-8);
    EXPECT_GT(std::abs(e["mtf_nyquist_x.worst"] - before), 1e-3);
    before = e["mtf_nyquist_x.worst"];
  }
  EXPECT_TRUE(says(folder.lines(study_of(replaced(terms, "w131.r", "wavelength.r2"), R"("rer")")), "no such term"));
}

// What does not change is the same everywhere, to the bit and at no cost.
TEST(EvaluatorField, WithoutTermsAllPlacesAreOne) {
  const Folder folder;
  Evaluated e = evaluated(folder, study_of(kPitches, R"("rer", "rer.mean", "rer.worst")"));
  e.at(1);
  EXPECT_EQ(e["rer.mean"], e["rer"]);
  EXPECT_EQ(e["rer.worst"], e["rer"]);
}

TEST(EvaluatorField, Refusals) {
  const Folder folder;
  EXPECT_TRUE(says(folder.lines(study_of(kPitches, R"("netd.worst")")), "netd is that of the optical axis"));
  EXPECT_TRUE(says(folder.lines(study_of(kPitches, R"("ifov.worst")")), "ifov is the same all over the image"));
  EXPECT_TRUE(says(folder.lines(study_of(kPitches, R"("rer.best")")), "axis, mean or worst"));
  folder.write("camera.toml", replaced(lens(kTerms), "format = [640, 512]\n", ""));
  Evaluated e = evaluated(folder, study_of(kPitches, R"("rer.worst", "rer")"));
  EXPECT_TRUE(says(e.evaluator->gaps().at(1), "no [frame] format"));
}

}  // namespace
