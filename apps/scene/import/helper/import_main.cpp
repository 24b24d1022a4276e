// SPDX-License-Identifier: Apache-2.0
// mtfkit-import EXTENSION FOLDER MEMORY_BYTES CPU_SECONDS OUTPUT_BYTES: parses the mesh file on the standard input,
// whose name ends as NAME does, and writes the mesh to the standard output (mesh_stream.h). Started by import_mesh.cpp
// alone. The limits bind before a byte of the file is read.

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

#include "apps/scene/import/helper/buffer_file.h"
#include "apps/scene/import/helper/mesh_readers.h"
#include "apps/scene/import/mesh_stream.h"

namespace apps::scene {
namespace {

struct Request {
  std::string extension, folder;
  std::uint64_t memory_bytes, cpu_s, output_bytes;
};

void limit(int resource, rlim_t soft, rlim_t hard) {
  const rlimit both{soft, hard};
  if (::setrlimit(static_cast<__rlimit_resource>(resource), &both) != 0)
    throw std::runtime_error("no limits can be set");
}

void set_limits(const Request& request) {
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_AS, request.memory_bytes, request.memory_bytes);
  limit(RLIMIT_CPU, request.cpu_s, request.cpu_s + 1);  // SIGXCPU, then SIGKILL
}

radiometry::scene::Mesh mesh_of(const Request& request, std::string_view content) {
  if (request.extension == ".obj") return read_obj(content);
  if (request.extension == ".ply") return read_ply(content);
  if (request.extension == ".stl") return read_stl(content);
  return read_gltf(request.extension, content, request.folder);
}

std::string imported(const Request& request) {
  set_limits(request);
  const radiometry::scene::Mesh mesh = mesh_of(request, read_all(STDIN_FILENO));
  if (mesh.faces() == 0) throw std::runtime_error("it has no faces");
  if (stream_size(mesh) > request.output_bytes) return encode_failure(ImportOutcome::too_large, "");
  return encode_mesh(mesh);
}

std::string result(const Request& request) {
  try {
    return imported(request);
  } catch (const std::bad_alloc&) {
    return encode_failure(ImportOutcome::out_of_memory, "");
  } catch (const std::length_error&) {  // a container asked for more than there can be
    return encode_failure(ImportOutcome::out_of_memory, "");
  } catch (const std::exception& error) {
    return encode_failure(ImportOutcome::damaged, error.what());
  }
}

bool write_all(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

std::uint64_t number(std::string_view text) {
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

}  // namespace
}  // namespace apps::scene

int main(int argc, char** argv) {
  using namespace apps::scene;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // the process ends with the one that started it
  if (argc != 6) return 2;
  const bool sent = write_all(result({argv[1], argv[2], number(argv[3]), number(argv[4]), number(argv[5])}));
  return sent ? 0 : 1;
}
