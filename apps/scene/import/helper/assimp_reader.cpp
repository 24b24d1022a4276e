// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/assimp_reader.h"

#include <assimp/importerdesc.h>
#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <exception>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>

#include "apps/scene/import/helper/given_files.h"
#include "apps/scene/import/helper/mesh_builder.h"
#include "apps/scene/import/helper/number_parse.h"

namespace apps::scene {
namespace {

using radiometry::scene::Mesh;
using radiometry::scene::Point;

void require(bool condition, const char* what) {
  if (!condition) throw std::runtime_error(what);
}

/// What gives a face its group.
enum class GroupNames { of_mesh, of_node };

/// x -> linear x + shift, in double: Assimp's own product of matrices is float.
struct Affine {
  std::array<std::array<double, 3>, 3> linear{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Point shift{};
};

Affine affine_of(const aiMatrix4x4& m) {
  return {{{{m.a1, m.a2, m.a3}, {m.b1, m.b2, m.b3}, {m.c1, m.c2, m.c3}}}, {m.a4, m.b4, m.c4}};
}

Point apply(const Affine& map, const Point& p) {
  Point mapped = map.shift;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) mapped[i] += map.linear[i][j] * p[j];
  return mapped;
}

Affine product(const Affine& outer, const Affine& inner) {
  Affine result{{}, apply(outer, inner.shift)};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) result.linear[i][j] += outer.linear[i][k] * inner.linear[k][j];
  return result;
}

double determinant(const Affine& map) {
  const auto& m = map.linear;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

std::string text_of(const aiString& name) {
  return {name.data, std::min<std::size_t>(name.length, sizeof(name.data) - 1)};
}

// A face that a transform mirrors is seen from the other side: its corners run backwards.
void add_part(MeshBuilder& builder, const aiMesh& part, const Affine& map) {
  constexpr std::uint32_t unknown = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numbers(part.mNumVertices, unknown), face;  // of the vertices in the mesh
  const bool mirrored = determinant(map) < 0.0;
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const std::span<const unsigned> indices(part.mFaces[i].mIndices, part.mFaces[i].mNumIndices);
    face.clear();
    for (const unsigned index : indices) {
      require(index < part.mNumVertices, "a face has a vertex that is not there");
      const aiVector3D& p = part.mVertices[index];
      if (numbers[index] == unknown) numbers[index] = builder.vertex(apply(map, {p.x, p.y, p.z}));
      face.push_back(numbers[index]);
    }
    if (mirrored) std::reverse(face.begin(), face.end());
    builder.add_face(face);
  }
}

std::string material_name(const aiScene& scene, const aiMesh& part) {
  aiString name;
  if (part.mMaterialIndex < scene.mNumMaterials) scene.mMaterials[part.mMaterialIndex]->Get(AI_MATKEY_NAME, name);
  // The material that Assimp adds where the file names none.
  return text_of(name) == AI_DEFAULT_MATERIAL_NAME ? std::string() : text_of(name);
}

Mesh mesh_of(const aiScene& scene, GroupNames groups) {
  struct Place {
    const aiNode* node;
    Affine map;
  };
  MeshBuilder builder;
  std::vector<Place> open;  // a stack of our own: the depth of the tree is the file's choice
  if (scene.mRootNode != nullptr) open.push_back({scene.mRootNode, affine_of(scene.mRootNode->mTransformation)});
  while (!open.empty()) {
    const auto [node, map] = open.back();
    open.pop_back();
    for (const unsigned index : std::span(node->mMeshes, node->mNumMeshes)) {
      require(index < scene.mNumMeshes, "a node has a mesh that is not there");
      const aiMesh& part = *scene.mMeshes[index];
      builder.set_group(text_of(groups == GroupNames::of_node ? node->mName : part.mName));
      builder.set_material(material_name(scene, part));
      add_part(builder, part, map);
    }
    for (unsigned i = node->mNumChildren; i-- > 0;)  // the first child is taken first
      open.push_back({node->mChildren[i], product(map, affine_of(node->mChildren[i]->mTransformation))});
  }
  return builder.take();
}

void keep_only(Assimp::Importer& importer, std::string_view name) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;)
    if (importer.GetImporterInfo(i)->mName != name) importer.UnregisterLoader(importer.GetImporter(i));
  require(importer.GetImporterCount() == 1, "Assimp was built without an importer for it");
}

const aiScene& scene_of(Assimp::Importer& importer, const std::string& name, GivenFiles* files) {
  importer.SetIOHandler(files);  // which the importer owns from now on
  const aiScene* const scene = importer.ReadFile(name, 0);
  if (scene != nullptr) return *scene;
  if (importer.GetException()) std::rethrow_exception(importer.GetException());
  throw std::runtime_error(importer.GetErrorString());
}

// Binary files say how many faces of 50 bytes follow the 84 bytes at the beginning. Assimp takes a text that was cut
// between two faces for a whole one.
void check_end_of_stl(std::string_view content) {
  constexpr std::size_t head = 84, face = 50;
  std::uint32_t faces = 0;
  if (content.size() >= head)
    std::copy_n(content.data() + head - sizeof faces, sizeof faces, reinterpret_cast<char*>(&faces));
  if (content.size() == head + face * std::uint64_t{faces}) return;
  const std::size_t end = content.rfind("endsolid");
  const std::size_t line_end = end == std::string_view::npos ? end : content.find('\n', end);
  require(end != std::string_view::npos &&
              (line_end == std::string_view::npos || trimmed(content.substr(line_end)).empty()),
          "it ends before all its faces are there, or is no STL file");
}

}  // namespace

Mesh read_stl(std::string content) {
  check_end_of_stl(content);
  Assimp::Importer importer;
  keep_only(importer, "Stereolithography (STL) Importer");
  return mesh_of(scene_of(importer, "mesh.stl", new GivenFiles("mesh.stl", std::move(content), {})),
                 GroupNames::of_mesh);
}

Mesh read_gltf(const std::string& extension, std::string content, const std::filesystem::path& folder) {
  Assimp::Importer importer;
  keep_only(importer, "glTF2 Importer");
  const std::string name = "mesh" + extension;
  return mesh_of(scene_of(importer, name, new GivenFiles(name, std::move(content), folder)), GroupNames::of_node);
}

}  // namespace apps::scene
