// SPDX-License-Identifier: Apache-2.0
#include "mtf/plan/field_tiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "mtf/engines/kept_plane.h"
#include "mtf/engines/mean_and_deviation.h"
#include "mtf/parallel.h"
#include "mtf/plan/padding.h"
#include "mtf/plan/plan_parts.h"
#include "mtf/words.h"

namespace mtf {
namespace {

constexpr std::array<std::int64_t, 3> kTileSides{FieldTiles::kLeastSide, 256, 512};  // pixels, about
constexpr std::size_t kMostTileModes = 40;
constexpr std::array kHaloShares{0.15, 0.3, 0.5};  // of what modes and halos may err by
constexpr std::int64_t kTailLength = 512;          // samples
constexpr std::int64_t kLeastHalo = 8;             // samples
constexpr double kOtfNoise = 1.2e-7;               // of a kernel, four times the rms rounding of an OTF value
constexpr std::array kFiner{PitchRatio{5, 4}, PitchRatio{3, 2}, PitchRatio{2, 1}};
// Of the cost of a transform there and back, where there is known; and where several samples make a pixel.
constexpr double kAgain = 0.6, kAgainOfMany = 0.4, kMany = 1.5;
constexpr double kWeightMs = 1.3e-6;  // for a pixel and mode

double in_double(std::int64_t n) { return static_cast<double>(n); }

PitchRatio finer_ratio(PitchRatio ratio, PitchRatio finer) {
  const std::int64_t p = ratio.samples * finer.samples, q = ratio.pixels * finer.pixels, common = std::gcd(p, q);
  return {p / common, q / common};
}

/// Samples that tiles may read: the scene's, or finer ones.
struct FineScene {
  SampleGrid grid;
  PitchRatio x, y;
  std::optional<Plan> finer = {};
  bool interpolated() const { return finer.has_value(); }
};

std::vector<FineScene> fine_scenes(const FieldTilesTask& task) {
  const SampleGrid &in = task.in, &out = task.out;
  const auto x = pitch_ratio(out.step_x_um, in.step_x_um), y = pitch_ratio(out.step_y_um, in.step_y_um);
  const auto smooth = [](const PitchRatio& r) { return is_smooth(r.samples) && is_smooth(r.pixels); };
  if (!x || !y || !smooth(*x) || !smooth(*y)) return {};
  std::vector<FineScene> list{{in, *x, *y, {}}};
  if (task.options.border != Border::reflect && task.options.border != Border::periodic) return list;
  const auto whole = std::find_if(kFiner.begin(), kFiner.end(), [&](const PitchRatio& finer) {
    return in.width % finer.pixels == 0 && in.height % finer.pixels == 0;
  });
  const double ratio = in_double(whole->samples) / in_double(whole->pixels);
  const SampleGrid grid{in.width / whole->pixels * whole->samples, in.height / whole->pixels * whole->samples,
                        in.step_x_um / ratio, in.step_y_um / ratio};
  list.push_back({grid, finer_ratio(*x, *whole), finer_ratio(*y, *whole), task.interpolate(grid)});
  return list;
}

/// The OTFs of the modes of the image on such samples, and their kernels along x and y.
struct FineOtfs {
  std::vector<std::shared_ptr<const FactoredOtf>> otfs;
  std::array<std::vector<SectionKernels>, 2> kernels;
};

FineOtfs fine_otfs(const FieldTilesTask& task, const FineScene& scene) {
  constexpr std::array stages{Stage::presample};
  const double fx = 500.0 / scene.grid.step_x_um, fy = 500.0 / scene.grid.step_y_um;
  Taper taper;
  if (scene.interpolated()) {
    taper.from_cy_mm = {500.0 / task.in.step_x_um, 500.0 / task.in.step_y_um};
    taper.to_cy_mm = {FieldTiles::kReach * taper.from_cy_mm[0], FieldTiles::kReach * taper.from_cy_mm[1]};
    taper.sharpness = std::log(30.0 / task.options.tolerance);
  }
  FineOtfs fine;
  for (std::size_t m = 1; m <= task.field.count(); ++m)
    fine.otfs.push_back(std::make_shared<FactoredOtf>(task.axis, stages, task.options.aperture,
                                                      SamplerOptions{.fx_max = fx,
                                                                     .fy_max = fy,
                                                                     .table_share = kTableShare * task.allowed,
                                                                     .samples = 160000,
                                                                     .threads = task.options.threads,
                                                                     .taper = taper,
                                                                     .given = task.field.factor(m),
                                                                     .progress = task.options.progress},
                                                      m > 1 ? fine.otfs.front().get() : nullptr));
  for (const auto& otf : fine.otfs)
    for (const bool x : {true, false})
      fine.kernels[x ? 0 : 1].emplace_back(*otf,
                                           CanvasRequest{.axis = x ? Axis::x : Axis::y,
                                                         .border = Border::periodic,
                                                         .samples = kTailLength,
                                                         .step_um = x ? scene.grid.step_x_um : scene.grid.step_y_um,
                                                         .other_nyquist_cy_mm = x ? fy : fx,
                                                         .pitch_um = x ? task.out.step_x_um : task.out.step_y_um},
                                           kTailLength);
  return fine;
}

/// The image cut into tiles of about one side, each with the modes that it takes.
struct CutImage {
  std::int64_t width = 0, height = 0;  ///< of a tile
  std::vector<TileModes> tiles = {};
  std::vector<double> amount = {};  ///< of each mode of the image, the largest of all tiles
  double halo_allowed = 0.0;
  double error = 0.0, gain = 0.0;  ///< gain: bound of the sum of the moduli of a tile's modes
  std::size_t modes = 0;           ///< of all tiles
};

std::optional<CutImage> cut_image(const FieldTilesTask& task, std::int64_t side, std::int64_t multiple_x,
                                  std::int64_t multiple_y, double allowed) {
  const auto length = [side](std::int64_t pixels, std::int64_t multiple) {
    const std::int64_t tiles = std::max<std::int64_t>(1, (pixels + side / 2) / side),
                       each = (pixels + tiles - 1) / tiles;
    return (each + multiple - 1) / multiple * multiple;
  };
  const SampleGrid& out = task.out;
  CutImage best{.width = length(out.width, multiple_x), .height = length(out.height, multiple_y)};
  std::vector<Region> regions;
  for (std::int64_t y = 0; y < out.height; y += best.height)
    for (std::int64_t x = 0; x < out.width; x += best.width)
      regions.push_back({x, y, std::min(best.width, out.width - x), std::min(best.height, out.height - y)});
  for (const FieldModes::Measure& measure : task.field.measures()) {
    std::vector<std::optional<TileModes>> tiles(regions.size());
    parallel_for_each(std::ssize(regions), 1, task.options.threads, [&](std::int64_t i) {
      const auto k = static_cast<std::size_t>(i);
      tiles[k] = tile_modes(task.field, measure, regions[k], allowed, kMostTileModes);
    });
    if (!std::all_of(tiles.begin(), tiles.end(), [](const auto& tile) { return tile.has_value(); })) continue;
    std::size_t modes = 0;
    for (const auto& tile : tiles) modes += tile->count;
    if (!best.tiles.empty() && modes >= best.modes) continue;
    best.modes = modes;
    best.tiles.clear();
    for (auto& tile : tiles) best.tiles.push_back(std::move(*tile));
  }
  if (best.tiles.empty()) return std::nullopt;
  best.amount.assign(task.field.count(), 0.0);
  for (const TileModes& tile : best.tiles) {
    best.error = std::max(best.error, tile.error);
    double gain = 0.0;
    for (std::size_t m = 0; m < best.amount.size(); ++m) {
      best.amount[m] = std::max(best.amount[m], tile.amount[m]);
      for (std::size_t k = 0; k < tile.count; ++k)
        gain += std::abs(tile.mix[k * best.amount.size() + m]) * task.field.factor(m + 1)->largest;
    }
    best.gain = std::max(best.gain, gain);
  }
  return best;
}

/// How often the periods of all tiles hold a sample of the scene at most, each place of a mirrored or repeated scene
/// counted as the sample that stands there, those of other canvases as they are.
std::int64_t most_reads(const FieldTileAxis& axis, Border border, std::int64_t samples) {
  const bool images = border == Border::reflect || border == Border::periodic;
  const std::int64_t canvas = canvas_length(border, samples);
  std::vector<std::int64_t> reads(static_cast<std::size_t>(canvas), 0);
  for (std::int64_t i = 0; i < axis.count; ++i)
    for (std::int64_t k = 0; k < axis.job.samples; ++k) {
      const std::int64_t at = axis.sample(i, k);
      ++reads[static_cast<std::size_t>(images ? border_source(border, at, samples) : (at % canvas + canvas) % canvas)];
    }
  return *std::max_element(reads.begin(), reads.end());
}

/// How far the kernels of the modes of a tile reach, along x or y; the largest of all tiles. Nothing where a halo of
/// the most samples would not leave out little enough.
std::optional<std::vector<double>> reach_of(const FieldTilesTask& task, const FineOtfs& fine, const CutImage& cut,
                                            bool along_x, double allowed) {
  const std::vector<SectionKernels>& kernels = fine.kernels[along_x ? 0 : 1];
  const auto of_tile = [&](std::size_t t) {
    std::vector<double> sum(static_cast<std::size_t>(kTailLength / 2 + 1), 0.0);
    for (std::size_t k = 0; k < cut.tiles[t].count; ++k) {
      const std::span<const double> mix = std::span(cut.tiles[t].mix).subspan(k * kernels.size(), kernels.size());
      double gain = 0.0;
      for (std::size_t m = 0; m < mix.size(); ++m) gain = std::max(gain, std::abs(mix[m]) * fine.otfs[m]->gain());
      const std::vector<double> tails =
          tails_of_sum(kernels, mix, kOtfNoise * gain / std::sqrt(in_double(kTailLength)));
      std::transform(sum.begin(), sum.end(), tails.begin(), sum.begin(), std::plus());
    }
    return sum;
  };
  std::vector<std::vector<double>> tiles(cut.tiles.size());
  tiles[0] = of_tile(0);
  if (tiles[0].back() > allowed) return std::nullopt;
  parallel_for(std::ssize(tiles) - 1, 1, task.options.threads, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t)
      tiles[t + 1] = of_tile(t + 1);
  });
  for (const std::vector<double>& tile : tiles)
    std::transform(tile.begin(), tile.end(), tiles[0].begin(), tiles[0].begin(),
                   [](double p, double q) { return std::max(p, q); });
  return tiles[0];
}

