// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finished tiles of a run that may be stopped: OUT.part holds their pixels, OUT.part.tiles a line of what the run is
// and a record for each tile, with the counts that belong to it and a checksum of pixels and counts. The two files
// survive a signal, a kill and a full disk; the same command continues from them. When it is done only the image is
// left.

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "mtf/image.h"
#include "mtf/survey/survey.h"

namespace mtf::io {

struct TileStoreLayout {
  std::string key;  ///< all that the pixels depend on; another key is another run
  std::int64_t width = 0, height = 0;
  std::size_t planes = 1;
  std::int64_t tiles = 0;
  std::size_t counts = 0;                      ///< that belong to a tile
  std::function<Region(std::int64_t)> region;  ///< of a tile
};

/// Whole numbers that belong to a tile beside its pixels, TileStoreLayout::counts of them; with the caller's meaning.
using TileCounts = std::vector<std::int64_t>;

/// Whose pixels are not kept longer than the process.
class TileStore {
 public:
  /// Opens what a stopped run left, or starts over: `note` says why when something was there. Throws RuntimeError when
  /// the files cannot be made, the disk has no room for all pixels, or another process is writing them.
  TileStore(const std::string& out, TileStoreLayout layout, bool resume);
  ~TileStore();
  TileStore(const TileStore&) = delete;
  TileStore& operator=(const TileStore&) = delete;

  bool done(std::int64_t tile) const { return done_[static_cast<std::size_t>(tile)]; }
  std::int64_t resumed() const { return resumed_; }
  const std::string& note() const { return note_; }
  /// The counts of the tiles that a stopped run left.
  const std::vector<TileCounts>& resumed_counts() const { return resumed_counts_; }
  /// Keeps a finished tile. From several threads, each tile once. Throws RuntimeError naming the disk, UsageError for
  /// another number of counts than the layout has.
  void write(std::int64_t tile, std::span<const ImageView<const float>> planes, const TileCounts& counts = {});
  /// Rows from `first` of one plane.
  void read_rows(std::size_t plane, std::int64_t first, ImageView<float> rows) const;
  /// The image is written: removes both files.
  void remove();

 private:
  bool load();
  void start_over();

  std::string pixels_path_, journal_path_, note_;
  TileStoreLayout layout_;
  std::vector<char> done_;  // not bits: tiles are marked by several threads
  std::vector<TileCounts> resumed_counts_;
  std::int64_t resumed_ = 0;
  std::mutex journal_lock_;
  int pixels_ = -1, journal_ = -1;
};

}  // namespace mtf::io
