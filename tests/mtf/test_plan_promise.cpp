// SPDX-License-Identifier: Apache-2.0
// The promise, at random: realised rms error <= predicted <= tolerance, or a refusal that names a tolerance that works.
#include <algorithm>
#include <cstdio>
#include <random>

#include "tests/expect_error.h"
#include "tests/mtf/plan_support.h"

namespace mtf::test {
namespace {

struct Draw {
  std::mt19937 generator;
  explicit Draw(unsigned seed) : generator(seed) {}
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator); }
  double decades(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
  int below(int n) { return static_cast<int>(generator() % static_cast<unsigned>(n)); }
};

System<double> random_system(Draw& draw) {
  System<double> s = bare(15.0, draw.below(2) == 0 ? 15.0 : 11.0);
  const int count = 1 + draw.below(5);
  bool pupil = false;
  for (int i = 0; i < count; ++i) switch (draw.below(8)) {
      case 0:
        if (pupil) break;
        pupil = true;
        s.optics.f_number = draw.decades(0.8, 20.0);
        if (draw.below(3) == 0) s.optics.obscuration = 0.35;
        s.add(Stage::presample, Component<double>::make("diffraction"));
        break;
      case 1:
        s.add(Stage::presample, test::gaussian(draw.decades(0.01, 30.0)));
        break;
      case 2:
        s.add(Stage::presample, footprint(draw.decades(0.1, 15.0)));
        break;
      case 3:
        s.add(Stage::presample, jitter(draw.decades(0.01, 30.0)));
        break;
      case 4:
        s.add(Stage::presample, motion(draw.decades(0.05, 40.0), 15.0 * draw.below(24)));
        break;
      case 5:
        s.add(Stage::presample, rc(draw.decades(5.0, 1e5), draw.below(2)));
        break;
      case 6: {
        auto wavefront = Component<double>::make("rms_wavefront");
        set(wavefront, "rms", draw.decades(1e-4, 0.1));
        s.add(Stage::presample, wavefront);
        break;
      }
      default: {
        auto filter = Component<double>::make("butterworth");
        set(filter, "cutoff", draw.decades(10.0, 500.0), "cy/mm");
        set(filter, "poles", 1 + draw.below(5));
        choose(filter, "axis", draw.below(2));
        s.add(Stage::presample, filter);
      }
    }
  return s;
}

Image random_scene(Draw& draw, std::int64_t width, std::int64_t height) {
  const double mean = draw.below(3) == 0 ? draw.decades(1.0, 1e4) : 0.0;
  const auto w = static_cast<double>(width), h = static_cast<double>(height);
  const double a = draw.uniform(-1.0, 1.0), b = draw.uniform(-1.0, 1.0), c = draw.uniform(-0.3, 0.3);
  const auto px = static_cast<std::int64_t>(draw.uniform(0, w)), py = static_cast<std::int64_t>(draw.uniform(0, h));
  switch (draw.below(5)) {
    case 0:
      return random_image(width, height, static_cast<unsigned>(draw.generator()), mean, draw.decades(0.1, 10.0));
    case 1:
      return image_of(width, height, [&](auto x, auto y) {
        const auto u = static_cast<double>(x) / w - 0.5, v = static_cast<double>(y) / h - 0.5;
        return mean + (a * u + b * v + 0.3 * c > 0.0 ? 1.0 : 0.0);
      });
    case 2:
      return image_of(width, height, [&](auto x, auto y) { return mean + (x == px && y == py ? 5.0 : 0.0); });
    case 3:
      return image_of(width, height, [&](auto x, auto y) {
        return mean + a * static_cast<double>(x) / w + b * static_cast<double>(y) / h;
      });
    default: {  // a bright edge column and corner: the border repeats what is rare in the image
      return image_of(width, height,
                      [&](auto x, auto y) { return mean + (x == 0 ? 3.0 : 0.0) + (x + y == 0 ? 9 : 0); });
    }
  }
}

struct Tally {
  int kept = 0, refused = 0, shortened = 0;
  std::vector<double> slack;       // predicted / realised
  std::vector<double> arithmetic;  // the same where rounding makes up nearly all of the prediction
};

// Compiles for this scene; a refused tolerance is replaced by the one that the refusal names. Nothing when that is 1
// or more: then there is no tolerance to keep.
std::optional<Plan> compile_or_named(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                                     PlanOptions& options, Tally& tally) {
  try {
    return compile(system, in, out, options);
  } catch (const UsageError& refusal) {
    ++tally.refused;
    const double named = named_tolerance(refusal.what());
    if (named < 0.0) {
      EXPECT_TRUE(says(std::string(refusal.what()), "no tolerance")) << refusal.what();
      return std::nullopt;
    }
    EXPECT_GT(named, options.tolerance) << refusal.what();
    options.tolerance = named;
    try {
      return compile(system, in, out, options);
    } catch (const UsageError& again) {
      ADD_FAILURE() << "the named tolerance is refused: " << refusal.what() << " -> " << again.what();
      return std::nullopt;
    }
  }
}

void check_case(unsigned seed, int largest, Tally& tally) {
  Draw draw(seed);
  const System<double> system = [&] {
    System<double> s = random_system(draw);
    if (draw.below(4) == 0) s.frame.columns = 1 + draw.below(6), s.frame.rows = 1 + draw.below(6);
    return s;
  }();
  const auto side = [&] { return std::int64_t{1} + static_cast<std::int64_t>(draw.below(largest)); };
  const std::int64_t width = side(), height = side();
  constexpr std::array whole{1.0, 2.0, 3.0, 4.0};
  const auto ratio = [&](std::int64_t n) {
    const double r = draw.below(2) == 0 ? whole[static_cast<std::size_t>(draw.below(4))] : draw.uniform(0.7, 6.0);
    return std::min(r, static_cast<double>(n));
  };
  const double ratio_x = ratio(width), ratio_y = ratio(height);
  const SampleGrid in = scene_grid(system, width, height, ratio_x, ratio_y);
  const SampleGrid out = detector_grid(system, in);
  const Border border = kBorders[static_cast<std::size_t>(draw.below(4))];
  const Image scene = random_scene(draw, width, height);
  const Statistics s = statistics(scene.view());
  const double border_value = draw.below(3) == 0 ? s.mean + draw.uniform(-100.0, 100.0) : s.mean;
  PlanOptions options = options_for(scene, border, draw.decades(1e-6, 1e-1), border_value);
  if (!options.scene) return;
  const std::optional<Plan> plan = compile_or_named(system, in, out, options, tally);
  if (!plan) return;
  const auto expected = reference_image(scene, in, out, otf_of(system, Stage::presample), border, border_value);
  const double rms = rms_distance(run(*plan, scene, border_value), expected) / options.scene->std;
  const double predicted = plan->report().predicted.total();
  EXPECT_LE(rms, predicted) << "seed " << seed << " border " << kBorderNames[static_cast<std::size_t>(border)]
                            << " ratios " << ratio_x << ", " << ratio_y << " norm "
                            << options.scene->canvas_norm / options.scene->std << " rms/predicted " << rms / predicted
                            << "\n"
                            << plan->explain();
  EXPECT_LE(predicted, options.tolerance) << "seed " << seed;
  ++tally.kept;
  if (plan->report().predicted.wrap > 0.0) ++tally.shortened;
  if (rms == 0.0) return;
  tally.slack.push_back(predicted / rms);
  if (plan->report().predicted.arithmetic > 0.9 * predicted) tally.arithmetic.push_back(predicted / rms);
}

void sweep(unsigned first, int cases, int largest) {
  Tally tally;
  for (int i = 0; i < cases; ++i) check_case(first + static_cast<unsigned>(i), largest, tally);
  ASSERT_GT(tally.kept, cases / 2);
  const auto print = [](const char* what, std::vector<double>& ratios) {
    std::sort(ratios.begin(), ratios.end());
    const auto quantile = [&](double q) {
      return ratios[static_cast<std::size_t>(q * static_cast<double>(ratios.size() - 1))];
    };
    std::printf("  predicted / realised, %s: %zu cases, least %.2f, median %.1f, 95%% %.0f\n", what, ratios.size(),
                quantile(0.0), quantile(0.5), quantile(0.95));
    return quantile(0.5);
  };
  std::printf("%d plans kept their promise, %d tolerances refused at first, %d canvases shortened\n", tally.kept,
              tally.refused, tally.shortened);
  print("all", tally.slack);
  EXPECT_LT(print("rounding only", tally.arithmetic), 30.0) << "the rounding model is far too loose";
}

TEST(PlanPromise, holds_for_random_systems_scenes_and_tolerances) { sweep(1000, 400, 48); }

TEST(PlanPromiseLong, holds_for_random_systems_scenes_and_tolerances) { sweep(100000, 5000, 100); }

}  // namespace
}  // namespace mtf::test