/// Tiles of one cut on such samples, with a halo of so many samples or somewhat more.
FieldTileAxis tile_axis_with(const FieldTilesTask& task, const FineScene& scene, const CutImage& cut, bool x,
                             std::int64_t halo) {
  FieldTileAxis tiles{.ratio = x ? scene.x : scene.y, .tile = x ? cut.width : cut.height};
  tiles.count = ((x ? task.out.width : task.out.height) + tiles.tile - 1) / tiles.tile;
  const auto [p, q] = tiles.ratio;
  std::int64_t length = 0, pixels = tiles.tile;
  do {
    pixels += q;
    length = pixels / q * p;
  } while (length - tiles.tile_samples() < 2 * halo || !is_smooth(pixels) || !is_smooth(length));
  tiles.halo = (length - tiles.tile_samples()) / 2;
  tiles.job.frequency = {Basis::fourier, length, x ? scene.grid.step_x_um : scene.grid.step_y_um};
  tiles.job.border = Border::periodic;
  tiles.job.samples = length;
  tiles.job.outputs = tiles.tile;
  tiles.job.pitch_um = x ? task.out.step_x_um : task.out.step_y_um;
  tiles.job.resampling = Resampling::fold;
  tiles.job.out_length = pixels;
  tiles.job.keep = tiles.job.frequency.half_count();
  return tiles;
}

