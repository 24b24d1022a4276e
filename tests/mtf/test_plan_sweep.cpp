// SPDX-License-Identifier: Apache-2.0
// The promise over random work, with every method that a plan offers: realised rms error <= promised <= tolerance, or a
// refusal that names a tolerance which works. The reference is the exact OTF on the defined canvas, in double.
//
// MTFKIT_SWEEP_FIRST and MTFKIT_SWEEP_CASES choose other seeds than a test's own: a failure prints its seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>

#include "apps/check/reference_fft.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "tests/mtf/sweep_cases.h"

namespace mtf::test {
namespace {

const std::string kAsSimulate = "as simulate";
constexpr double kLoosestMedian = 30.0;
constexpr int kEnoughCases = 20;  // for a median to mean something
constexpr int kForcedEvery = 4;   // of so many cases, one insists on every possible method

/// promised / realised of every plan that ran, by name of the group.
class Tightness {
 public:
  void add(const std::string& group, double ratio) { ratios_[group].push_back(ratio); }
  double median(const std::string& group) { return quantile(ratios_[group], 0.5); }
  void print() {
    std::printf("  %-32s %7s %8s %8s %8s\n", "promised / realised", "plans", "least", "median", "95 %");
    for (auto& [group, ratios] : ratios_)
      std::printf("  %-32s %7zu %8.2f %8.1f %8.3g\n", group.c_str(), ratios.size(), quantile(ratios, 0.0),
                  quantile(ratios, 0.5), quantile(ratios, 0.95));
  }

 private:
  static double quantile(std::vector<double>& ratios, double q) {
    if (ratios.empty()) return 0.0;
    std::sort(ratios.begin(), ratios.end());
    return ratios[static_cast<std::size_t>(q * static_cast<double>(ratios.size() - 1))];
  }
  std::map<std::string, std::vector<double>> ratios_;
};

class Sweep {
 public:
  explicit Sweep(std::vector<Photograph> photographs) : photographs_(std::move(photographs)) {}

  void run(std::uint64_t first, int cases, const SweepLimits& limits) {
    flat_parts_ = limits.flat_parts;
    if (const char* other = std::getenv("MTFKIT_SWEEP_FIRST")) first = std::strtoull(other, nullptr, 10);
    if (const char* other = std::getenv("MTFKIT_SWEEP_CASES")) cases = std::atoi(other);
    for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(cases); ++seed) {
      const SweepCase c = sweep_case(seed, limits, photographs_);
      SCOPED_TRACE(c.describe());
      try {
        check(c);
      } catch (const std::exception& e) {
        ADD_FAILURE() << e.what();
      }
    }
    report();
  }

 private:
  void check(const SweepCase& c) {
    ++cases_;
    PlanOptions options = c.options();
    if (!options.scene) {
      ++flat_;
      return check_flat(c, options);
    }
    const std::vector<double> expected = reference(c);
    // What `mtf simulate` gives its plan, and what somebody has who knows only mean and contrast of the scene.
    const auto spectrum = scene_spectrum(c.scene.view(), c.border, 1);
    for (const bool with_spectrum : {true, false}) {
      if (!with_spectrum && !spectrum) continue;  // borders that have none
      options = c.options();
      if (with_spectrum) options.spectrum = spectrum;
      const std::optional<Plan> plan = compile_or_named(c, options);
      if (!plan) continue;
      const std::string what = with_spectrum ? kAsSimulate : "summary only";
      if (with_spectrum) ++chosen_[plan->report().method];
      check_plan(c, *plan, expected, options, {"all, " + what, plan->report().method + ", " + what});
      if (c.seed % kForcedEvery != 0) continue;
      for (const Candidate& candidate : plan->report().candidates) {
        if (!candidate.possible || kMethodNames[static_cast<std::size_t>(candidate.method)] == plan->report().method)
          continue;
        options.method = candidate.method;
        check_plan(c, c.compile_with(options), expected, options,
                   {std::string(kMethodNames[static_cast<std::size_t>(candidate.method)]) + ", insisted on"});
      }
    }
  }

  // With frequencies times `stretch`.
  static std::vector<double> reference(const SweepCase& c, double stretch = 1.0) {
    const apps::check::OtfColumn exact = apps::check::exact_otf(c.system, c.stages, c.aperture, c.in);
    const apps::check::OtfColumn otf = [&](double fx, std::span<const double> fy, std::span<std::complex<double>> h) {
      std::vector<double> stretched(fy.begin(), fy.end());
      for (double& f : stretched) f *= stretch;
      exact(fx * stretch, stretched, h);
    };
    return apps::check::reference_image_fft(c.scene.view(), c.in, c.out, otf, c.border, c.border_value, 1);
  }

  // What the last bit of the frequencies is worth: blurs of 1e12 cycles a band have no OTF that double could tell.
  static double conditioning(const SweepCase& c, const std::vector<double>& expected) {
    const std::vector<double> other = reference(c, 1.0 + 0x1p-52);
    double squares = 0.0;
    for (std::size_t i = 0; i < other.size(); ++i) squares += std::pow(other[i] - expected[i], 2);
    return std::sqrt(squares / static_cast<double>(other.size()));
  }

