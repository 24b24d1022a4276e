// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/mesh_stream.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "mtf/error.h"

namespace apps::scene {
namespace {

using radiometry::scene::Mesh;
using radiometry::scene::Point;

void require(bool condition, const char* what) {
  if (!condition) throw mtf::RuntimeError(what);
}

class Writer {
 public:
  explicit Writer(std::uint64_t size) { bytes_.reserve(size); }

  template <class T>
  void put(std::span<const T> values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  template <class T>
  void put(T value) {
    put(std::span<const T>(&value, 1));
  }
  void put_names(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      put(static_cast<std::uint32_t>(name.size()));
      bytes_ += name;
    }
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}

  std::string_view take(std::uint64_t size) {
    require(size <= left_.size(), "the mesh that was sent is shorter than it says");
    const std::string_view taken = left_.substr(0, size);
    left_.remove_prefix(size);
    return taken;
  }
  template <class T>
  std::vector<T> array(std::uint64_t count) {
    require(count <= left_.size() / sizeof(T), "the mesh that was sent is shorter than it says");
    const std::string_view bytes = take(count * sizeof(T));
    std::vector<T> values(count);
    if (count > 0) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  template <class T>
  T one() {
    return array<T>(1).front();
  }
  std::vector<std::string> names(std::uint64_t count) {
    require(count <= left_.size() / sizeof(std::uint32_t), "the mesh that was sent is shorter than it says");
    std::vector<std::string> read;
    for (std::uint64_t i = 0; i < count; ++i) read.emplace_back(take(one<std::uint32_t>()));
    return read;
  }
  std::string_view rest() const { return left_; }

 private:
  std::string_view left_;
};

bool all_below(const std::vector<std::uint32_t>& indices, std::size_t count) {
  return std::all_of(indices.begin(), indices.end(), [count](std::uint32_t index) { return index < count; });
}

Mesh read_mesh(Reader& reader) {
  const std::vector<std::uint64_t> counts = reader.array<std::uint64_t>(6);
  const std::uint64_t faces = counts[1];
  Mesh mesh;
  mesh.vertices = reader.array<Point>(counts[0]);
  mesh.corners = reader.array<std::uint32_t>(counts[2]);
  const std::vector<std::uint32_t> sizes = reader.array<std::uint32_t>(faces);
  mesh.group = reader.array<std::uint32_t>(faces);
  mesh.material = reader.array<std::uint32_t>(faces);
  mesh.group_names = reader.names(counts[3]);
  mesh.material_names = reader.names(counts[4]);
  mesh.notes = reader.names(counts[5]);
  require(reader.rest().empty(), "the mesh that was sent is longer than it says");

  require(all_below(mesh.corners, mesh.vertices.size()), "a face has a vertex that is not there");
  require(all_below(mesh.group, mesh.group_names.size()), "a face has a group that is not there");
  require(all_below(mesh.material, mesh.material_names.size()), "a face has a material that is not there");
  mesh.first.reserve(faces + 1);
  mesh.first.push_back(0);
  for (const std::uint32_t size : sizes) mesh.first.push_back(mesh.first.back() + size);
  require(mesh.first.back() == mesh.corners.size(), "the corners of the faces do not add up");
  return mesh;
}

std::uint64_t names_size(const std::vector<std::string>& names) {
  std::uint64_t size = 0;
  for (const std::string& name : names) size += sizeof(std::uint32_t) + name.size();
  return size;
}

}  // namespace

std::uint64_t stream_size(const Mesh& mesh) {
  return 7 * sizeof(std::uint64_t) + mesh.vertices.size() * sizeof(Point) +
         (mesh.corners.size() + 3 * mesh.faces()) * sizeof(std::uint32_t) + names_size(mesh.group_names) +
         names_size(mesh.material_names) + names_size(mesh.notes);
}

std::string encode_mesh(const Mesh& mesh) {
  Writer out(stream_size(mesh));
  for (const std::uint64_t number :
       {static_cast<std::uint64_t>(ImportOutcome::mesh), std::uint64_t{mesh.vertices.size()},
        std::uint64_t{mesh.faces()}, std::uint64_t{mesh.corners.size()}, std::uint64_t{mesh.group_names.size()},
        std::uint64_t{mesh.material_names.size()}, std::uint64_t{mesh.notes.size()}})
    out.put(number);
  out.put(std::span<const Point>(mesh.vertices));
  out.put(std::span<const std::uint32_t>(mesh.corners));
  for (std::size_t face = 0; face < mesh.faces(); ++face)
    out.put(static_cast<std::uint32_t>(mesh.first[face + 1] - mesh.first[face]));
  out.put(std::span<const std::uint32_t>(mesh.group));
  out.put(std::span<const std::uint32_t>(mesh.material));
  out.put_names(mesh.group_names);
  out.put_names(mesh.material_names);
  out.put_names(mesh.notes);
  return out.take();
}

std::string encode_failure(ImportOutcome outcome, std::string_view text) {
  Writer out(sizeof(std::uint64_t) + text.size());
  out.put(static_cast<std::uint64_t>(outcome));
  out.put(std::span<const char>(text.data(), text.size()));
  return out.take();
}

DecodedImport decode_import(std::string_view bytes) {
  Reader reader(bytes);
  DecodedImport decoded;
  const std::uint64_t kind = reader.one<std::uint64_t>();
  require(kind >= static_cast<std::uint64_t>(ImportOutcome::mesh) &&
              kind <= static_cast<std::uint64_t>(ImportOutcome::too_large),
          "what was sent is no mesh");
  decoded.outcome = static_cast<ImportOutcome>(kind);
  if (decoded.outcome == ImportOutcome::mesh)
    decoded.mesh = read_mesh(reader);
  else
    decoded.text = reader.rest();
  return decoded;
}

}  // namespace apps::scene
