// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/import_mesh.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/scene/import/mesh_stream.h"
#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/words.h"
#include "mtf/work/module.h"
#include "mtf/work/usable_memory.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

// The process `mtfkit-import`: where its program is, and one run of it.

struct ImportRequest {
  int descriptor = -1;    ///< of the mesh file, at its beginning
  std::string extension;  ///< ".obj"
  fs::path folder;        ///< of the buffers of a .gltf file; empty when there may be none
  std::uint64_t memory_bytes = 0, cpu_s = 0, output_bytes = 0;
};

/// Seconds that may pass for each second of processor time: a busy machine gives a tenth of a core.
constexpr std::uint64_t import_patience = 10;

enum class ImportEnd {
  sent,       ///< the process sent all that it had to
  too_long,   ///< it used the processor time, or `import_patience` times as long passed
  too_large,  ///< it sent more than `output_bytes`
  crashed
};

struct ImportRun {
  ImportEnd end = ImportEnd::crashed;
  std::string bytes;  ///< what it sent (mesh_stream.h)
};

// The folders in which the loader searches for libraries: the run path of the program is among them.
std::vector<fs::path> run_path() {
  std::vector<fs::path> folders;
  void* const program = ::dlopen(nullptr, RTLD_LAZY);
  if (program == nullptr) return folders;
  Dl_serinfo size{};
  if (::dlinfo(program, RTLD_DI_SERINFOSIZE, &size) == 0) {
    std::vector<Dl_serinfo> storage(size.dls_size / sizeof(Dl_serinfo) + 1, size);
    if (::dlinfo(program, RTLD_DI_SERINFO, storage.data()) == 0)
      for (unsigned i = 0; i < size.dls_cnt; ++i) folders.emplace_back(storage.front().dls_serpath[i].dls_name);
  }
  ::dlclose(program);
  return folders;
}

// In the folder or one of those above; empty when it is not there.
fs::path found_above(fs::path folder) {
  constexpr int depth = 5;  // of a test program or a Python module below the build folder or the prefix
  for (int up = 0; up < depth && folder != folder.root_path(); ++up, folder = folder.parent_path()) {
    const fs::path program = folder / "libexec" / "mtfkit" / "mtfkit-import";
    std::error_code error;
    if (fs::is_regular_file(program, error)) return program;
  }
  return {};
}

[[noreturn]] void refuse_start(int error_number) {
  throw mtf::RuntimeError("cannot start the process that reads mesh files: " +
                          std::generic_category().message(error_number));
}

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(std::exchange(number_, -1));
  }

 private:
  int number_;
};

/// Killed and waited for at the latest when it goes out of scope.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  ~Child() {
    if (id_ > 0) kill();
    if (id_ > 0) wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void kill() const { ::kill(id_, SIGKILL); }
  /// The status as waitpid gives it.
  int wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
  }

 private:
  pid_t id_;
};

/// Standard input and output as given, errors nowhere, no other descriptor; signals as a fresh process has them.
pid_t spawn(const fs::path& program, std::vector<std::string> words, int in, int out) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t set;
  sigemptyset(&set);
  posix_spawnattr_setsigmask(&attributes, &set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU}) sigaddset(&set, signal);
  posix_spawnattr_setsigdefault(&attributes, &set);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) refuse_start(error);
  return child;
}

/// All that comes until the other end is closed, but not more than `most` bytes.
ImportEnd receive(int descriptor, Clock::time_point deadline, std::uint64_t most, std::string& bytes) {
  std::vector<char> piece(std::size_t{1} << 18U);
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return ImportEnd::too_long;
    pollfd end{descriptor, POLLIN, 0};
    const int ready = ::poll(&end, 1, static_cast<int>(std::min<std::int64_t>(left.count(), 1 << 30)));
    if (ready < 0 && errno != EINTR) return ImportEnd::crashed;
    if (ready <= 0) continue;
    const ssize_t count = ::read(descriptor, piece.data(), piece.size());
    if (count == 0) return ImportEnd::sent;
    if (count < 0 && errno != EINTR) return ImportEnd::crashed;
    if (count < 0) continue;
    if (static_cast<std::uint64_t>(count) > most - bytes.size()) return ImportEnd::too_large;
    bytes.append(piece.data(), static_cast<std::size_t>(count));
  }
}

/// `libexec/mtfkit/mtfkit-import` below the build folder or the prefix that this code lies in, or that a folder of the
/// program's run path lies in. The environment variable MTFKIT_IMPORT names another one. Throws RuntimeError with the
/// places that were searched.
fs::path import_program() {
  if (const char* chosen = std::getenv("MTFKIT_IMPORT"); chosen != nullptr && *chosen != '\0') return chosen;
  const fs::path own = mtf::code_folder(reinterpret_cast<const void*>(&import_program));
  if (const fs::path program = found_above(own); !program.empty()) return program;
  // A program linked with the static libraries may lie anywhere, but its run path leads to the installation.
  for (const fs::path& folder : run_path())
    if (const fs::path program = found_above(folder); !program.empty()) return program;
  throw mtf::RuntimeError(
      "cannot find libexec/mtfkit/mtfkit-import, the program that reads mesh files, neither above " + own.string() +
      " nor above the folders of the run path; install mtfkit with it, or name it in the "
      "environment variable MTFKIT_IMPORT");
}

/// Runs the process to its end. Throws RuntimeError when it cannot be started.
ImportRun run_import(const ImportRequest& request) {
  const fs::path program = import_program();
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) refuse_start(errno);
  const Descriptor out(ends[0]);
  Descriptor in(ends[1]);
  Child child(spawn(program,
                    {program.string(), request.extension, request.folder.string(), std::to_string(request.memory_bytes),
                     std::to_string(request.cpu_s), std::to_string(request.output_bytes)},
                    request.descriptor, in.number()));
  in.close();

  ImportRun run;
  const auto deadline = Clock::now() + std::chrono::seconds(import_patience * request.cpu_s);
  run.end = receive(out.number(), deadline, request.output_bytes, run.bytes);
  if (run.end != ImportEnd::sent) child.kill();
  const int status = child.wait();
  if (run.end == ImportEnd::sent && WIFSIGNALED(status))
    run.end = WTERMSIG(status) == SIGXCPU ? ImportEnd::too_long : ImportEnd::crashed;
  if (run.end == ImportEnd::sent && (!WIFEXITED(status) || WEXITSTATUS(status) != 0)) run.end = ImportEnd::crashed;
  return run;
}

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
    if (descriptor() < 0 || ::fstat(descriptor(), &status) != 0)
      refuse(file, std::generic_category().message(errno), "check the path and its permissions");
    size_ = static_cast<std::uint64_t>(status.st_size);
    if (S_ISDIR(status.st_mode)) refuse(file, "it is a folder", "name a mesh file in it");
    if (!S_ISREG(status.st_mode)) refuse(file, "it is not an ordinary file", "store the mesh in a file first");
    if (size_ == 0) refuse(file, "the file is empty", "copy or export it again");
  }
  int descriptor() const { return descriptor_.number(); }
  std::uint64_t size() const { return size_; }

 private:
  Descriptor descriptor_;
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
