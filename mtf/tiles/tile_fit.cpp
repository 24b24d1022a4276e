// SPDX-License-Identifier: Apache-2.0
#include "mtf/tiles/tile_fit.h"

#include <algorithm>
#include <cmath>

namespace mtf {
namespace {

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

}  // namespace

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

}  // namespace mtf