double tiles_cost_ms(const CutImage& cut, const FieldTileAxis& x, const FieldTileAxis& y) {
  const double once = fft_cost_ms(x.job, y.job, Parities(false, false, false));
  const double again = in_double(x.ratio.samples) > kMany * in_double(x.ratio.pixels) ? kAgainOfMany : kAgain;
  double ms = 0.0;
  for (const TileModes& tile : cut.tiles)
    if (tile.count > 0)
      ms += once * (1.0 + again * in_double(static_cast<std::int64_t>(tile.count) - 1)) +
            kWeightMs * in_double(cut.width * cut.height) * in_double(static_cast<std::int64_t>(tile.count));
  return ms;
}

double interpolation_ms(const FineScene& scene) {
  if (scene.interpolated())
    for (const Candidate& way : scene.finer->report().candidates)
      if (way.reason.empty()) return way.cost_ms;
  return 0.0;
}

double least_cost_ms(const FieldTilesTask& task, const FineScene& scene, const CutImage& cut, std::int64_t halo) {
  return tiles_cost_ms(cut, tile_axis_with(task, scene, cut, true, halo),
                       tile_axis_with(task, scene, cut, false, halo)) +
         interpolation_ms(scene);
}

/// What that costs and errs by.
std::optional<FieldTilesChoice> judged(const FieldTilesTask& task, const FineScene& scene, const FineOtfs& fine,
                                       const CutImage& cut) {
  const PlanOptions& options = task.options;
  const bool images = options.border == Border::reflect || options.border == Border::periodic;
  const double density =
      std::sqrt(std::max(1.0, task.out.step_x_um / scene.grid.step_x_um * (task.out.step_y_um / scene.grid.step_y_um)));
  // What the periods of all tiles hold together, relative to the image's std: more with a longer halo.
  const double area = std::sqrt(std::max(1.0, task.in.area_um2() / task.out.area_um2()));
  const auto norm_of = [&](const FieldTileAxis& x, const FieldTileAxis& y) {
    const std::int64_t reads =
        most_reads(x, options.border, scene.grid.width) * most_reads(y, options.border, scene.grid.height);
    return std::sqrt(in_double(reads)) * (images ? area : task.norm);
  };
  std::array<std::int64_t, 2> halos{kLeastHalo, kLeastHalo};
  std::array<FieldTileAxis, 2> axes{tile_axis_with(task, scene, cut, true, kLeastHalo),
                                    tile_axis_with(task, scene, cut, false, kLeastHalo)};
  std::array<double, 2> missed{};
  for (const bool along_x : {true, false}) {
    const std::size_t a = along_x ? 0 : 1;
    const double allowed = 0.5 * cut.halo_allowed / density;
    const auto tails = reach_of(task, fine, cut, along_x, allowed / (task.norm + area));
    if (!tails) return std::nullopt;
    const double norm = task.norm + norm_of(axes[0], axes[1]);
    // A pixel's centre may lie half a sample nearer to the edge.
    const auto left_out = [&](std::int64_t halo) { return norm * (*tails)[static_cast<std::size_t>(halo - 1)]; };
    while (left_out(halos[a]) > allowed && halos[a] < kTailLength / 2) ++halos[a];
    axes[a] = tile_axis_with(task, scene, cut, along_x, halos[a]);
    missed[a] = density * (*tails)[static_cast<std::size_t>(std::min(axes[a].halo, kTailLength / 2) - 1)];
    if (left_out(halos[a]) > allowed || axes[a].job.out_length > 3 * axes[a].tile + 64) return std::nullopt;
  }
  const FieldTileAxis *x = &axes[0], *y = &axes[1];
  const double norm = norm_of(*x, *y);
  FieldTilesChoice choice{.candidate = {}, .axes = {*x, *y}, .halos = halos, .grid = scene.grid, .finer = scene.finer};
  Candidate& report = choice.candidate;
  report.method = Method::field_tiles;
  report.detail =
      plural(std::ssize(cut.tiles), "tile") + " of " + size_text(cut.width, cut.height) + " pixels, halo " +
      std::to_string(std::min(x->halo, y->halo)) + " samples" +
      (scene.interpolated() ? ", scene interpolated to " + size_text(scene.grid.width, scene.grid.height) : "") + ", " +
      fixed(in_double(static_cast<std::int64_t>(cut.modes)) / in_double(std::ssize(cut.tiles)), 1) + " modes a tile";
  const double unit = norm * std::sqrt(samples_per_pixel(scene.grid, task.out));
  std::size_t most = 0;
  for (const TileModes& tile : cut.tiles) most = std::max(most, tile.count);
  report.predicted.modes = task.field.error(task.field.count()) + cut.error;
  report.predicted.wrap = (task.norm + norm) * (missed[0] + missed[1]);
  for (std::size_t m = 0; m < fine.otfs.size(); ++m) {
    report.predicted.table += unit * cut.amount[m] * fine.otfs[m]->table_error();
    report.predicted.band += unit * cut.amount[m] * fine.otfs[m]->quadrature_error();
  }
  // Transforms, weights and sums of OTFs and of modes; then the image, and what interpolation rounded.
  const double units =
      rounding_units(x->job, y->job) + 4.0 * TileModes::kTerms + 2.0 + in_double(static_cast<std::int64_t>(most));
  report.predicted.arithmetic = kFloatUnit * units * unit * cut.gain + storage_error(options);
  if (scene.interpolated()) report.predicted.arithmetic += unit * cut.gain * scene.finer->report().predicted.total();
  report.cost_ms = tiles_cost_ms(cut, *x, *y) + interpolation_ms(scene);
  report.bytes = static_cast<std::int64_t>(static_cast<double>(cut.modes) *
                                           spectral_bytes(x->job, y->job, Parities(false, false, false)));
  return choice;
}

}  // namespace

