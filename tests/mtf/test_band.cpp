// SPDX-License-Identifier: Apache-2.0
// Means over a band: the rules, and System::otf against values that mpmath computed to 18 digits from the areas of
// overlapping circles, split at the kinks and integrated by tanh-sinh quadrature.
#include <gtest/gtest.h>

#include <cmath>

#include "mtf/band.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/conformance.h"

namespace mtf::test {
namespace {

double integral(const WavelengthNodes& nodes, const auto& p) {
  double sum = 0.0;
  for (std::size_t i = 0; i < nodes.weight.size(); ++i) sum += nodes.weight[i] * p(nodes.wavelength_um[i]);
  return sum;
}

/// Straight lines through (8, 1), (9.1, 0.2), (10.4, 0.9), (12, 0.5), over their area 2.495.
Band with_rate() {
  const auto density = [](double l) {
    constexpr std::array x{8.0, 9.1, 10.4, 12.0}, y{1.0, 0.2, 0.9, 0.5};
    std::size_t i = 0;
    while (i + 2 < x.size() && l > x[i + 1]) ++i;
    return (y[i] + (y[i + 1] - y[i]) * (l - x[i]) / (x[i + 1] - x[i])) / 2.495;
  };
  return {8.0, 12.0, std::make_shared<const ElectronRate>(nullptr, density, std::vector{8.0, 9.1, 10.4, 12.0})};
}

System<double> pupil_in(const Band& band, double obscuration) {
  System<double> system = mwir();
  system.optics.wavelength_um.reset();
  system.optics.obscuration = obscuration;
  system.band = band;
  return system;
}

Averaged<double> diffraction(const System<double>& system, double f) {
  const Freq<double> at{0.6 * f, 0.8 * f};
  return system.otf_with_error(std::span(system.list(Stage::presample)).first(1), std::span(&at, 1));
}

TEST(Band, parts_end_at_the_kinks_within) {
  const std::array kinks{12.0, 9.0, 3.0, 8.0, 10.5, 9.0, 14.0};
  EXPECT_EQ(parts_of({8.0, 12.0}, kinks), (std::vector{8.0, 9.0, 10.5, 12.0}));
  EXPECT_EQ(parts_of({8.0, 12.0}, {}), (std::vector{8.0, 12.0}));
}

// The square root of the distance from either end, times a polynomial, is one of the angle.
TEST(Band, a_part_integrates_half_integer_powers_at_its_ends) {
  for (const Band& band : {Band{8.0, 12.0}, with_rate()}) {
    const double begin = 8.5, end = 11.25;
    const auto p = [&](double l) { return std::pow(l - begin, 1.5) * std::sqrt(end - l) * (1.0 + 0.3 * l); };
    const double fine = integral(part_nodes(band, begin, end, 400), p);
    for (const int n : {24, 48, 100}) EXPECT_NEAR(integral(part_nodes(band, begin, end, n), p), fine, 1e-13) << n;
  }
}

TEST(Band, weights_of_all_parts_sum_to_one) {
  for (const Band& band : {Band{8.0, 12.0}, with_rate()})
    for (const int n : {16, 64, 256}) {
      double sum = 0.0;
      const std::vector<double> ends = parts_of(band, std::array{8.0001, 9.1, 9.7, 11.999});
      for (std::size_t i = 0; i + 1 < ends.size(); ++i)
        sum += integral(part_nodes(band, ends[i], ends[i + 1], n), [](double) { return 1.0; });
      EXPECT_NEAR(sum, 1.0, 1e-14) << n;
    }
}

TEST(Band, average_of_a_pupil_is_known_to_1e_12) {
  struct Known {
    double f, obscuration, value;
  };
  for (const Known& k : std::initializer_list<Known>{{0.2, 0.0, 0.994907055945567025},
                                                     {10, 0.0, 0.747129402547329552},
                                                     {40, 0.0, 0.111582825398743742},
                                                     {61, 0.0, 0.0000875753864129263112},
                                                     {62.4, 0.0, 9.84792570599870937e-8},
                                                     {0.2, 0.3, 0.992724412719586798},
                                                     {10, 0.3, 0.645225259456781901},
                                                     {41.7, 0.3, 0.0973696651204090197},
                                                     {55, 0.3, 0.00590452326481129637},
                                                     {0.2, 0.9, 0.949070575149618419},
                                                     {10, 0.9, 0.0829235297938909505},
                                                     {50, 0.9, 0.0239701203014364272},
                                                     {61, 0.9, 0.000460923086383822691},
                                                     {0.2, 0.999, 0.0403891928915629608},
                                                     {10, 0.999, 0.000823095478556508273},
                                                     {41.7, 0.999, 0.000458323710290693874},
                                                     {55, 0.999, 0.000186435381963365062},
                                                     {54.166666666666664, 0.999, 0.000200836684027080934}}) {
    const Averaged<double> h = diffraction(pupil_in({8.0, 12.0}, k.obscuration), k.f);
    EXPECT_NEAR(h.value[0].re, k.value, 1e-12) << k.f << " " << k.obscuration;
    EXPECT_LE(h.error[0], kBandError) << k.f << " " << k.obscuration;
  }
  EXPECT_NEAR(diffraction(pupil_in({3.0, 5.0}, 0.97), 125.0).value[0].re, 0.00737457878462699941, 1e-12);
  EXPECT_NEAR(diffraction(pupil_in({3.0, 5.0}, 0.97), 110.0).value[0].re, 0.0103697737573846375, 1e-12);
  EXPECT_NEAR(diffraction(pupil_in({3.0, 12.0}, 0.0), 60.0).value[0].re, 0.135200064340889047, 1e-12);
  EXPECT_NEAR(diffraction(pupil_in({3.0, 12.0}, 0.0), 100.0).value[0].re, 0.0258029783605322225, 1e-12);
}

TEST(Band, average_weighs_by_the_electron_rate) {
  struct Known {
    double f, obscuration, value;
  };
  for (const Known& k : std::initializer_list<Known>{{60, 0.3, 0.000522607423963431231},
                                                     {30, 0.3, 0.281014721571141008},
                                                     {45, 0.6, 0.0712712525825854615},
                                                     {50, 0.0, 0.0211232045075010959},
                                                     {10, 0.0, 0.745722887637148801}}) {
    const Averaged<double> h = diffraction(pupil_in(with_rate(), k.obscuration), k.f);
    EXPECT_NEAR(h.value[0].re, k.value, 1e-12) << k.f << " " << k.obscuration;
    EXPECT_LE(h.error[0], kBandError) << k.f << " " << k.obscuration;
  }
}

// 1600 samples between which the rate is a straight line: against the plain sum over each of them.
TEST(Band, a_ragged_rate_of_many_samples_costs_no_accuracy) {
  std::vector<double> at, value;
  Random random(7);
  for (int i = 0; i <= 1600; ++i) at.push_back(8.0 + i / 400.0), value.push_back(random.uniform(0.0, 1.0));
  double area = 0.0;
  for (std::size_t i = 0; i < 1600; ++i) area += 0.5 * (value[i] + value[i + 1]) / 400.0;
  const auto density = [&](double l) {
    const double place = std::clamp((l - 8.0) * 400.0, 0.0, 1600.0);
    const std::size_t i = std::min<std::size_t>(1599, static_cast<std::size_t>(place));
    return (value[i] + (value[i + 1] - value[i]) * (place - static_cast<double>(i))) / area;
  };
  const Band band{8.0, 12.0, std::make_shared<const ElectronRate>(nullptr, density, at)};
  for (const double obscuration : {0.0, 0.3, 0.9})
    for (const double f : {3.0, 30.0, 45.0, 55.0, 61.0}) {
      const System<double> system = pupil_in(band, obscuration);
      const auto p = [&](double l) {
        return system.list(Stage::presample)[0].component.otf({0.6 * f, 0.8 * f}, system.context(l)).re;
      };
      double plain = 0.0;  // a kink lies in 3 of 1600 panels at most: split by hundreds of nodes
      for (std::size_t i = 0; i < 1600; ++i)
        plain += integral(part_nodes({at[i], at[i + 1]}, at[i], at[i + 1], 200),
                          [&](double l) { return density(l) * p(l); }) /
                 400.0;
      const Averaged<double> h = diffraction(system, f);
      EXPECT_NEAR(h.value[0].re, plain, 1e-10) << f << " " << obscuration;
      EXPECT_LE(h.error[0], kBandError) << f << " " << obscuration;
    }
}

// All electrons within 1e-9 um: the average is the value there, and 1 at zero frequency.
TEST(Band, a_rate_as_narrow_as_a_line_gives_the_value_of_its_wavelength) {
  const double middle = 10.0, half = 1e-9;
  const auto density = [=](double l) { return std::max(0.0, 1.0 - std::abs(l - middle) / half) / half; };
  const Band band{8.0, 12.0,
                  std::make_shared<const ElectronRate>(nullptr, density,
                                                       std::vector{8.0, middle - half, middle, middle + half, 12.0})};
  const System<double> system = pupil_in(band, 0.3);
  EXPECT_NEAR(diffraction(system, 0.0).value[0].re, 1.0, 1e-15);
  for (const double f : {5.0, 30.0, 40.0}) {
    const Complex<double> there =
        system.list(Stage::presample)[0].component.otf({0.6 * f, 0.8 * f}, system.context(middle));
    EXPECT_NEAR(diffraction(system, f).value[0].re, there.re, 1e-10) << f;
  }
}

// A ring of one millionth of the aperture: where 1e-12 cannot be had, what is reached is said.
TEST(Band, average_says_what_it_errs_by) {
  for (const auto& [f, value] : std::initializer_list<std::pair<double, double>>{{0.2, 0.0000403326784995814134},
                                                                                 {10, 8.2307809151943256e-7},
                                                                                 {41.7, 4.58643780068103805e-7},
                                                                                 {50, 2.75794168617770646e-7},
                                                                                 {61, 7.21781175651037533e-8}}) {
    const Averaged<double> h = diffraction(pupil_in({8.0, 12.0}, 0.999999), f);
    EXPECT_LE(std::abs(h.value[0].re - value), std::max(h.error[0], 1e-12)) << f;
    EXPECT_LE(h.error[0], 1e-9) << f;
  }
}

// What BandRule and BandMean rely on.
TEST(Band, kinks_of_chromatic_components_go_with_one_over_wavelength) {
  for (const Case& c : conformance_cases()) {
    const Component<double>& component = only_component(c.system);
    const std::vector<double> kinks = component.kinks_cy_mm(c.system.context(4.0));
    EXPECT_TRUE(std::is_sorted(kinks.begin(), kinks.end())) << c.name;
    if (!component.traits(c.system.context()).chromatic) continue;
    const std::vector<double> twice = component.kinks_cy_mm(c.system.context(8.0));
    ASSERT_EQ(kinks.size(), twice.size()) << c.name;
    for (std::size_t i = 0; i < kinks.size(); ++i) EXPECT_NEAR(twice[i] / kinks[i], 0.5, 1e-12) << c.name;
    if (const double cutoff = component.cutoff_cy_mm(c.system.context(4.0)); std::isfinite(cutoff)) {
      EXPECT_EQ(kinks.back(), cutoff) << c.name;
    }
  }
}

}  // namespace
}  // namespace mtf::test
