// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/tile_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/sha256.h"
#include "mtf/math/word_hash.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

/// A line of the journal: the counts of a tile, its number and the checksum, each of 8 bytes.
std::int64_t record_bytes(const TileStoreLayout& layout) {
  return static_cast<std::int64_t>((layout.counts + 2) * sizeof(std::int64_t));
}

std::uint64_t hash_of(const TileCounts& counts) {
  std::uint64_t hash = kWordHashStart;
  for (const std::int64_t count : counts) hash = mixed(hash, static_cast<std::uint64_t>(count));
  return hash;
}

std::uint64_t hash_row(std::uint64_t hash, const float* row, std::int64_t n) {
  for (std::int64_t i = 0; i < n; ++i) {
    std::uint32_t word = 0;
    std::memcpy(&word, row + i, sizeof word);
    hash = mixed(hash, word);
  }
  return hash;
}

[[noreturn]] void fail(const std::string& path, int error_number) {
  const bool full = error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG;
  throw RuntimeError("cannot write " + path + ": " + std::generic_category().message(error_number) +
                     (full ? "; finished tiles are kept: free space and run the same command again"
                           : "; choose a folder you may write to"));
}

// 0 or the error number; short transfers are continued. A file that ends early is EIO.
template <class Transfer, class Byte>
int transfer_all(Transfer&& transfer, int descriptor, Byte* data, std::int64_t size, std::int64_t at) {
  while (size > 0) {
    const ssize_t moved = transfer(descriptor, data, static_cast<std::size_t>(size), static_cast<off_t>(at));
    if (moved < 0 && errno == EINTR) continue;
    if (moved <= 0) return moved < 0 ? errno : EIO;
    data += moved;
    size -= moved;
    at += moved;
  }
  return 0;
}

int write_at(int descriptor, const float* row, std::int64_t n, std::int64_t at) {
  return transfer_all(::pwrite, descriptor, reinterpret_cast<const char*>(row), 4 * n, 4 * at);
}
int read_at(int descriptor, float* row, std::int64_t n, std::int64_t at) {
  return transfer_all(::pread, descriptor, reinterpret_cast<char*>(row), 4 * n, 4 * at);
}

std::int64_t position(const TileStoreLayout& layout, std::size_t plane, std::int64_t x, std::int64_t y) {
  return (static_cast<std::int64_t>(plane) * layout.height + y) * layout.width + x;
}

// What a stopped run left is used up, damaged or not; pixels without a journal are somebody else's file.
void require_ours(const std::string& pixels, const std::string& journal) {
  struct stat status {};
  const bool has_pixels = ::stat(pixels.c_str(), &status) == 0 && status.st_size > 0;
  const bool has_journal = ::stat(journal.c_str(), &status) == 0 && status.st_size > 0;
  if (has_pixels && !has_journal)
    throw UsageError(pixels + " is in the way and not of a stopped run; move it, or name another output");
}

std::string header_of(const TileStoreLayout& layout) {
  return "mtfkit tiles 3 " +
         sha256_hex(layout.key + " " + size_text(layout.width, layout.height) + "x" + std::to_string(layout.planes) +
                    " in " + std::to_string(layout.tiles) + " with " + std::to_string(layout.counts)) +
         "\n";
}

}  // namespace

TileStore::TileStore(const std::string& out, TileStoreLayout layout, bool resume)
    : pixels_path_(out + ".part"), journal_path_(out + ".part.tiles"), layout_(std::move(layout)) {
  done_.assign(static_cast<std::size_t>(layout_.tiles), 0);
  for (const std::string& path : {pixels_path_, journal_path_}) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
      throw RuntimeError("cannot write " + path + ": it is no ordinary file; remove it or name another output");
  }
  require_ours(pixels_path_, journal_path_);
  journal_ = ::open(journal_path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND | O_NOFOLLOW, 0666);
  if (journal_ < 0) fail(journal_path_, errno);
  if (::flock(journal_, LOCK_EX | LOCK_NB) != 0) {
    ::close(journal_);
    journal_ = -1;
    throw RuntimeError(journal_path_ + ": another run is writing it; wait for that, or name another output");
  }
  pixels_ = ::open(pixels_path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (pixels_ < 0) {
    const int error_number = errno;
    ::close(journal_);
    fail(pixels_path_, error_number);
  }
  try {
    if (!resume || !load()) start_over();
  } catch (...) {
    ::close(pixels_);
    ::close(journal_);
    throw;
  }
}

TileStore::~TileStore() {
  if (pixels_ >= 0) ::close(pixels_);
  if (journal_ >= 0) ::close(journal_);
}

