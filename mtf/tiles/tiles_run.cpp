// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>

#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/parallel.h"
#include "mtf/tiles/tile_queue.h"
#include "mtf/tiles/tiles.h"
#include "mtf/words.h"
#include "mtf/work/stopwatch.h"

namespace mtf {
namespace {

constexpr std::int64_t kRowsForAThread = 256;

// Neighbouring positions of a canvas whose samples are neighbours too: forwards, mirrored, or one sample held.
struct Run {
  std::int64_t at = 0, count = 0, source = 0, step = 0;  // source -1: the value of a constant border
};

std::vector<Run> runs_of(Border border, std::int64_t first, std::int64_t count, std::int64_t n) {
  std::vector<Run> runs;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t source = border_source(border, first + i, n);
    if (!runs.empty()) {
      Run& last = runs.back();
      const std::int64_t step = source - (last.source + (last.count - 1) * last.step);
      const bool constant = source < 0 || last.source < 0;
      if (constant ? source == last.source : std::abs(step) <= 1 && (last.count == 1 || step == last.step)) {
        if (last.count == 1 && !constant) last.step = step;
        ++last.count;
        continue;
      }
    }
    runs.push_back({i, 1, source, 0});
  }
  return runs;
}

// One thread reads all at once, several share the rows.
void read_rows(const ReadWindow& read, std::size_t channel, std::int64_t x, std::int64_t y, ImageView<float> to,
               int threads) {
  parallel_for(to.height, threads == 1 ? to.height : kRowsForAThread, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 read(channel, x, y + begin, {to.row(begin), to.width, end - begin, to.stride});
               });
}

constexpr std::int64_t kBlock = 64;
constexpr double kFewFlatBlocks = 0.3;
constexpr std::int64_t kWorthPlanning = std::int64_t{1} << 23;  // samples; below, planning costs more than it saves
constexpr double kWorthIt = 2.0;  // of the work of the whole image, whose planning takes three times as much
constexpr double kReading = 0.05, kCoarse = 0.3;          // work besides transforms, a sample of the scene
constexpr std::array<std::int64_t, 2> kSides{512, 1024};  // of a tile in samples

bool is_flat(ImageView<const float> plane, const Region& region) {
  const float first = plane.at(region.x, region.y);
  for (std::int64_t y = region.y; y < region.y + region.height; ++y)
    for (std::int64_t x = region.x; x < region.x + region.width; ++x)
      if (plane.at(x, y) != first) return false;
  return true;
}

// Share of the blocks that are flat in all planes. As a rule a few samples show that a block is not.
double flat_blocks(std::span<const ImageView<const float>> planes) {
  const std::int64_t columns = planes[0].width / kBlock, rows = planes[0].height / kBlock;
  std::int64_t flat = 0;
  for (std::int64_t j = 0; j < rows; ++j)
    for (std::int64_t i = 0; i < columns; ++i)
      flat += std::ranges::all_of(planes, [&](const auto& plane) {
        return is_flat(plane, {i * kBlock, j * kBlock, kBlock, kBlock});
      });
  return static_cast<double>(flat) / static_cast<double>(std::max<std::int64_t>(1, columns * rows));
}

}  // namespace

Tile TiledSensorPlan::tile(std::int64_t index) const {
  if (report_.whole) return {0, {0, 0, out_.width, out_.height}};
  const auto range = [](const TileAxis& axis, std::int64_t i) {
    const std::int64_t from = std::max<std::int64_t>(0, i * axis.tile - axis.skipped);
    const std::int64_t to = std::min(axis.outputs, (i + 1) * axis.tile - axis.skipped);
    return std::pair{from, to - from};
  };
  const auto [x, width] = range(x_, index % x_.count());
  const auto [y, height] = range(y_, index / x_.count());
  return {index, {x, y, width, height}};
}

// What a worker needs for a tile, and for the next one again: fresh pages cost more than much of the work on them.
struct TiledSensorPlan::Workspace {
  explicit Workspace(const TiledSensorPlan& plan)
      : canvas(plan.x_.canvas_samples(), plan.y_.canvas_samples()),
        wide(plan.x_.canvas_pixels(), plan.y_.canvas_pixels()),
        pixels(plan.x_.tile + 2 * plan.x_.post, plan.y_.tile + 2 * plan.y_.post) {}
  Image canvas, wide, pixels;
};

