// SPDX-License-Identifier: Apache-2.0
// No jumps: along every line the change of an OTF is the integral of its slope, down to neighbouring doubles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>

#include "calib/fit/system_jet.h"
#include "tests/expect_error.h"
#include "tests/mtf/conformance.h"

namespace calib {
namespace {

using mtf::Complex;
using mtf::System;
using mtf::test::Case;
using mtf::test::conformance_cases;
using mtf::test::only_component;
using mtf::test::scalars_of;

constexpr double kUlp = std::numeric_limits<double>::epsilon();

struct Sample {
  double t = 0.0;
  Complex<double> value, slope;
  double condition = 0.0;  ///< what a relative change of t, or of fx and fy each, does to the value
};
using Line = std::function<Sample(double)>;

double norm(const Complex<double>& z) { return std::hypot(z.re, z.im); }
Complex<double> sum(double a, const Complex<double>& x, const Complex<double>& y) {
  return {a * x.re + y.re, a * x.im + y.im};
}

/// A relative condition from which on a rounding of t is a turn of its own, and no change of the value means anything.
constexpr double kLost = 0.01 / kUlp;

// Compares the change of the value over an interval with Simpson's rule for the analytic slope, and halves the interval
// until they agree or its ends are neighbouring doubles: there a change beyond the slope is a jump. Kinks and sharp
// bends only take more halvings. Where the OTF turns too fast to be followed everywhere, or the budget is spent, the
// search continues in the half that agrees less.
// Allowed beyond the slope: 16 ulp of `scale`, and the conditioning of t itself, 8 ulp of t x the steepest slope
// nearby.
class JumpSearch {
 public:
  JumpSearch(const Line& line, double scale) : line_(line), scale_(scale) {}

  /// "" or a description of the jump.
  std::string between(const Sample& a, const Sample& b) {
    budget_ = 300;
    condition_ = 0.0;
    found_.clear();
    search(a, b);
    return found_;
  }

 private:
  void see(const Sample& s) { condition_ = std::max(condition_, s.condition); }
  double noise() const { return kUlp * (16.0 * scale_ + 8.0 * condition_); }

  void search(const Sample& a, const Sample& b) {
    see(a), see(b);
    if (!(condition_ < kLost)) return;
    const double width = b.t - a.t, t = a.t + 0.5 * width;
    const Complex<double> change = sum(-1.0, a.value, b.value);
    if (t == a.t || t == b.t) {
      const double allowed = 2.0 * width * std::max(norm(a.slope), norm(b.slope)) + noise();
      if (!(norm(change) <= allowed) && !scatters(a.t, norm(change)) && found_.empty())
        found_ = "jump of " + mtf::format_double(norm(change) / kUlp) + " ulp at " + mtf::format_double(a.t) + ", " +
                 mtf::format_double(allowed / kUlp) + " allowed";
      return;
    }
    const Sample m = line_(t);
    see(m);
    const Complex<double> slopes = sum(4.0, m.slope, sum(1.0, a.slope, b.slope));
    if (norm(sum(-width / 6.0, slopes, change)) <= 0.5 * noise()) return;
    const double turn = width * std::max({norm(a.slope), norm(m.slope), norm(b.slope)});
    if (--budget_ > 0 && turn < 4.0 * scale_) {
      search(a, m);
      search(m, b);
      return;
    }
    const auto disagreement = [](const Sample& p, const Sample& q) {
      return norm(sum(-0.5 * (q.t - p.t), sum(1.0, p.slope, q.slope), sum(-1.0, p.value, q.value)));
    };
    if (disagreement(a, m) > disagreement(m, b))
      search(a, m);
    else
      search(m, b);
  }

