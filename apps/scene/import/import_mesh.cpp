// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/import_mesh.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <system_error>

#include "apps/scene/import/import_process.h"
#include "apps/scene/import/mesh_stream.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"
#include "mtf/work/usable_memory.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20U;

std::string shown(const fs::path& file) { return mtf::printable(file.string(), 1000); }

[[noreturn]] void refuse(const fs::path& file, const std::string& what, const std::string& remedy) {
  throw mtf::RuntimeError("cannot read the mesh " + shown(file) + ": " + what + "; " + remedy);
}

/// Of the file as it was when it was opened: nothing that is no ordinary file is read.
class InputFile {
 public:
  explicit InputFile(const fs::path& file)
      : descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
      const int reason = errno;
      close();
      refuse(file, std::generic_category().message(reason), "check the path and its permissions");
    }
    const bool ordinary = S_ISREG(status.st_mode);
    size_ = static_cast<std::uint64_t>(status.st_size);
    if (ordinary && size_ > 0) return;
    close();
    if (S_ISDIR(status.st_mode)) refuse(file, "it is a folder", "name a mesh file in it");
    if (!ordinary) refuse(file, "it is not an ordinary file", "store the mesh in a file first");
    refuse(file, "the file is empty", "copy or export it again");
  }
  ~InputFile() { close(); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  int descriptor() const { return descriptor_; }
  std::uint64_t size() const { return size_; }

 private:
  void close() const {
    if (descriptor_ >= 0) ::close(descriptor_);
  }

  int descriptor_;
  std::uint64_t size_ = 0;
};

std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const char* known : {".obj", ".ply", ".stl", ".gltf", ".glb"})
    if (extension == known) return extension;
  throw mtf::UsageError(
      "cannot read the mesh " + shown(file) + ": the extension \"" + mtf::printable(extension, 20) +
      "\" is not known; meshes are read from .obj, .ply, .stl, .gltf and .glb files: export it as one");
}

/// Address space that any mesh of that many bytes can be read in.
std::uint64_t plenty_for(std::uint64_t size) { return 512 * mebibyte + 64 * size; }

/// Whether the usable memory sets the limit, not the size of the file.
bool short_of_memory(const InputFile& input, const ImportLimits& limits) {
  return limits.memory_bytes == 0 && mtf::usable_bytes() < static_cast<double>(plenty_for(input.size()));
}

ImportRequest request_for(const fs::path& file, const InputFile& input, const ImportLimits& limits) {
  const auto memory = static_cast<std::uint64_t>(mtf::usable_bytes());
  const std::uint64_t size = input.size();
  ImportRequest request;
  request.descriptor = input.descriptor();
  request.extension = extension_of(file);
  if (request.extension == ".gltf") request.folder = fs::absolute(file).parent_path();
  request.memory_bytes = limits.memory_bytes > 0 ? limits.memory_bytes : std::min(memory, plenty_for(size));
  request.cpu_s = limits.cpu_s > 0 ? limits.cpu_s : 1 + (size + 4 * mebibyte - 1) / (4 * mebibyte);
  request.output_bytes =
      limits.output_bytes > 0 ? limits.output_bytes : std::min(memory / 4, 64 * mebibyte + 64 * size);
  return request;
}

[[noreturn]] void refuse_end(const fs::path& file, const ImportRequest& request, ImportEnd end) {
  const std::string remedy =
      "export it again, as binary PLY for instance; a file that is right and needs more can be read with higher "
      "ImportLimits";
  if (end == ImportEnd::too_long)
    refuse(file,
           "reading it took more than " + mtf::io::number_text(request.cpu_s) + " s of processor time or " +
               mtf::io::number_text(import_patience * request.cpu_s) + " s in all",
           remedy);
  if (end == ImportEnd::too_large)
    refuse(file, "its mesh is larger than " + mtf::io::shown_bytes(static_cast<double>(request.output_bytes)), remedy);
  refuse(file, "the process that reads it crashed", "the file is damaged, or memory was short: export it again");
}

DecodedImport imported(const fs::path& file, const ImportRequest& request) {
  const ImportRun run = run_import(request);
  if (run.end != ImportEnd::sent) refuse_end(file, request, run.end);
  try {
    return decode_import(run.bytes);
  } catch (const mtf::RuntimeError& error) {
    refuse(file, error.what(), "export it again");
  }
}

void to_scene(Mesh& mesh, double unit_m, bool y_up) {
  for (Point& p : mesh.vertices) {
    if (y_up) p = {p[0], -p[2], p[1]};
    for (double& x : p) x = x * unit_m + 0.0;  // -0 becomes 0
  }
}

}  // namespace

Mesh import_mesh(const fs::path& file, double unit_m, Up up, const ImportLimits& limits) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m))
    throw mtf::UsageError("cannot read the mesh " + shown(file) + ": its unit is " + mtf::io::number_text(unit_m) +
                          " m; give a positive length such as 0.001 for millimetres");
  static_cast<void>(extension_of(file));  // before the file is opened
  const InputFile input(file);
  const ImportRequest request = request_for(file, input, limits);
  DecodedImport decoded = imported(file, request);
  switch (decoded.outcome) {
    case ImportOutcome::mesh:
      break;
    case ImportOutcome::damaged:
      refuse(file, mtf::printable(decoded.text), "export it again");
    case ImportOutcome::out_of_memory:
      refuse(file,
             "reading it needs more than " + mtf::io::shown_bytes(static_cast<double>(request.memory_bytes)) +
                 " of memory",
             short_of_memory(input, limits)
                 ? std::string(mtf::usable_memory().whose) + " no more: raise that limit, or simplify the mesh"
                 : "the file is damaged, or has to be simplified");
    case ImportOutcome::too_large:
      refuse_end(file, request, ImportEnd::too_large);
  }
  const bool gltf = request.extension == ".gltf" || request.extension == ".glb";
  to_scene(decoded.mesh, unit_m, up == Up::y || (up == Up::of_format && gltf));
  return std::move(decoded.mesh);
}

}  // namespace apps::scene