// A single tile at work leaves the other threads to help it.
int TiledSensorPlan::helpers() const { return std::max(1, threads_of(threads_) / report_.in_flight); }

void TiledSensorPlan::read_canvas(const ReadWindow& read, std::size_t channel, std::int64_t index, double border_value,
                                  Image& canvas) const {
  const auto xs = runs_of(border_, x_.first_sample(index % x_.count()), canvas.width(), in_.width);
  const auto ys = runs_of(border_, y_.first_sample(index / x_.count()), canvas.height(), in_.height);
  for (const Run& y : ys)
    for (const Run& x : xs) {
      const ImageView<float> to = part_of(canvas.view(), {x.at, y.at, x.count, y.count});
      if (x.source < 0 || y.source < 0) {
        for (std::int64_t j = 0; j < y.count; ++j) std::fill_n(to.row(j), x.count, static_cast<float>(border_value));
        continue;
      }
      const auto low = [](const Run& run) { return run.step < 0 ? run.source - (run.count - 1) : run.source; };
      const auto distinct = [](const Run& run) { return run.step == 0 ? 1 : run.count; };
      if (x.step == 1 && y.step == 1) {
        read_rows(read, channel, x.source, y.source, to, report_.in_flight == 1 ? helpers() : 1);
        continue;
      }
      Image window(distinct(x), distinct(y));
      read(channel, low(x), low(y), window.view());
      for (std::int64_t j = 0; j < y.count; ++j)
        for (std::int64_t i = 0; i < x.count; ++i)
          to.at(i, j) = window.at(x.source + i * x.step - low(x), y.source + j * y.step - low(y));
    }
}

// The pixels of a tile and its post halo, those beyond the detector by its border rule; a periodic scene has supplied
// them already.
void TiledSensorPlan::filter_after_sampling(std::int64_t index, double border_value, Image& pixels) const {
  const std::int64_t left = x_.first + index % x_.count() * x_.tile - x_.post;
  const std::int64_t top = y_.first + index / x_.count() * y_.tile - y_.post;
  if (border_ != Border::periodic) {
    const auto constant = static_cast<float>(dc_ * border_value);
    const auto source = [&](std::int64_t at, std::int64_t first, std::int64_t n, std::int64_t count) {
      const std::int64_t s = border_source(border_, at, n);
      return s < 0 ? s : std::clamp<std::int64_t>(s - first, 0, count - 1);  // no output reads beyond
    };
    for (std::int64_t y = 0; y < pixels.height(); ++y)  // columns first: the rows copied below are whole
      for (std::int64_t x = 0; x < pixels.width(); ++x) {
        if (left + x >= 0 && left + x < detector_.width) continue;
        const std::int64_t s = source(left + x, left, detector_.width, pixels.width());
        pixels.at(x, y) = s < 0 ? constant : pixels.at(s, y);
      }
    for (std::int64_t y = 0; y < pixels.height(); ++y) {
      if (top + y >= 0 && top + y < detector_.height) continue;
      const std::int64_t s = source(top + y, top, detector_.height, pixels.height());
      float* row = pixels.view().row(y);
      if (s < 0)
        std::fill_n(row, pixels.width(), constant);
      else if (s != y)
        std::memcpy(row, pixels.view().row(s), static_cast<std::size_t>(pixels.width()) * sizeof(float));
    }
  }
  inner_->post->run(pixels.view(), pixels.view(), 0.0, helpers());
}