FieldTilesChoice choose_field_tiles(const FieldTilesTask& task) {
  FieldTilesChoice best;
  best.candidate.method = Method::field_tiles;
  const auto none = [&](const std::string& reason) {
    best.candidate.reason = reason;
    return best;
  };
  if (task.field.count() == 0) return none("the mean OTF keeps the tolerance by itself; leave --method out");
  const std::vector<FineScene> scenes = fine_scenes(task);
  if (scenes.empty()) return none("the pitch is not a ratio of small whole numbers of samples");
  const double left = task.field.error(task.field.count());
  const FineScene& last = scenes.back();
  std::vector<CutImage> cuts;
  for (const std::int64_t side : kTileSides)
    for (const double share : kHaloShares) {
      const double halo = share * task.allowed, modes = task.allowed - halo - left;
      if (modes <= 0.0) continue;
      std::optional<CutImage> cut = cut_image(task, side, std::lcm(last.x.pixels, scenes[0].x.pixels),
                                              std::lcm(last.y.pixels, scenes[0].y.pixels), modes);
      if (!cut) continue;
      cut->halo_allowed = halo;
      cuts.push_back(std::move(*cut));
    }
  if (cuts.empty()) return none("tiles take more than " + std::to_string(kMostTileModes) + " modes each");
  // The cheapest first, with short halos. Where halos may err by as much or less they are no shorter, of whatever
  // tiles, than those that have been found: what is dearer with these is not judged.
  struct Way {
    std::size_t scene;
    const CutImage* cut;
    std::int64_t halo = kLeastHalo;
  };
  std::vector<Way> ways;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (const CutImage& cut : cuts) ways.push_back({i, &cut});
  const auto least_ms = [&](const Way& way) { return least_cost_ms(task, scenes[way.scene], *way.cut, way.halo); };
  std::ranges::sort(ways, {}, least_ms);
  std::vector<std::optional<FineOtfs>> fine(scenes.size());
  const CutImage* chosen = nullptr;
  for (const Way& way : ways) {
    const double below = chosen != nullptr ? best.candidate.cost_ms : std::numeric_limits<double>::infinity();
    if (least_ms(way) >= below) continue;
    if (!fine[way.scene]) fine[way.scene] = fine_otfs(task, scenes[way.scene]);
    std::optional<FieldTilesChoice> choice = judged(task, scenes[way.scene], *fine[way.scene], *way.cut);
    if (!choice) continue;
    for (Way& other : ways)
      if (other.scene == way.scene && other.cut->halo_allowed <= way.cut->halo_allowed)
        other.halo = std::max(other.halo, std::min(choice->halos[0], choice->halos[1]));
    if (choice->candidate.cost_ms >= below) continue;
    best = std::move(*choice);
    best.otfs = fine[way.scene]->otfs;
    chosen = way.cut;
  }
  if (chosen == nullptr) return none("no halo up to a tile keeps the tolerance");
  best.tiles = chosen->tiles;
  return best;
}

