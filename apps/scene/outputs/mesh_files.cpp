// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/outputs/mesh_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <string_view>

#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/words.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
using radiometry::scene::Mesh;
using radiometry::scene::Point;

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw mtf::UsageError("cannot write the mesh " + mtf::printable(file.string(), 1000) + ": " + what);
}

void append(mtf::io::AtomicFile& file, std::string_view text) { file.write(text.data(), text.size()); }

static_assert(std::endian::native == std::endian::little, "append_binary is for such machines");

/// The bytes of a number, lowest first.
template <class T>
void append_binary(mtf::io::AtomicFile& file, T value) {
  file.write(&value, sizeof value);
}

/// The bytes of a number, highest first.
template <class T>
void append_big_endian(mtf::io::AtomicFile& file, T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  std::reverse(bytes.begin(), bytes.end());
  file.write(bytes.data(), bytes.size());
}

void check_obj_names(const fs::path& file, const std::vector<std::string>& names) {
  constexpr std::string_view blanks = " \t\v\f";
  for (const std::string& name : names)
    if (name.find_first_of("\r\n") != std::string::npos || name.ends_with('\\') ||
        (!name.empty() && (blanks.find(name.front()) != blanks.npos || blanks.find(name.back()) != blanks.npos)))
      refuse(file,
             "OBJ cannot hold the name \"" + mtf::printable(name) +
                 "\"; take one without line breaks, without blanks at its ends and without a backslash at its end");
}

bool is_word(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

void check_values(const fs::path& file, const std::vector<MeshValues>& all, std::size_t count, const char* of) {
  for (const MeshValues& values : all) {
    if (!is_word(values.name))
      refuse(file, "values cannot have the name \"" + mtf::printable(values.name) + "\"; take letters, digits and _");
    if (values.values.size() != count)
      refuse(file, "there are " + mtf::io::number_text(values.values.size()) + " values of \"" + values.name +
                       "\" for " + mtf::io::number_text(count) + " " + of);
  }
}

void check_values(const fs::path& file, const Mesh& mesh, const std::vector<MeshValues>& of_vertices,
                  const std::vector<MeshValues>& of_faces) {
  check_values(file, of_vertices, mesh.vertices.size(), "vertices");
  check_values(file, of_faces, mesh.faces(), "faces");
}

/// Whether every face has few enough corners for the type of their number that all programs read.
bool has_small_faces(const Mesh& mesh) {
  for (std::size_t face = 0; face < mesh.faces(); ++face)
    if (mesh.corners_of(face).size() > std::numeric_limits<std::uint8_t>::max()) return false;
  return true;
}

std::string ply_header(const Mesh& mesh, const std::vector<MeshValues>& of_vertices,
                       const std::vector<MeshValues>& of_faces) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment written by mtfkit; metres, x east, y north, z up\n";
  const auto add_names = [&text](const char* kind, const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i)
      text += std::string("comment ") + kind + " " + std::to_string(i) + " " + mtf::printable(names[i]) + "\n";
  };
  const auto add_values = [&text](const std::vector<MeshValues>& all) {
    for (const MeshValues& values : all) text += "property float " + values.name + "\n";
  };
  add_names("group", mesh.group_names);
  add_names("material", mesh.material_names);
  text += "element vertex " + std::to_string(mesh.vertices.size()) + "\n";
  text += "property double x\nproperty double y\nproperty double z\n";
  add_values(of_vertices);
  text += "element face " + std::to_string(mesh.faces()) + "\n";
  text += std::string("property list ") + (has_small_faces(mesh) ? "uchar" : "uint") +
          " int vertex_indices\nproperty int group\nproperty int material\n";
  add_values(of_faces);
  return text + "end_header\n";
}

}  // namespace