  static void check_flat(const SweepCase& c, const PlanOptions& options) {
    if (c.border == Border::constant) return;  // its value adds contrast
    const Plan plan = c.compile_with(options);
    Image out(c.out.width, c.out.height);
    plan.run(c.scene.view(), out.view(), c.border_value, 1);
    EXPECT_EQ(out.at(0, 0), static_cast<float>(plan.dc() * static_cast<double>(c.scene.at(0, 0))));
  }

  // A refused tolerance is replaced by the one that the refusal names; nothing where none below 1 can be kept.
  std::optional<Plan> compile_or_named(const SweepCase& c, PlanOptions& options) {
    try {
      return c.compile_with(options);
    } catch (const UnreachableTolerance& refusal) {
      ++refused_;
      if (!(refusal.reachable() < 1.0)) {
        ++unreachable_;
        return std::nullopt;
      }
      EXPECT_GT(refusal.reachable(), options.tolerance);
      options.tolerance = refusal.reachable();
    }
    try {
      return c.compile_with(options);
    } catch (const UnreachableTolerance& again) {
      ADD_FAILURE() << "the named tolerance is refused: " << again.what();
      return std::nullopt;
    }
  }

  void check_plan(const SweepCase& c, const Plan& plan, const std::vector<double>& expected, const PlanOptions& options,
                  const std::vector<std::string>& groups) {
    Image out(c.out.width, c.out.height);
    plan.run(c.scene.view(), out.view(), c.border_value, 1);
    double squares = 0.0;
    for (std::int64_t i = 0; i < out.size(); ++i)
      squares += std::pow(out.data()[i] - expected[static_cast<std::size_t>(i)], 2);
    const double rms = std::sqrt(squares / static_cast<double>(out.size())) / options.scene->std;
    const double promised = plan.report().predicted.total();
    double reference_rounding = 1e-14 * options.scene->largest / options.scene->std;
    if (rms > promised + reference_rounding) {
      const double rounding = 4.0 * conditioning(c, expected) / options.scene->std;
      if (rounding > 0.5 * rms) ++ill_conditioned_;
      reference_rounding += rounding;
    }
    EXPECT_LE(rms, promised + reference_rounding)
        << (options.spectrum ? "with spectrum\n" : "without spectrum\n") << plan.explain();
    EXPECT_LE(promised, options.tolerance) << plan.explain();
    ++plans_;
    for (const std::string& group : groups)
      if (rms > reference_rounding) tightness_.add(group, promised / rms);
  }

  void report() {
    std::printf("%d cases, %d plans run; %d scenes flat; %d tolerances refused, %d of them with none below 1\n", cases_,
                plans_, flat_, refused_, unreachable_);
    if (ill_conditioned_ > 0)
      std::printf("%d plans of OTFs that the last bit of the frequency decides\n", ill_conditioned_);
    for (const auto& [method, count] : chosen_) std::printf("  chosen: %-15s %d\n", method.c_str(), count);
    tightness_.print();
    if (cases_ < kEnoughCases) return;
    EXPECT_GT(plans_, cases_ - cases_ / 4);
    // Light in flat rows is given a share of the tolerance whether it needs it or not.
    if (flat_parts_) return;
    EXPECT_LE(tightness_.median("all, " + kAsSimulate), kLoosestMedian);
  }

  std::vector<Photograph> photographs_;
  bool flat_parts_ = false;
  int cases_ = 0, plans_ = 0, ill_conditioned_ = 0, flat_ = 0, refused_ = 0, unreachable_ = 0;
  std::map<std::string, int> chosen_;
  Tightness tightness_;
};

constexpr SweepLimits kShort{16, 160}, kLong{16, 700}, kShortFlat{16, 160, true}, kLongFlat{16, 700, true};

TEST(PlanSweep, made_scenes) { Sweep({}).run(1, 40, kShort); }
// A corner of 101 x 433 samples beside a bright line: rounding of FFTW's prime lengths concentrates there.
TEST(PlanSweep, prime_lengths) { Sweep({}).run(910'186, 1, kLong); }
// An OTF of frequencies far below an eighth of Nyquist alone, and 0 at 0.
TEST(PlanSweep, narrow_low_pass) { Sweep({}).run(910'928, 1, kLong); }
// Two images 1e9 pixels apart, a whole number of the canvases by which the padding is judged.
TEST(PlanSweep, two_images_far_apart) { Sweep({}).run(930'331, 1, kLong); }
// Samples of 1789 um x 3.2e-5 um: the mean over the band of a defocus of 1e6 waves ends far below the corner.
TEST(PlanSweepLong, mean_over_the_band_of_a_narrow_otf) { Sweep({}).run(920'103, 1, kLong); }
TEST(PlanSweepLong, made_scenes) { Sweep({}).run(10'000, 1500, kLong); }

TEST(PlanSweep, flat_parts) { Sweep({}).run(1, 30, kShortFlat); }
TEST(PlanSweepLong, flat_parts) { Sweep({}).run(30'000, 500, kLongFlat); }

void photographed(std::uint64_t first, int cases, const SweepLimits& limits) {
  std::vector<Photograph> images = photographs();
  if (images.empty()) GTEST_SKIP() << "no shared data";
  Sweep(std::move(images)).run(first, cases, limits);
}

TEST(PlanSweep, photographs) { photographed(1, 20, kShort); }
TEST(PlanSweepLong, photographs) { photographed(20'000, 700, kLong); }

}  // namespace
}  // namespace mtf::test