  /// The values next to t alternate by `change`, and the conditioning of t is as large as that. This holds also where
  /// the doubles are so sparse that the phase of an oscillation takes whole half turns alone: the slope vanishes there,
  /// and the values may keep their side for hundreds of doubles; the slopes at smaller t tell.
  bool scatters(double t, double change) const {
    double variation = 0.0, conditioning = 0.0, u = t;
    Complex<double> last = line_(u).value;
    for (int i = 0; i < 512; ++i) {
      u = std::nextafter(u, 0.0);
      const Complex<double> next = line_(u).value;
      variation += norm(sum(-1.0, last, next));
      last = next;
    }
    for (int k = 1; k <= 45; ++k)
      for (const double near : {t - std::ldexp(t, -k), t * std::pow(0.618, k)})
        conditioning = std::max(conditioning, line_(near).condition * t / near);
    return conditioning >= kLost || (variation >= 4.0 * change && 8.0 * kUlp * conditioning >= change);
  }

  const Line& line_;
  double scale_, condition_ = 0.0;
  int budget_ = 0;
  std::string found_;
};

/// Goes through increasing positions; "" or the first jump.
std::string first_jump(const Line& line, double scale, const std::vector<double>& positions) {
  JumpSearch search(line, scale);
  Sample last = line(positions.front());
  for (const double t : positions) {
    const Sample next = line(t);
    if (!std::isfinite(norm(next.value)) || std::isnan(norm(next.slope)))
      return "not finite at " + mtf::format_double(t);
    if (std::string jump = search.between(last, next); !jump.empty()) return jump;
    last = next;
  }
  return "";
}

/// Series and quadratures: what they promise beyond rounding, as their headers state it. Others round at their own
/// scale.
double stated_error(const Case& c) {
  System<double> system = c.system;
  const std::string_view kind = only_component(system).kind();
  if (kind == "vibration") return 1e-14;
  if (kind == "turbulence") return 2e-13;  // the integral over the path, to some 1e-14, times the exponent
  if (kind != "wavefront" && kind != "defocus") return 0.0;
  double obscuration = *system.optics.obscuration;
  for (const auto& scalar : scalars_of(only_component(system)))
    if (scalar.name == "obscuration") obscuration = *scalar.value;
  const double ring = (1.0 - obscuration) * (1.0 + obscuration);
  return kind == "wavefront" ? 2e-13 / ring : 1e-14 / ring;
}

/// The size of what is rounded: 16 ulp of it are allowed.
double rounding_scale(const Case& c) {
  const mtf::Context<double> ctx = c.system.context();
  const mtf::Component<double>& component = only_component(c.system);
  const double gain = component.traits(ctx).gain ? 1.0 + component.deviation(1e300, 1e300, ctx) : 1.0;
  return std::max(gain, stated_error(c) / (16.0 * kUlp));
}

TEST(Stability, search_finds_a_jump_of_1e12_and_passes_a_kink) {
  const auto line = [](double jump, double kink) {
    return [=](double t) {
      const double side = t < 0.3183 ? 0.0 : 1.0;
      const double slope = kink * side - std::sin(t);
      return Sample{
          t, {std::cos(t) + jump * side + kink * side * (t - 0.3183), 0.0}, {slope, 0.0}, std::abs(t * slope)};
    };
  };
  const std::vector<double> positions{0.0, 0.25, 0.5, 1.0, 2.0};
  EXPECT_EQ(first_jump(line(0.0, 0.0), 1.0, positions), "");
  EXPECT_EQ(first_jump(line(0.0, 0.7), 1.0, positions), "");
  for (const double jump : {1e-12, -1e-9, 1e-3, 0.5})
    EXPECT_TRUE(says(first_jump(line(jump, 0.0), 1.0, positions), "at 0.318")) << jump;
  EXPECT_NE(first_jump(line(1e-12, 0.7), 1.0, positions), "");
}

/// 0, the smallest double, every decade to 1e300, every tenth in between where components live, and both sides of the
/// cutoff ever closer.
std::vector<double> frequencies(double cutoff) {
  std::vector<double> all{0.0, 5e-324};
  for (int decade = -320; decade <= 300; decade += 5) all.push_back(std::pow(10.0, decade));
  for (double f = 1e-12; f < 1e12; f *= 1.1) all.push_back(f);
  if (std::isfinite(cutoff))
    for (int k = 1; k <= 52; ++k)
      for (const double side : {-1.0, 1.0}) all.push_back(cutoff * (1.0 + side * std::ldexp(1.0, -k)));
  std::sort(all.begin(), all.end());
  return all;
}

/// Nothing can be asked of a pupil that is all but closed (the promise ends at 0.999), nor of a wavefront of 1e6 waves,
/// whose factor climbs back to 1 at the cutoff within one ulp, nor of a mask whose teeth are narrower than the doubles
/// are apart at high frequencies.
bool is_degenerate(const Case& c) {
  System<double> system = c.system;
  for (const auto& scalar : scalars_of(only_component(system))) {
    if (scalar.name == "obscuration" && *scalar.value > 0.999999) return true;
    if (scalar.name == "wavelength_reference" && only_component(system).kind() == "rms_wavefront" &&
        *scalar.value > 1e3)
      return true;
    if (scalar.name == "sigma" && only_component(system).kind() == "unsharp" && *scalar.value > 100.0) return true;
  }
  return false;
}

/// A veil of scattered light and AC coupling keep the mean alone: a step beside f = 0, as their headers say.
bool steps_at_zero(const Case& c) {
  const std::string_view kind = only_component(c.system).kind();
  return kind == "aerosol" || kind == "rc_highpass";
}

/// Samples of a PSF say nothing from half a cycle a sample on: a step there, as their header says.
bool ends_in_a_step(const Case& c) { return only_component(c.system).kind() == "psf"; }

/// The cases of one part: of each kind at most 16, spread over its combinations of fields and its draws.
std::vector<const Case*> cases_of(int part, int parts) {
  std::map<std::string_view, std::vector<const Case*>> groups;
  for (const Case& c : conformance_cases())
    if (!is_degenerate(c) && !ends_in_a_step(c) && (c.typical || !only_component(c.system).is_slow()))
      groups[only_component(c.system).kind()].push_back(&c);
  std::vector<const Case*> all;
  int index = 0;
  for (const auto& [kind, group] : groups) {
    // Quadrature takes microseconds a value, and the scan some thousands of values a line.
    const bool slow = only_component(group.front()->system).is_slow();
    const std::size_t count = std::min<std::size_t>(group.size(), slow ? 6 : 32);
    for (std::size_t i = 0; i < count; ++i)
      if (i % 2 == 0 && index++ % parts == part) all.push_back(group[i * group.size() / count]);
  }
  return all;
}

constexpr int kParts = 8;

void expect_no_jump_along_frequency(int part) {
  for (const Case* each : cases_of(part, kParts)) {
    const Case& c = *each;
    const System<Jet4> jets = mtf::cast<Jet4>(c.system);
    const mtf::Component<Jet4>& component = only_component(jets);
    const mtf::Context<Jet4> ctx = jets.context();
    auto positions = frequencies(component.cutoff_cy_mm(ctx));
    if (steps_at_zero(c)) std::erase_if(positions, [](double f) { return f < 1e-300; });
    const double angle = mtf::test::Random(c.name).uniform(0.0, 2.0 * std::numbers::pi);
    for (const mtf::Freq<double>& d : {mtf::Freq<double>{1.0, 0.0}, {0.0, -1.0}, {std::cos(angle), std::sin(angle)}}) {
      const Line line = [&](double t) {
        mtf::Freq<Jet4> f{Jet4(t * d.x), Jet4(t * d.y)};
        f.x.v[1] = 1.0;
        f.y.v[2] = 1.0;
        const Complex<Jet4> h = component.otf(f, ctx);
        const Complex<double> by_x{h.re.v[1], h.im.v[1]}, by_y{h.re.v[2], h.im.v[2]};
        return Sample{t,
                      {h.re.a, h.im.a},
                      sum(d.x, by_x, sum(d.y, by_y, {})),
                      t * (std::abs(d.x) * norm(by_x) + std::abs(d.y) * norm(by_y))};
      };
      EXPECT_EQ(first_jump(line, rounding_scale(c), positions), "") << c.name << " along " << d.x << ", " << d.y;
    }
  }
}

/// Bounds of a parameter and the decades between them, from one end as far as check() accepts it.
std::vector<double> values_of(const Case& c, std::size_t index) {
  System<double> system = c.system;
  const auto scalar = scalars_of(only_component(system))[index];
  const mtf::FieldInfo& info = *scalar.info;
  const double lo = info.lo_open ? std::nextafter(info.lo, info.hi) : info.lo,
               hi = scalar.name == "obscuration" ? 0.999
                    : info.hi_open               ? std::nextafter(info.hi, info.lo)
                                                 : info.hi;
  std::vector<double> all{lo, hi, *scalar.value};
  for (double distance = 1e-18; distance < 2e9; distance *= 1.25)
    for (const double v : {info.lo + distance, info.hi - distance, distance, -distance})
      if (v > lo && v < hi) all.push_back(v);
  std::sort(all.begin(), all.end());
  std::erase_if(all, [&](double v) {
    *scalar.value = v;
    const auto problems = only_component(system).check(system.context());
    return std::any_of(problems.begin(), problems.end(), [](const mtf::Problem& p) { return p.error; });
  });
  return all;
}

void expect_no_jump_along_any_parameter(int part) {
  int lines = 0;
  for (const Case* each : cases_of(part, kParts)) {
    const Case& c = *each;
    if (!c.typical) continue;
    System<Jet4> jets = mtf::cast<Jet4>(c.system);
    const mtf::Context<Jet4> ctx = jets.context();
    const auto scalars = scalars_of(only_component(jets));
    for (std::size_t i = 0; i < scalars.size(); ++i) {
      const auto positions = values_of(c, i);
      const Jet4 own = *scalars[i].value;
      for (const mtf::Freq<double>& f : {mtf::Freq<double>{5.0, 3.0}, {-21.7, 4.4}, {0.0, 47.0}}) {
        const Line line = [&](double t) {
          *scalars[i].value = Jet4(t, 1);
          const Complex<Jet4> h = only_component(jets).otf({Jet4(f.x), Jet4(f.y)}, ctx);
          const Complex<double> slope{h.re.v[1], h.im.v[1]};
          return Sample{t, {h.re.a, h.im.a}, slope, std::abs(t) * norm(slope)};
        };
        Case widest = c;  // the line may go there, and an allowance is for the whole of it
        *scalars_of(only_component(widest.system))[i].value = positions.back();
        const double scale = std::max(rounding_scale(c), rounding_scale(widest));
        EXPECT_EQ(first_jump(line, scale, positions), "")
            << c.name << " along " << scalars[i].name << " at " << f.x << ", " << f.y;
        ++lines;
      }
      *scalars[i].value = own;
    }
  }
  EXPECT_GE(lines, 30);
}

/// Each part has cases of every kind; one goes with the suite, the others with the long tests.
class StabilityPart : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Each, StabilityPart, testing::Values(0));
TEST_P(StabilityPart, no_jump_along_frequency) { expect_no_jump_along_frequency(GetParam()); }
TEST_P(StabilityPart, no_jump_along_any_parameter) { expect_no_jump_along_any_parameter(GetParam()); }

class StabilityPartLong : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Each, StabilityPartLong, testing::Values(1, 2, 3, 4, 5, 6, 7));
TEST_P(StabilityPartLong, no_jump_along_frequency) { expect_no_jump_along_frequency(GetParam()); }
TEST_P(StabilityPartLong, no_jump_along_any_parameter) { expect_no_jump_along_any_parameter(GetParam()); }

}  // namespace
}  // namespace calib