// Filters the canvas in `memory`. True when the canvas is uniform.
bool TiledSensorPlan::run_tile(std::int64_t index, double border_value, const Image* far, double far_mean,
                               Workspace& memory, Image& out) const {
  auto& [canvas, wide, pixels] = memory;
  const Plan& near = inner_->presample;
  const bool flat = is_flat(canvas.view(), {0, 0, canvas.width(), canvas.height()});
  if (flat) {
    std::fill_n(pixels.data(), pixels.size(), static_cast<float>(near.dc() * canvas.data()[0]));
  } else {
    near.run(canvas.view(), wide.view(), 0.0, helpers());
    const Region inside{x_.margin - x_.post, y_.margin - y_.post, pixels.width(), pixels.height()};
    copy(part_of(wide.view(), inside), pixels.view());
  }
  if (far != nullptr) {
    const auto centre = [](const TileAxis& axis, std::int64_t i, double pitch) {
      return (static_cast<double>(axis.first + i * axis.tile - axis.post) + 0.5) * pitch;
    };
    add_interpolated(*coarse_, far->view(), centre(x_, index % x_.count(), out_.step_x_um),
                     centre(y_, index / x_.count(), out_.step_y_um), out_.step_x_um, out_.step_y_um, far_mean,
                     pixels.view());
  }
  // Values beyond float32 stay infinite, for the receiver of the tile to see.
  if (inner_->post && all_finite(pixels.view())) filter_after_sampling(index, border_value, pixels);
  const Region region = tile(index).region;
  const std::int64_t skip_x = region.x + x_.skipped - index % x_.count() * x_.tile + x_.post;
  const std::int64_t skip_y = region.y + y_.skipped - index / x_.count() * y_.tile + y_.post;
  out = copy_of(part_of(pixels.view(), {skip_x, skip_y, region.width, region.height}));
  return flat;
}

TileTally TiledSensorPlan::run_whole(const ReadWindow& read, std::size_t channels, const WriteTile& write,
                                     const TileRunOptions& options) const {
  TileTally tally;
  if (options.done && options.done(0)) {
    tally.resumed = 1;
    return tally;
  }
  std::vector<Image> planes;
  std::vector<ImageView<const float>> views;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<Image> scene;
    scene.emplace_back(in_.width, in_.height);
    read_rows(read, c, 0, 0, scene[0].view(), threads_);
    std::vector<Image> filtered = inner_->run(std::move(scene), options.border_value, threads_);
    planes.push_back(copy_of(part_of(filtered[0].view(), region_)));
    views.push_back(planes[c].view());
  }
  write(tile(0), views);
  tally.computed = 1;
  if (options.progress) options.progress(1, 1);
  return tally;
}

TileTally TiledSensorPlan::run(const ReadWindow& read, std::span<const Survey> surveys, const WriteTile& write,
                               const TileRunOptions& options) const {
  for (const Survey& survey : surveys)
    if (survey.statistics.not_finite > 0)
      throw RuntimeError(
          std::to_string(survey.statistics.not_finite) + " pixels are NaN or infinite, the first at column " +
          std::to_string(survey.statistics.first_x) + ", row " + std::to_string(survey.statistics.first_y) +
          "; replace them before the scene is cut into tiles");
  if (report_.whole) return run_whole(read, surveys.size(), write, options);
  std::vector<Image> far;
  if (far_)
    for (const Survey& survey : surveys) {
      if (survey.coarse.width() != coarse_->x.count || survey.coarse.height() != coarse_->y.count)
        throw UsageError("the survey was made with another coarse image; use `every` of the plan's report");
      far.emplace_back(survey.coarse.width(), survey.coarse.height());
      far_->run(survey.coarse.view(), far.back().view(), 0.0, threads_);
    }

  TileTally tally;
  std::mutex lock;
  double busy_ms = 0.0;
  TileQueue queue(report_.count, x_.count());
  std::int64_t finished = 0;
  const auto work = [&](Workspace& memory, std::int64_t index) {
    const bool there = options.done && options.done(index);
    const Stopwatch watch;
    bool flat = true;
    std::vector<Image> planes(there ? 0 : surveys.size());
    std::vector<ImageView<const float>> views;
    for (std::size_t c = 0; c < planes.size(); ++c) {
      read_canvas(read, c, index, options.border_value, memory.canvas);
      if (c + 1 == planes.size()) queue.was_read();
      flat = run_tile(index, options.border_value, far_ ? &far[c] : nullptr, far_ ? dc_ * surveys[c].shift : 0.0,
                      memory, planes[c]) &&
             flat;
      views.push_back(planes[c].view());
    }
    if (planes.empty()) queue.was_read();
    if (!there) write(tile(index), views);
    const double ms = watch.ms();
    const std::scoped_lock guard(lock);
    tally.resumed += there ? 1 : 0;
    tally.flat += !there && flat ? 1 : 0;
    tally.computed += !there && !flat ? 1 : 0;
    busy_ms += there ? 0.0 : flat ? -ms : 0.0;
    tally.saved_ms += there || flat ? 0.0 : ms;
    if (options.progress) options.progress(++finished, report_.count);
  };
  parallel_for(report_.in_flight, 1, report_.in_flight, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t worker = begin; worker < end; ++worker) try {
        Workspace memory(*this);
        for (std::int64_t i = queue.next(); i < report_.count; i = queue.next()) work(memory, i);
      } catch (...) {
        queue.stop();  // a failure ends all
        throw;
      }
  });
  // Mean of the tiles that were computed, for each that was not, less what it took all the same.
  const double mean = tally.computed > 0 ? tally.saved_ms / static_cast<double>(tally.computed) : 0.0;
  tally.saved_ms = std::max(0.0, mean * static_cast<double>(tally.flat) + busy_ms) / report_.in_flight;
  return tally;
}