FieldTiles::FieldTiles(FieldTilesChoice choice, Border border, int threads)
    : choice_(std::move(choice)),
      border_(border),
      engine_(choice_.axes[0].job, choice_.axes[1].job, Lines::rows, fft::Rigor::estimate) {
  const SpectralEngine<float> other(choice_.axes[0].job, choice_.axes[1].job, Lines::rows, fft::Rigor::estimate);
  std::vector<OtfBlocks<float>> of_image;  // in memory that is given back
  bool real = true;
  for (const auto& otf : choice_.otfs) {
    of_image.push_back(make_otf_blocks(*otf, other, threads));
    real = real && otf->is_real();
  }
  for (const TileModes& tile : choice_.tiles) {
    auto& list = otfs_.emplace_back();
    for (std::size_t k = 0; k < tile.count; ++k)
      list.push_back(engine_.make_blocks(real ? Parities() : Parities(false, false, false)));
  }
  // Sums of the OTFs of the image, a few rows at a time. Of a real one a row holds each number twice.
  const std::int64_t rows = engine_.blocks() * static_cast<std::int64_t>(otf_frequencies(engine_.y()).size());
  parallel_for(rows, 64, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::size_t t = 0; t < otfs_.size(); ++t)
      for (std::size_t k = 0; k < otfs_[t].size(); ++k) {
        const OtfBlocks<float>& to = otfs_[t][k];
        std::fill_n(to.data.data() + begin * kRow, (end - begin) * kRow, 0.0F);
        for (std::size_t m = 0; m < of_image.size(); ++m) {
          const auto factor = static_cast<float>(choice_.tiles[t].mix[k * of_image.size() + m]);
          const std::int64_t used = to.complex && !of_image[m].complex ? kLanes : kRow;
          for (std::int64_t row = begin; row < end; ++row) {
            const float* from = of_image[m].data.data() + row * kRow;
            float* sum = to.data.data() + row * kRow;
            for (std::int64_t i = 0; i < used; ++i) sum[i] += factor * from[i];
          }
        }
      }
  });
  choice_.otfs.clear();
}

