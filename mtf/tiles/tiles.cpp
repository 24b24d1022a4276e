// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/plan/padding.h"
#include "mtf/plan/plan.h"
#include "mtf/plan/plan_parts.h"
#include "mtf/tiles/tiles_refusal.h"
#include "mtf/words.h"
#include "mtf/work/usable_memory.h"

namespace mtf {
namespace {

constexpr double kRough = 1.6;  // a transform of a length with large factors, against a smooth one

std::int64_t round_up(std::int64_t n, std::int64_t to) { return (n + to - 1) / to * to; }

double cost_per_pixel(const TileAxis& axis) {
  const auto length = static_cast<double>(axis.canvas_samples());
  return length * (std::log2(length) + 8.0) * (is_smooth(axis.canvas_samples()) ? 1.0 : kRough) /
         static_cast<double>(std::min(axis.tile, axis.skipped + axis.outputs));
}

/// What is asked of an axis. Halos in scene samples (presample) and pixels (after the sampling).
struct TileRequest {
  PitchRatio ratio;
  std::int64_t region_first = 0, outputs = 0;
  std::int64_t halo_samples = 0, post_pixels = 0;
  std::int64_t most_samples = 0;  ///< of the canvas
  std::int64_t side = 0;          ///< forced tile side in pixels, rounded up to a multiple of q; 0: by cost
};

/// The tile of least work for a pixel, length x (log2 length + 8) / tile: smooth lengths, as long as allowed. Nothing
/// when no tile fits `most_samples`.
std::optional<TileAxis> tile_axis(const TileRequest& request) {
  const auto [p, q] = request.ratio;
  TileAxis axis;
  axis.ratio = request.ratio;
  axis.outputs = request.outputs;
  axis.first = request.region_first / q * q;
  axis.skipped = request.region_first - axis.first;
  axis.post = request.post_pixels;
  axis.margin = round_up(axis.post, q) + round_up(request.halo_samples, p) / p * q;
  const std::int64_t whole = round_up(axis.skipped + axis.outputs, q);
  if (request.side > 0) {
    axis.tile = std::min(round_up(request.side, q), whole);
    return axis;
  }
  std::optional<TileAxis> best;
  double least = std::numeric_limits<double>::infinity();
  for (axis.tile = q; axis.canvas_samples() <= request.most_samples; axis.tile += q) {
    const double cost = cost_per_pixel(axis);
    if (cost < least) least = cost, best = axis;
    if (axis.tile >= 2 * whole) break;  // up to here a longer tile may be the smooth one
  }
  return best;
}

// The largest tiles that a limit of memory allows.

/// Bytes that the plans of a run take, for one sample of what each works on: known when they are compiled.
struct TileNeeds {
  double otf = 4.1, buffers = 4.4;            ///< of the plan of a tile: here those of a real OTF, transformed in float
  double post_otf = 0.0, post_buffers = 0.0;  ///< of the filters after the sampling, for a pixel
  double coarse = 0.0;                        ///< of all that the coarse image needs
};

struct FitRequest {
  TileRequest x, y;  ///< but for most_samples, which is tried
  double limit = 0.0;
  double row_bytes = 0.0, more_rows = 0.0;  ///< of the reader: for each row of a canvas, and rows besides
  double coarse_samples = 0.0;
  double channels = 1.0;
  double receiver_bytes = 0.0;  ///< of the receiver of tiles, for a pixel of a tile
  double held_bytes = 0.0;      ///< of the caller
  int threads = 1;
  TileNeeds needs;
};

struct Fit {
  TileAxis x, y;
  int in_flight = 1;   ///< tiles at work at once
  double bytes = 0.0;  ///< of the run
  double overlap() const { return x.overlap() * y.overlap(); }
};

/// Largest ratio of the area of a tile's canvas to that of the tile: beyond it tiles cost too much.
inline constexpr double kMostOverlap = 4.0;

/// Samples of the longest side of a canvas: longer ones leave the caches.
inline constexpr std::int64_t kLongestSide = 4096;

/// Program, libraries, tables.
inline constexpr std::int64_t kFixedBytes = 40LL << 20;

constexpr double kParallelOverlap = 2.0;  // beyond which fewer threads on longer tiles are better
constexpr int kPlannedInFlight = 4;       // tiles that memory should hold at once

constexpr double kWorthMemory = 1.1;  // work of smaller tiles, relative to that of the largest that fit
constexpr std::int64_t kShortestSide = 32;

std::int64_t shorter(std::int64_t side) { return side * 7 / 8; }

double count(std::int64_t n) { return static_cast<double>(n); }

struct Bytes {
  double shared = 0.0, each = 0.0;  // of the run, of a tile at work
};

Bytes bytes_of(const FitRequest& r, const TileAxis& x, const TileAxis& y) {
  const double samples = count(x.canvas_samples()) * count(y.canvas_samples());
  const double wide = count(x.canvas_pixels()) * count(y.canvas_pixels());
  const double pixels = count(x.tile + 2 * x.post) * count(y.tile + 2 * y.post);
  Bytes bytes;
  bytes.shared = count(kFixedBytes) + r.needs.coarse * r.coarse_samples + r.needs.otf * samples +
                 r.needs.post_otf * pixels + r.row_bytes * (count(y.canvas_samples()) + r.more_rows) + r.held_bytes;
  // Canvas, its pixels and those of the tile with its post halo; the finished ones of each channel.
  bytes.each = (4.0 + r.needs.buffers) * samples + 4.0 * wide +
               (4.0 + 4.0 * r.channels + r.needs.post_buffers) * pixels +
               r.receiver_bytes * count(x.tile) * count(y.tile);
  return bytes;
}

// Of transforms, for a pixel.
double work(const Fit& fit) {
  return fit.overlap() * (std::log2(count(fit.x.canvas_samples()) * count(fit.y.canvas_samples())) + 16.0);
}

/// The number of threads has no part in the layout: the same tiles, and so the same bits, for any. Nothing, and the
/// reason, where no tile fits.
std::optional<Fit> fit_tiles(const FitRequest& request, std::string& reason) {
  const auto tiles_of = [&](std::int64_t side) -> std::optional<Fit> {
    TileRequest x = request.x, y = request.y;
    x.most_samples = y.most_samples = side;
    const auto across = tile_axis(x), down = tile_axis(y);
    if (!across || !down) return std::nullopt;
    return Fit{*across, *down};
  };
  const bool forced = request.x.side > 0;
  bool any = false;
  // Several tiles at work at once are worth some overlap; what would not fit otherwise runs one at a time.
  for (int in_flight = kPlannedInFlight; in_flight >= 1; in_flight /= 2)
    for (std::int64_t side = kLongestSide; side >= kShortestSide; side = shorter(side)) {
      std::optional<Fit> fit = tiles_of(side);
      if (!fit) break;
      if (!forced && any && fit->overlap() > (in_flight > 1 ? kParallelOverlap : kMostOverlap)) break;
      any = true;
      Bytes bytes = bytes_of(request, fit->x, fit->y);
      if (bytes.shared + in_flight * bytes.each > request.limit) continue;
      // Memory that saves next to no work is left to others.
      const double most_work = kWorthMemory * work(*fit);
      for (side = shorter(side); !forced && side >= kShortestSide; side = shorter(side)) {
        const auto smaller = tiles_of(side);
        if (!smaller || work(*smaller) > most_work) break;
        fit = smaller;
      }
      bytes = bytes_of(request, fit->x, fit->y);
      const double room = (request.limit - bytes.shared) / bytes.each;
      fit->in_flight = room >= request.threads ? request.threads : std::max(in_flight, static_cast<int>(room));
      fit->bytes = bytes.shared + fit->in_flight * bytes.each;
      return fit;
    }
  reason = any ? "a tile with its halo needs more" : "the halo is longer than a tile";
  return std::nullopt;
}

// How far around a tile the scene has to be known.

struct HaloRequest {
  SampleGrid in, out;        ///< scene and detector of the whole image
  double norm = 1.0;         ///< norm of the canvas relative to std, those of the tiles' own canvases added
  double budget = 0.0;       ///< rms error relative to std that both axes together may make
  std::int64_t longest = 0;  ///< halos beyond this are of no use
  ScaleSplit split = {};     ///< the part of the OTF that the tiles do
};

struct TileHalo {
  std::array<std::int64_t, 2> samples{};  ///< x, y
  double bound = 0.0;                     ///< rms error relative to std
};

constexpr std::int64_t kShortestCanvas = 1024, kLongestCanvas = 16384;
constexpr double kFloatRounding = 3e-8;  // rms rounding of an OTF value, and four times that in the noise of a kernel

/// The smallest halo whose missing tails keep the budget (Young's bound, as choose_canvas in mtf/plan/padding.h): along
/// each axis the kernel of nine sections of the OTF is summed from outside. Nothing when a longer one than `longest`
/// would be needed.
std::optional<TileHalo> find_halo(const System<double>& system, std::span<const Stage> stages,
                                  const PlanOptions& options, const HaloRequest& request) {
  const double fx = 500.0 / request.in.step_x_um, fy = 500.0 / request.in.step_y_um;
  const double alias = std::sqrt(samples_per_pixel(request.in, request.out));
  const double density = std::sqrt(
      std::max(1.0, request.out.step_x_um / request.in.step_x_um * (request.out.step_y_um / request.in.step_y_um)));
  const double share = options.tolerance / (alias * request.norm);
  const std::int64_t length = next_smooth(std::clamp(4 * request.longest, kShortestCanvas, kLongestCanvas));
  const FactoredOtf sampler(system, stages, options.aperture,
                            {.fx_max = fx,
                             .fy_max = fy,
                             .drop_budget = kDropShare * share,
                             .table_share = kTableShare * share,
                             .samples = 9 * length,
                             .threads = options.threads,
                             .split = request.split,
                             .progress = options.progress});
  TileHalo halo;
  for (const Axis axis : {Axis::x, Axis::y}) {
    const bool x = axis == Axis::x;
    const CanvasRequest along{axis,
                              options.border,
                              x ? request.in.width : request.in.height,
                              x ? request.in.step_x_um : request.in.step_y_um,
                              x ? fy : fx,
                              x ? request.out.step_x_um : request.out.step_y_um,
                              request.norm * density,
                              0.5 * request.budget};
    const double noise = 4.0 * kFloatRounding * sampler.gain() / std::sqrt(static_cast<double>(length));
    const std::vector<double> tails = kernel_tails(sampler, along, length, noise);
    const std::int64_t most = std::min<std::int64_t>(request.longest, length / 4);
    std::int64_t d = 0;
    while (d <= most && along.norm * tails[static_cast<std::size_t>(d)] > along.budget) ++d;
    if (d > most) return std::nullopt;
    halo.samples[x ? 0 : 1] = d + 1;  // a pixel's centre may lie half a sample nearer to the edge
    halo.bound += along.norm * tails[static_cast<std::size_t>(d)];
  }
  return halo;
}

// Shares of the tolerance that the presample steps are given; near and far also hold the rounding.
constexpr double kHaloShare = 0.25, kFarShare = 0.15, kNearShare = 0.55;
constexpr std::array<std::int64_t, 2> kEvery{8, 16};
constexpr double kCoarseBytes = 28.0;  // coarse image, its running sums, and plan: what is set aside for a sample
constexpr int kAttempts = 4;           // at tiles that fit

double area(const SampleGrid& grid) { return count(grid.width) * count(grid.height); }

double coarse_samples(const CoarseGrid& grid) { return count(grid.x.count) * count(grid.y.count); }

// The coarse image of each channel, before and after its filter.
TileNeeds needs_of(const Plan& near, const std::optional<Plan>& far, double channels) {
  TileNeeds needs;
  needs.otf = count(near.report().otf_bytes) / area(near.in());
  needs.buffers = count(near.report().run_bytes) / area(near.in());
  if (far) needs.coarse = 8.0 * channels + count(far->report().otf_bytes + far->report().run_bytes) / area(far->in());
  return needs;
}

// True when something is needed beyond what was thought, which it then is.
bool raise(TileNeeds& thought, const TileNeeds& found) {
  constexpr double slack = 1.02;  // lengths that are rounded up
  bool raised = false;
  for (double TileNeeds::*part : {&TileNeeds::otf, &TileNeeds::buffers, &TileNeeds::coarse})
    if (found.*part > slack * thought.*part) thought.*part = found.*part, raised = true;
  return raised;
}

void require_region(const Region& region, const SampleGrid& detector) {
  if (region.x >= 0 && region.y >= 0 && region.width > 0 && region.height > 0 &&
      region.x <= detector.width - region.width && region.y <= detector.height - region.height)
    return;
  throw UsageError("the region " + std::to_string(region.x) + "," + std::to_string(region.y) + "," +
                   std::to_string(region.width) + "," + std::to_string(region.height) +
                   " does not lie within the output of " + size_text(detector.width, detector.height) +
                   " pixels; give x,y,width,height in pixels within it");
}

// What the whole image needs at once, one channel after the other, beside the bytes of the plans.
double whole_bytes(const SampleGrid& in, const SampleGrid& out, const TileOptions& tiles, double plans) {
  const double pixels = tiles.region ? count(tiles.region->width) * count(tiles.region->height) : area(out);
  return count(kFixedBytes) + 4.0 * area(in) + 4.0 * area(out) +
         (4.0 * count(tiles.channels) + tiles.receiver_bytes) * pixels +
         2.0 * count(tiles.row_bytes) * count(tiles.more_rows) + count(tiles.held_bytes) + plans;
}

double plan_bytes(const Plan& plan) { return count(plan.report().otf_bytes + plan.report().run_bytes); }

}  // namespace

std::int64_t coarse_every(const SampleGrid& scene, Border border, std::int64_t memory) {
  const double limit = (memory > 0 ? count(memory) : usable_bytes()) / 5.0;
  for (const std::int64_t every : kEvery) {
    if (std::min(scene.width, scene.height) < 32 * every) return 0;  // a tile would be the scene
    if (kCoarseBytes * coarse_samples(coarse_grid(scene, border, every)) <= limit) return every;
  }
  std::int64_t every = 2 * kEvery.back();
  while (kCoarseBytes * coarse_samples(coarse_grid(scene, border, every)) > limit) every *= 2;
  return every;
}

std::optional<TiledSensorPlan> cut_into_tiles(const System<double>& system, const SampleGrid& scene,
                                              const PlanOptions& options, const TileOptions& tiles, std::int64_t every,
                                              std::string& reason) {
  constexpr std::array presample{Stage::presample};
  constexpr std::array after{Stage::readout, Stage::postsample};
  TiledSensorPlan plan;
  plan.in_ = scene;
  plan.detector_ = detector_grid(system, scene);
  plan.border_ = options.border;
  plan.threads_ = tiles.threads;
  plan.region_ = tiles.region.value_or(Region{0, 0, plan.detector_.width, plan.detector_.height});
  plan.out_ = plan.detector_;
  plan.out_.width = plan.region_.width;
  plan.out_.height = plan.region_.height;
  const auto rx = pitch_ratio(plan.detector_.step_x_um, scene.step_x_um);
  const auto ry = pitch_ratio(plan.detector_.step_y_um, scene.step_y_um);
  if (!rx || !ry) {
    reason = "the pitch is not a ratio of small whole numbers of samples";
    return std::nullopt;
  }
  const bool has_post = !system.list(Stage::readout).empty() || !system.list(Stage::postsample).empty();
  const double whole_x = count(scene.width) * count(rx->pixels) / count(rx->samples);
  const double whole_y = count(scene.height) * count(ry->pixels) / count(ry->samples);
  if (has_post && options.border == Border::periodic &&
      (whole_x != count(plan.detector_.width) || whole_y != count(plan.detector_.height))) {
    reason =
        "filters after the sampling of a periodic scene need its far side, which is no whole number of pixels away";
    return std::nullopt;
  }

  // Filters after the sampling take half of the tolerance; what comes before passes through their gain.
  const double norm =
      canvas_norm_of(options, scene) * std::sqrt(std::max(1.0, scene.area_um2() / plan.detector_.area_um2()));
  const std::int64_t longest = kLongestSide / 2;
  PlanOptions post_options = options;
  post_options.spectrum = nullptr;
  post_options.method = {};
  post_options.aperture = {};
  post_options.tolerance = 0.5 * options.tolerance;
  TileHalo post_halo;
  double post_norm = 1.0;
  if (has_post) {
    if (options.scene) post_options.scene = after_sampling(*options.scene, options, scene, plan.detector_);
    post_norm = canvas_norm_of(post_options, plan.detector_);
    const auto found = find_halo(system, after, post_options,
                                 {plan.detector_, plan.detector_, (1.0 + std::sqrt(kMostOverlap)) * post_norm,
                                  kHaloShare * post_options.tolerance, longest});
    if (!found) {
      reason = "the filters after the sampling are too wide at this tolerance";
      return std::nullopt;
    }
    post_halo = *found;
  }
  TileNeeds needs;
  // Their gain has to be known before the tolerance of the tile is; it is that of the OTF on any grid.
  double gain = 1.0;
  if (has_post) {
    PlanOptions probe = post_options;
    probe.border = Border::reflect;
    constexpr std::int64_t side = 256;
    const Plan post =
        compile_post(system, {side, side, plan.detector_.step_x_um, plan.detector_.step_y_um}, after, probe);
    gain = std::max(1.0, post.report().largest_gain);
    gain *= gain > 1.0 ? 1.05 : 1.0;  // between the frequencies of this grid
    needs.post_otf = count(post.report().otf_bytes) / count(side * side);
    needs.post_buffers = count(post.report().run_bytes) / count(side * side);
  }

  PlanOptions near_options = options;
  near_options.spectrum = nullptr;  // of the whole scene, not of a tile
  near_options.tolerance = (has_post ? 0.5 / gain : 1.0) * options.tolerance;
  const double share = near_options.tolerance;
  ScaleSplit split;
  if (every > 0) {
    plan.coarse_ = coarse_grid(scene, options.border, every);
    split = {ScaleSplit::Part::fine, plan.coarse_->split_sigma_um()};
  }
  const double concentration =
      plan.coarse_ ? std::sqrt(std::max(1.0, plan.coarse_->grid().area_um2() / plan.detector_.area_um2())) : 1.0;
  const auto compile_far = [&] {
    const SampleGrid coarse = plan.coarse_->grid();
    PlanOptions far = near_options;
    far.border = plan.coarse_->x.coarse_border();
    far.method = {};
    far.tolerance = std::min(0.9, kFarShare * share / concentration);
    if (far.scene) far.scene->canvas_norm *= std::sqrt(std::min(1.0, scene.area_um2() / coarse.area_um2()));
    return compile_part(system, coarse, coarse, far, {ScaleSplit::Part::coarse, split.sigma_um});
  };
  const auto halo =
      find_halo(system, presample, near_options,
                {scene, plan.detector_, (1.0 + std::sqrt(kMostOverlap)) * norm, kHaloShare * share, longest, split});
  if (!halo) {
    reason = "the point spread is wider than a tile at this tolerance";
    return std::nullopt;
  }

  FitRequest request;
  request.x = {*rx, plan.region_.x, plan.region_.width, halo->samples[0], post_halo.samples[0], 0, tiles.side};
  request.y = {*ry, plan.region_.y, plan.region_.height, halo->samples[1], post_halo.samples[1], 0, tiles.side};
  request.limit = tiles.memory > 0 ? count(tiles.memory) : usable_bytes();
  request.row_bytes = count(tiles.row_bytes);
  request.more_rows = count(tiles.more_rows);
  request.channels = count(tiles.channels);
  request.receiver_bytes = tiles.receiver_bytes;
  request.held_bytes = count(tiles.held_bytes);
  request.threads = threads_of(tiles.threads);
  if (plan.coarse_) request.coarse_samples = coarse_samples(*plan.coarse_);
  needs.coarse = 8.5 + 8.0 * request.channels;
  request.needs = needs;
  // What the plans need is known when there are plans; more than was thought, and they are made for smaller tiles.
  std::optional<Plan> near;
  std::optional<Fit> fit;
  double overlap = 0.0;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    fit = fit_tiles(request, reason);
    if (!fit) return std::nullopt;
    overlap = fit->overlap();
    PlanOptions inner = near_options;
    inner.border = Border::reflect;
    inner.tolerance = (every > 0 ? kNearShare : kNearShare + kFarShare) * share;
    if (inner.scene) inner.scene->canvas_norm = norm * inner.scene->std * std::sqrt(std::max(1.0, overlap));
    const SampleGrid canvas{fit->x.canvas_samples(), fit->y.canvas_samples(), scene.step_x_um, scene.step_y_um};
    const SampleGrid wide{fit->x.canvas_pixels(), fit->y.canvas_pixels(), plan.detector_.step_x_um,
                          plan.detector_.step_y_um};
    near = compile_part(system, canvas, wide, inner, split);
    if (every > 0 && !plan.far_) plan.far_ = compile_far();
    if (!raise(request.needs, needs_of(*near, plan.far_, request.channels))) break;
  }
  plan.x_ = fit->x;
  plan.y_ = fit->y;
  plan.report_.in_flight = fit->in_flight;
  plan.report_.bytes = static_cast<std::int64_t>(fit->bytes);
  plan.dc_ = near->dc();
  double predicted = near->report().predicted.total() + halo->bound;
  if (plan.far_) {
    plan.dc_ = plan.far_->dc();
    predicted += plan.far_->report().predicted.total() * concentration + kCoarseError * norm;
  }
  std::optional<Plan> post;
  if (has_post) {
    PlanOptions after_options = post_options;
    after_options.border = Border::reflect;
    after_options.tolerance = (1.0 - kHaloShare) * post_options.tolerance;
    if (after_options.scene) after_options.scene->canvas_norm *= std::sqrt(std::max(1.0, overlap));
    post = compile_post(system,
                        {plan.x_.tile + 2 * plan.x_.post, plan.y_.tile + 2 * plan.y_.post, plan.detector_.step_x_um,
                         plan.detector_.step_y_um},
                        after, after_options);
    predicted = predicted * gain + post->report().predicted.total() + post_halo.bound;
  }
  plan.inner_ = SensorPlan{std::move(*near), std::nullopt, std::move(post), predicted, system, options};
  TileReport& report = plan.report_;
  report.count = plan.x_.count() * plan.y_.count();
  report.side = {plan.x_.tile, plan.y_.tile};
  report.halo = halo->samples;
  report.post_halo = {plan.x_.post, plan.y_.post};
  report.every = every;
  report.halo_error = halo->bound * gain + post_halo.bound;
  report.predicted_error = predicted;
  report.tolerance = options.tolerance;
  return plan;
}