void write_obj(const fs::path& file, const Mesh& mesh) {
  check_obj_names(file, mesh.group_names);
  check_obj_names(file, mesh.material_names);
  mtf::io::AtomicFile out(file.string());
  append(out, "# written by mtfkit; metres, x east, y north, z up\n");
  std::string line;
  for (const Point& p : mesh.vertices) {
    line = "v";
    for (const double x : p) line += " " + mtf::io::number_text(x);
    append(out, line + "\n");
  }
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t group = none, material = none;
  for (std::size_t face = 0; face < mesh.faces(); ++face) {
    line.clear();
    if (mesh.group[face] != group) line += "g " + mesh.group_names[group = mesh.group[face]] + "\n";
    if (mesh.material[face] != material) line += "usemtl " + mesh.material_names[material = mesh.material[face]] + "\n";
    line += "f";
    for (const std::uint32_t corner : mesh.corners_of(face))
      line += " " + mtf::io::number_text(corner + std::uint64_t{1});
    append(out, line + "\n");
  }
  out.commit();
}

void write_ply(const fs::path& file, const Mesh& mesh, const std::vector<MeshValues>& of_vertices,
               const std::vector<MeshValues>& of_faces) {
  check_values(file, mesh, of_vertices, of_faces);
  const bool small = has_small_faces(mesh);
  mtf::io::AtomicFile out(file.string());
  append(out, ply_header(mesh, of_vertices, of_faces));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (const double x : mesh.vertices[i]) append_binary(out, x);
    for (const MeshValues& values : of_vertices) append_binary(out, values.values[i]);
  }
  for (std::size_t face = 0; face < mesh.faces(); ++face) {
    const std::span<const std::uint32_t> corners = mesh.corners_of(face);
    if (small)
      append_binary(out, static_cast<std::uint8_t>(corners.size()));
    else
      append_binary(out, static_cast<std::uint32_t>(corners.size()));
    out.write(corners.data(), corners.size_bytes());
    append_binary(out, mesh.group[face]);
    append_binary(out, mesh.material[face]);
    for (const MeshValues& values : of_faces) append_binary(out, values.values[face]);
  }
  out.commit();
}

void write_vtk(const fs::path& file, const Mesh& mesh, const std::vector<MeshValues>& of_vertices,
               const std::vector<MeshValues>& of_faces) {
  check_values(file, mesh, of_vertices, of_faces);
  if (mesh.vertices.size() + mesh.corners.size() + mesh.faces() > std::numeric_limits<std::int32_t>::max())
    refuse(file, "VTK's old format counts up to 2^31 only; write PLY");
  mtf::io::AtomicFile out(file.string());
  const auto put_values = [&out](const char* type, const std::string& name, const auto& values) {
    append(out, "\nSCALARS " + name + " " + type + " 1\nLOOKUP_TABLE default\n");
    for (const auto value : values) append_big_endian(out, value);
  };
  append(out,
         "# vtk DataFile Version 3.0\nwritten by mtfkit; metres, x east, y north, z up\nBINARY\nDATASET POLYDATA\n");
  append(out, "POINTS " + std::to_string(mesh.vertices.size()) + " double\n");
  for (const Point& p : mesh.vertices)
    for (const double x : p) append_big_endian(out, x);
  append(out, "\nPOLYGONS " + std::to_string(mesh.faces()) + " " + std::to_string(mesh.corners.size() + mesh.faces()) +
                  "\n");
  for (std::size_t face = 0; face < mesh.faces(); ++face) {
    const std::span<const std::uint32_t> corners = mesh.corners_of(face);
    append_big_endian(out, static_cast<std::uint32_t>(corners.size()));
    for (const std::uint32_t corner : corners) append_big_endian(out, corner);
  }
  append(out, "\nCELL_DATA " + std::to_string(mesh.faces()));
  put_values("int", "group", mesh.group);
  put_values("int", "material", mesh.material);
  for (const MeshValues& values : of_faces) put_values("float", values.name, values.values);
  if (!of_vertices.empty()) append(out, "\nPOINT_DATA " + std::to_string(mesh.vertices.size()));
  for (const MeshValues& values : of_vertices) put_values("float", values.name, values.values);
  append(out, "\n");
  out.commit();
}

}  // namespace apps::scene