std::int64_t FieldTiles::otf_bytes() const {
  std::int64_t numbers = 0;
  for (const auto& tile : otfs_)
    for (const OtfBlocks<float>& otf : tile) numbers += otf.size();
  return numbers * static_cast<std::int64_t>(sizeof(float));
}

std::int64_t FieldTiles::run_bytes() const {
  const std::int64_t period = choice_.axes[0].job.samples * choice_.axes[1].job.samples;
  const std::int64_t finer = choice_.finer ? choice_.grid.width * choice_.grid.height : 0;
  return engine_.run_bytes(1, 1) + static_cast<std::int64_t>(sizeof(float)) * (4 * period + finer) +
         (choice_.finer ? choice_.finer->report().run_bytes : 0);
}

void FieldTiles::add(ImageView<const float> scene, ImageView<float> image, double border_value, int threads) const {
  Image finer;
  if (choice_.finer) {
    finer = Image(choice_.grid.width, choice_.grid.height);
    choice_.finer->run(scene, finer.view(), border_value, threads);
    scene = finer.view();
  }
  parallel_for_each(std::ssize(otfs_), 1, threads, [&](std::int64_t i) {
    const auto tile = static_cast<std::size_t>(i);
    if (!otfs_[tile].empty()) add_tile(tile, scene, border_value, image);
  });
}