// True when the journal is of this very run and every pixel that it vouches for is as it was written.
bool TileStore::load() {
  struct stat status {};
  if (::fstat(journal_, &status) != 0 || status.st_size == 0) return false;
  const std::string header = header_of(layout_);
  std::string found(header.size(), '\0');
  const auto length = static_cast<std::int64_t>(header.size());
  if (transfer_all(::pread, journal_, found.data(), length, 0) != 0 || found != header) {
    note_ = "is of another run or scene";
    return false;
  }
  std::vector<float> row(static_cast<std::size_t>(layout_.width));
  // A record cut short is that of a tile that was not finished.
  const std::int64_t record_size = record_bytes(layout_);
  for (std::int64_t at = length; at + record_size <= status.st_size; at += record_size) {
    std::vector<std::int64_t> words(layout_.counts + 2);
    if (transfer_all(::pread, journal_, reinterpret_cast<char*>(words.data()), record_size, at) != 0) return false;
    const TileCounts counts(words.begin(), words.end() - 2);
    const std::int64_t tile = words[layout_.counts];
    bool whole = tile >= 0 && tile < layout_.tiles;
    std::uint64_t hash = hash_of(counts);
    if (whole) {
      const Region region = layout_.region(tile);
      for (std::size_t plane = 0; whole && plane < layout_.planes; ++plane)
        for (std::int64_t y = 0; whole && y < region.height; ++y) {
          whole = read_at(pixels_, row.data(), region.width, position(layout_, plane, region.x, region.y + y)) == 0;
          hash = hash_row(hash, row.data(), region.width);
        }
    }
    if (!whole || hash != std::bit_cast<std::uint64_t>(words.back())) {
      note_ = "is damaged";
      resumed_ = 0;
      resumed_counts_.clear();
      done_.assign(done_.size(), 0);
      return false;
    }
    char& mark = done_[static_cast<std::size_t>(tile)];
    if (mark == 0) {
      ++resumed_;
      resumed_counts_.push_back(counts);
    }
    mark = 1;
  }
  const std::int64_t torn = (status.st_size - length) % record_size;
  return ::ftruncate(journal_, status.st_size - torn) == 0;
}

void TileStore::start_over() {
  if (!note_.empty()) note_ = pixels_path_ + " " + note_ + ": starting over";
  const std::string header = header_of(layout_);
  if (::ftruncate(journal_, 0) != 0 || ::ftruncate(pixels_, 0) != 0) fail(pixels_path_, errno);
  if (::write(journal_, header.data(), header.size()) != static_cast<ssize_t>(header.size()))
    fail(journal_path_, errno != 0 ? errno : ENOSPC);
  // Room for everything now, rather than none in an hour; file systems that cannot promise it get the size alone.
  const std::int64_t bytes = 4 * position(layout_, layout_.planes, 0, 0);
  const int refused = ::fallocate(pixels_, 0, 0, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
  if (refused == 0) return;
  if (refused != EOPNOTSUPP && refused != ENOSYS) {
    remove();
    throw RuntimeError("cannot write " + pixels_path_ + ": " + shown_bytes(static_cast<double>(bytes)) +
                       " are needed there: " + std::generic_category().message(refused) +
                       "; free space or choose another folder");
  }
  if (::ftruncate(pixels_, static_cast<off_t>(bytes)) != 0) fail(pixels_path_, errno);
}

void TileStore::write(std::int64_t tile, std::span<const ImageView<const float>> planes, const TileCounts& counts) {
  if (counts.size() != layout_.counts)
    throw UsageError("a tile with " + std::to_string(counts.size()) + " counts; those of " + pixels_path_ + " have " +
                     std::to_string(layout_.counts) + ", as TileStoreLayout::counts says");
  const Region region = layout_.region(tile);
  std::uint64_t hash = hash_of(counts);
  for (std::size_t plane = 0; plane < planes.size(); ++plane)
    for (std::int64_t y = 0; y < region.height; ++y) {
      const float* row = planes[plane].row(y);
      if (const int error = write_at(pixels_, row, region.width, position(layout_, plane, region.x, region.y + y)))
        fail(pixels_path_, error);
      hash = hash_row(hash, row, region.width);
    }
  // One append a record: they neither mix nor come before their pixels.
  std::vector<std::int64_t> words = counts;
  words.push_back(tile);
  words.push_back(std::bit_cast<std::int64_t>(hash));
  const auto size = static_cast<ssize_t>(words.size() * sizeof(std::int64_t));
  const std::scoped_lock lock(journal_lock_);
  const off_t before = ::lseek(journal_, 0, SEEK_END);
  if (::write(journal_, words.data(), static_cast<std::size_t>(size)) != size) {
    const int error_number = errno != 0 ? errno : ENOSPC;
    static_cast<void>(::ftruncate(journal_, before));  // half a record would misalign those after it
    fail(journal_path_, error_number);
  }
  done_[static_cast<std::size_t>(tile)] = 1;
}

void TileStore::read_rows(std::size_t plane, std::int64_t first, ImageView<float> rows) const {
  for (std::int64_t y = 0; y < rows.height; ++y)
    if (const int error = read_at(pixels_, rows.row(y), layout_.width, position(layout_, plane, 0, first + y)))
      throw RuntimeError("cannot read " + pixels_path_ + ": " + std::generic_category().message(error) +
                         "; remove it and run the command again");
}

void TileStore::remove() {
  ::unlink(pixels_path_.c_str());
  ::unlink(journal_path_.c_str());
}

}  // namespace mtf::io
