// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "mtf/components/accelerated_motion.h"
#include "mtf/components/bolometer.h"
#include "mtf/components/defocus.h"
#include "mtf/components/diffraction.h"
#include "mtf/components/eye.h"
#include "mtf/components/footprint.h"
#include "mtf/components/image_intensifier.h"
#include "mtf/components/jitter.h"
#include "mtf/components/lowpass.h"
#include "mtf/components/turbulence.h"
#include "mtf/components/vibration.h"
#include "mtf/error.h"
#include "mtf/from_quantities.h"
#include "mtf/literals.h"
#include "mtf/otf/same_list.h"
#include "mtf/plan/sensor_plan.h"
#include "tests/expect_error.h"
#include "tests/mtf/builders.h"

namespace mtf::test {
namespace {

using namespace mtf::literals;

/// Looks like a component, and is not in the list.
template <class S>
struct Unlisted {
  static constexpr std::string_view kind = "unlisted";
  S value{};
  static constexpr auto fields() { return std::tuple{Field{&Unlisted::value, FieldInfo{.name = "value"}}}; }
};

TEST(TypedComponent, system_equals_the_one_made_by_names) {
  System<double> system;
  system.frame = make_frame({.focal_length = 100_mm, .pitch = 15_um, .integration_time = 10_ms});
  system.optics = make_optics({.f_number = 2.0, .wavelength = 4_um});
  system.add(Stage::presample, Diffraction<double>{});
  system.add(Stage::presample, Footprint<double>{.width = 15_um});
  system.add(Stage::presample, Jitter<double>{.rms = 2_um});
  EXPECT_TRUE(same_list(system, mwir(), Stage::presample));
  EXPECT_EQ(system.list(Stage::presample)[2].label, "jitter");
  EXPECT_TRUE(system.check().empty());
  for (const Freq<double> f : {Freq<double>{0.0, 0.0}, {33.3, 0.0}, {10.0, -60.0}})
    EXPECT_EQ(system.otf(f).re, mwir().otf(f).re);
}

TEST(TypedComponent, numbers_are_held_in_the_unit_of_their_name) {
  const auto number = [](Component<double> component, std::string_view name) {
    const FieldRef<double> found = field(component, name);
    const auto* optional = std::get_if<std::optional<double>*>(&found.value);
    return optional != nullptr ? (*optional)->value() : *std::get<double*>(found.value);
  };
  EXPECT_EQ(number(Defocus<double>{.distance_um = 0.03_mm}, "distance"), 30.0);
  EXPECT_EQ(number(Defocus<double>{.waves = 0.5, .wavelength_reference_um = 633_nm}, "wavelength_reference"), 0.633);
  EXPECT_EQ(number(Turbulence<double>{.fried_parameter_mm = 0.05_m}, "fried_parameter"), 50.0);
  EXPECT_EQ(number(Turbulence<double>{.path_length_m = 4_km}, "path_length"), 4000.0);
  EXPECT_EQ(number(Bolometer<double>{.time_constant_s = 12_ms}, "time_constant"), 0.012);
  EXPECT_EQ(number(AcceleratedMotion<double>{.velocity_um_s = 2_mm / 1_s}, "velocity"), 2000.0);
  EXPECT_EQ(number(Eye<double>{}, "luminance"), 100.0);
  EXPECT_EQ(number(Butterworth<double>{{.cutoff = 400_kHz, .pixel_clock_hz = 10_MHz}, 3}, "pixel_clock"), 1e7);
  for (int direction = -360; direction <= 360; ++direction)
    EXPECT_EQ(number(Vibration<double>{.amplitude = 2_px, .direction_deg = degrees(direction)}, "direction"),
              direction);
}

TEST(TypedComponent, can_be_had_back_as_its_type) {
  Component<double> component = Jitter<double>{.rms = 20_urad};
  ASSERT_NE(component.get_if<Jitter<double>>(), nullptr);
  EXPECT_EQ(component.get_if<Jitter<double>>()->rms.x.value, 20.0);
  EXPECT_EQ(component.get_if<Footprint<double>>(), nullptr);
  EXPECT_EQ(Component<double>::make("vibration").get_if<Jitter<double>>(), nullptr);
  const Component<double> copy = component;
  set(component, "rms", 5.0, "um");
  EXPECT_EQ(component.get_if<Jitter<double>>()->rms.x.value, 5.0);
  EXPECT_EQ(copy.get_if<Jitter<double>>()->rms.x.value, 20.0);
  component = Footprint<double>{.fill_factor = 0.9};
  EXPECT_EQ(component.kind(), "footprint");
  EXPECT_EQ(component.get_if<Footprint<double>>()->fill_factor, 0.9);
}

TEST(TypedComponent, other_scalars) {
  const Component<float> component = Jitter<float>{.rms = 20_urad};
  EXPECT_EQ(component.get_if<Jitter<float>>()->rms.x.value, 20.0F);
}

TEST(TypedComponent, type_that_is_not_in_the_list_is_refused) {
  System<double> system;
  EXPECT_THROW(system.add(Stage::presample, Unlisted<double>{}), UsageError);
  EXPECT_EQ(Component<double>(Jitter<double>{}).get_if<Unlisted<double>>(), nullptr);
}

// Only electronics, which have a scan, may say their frequency in time.
TEST(TypedComponent, a_temporal_frequency_where_a_spatial_one_is_meant_is_refused) {
  System<double> system = mwir();
  system.add(Stage::presample, ImageIntensifier<double>{.frequency = kilohertz(3)});
  expect_refused({"presample[3].frequency", "kHz", "a spatial frequency"}, [&] {
    static_cast<void>(compile_sensor(system, SampleGrid{32, 32, 15.0, 15.0}, PlanOptions{}));
  });
}

TEST(TypedComponent, choices_by_their_words) {
  EXPECT_EQ(choice_of(kAxisNames, "y").index, 1);
  EXPECT_EQ(axis_of(choice_of(kAxisNames, "x")), Axis::x);
  expect_refused({"\"z\"", "x, y"}, [] { choice_of(kAxisNames, "z"); });
}

}  // namespace
}  // namespace mtf::test