void FieldTiles::add_tile(std::size_t tile, ImageView<const float> samples, double border_value,
                          ImageView<float> image) const {
  const auto& [x, y] = choice_.axes;
  const TileModes& modes = choice_.tiles[tile];
  const Region& region = modes.region;
  Image period(x.job.samples, y.job.samples);
  std::vector<Region> runs;  // of samples that lie side by side: x is the place in the period, y the sample, -1 beyond
  for (std::int64_t k = 0; k < period.width(); ++k) {
    const std::int64_t sample = border_source(border_, x.sample(region.x / x.tile, k), samples.width);
    if (runs.empty() || sample < 0 || sample != runs.back().y + runs.back().width)
      runs.push_back({k, sample, 1, 1});
    else
      ++runs.back().width;
  }
  const auto beyond = static_cast<float>(border_value);
  for (std::int64_t k = 0; k < period.height(); ++k) {
    const std::int64_t row = border_source(border_, y.sample(region.y / y.tile, k), samples.height);
    float* const to = period.view().row(k);
    for (const Region& run : runs)
      if (row < 0 || run.y < 0)
        std::fill_n(to + run.x, run.width, beyond);
      else
        std::copy_n(samples.row(row) + run.y, run.width, to + run.x);
  }
  UniformRuns flat;
  const std::optional<MeanAndDeviation> sampled = sampled_mean_and_deviation(period.view());
  const MeanAndDeviation about = sampled ? *sampled : mean_and_deviation(period.view(), 1, flat);
  if (about.deviation == 0.0) return;
  const std::vector<float> terms = tile_terms(region.width);
  Image sum(region.width, region.height);
  std::fill_n(sum.data(), sum.size(), 0.0F);
  KeptPlane kept;
  for (std::size_t k = 0; k < modes.count; ++k) {
    const auto take = [&](std::int64_t row, std::int64_t, std::span<const float> filtered) {
      if (row >= region.height) return;
      std::array<kernels::Scaled, TileModes::kTerms> weight;
      for (std::size_t i = 0; i < weight.size(); ++i)
        weight[i] = {
            modes.rows[(k * static_cast<std::size_t>(region.height) + static_cast<std::size_t>(row)) * weight.size() +
                       i],
            terms.data() + i * static_cast<std::size_t>(region.width)};
      kernels::add_weighted(filtered.data(), region.width, weight, sum.view().row(row));
    };
    engine_.run({Channel{.in = period.view(),
                         .out = {},
                         .mean = about.mean,
                         .scale = scale_for(about.deviation),
                         .sampled = sampled.has_value(),
                         .dc = 0.0,
                         .flat = &flat,
                         .kept = &kept,
                         .take = take}},
                otfs_[tile][k], 1);
  }
  for (std::int64_t row = 0; row < region.height; ++row) {
    float* to = image.row(region.y + row) + region.x;
    for (std::int64_t i = 0; i < region.width; ++i) to[i] += sum.at(i, row);
  }
}

}  // namespace mtf