std::vector<Image> TiledSensorPlan::run(std::span<const ImageView<const float>> scene, double border_value,
                                        TileTally* tally) const {
  const ReadWindow read = windows_of(scene);
  std::vector<Survey> surveys;
  std::vector<Image> out;
  for (std::size_t c = 0; c < scene.size(); ++c) {
    if (scene[c].width != in_.width || scene[c].height != in_.height)
      throw UsageError("a plane is " + size_text(scene[c].width, scene[c].height) + ", the plan was made for " +
                       size_text(in_.width, in_.height));
    surveys.push_back(survey(
        read, c, in_, {.border = border_, .border_value = border_value, .every = report_.every, .threads = threads_}));
    out.emplace_back(out_.width, out_.height);
  }
  const auto write = [&](const Tile& tile, std::span<const ImageView<const float>> planes) {
    for (std::size_t c = 0; c < planes.size(); ++c) copy(planes[c], part_of(out[c].view(), tile.region));
  };
  const TileTally done = run(read, surveys, write, {.border_value = border_value});
  if (tally != nullptr) *tally = done;
  return out;
}

double TiledSensorPlan::flat_share(std::span<const ImageView<const float>> scene, double border_value) const {
  if (report_.whole) return 0.0;
  std::int64_t flat = 0;
  for (std::int64_t index = 0; index < report_.count; ++index) {
    // The canvas is flat where its part within the scene is, and a constant border has the same value.
    const auto within = [](std::int64_t first, std::int64_t count, std::int64_t n) {
      const std::int64_t from = std::clamp<std::int64_t>(first, 0, n - 1);
      return std::pair{from, std::clamp<std::int64_t>(first + count, from + 1, n) - from};
    };
    const auto [x, width] = within(x_.first_sample(index % x_.count()), x_.canvas_samples(), in_.width);
    const auto [y, height] = within(y_.first_sample(index / x_.count()), y_.canvas_samples(), in_.height);
    const Region region{x, y, width, height};
    flat += std::ranges::all_of(scene, [&](const ImageView<const float>& plane) {
      const bool continued =
          border_ != Border::constant || plane.at(region.x, region.y) == static_cast<float>(border_value);
      return continued && is_flat(plane, region);
    });
  }
  return static_cast<double>(flat) / static_cast<double>(report_.count);
}

std::optional<TiledSensorPlan> worth_tiling(const System<double>& system, const SampleGrid& scene,
                                            std::span<const ImageView<const float>> planes, double border_value,
                                            const PlanOptions& options) {
  const double samples = static_cast<double>(scene.width) * static_cast<double>(scene.height);
  if (planes.empty() || samples < static_cast<double>(kWorthPlanning) || flat_blocks(planes) < kFewFlatBlocks)
    return std::nullopt;
  for (const std::int64_t side : kSides) {
    const double ratio = std::max(system.frame.pitch_x_um / scene.step_x_um, 1.0);
    TiledSensorPlan plan =
        compile_tiled(system, scene, options,
                      {.threads = options.threads,
                       .side = std::max<std::int64_t>(1, std::llround(static_cast<double>(side) / ratio))});
    if (plan.report().whole) return std::nullopt;
    const SampleGrid& canvas = plan.inner().presample.in();
    const double each = static_cast<double>(canvas.width) * static_cast<double>(canvas.height);
    const double busy = static_cast<double>(plan.report().count) * (1.0 - plan.flat_share(planes, border_value));
    const double work = busy * each / samples + kReading + (plan.report().every > 0 ? kCoarse : 0.0);
    if (work < kWorthIt) return plan;
  }
  return std::nullopt;
}

}  // namespace mtf
