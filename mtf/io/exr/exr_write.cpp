// SPDX-License-Identifier: Apache-2.0

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfStringVectorAttribute.h>
#include <OpenEXR/ImfThreading.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <OpenEXR/ImfVecAttribute.h>

#include <algorithm>
#include <exception>
#include <set>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/io/plane_checks.h"
#include "mtf/parallel.h"
#include "mtf/words.h"
#include "mtf/work/stop.h"

namespace mtf::io {
namespace {

/// The library's pool of threads is one for the whole process; it only grows here. 0 = all cores.
void use_exr_threads(int threads) {
  const int wanted = threads_of(threads);
  if (Imf::globalThreadCount() < wanted) Imf::setGlobalThreadCount(wanted);
}

// Every byte of the library goes through AtomicFile, which keeps the first failure: the library writes its chunk table
// in a destructor and swallows what is thrown there.
class AtomicStream : public Imf::OStream {
 public:
  AtomicStream(AtomicFile& file, const std::string& path) : Imf::OStream(path.c_str()), file_(file) {}
  void write(const char bytes[], int count) override { file_.write(bytes, static_cast<std::size_t>(count)); }
  std::uint64_t tellp() override { return file_.position(); }
  void seekp(std::uint64_t position) override { file_.seek(position); }

 private:
  AtomicFile& file_;
};

void check_name(const std::string& path, const std::string& what, const std::string& name) {
  const std::string named = path + ": " + what + " name '" + printable(name, 40);
  if (name.empty() || name.size() > 255) throw UsageError(named + "' must have 1 to 255 characters");
  if (name.find('\0') != std::string::npos) throw UsageError(named + "' has a zero byte in it");
}

void check_attribute_name(const std::string& path, const Imf::Header& header, const std::string& name) {
  check_name(path, "attribute", name);
  if (header.find(name) != header.end())
    throw UsageError(path + ": attribute '" + printable(name, 40) +
                     "' is given twice or reserved by OpenEXR; rename it");
}

void insert_metadata(const std::string& path, Imf::Header& header, const Metadata& metadata) {
  const auto insert = [&](const std::string& name, const Imf::Attribute& attribute) {
    check_attribute_name(path, header, name);
    header.insert(name, attribute);
  };
  for (const auto& [name, text] : metadata.text) insert(name, Imf::StringAttribute(text));
  for (const auto& [name, pair] : metadata.pairs) insert(name, Imf::V2dAttribute(Imath::V2d(pair[0], pair[1])));
  for (const auto& [name, list] : metadata.lists) insert(name, Imf::FloatVectorAttribute(list));
  if (!metadata.history.empty()) insert("mtf:history", Imf::StringVectorAttribute(metadata.history));
}

void check_names(const std::string& path, const std::vector<std::string>& names) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    check_name(path, "channel", name);
    if (!seen.insert(name).second)
      throw UsageError(path + ": two channels are called '" + printable(name, 40) + "'; rename one");
  }
}

// Runs `write` and turns what the library throws into our errors.
template <class Action>
void guarded_write(const std::string& path, AtomicFile& file, Action&& write) {
  try {
    write();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    file.check(0);  // a failed write explains more than what the library made of it
    throw RuntimeError("cannot write " + path + ": " + printable(error.what()) +
                       "; check the image and its attributes");
  }
  file.commit();
}

constexpr int kTileSide = 256;

}  // namespace

void write_exr(const std::string& path, const std::vector<NamedPlane>& planes, const Metadata& metadata) {
  check_planes(path, planes);
  std::vector<std::string> names;
  for (const NamedPlane& plane : planes) names.push_back(plane.name);
  check_names(path, names);
  const ImageView<const float>& first = planes[0].plane;

  AtomicFile file(path);
  guarded_write(path, file, [&] {
    Imf::Header header(static_cast<int>(first.width), static_cast<int>(first.height));
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    for (const NamedPlane& plane : planes) {
      header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
      // The library only reads through this pointer.
      auto* base = reinterpret_cast<char*>(const_cast<float*>(plane.plane.data));
      buffer.insert(plane.name, Imf::Slice(Imf::FLOAT, base, sizeof(float),
                                           static_cast<std::size_t>(plane.plane.stride) * sizeof(float)));
    }
    insert_metadata(path, header, metadata);
    AtomicStream stream(file, path);
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(buffer);
    constexpr std::int64_t kLines = 256;  // whole chunks of the compression: the bytes are those of one call
    for (std::int64_t y = 0; y < first.height; y += kLines) {
      require_going_on();
      output.writePixels(static_cast<int>(std::min(kLines, first.height - y)));
    }
  });
}

void write_tiled_exr(const std::string& path, const std::vector<std::string>& names, std::int64_t width,
                     std::int64_t height, const ReadRows& rows, const Metadata& metadata, int threads) {
  check_names(path, names);
  check_plane_pixels(path, width, height);
  use_exr_threads(threads);
  AtomicFile file(path);
  guarded_write(path, file, [&] {
    Imf::Header header(static_cast<int>(width), static_cast<int>(height));
    header.compression() = Imf::ZIP_COMPRESSION;
    header.setTileDescription(Imf::TileDescription(kTileSide, kTileSide, Imf::ONE_LEVEL));
    for (const std::string& name : names) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    insert_metadata(path, header, metadata);
    AtomicStream stream(file, path);
    Imf::TiledOutputFile output(stream, header, Imf::globalThreadCount());
    std::vector<Image> planes;
    for (std::size_t c = 0; c < names.size(); ++c)
      planes.emplace_back(width, std::min<std::int64_t>(kTileSide, height));
    for (std::int64_t first = 0; first < height; first += kTileSide) {
      require_going_on();
      std::vector<ImageView<float>> views;
      Imf::FrameBuffer buffer;
      for (std::size_t c = 0; c < names.size(); ++c) {
        views.push_back({planes[c].data(), width, std::min<std::int64_t>(kTileSide, height - first), width});
        // The library adds coordinates to a base outside the plane; through integers this is well defined.
        const auto origin = static_cast<std::uintptr_t>(first * width * std::int64_t{sizeof(float)});
        auto* base = reinterpret_cast<char*>(reinterpret_cast<std::uintptr_t>(planes[c].data()) - origin);
        buffer.insert(names[c],
                      Imf::Slice(Imf::FLOAT, base, sizeof(float), static_cast<std::size_t>(width) * sizeof(float)));
      }
      rows(first, views);
      output.setFrameBuffer(buffer);
      const int row = static_cast<int>(first / kTileSide);
      output.writeTiles(0, output.numXTiles(0) - 1, row, row);
    }
  });
}

}  // namespace mtf::io
