// SPDX-License-Identifier: Apache-2.0
// OTFs and their derivatives by every scalar against notebooks-data/reference/gradients.csv: 50-digit arithmetic from
// the definitions, at 0, at the cutoff, at bounds and branch switches. Where a derivative does not exist the row says
// which side is meant (`mean`: the value 0 at the tip of an even OTF).
#include <gtest/gtest.h>

#include <iostream>
#include <set>

#include "calib/fit/system_jet.h"
#include "tests/mtf/builders.h"
#include "tests/mtf/components/own_test.h"
#include "tests/mtf/conformance.h"
#include "tests/mtf/reference_table.h"

namespace calib {
namespace {

using mtf::Complex;
using mtf::Component;
using mtf::FieldRef;
using mtf::Freq;
using mtf::System;
using mtf::test::number;
using mtf::test::only_component;
using mtf::test::reference_table;
using mtf::test::Row;

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) all.push_back(part);
  return all;
}

double value_in(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

/// "number unit": the unit, nullptr for a plain number.
const mtf::Unit* unit_in(const std::string& text) {
  const auto space = text.find(' ');
  return space == std::string::npos ? nullptr : mtf::find_unit(text.substr(space + 1));
}

/// "f:value|f:value unit"
std::shared_ptr<const mtf::Curve> curve_in(const std::string& text) {
  std::vector<double> f, value;
  for (const std::string& sample : split(text.substr(0, text.find(' ')), '|')) {
    f.push_back(value_in(sample));
    value.push_back(value_in(sample.substr(sample.find(':') + 1)));
  }
  return std::make_shared<const mtf::Curve>(mtf::make_curve("table", *unit_in(text), f, value));
}

void set_field(Component<double>& component, const std::string& name, const std::string& text) {
  for (const FieldRef<double>& field : component.fields()) {
    const bool y = name == std::string(field.info->name) + "_y", x = name == std::string(field.info->name) + "_x";
    if (name != field.info->name && !x && !y) continue;
    std::visit(
        [&](auto* v) {
          using T = std::remove_pointer_t<decltype(v)>;
          if constexpr (std::is_same_v<T, mtf::AxisPair<double>>) {
            (y ? v->y : v->x) = mtf::Extent<double>{value_in(text), unit_in(text)};
            v->split = x || y;
          } else if constexpr (std::is_same_v<T, mtf::SpatialFrequency<double>>) {
            *v = mtf::SpatialFrequency<double>{value_in(text), unit_in(text)};
          } else if constexpr (std::is_same_v<T, int>) {
            *v = std::stoi(text);
          } else if constexpr (std::is_same_v<T, mtf::Choice>) {
            v->index = static_cast<int>(std::find(v->names.begin(), v->names.end(), text) - v->names.begin());
            ASSERT_LT(v->index, static_cast<int>(v->names.size())) << text;
          } else if constexpr (std::is_same_v<T, mtf::Taps<double>>) {
            for (const std::string& row : split(text, '/')) {
              v->emplace_back();
              for (const std::string& tap : split(row, '|')) v->back().push_back(value_in(tap));
            }
          } else if constexpr (std::is_same_v<T, mtf::Coefficients<double>>) {
            for (const std::string& coefficient : split(text, '|')) v->push_back(value_in(coefficient));
          } else if constexpr (std::is_same_v<T, mtf::CurveSum<double>>) {
            *v = curve_in(text);
          } else {
            *v = value_in(text);
          }
        },
        field.value);
    return;
  }
  FAIL() << component.kind() << " has no field " << name;
}

/// The scalars outside the component that a row may set or differentiate by.
template <class S>
std::vector<std::pair<std::string, S*>> surroundings(System<S>& system) {
  return {{"frame.focal_length", &system.frame.focal_length_mm},
          {"frame.pitch_x", &system.frame.pitch_x_um},
          {"frame.pitch_y", &system.frame.pitch_y_um},
          {"frame.integration_time", &system.frame.integration_time_s},
          {"optics.f_number", &*system.optics.f_number},
          {"optics.obscuration", &*system.optics.obscuration},
          {"optics.wavelength", &*system.optics.wavelength_um}};
}

System<double> system_of(const Row& row) {
  System<double> system;
  system.frame = {100.0, 17.0, 17.0, 0.01, 0, 0};
  system.optics.f_number = 2.0;
  system.optics.obscuration = 0.0;
  system.optics.wavelength_um = 4.0;
  auto component = Component<double>::make(row.at("kind"));
  for (const std::string& setting : split(row.at("settings"), ';')) {
    const std::string name = setting.substr(0, setting.find('=')), text = setting.substr(setting.find('=') + 1);
    if (name.find('.') == std::string::npos) set_field(component, name, text);
    for (const auto& [outside, value] : surroundings(system))
      if (outside == name) *value = value_in(text);
  }
  for (const mtf::Stage stage : mtf::kStages)
    if (component.stages().allows(stage)) {
      system.add(stage, component);
      break;
    }
  return system;
}

/// The scalar of that name; the n-th tap is taps[n].
Jet4* scalar_named(System<Jet4>& system, Freq<Jet4>& f, const std::string& name) {
  if (name == "fx") return &f.x;
  if (name == "fy") return &f.y;
  for (const auto& [outside, value] : surroundings(system))
    if (outside == name) return value;
  const auto bracket = name.find('[');
  int left = bracket == std::string::npos ? 0 : std::stoi(name.substr(bracket + 1));
  const std::string plain = bracket == std::string::npos ? name : name.substr(0, bracket) + "[]";
  for (const auto& scalar : mtf::test::scalars_of(only_component(system)))
    if (scalar.name == plain && left-- == 0) return scalar.value;
  return nullptr;
}

double distance(const Complex<double>& z, const Row& row, const std::string& re, const std::string& im) {
  return std::hypot(z.re - number(row, re), z.im - number(row, im));
}

TEST(Gradients, against_the_table) {
  std::map<std::string, double> worst;
  for (const Row& row : reference_table("gradients.csv")) {
    System<Jet4> system = mtf::cast<Jet4>(system_of(row));
    Freq<Jet4> f{Jet4(number(row, "fx_hex")), Jet4(number(row, "fy_hex"))};
    const std::string where = row.at("kind") + " " + row.at("settings") + " by " + row.at("parameter") + " at " +
                              row.at("fx_hex") + ", " + row.at("fy_hex");
    Jet4* const by = scalar_named(system, f, row.at("parameter"));
    ASSERT_NE(by, nullptr) << where;
    by->v[2] = 1.0;
    const Complex<Jet4> h = only_component(system).otf(f, system.context());
    const double size = std::hypot(number(row, "otf_re"), number(row, "otf_im"));
    EXPECT_LE(distance({h.re.a, h.im.a}, row, "otf_re", "otf_im"),
              8.0 * 0x1p-52 * std::max(1.0, size) + number(row, "otf_rounding"))
        << where;
    const double slope = std::hypot(number(row, "d_re"), number(row, "d_im"));
    const double scale = slope + number(row, "d_largest"), rounding = number(row, "d_rounding");
    const double error = distance({h.re.v[2], h.im.v[2]}, row, "d_re", "d_im");
    EXPECT_LE(error, 1e-9 * scale + rounding) << where << ", " << row.at("side") << ": " << h.re.v[2] << " "
                                              << h.im.v[2] << " against " << row.at("d_re") << " " << row.at("d_im");
    if (scale > 0.0) {
      double& largest = worst[row.at("kind")];
      largest = std::max(largest, std::max(0.0, error - rounding) / scale);
    }
  }
  for (const auto& [kind, error] : worst) std::cout << "gradient of " << kind << ": largest error " << error << "\n";
}

// Those without rows have a test of their own, and their slopes are held against differences in test_jet.cpp.
TEST(Gradients, every_kind_has_rows_or_a_test_of_its_own) {
  std::set<std::string> found;
  for (const Row& row : reference_table("gradients.csv")) found.insert(row.at("kind"));
  EXPECT_GE(found.size(), 35u);
  for (const std::string_view kind : mtf::component_kinds())
    EXPECT_TRUE(found.contains(std::string(kind)) || mtf::test::has_own_test(kind))
        << kind << ": write tests/mtf/components/test_" << kind
        << ".cpp, or add it to notebooks-data/reference/generators/gradient_kinds.py";
}

}  // namespace
}  // namespace calib