TiledSensorPlan compile_tiled(const System<double>& system, const SampleGrid& scene, const PlanOptions& options,
                              const TileOptions& tiles) {
  const SampleGrid detector = detector_grid(system, scene);
  if (tiles.region) require_region(*tiles.region, detector);
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
    throw UsageError("tolerance " + format_double(options.tolerance) + " is outside (0, 1)");
  const double limit = tiles.memory > 0 ? count(tiles.memory) : usable_bytes();

  std::optional<TiledSensorPlan> best;
  std::string reason;
  std::optional<double> too_small;  // the share of the tolerance that rounding exceeds
  const auto work = [](const TiledSensorPlan& plan) {
    return count(plan.report().count) * count(plan.inner().presample.in().width) *
           count(plan.inner().presample.in().height) * (plan.report().every > 0 ? 1.2 : 1.0);
  };
  const bool one_otf = system.is_isoplanatic();
  if (!one_otf) {
    require_valid(system);
    reason = "the OTF changes over the field by " + names_over_field(system) + ", and tiles share one";
  }
  for (const std::int64_t every : {std::int64_t{0}, coarse_every(scene, options.border, tiles.memory)}) {
    if (!one_otf || (best && every == 0)) continue;
    try {
      auto plan = cut_into_tiles(system, scene, options, tiles, every, reason);
      if (plan && (!best || work(*plan) < work(*best))) best = std::move(plan);
    } catch (const UnreachableTolerance&) {
      reason =
          "rounding of its float32 samples leaves too little of the tolerance for what tiles cut off beyond their halo";
      too_small = kFarShare;
    }
  }
  // More tiles than the scene is worth: one plan for all of it is less work.
  const double all = count(scene.width) * count(scene.height);
  const bool useful = best && (tiles.side > 0 || work(*best) <= kMostOverlap * all);
  if (useful) return std::move(*best);

  const auto require_room = [&](double bytes) {
    if (!(bytes > limit)) return;
    if (!one_otf)
      throw UsageError(reason + ": the scene is filtered at once, which needs " + mebibytes(bytes) + "; the limit is " +
                       mebibytes(limit));
    TileOptions given = tiles;
    given.memory = static_cast<std::int64_t>(limit);
    refuse_memory(system, scene, options, given, reason, too_small, bytes);
  };
  const TileNeeds least;  // before there is a plan, which is worth no time where even this is too much
  double bytes = whole_bytes(scene, detector, tiles, (least.otf + least.buffers) * area(scene));
  if (bytes > limit && best) return std::move(*best);
  require_room(bytes);
  TiledSensorPlan plan;
  plan.in_ = scene;
  plan.detector_ = detector;
  plan.border_ = options.border;
  plan.threads_ = tiles.threads;
  plan.region_ = tiles.region.value_or(Region{0, 0, detector.width, detector.height});
  plan.out_ = detector;
  plan.out_.width = plan.region_.width;
  plan.out_.height = plan.region_.height;
  plan.inner_ = compile_sensor(system, scene, options);
  const SensorPlan& whole = *plan.inner_;
  bytes =
      whole_bytes(scene, detector, tiles, plan_bytes(whole.presample) + (whole.post ? plan_bytes(*whole.post) : 0.0));
  if (bytes > limit && best) return std::move(*best);
  require_room(bytes);
  TileReport& report = plan.report_;
  report.whole = true;
  report.reason = best ? "tiles with their halos are more work" : reason;
  report.side = {plan.out_.width, plan.out_.height};
  report.bytes = static_cast<std::int64_t>(bytes);
  report.predicted_error = plan.inner_->predicted_error;
  report.tolerance = options.tolerance;
  return plan;
}

}  // namespace mtf
