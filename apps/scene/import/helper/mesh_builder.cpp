// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/import/helper/mesh_builder.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>

namespace apps::scene {
namespace {

// Numbers things in the order in which they first come.
template <class Numbers, class Key>
std::uint32_t number_of(Numbers& numbers, std::vector<Key>& keys, const Key& key) {
  if (keys.size() == std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("it has more than 4e9 vertices");
  const auto [place, is_new] = numbers.try_emplace(key, static_cast<std::uint32_t>(keys.size()));
  if (is_new) keys.push_back(key);
  return place->second;
}

}  // namespace

std::size_t MeshBuilder::PointHash::operator()(const radiometry::scene::Point& point) const {
  std::uint64_t hash = 0;
  for (const double x : point) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32U;
  }
  return hash;
}

void MeshBuilder::set_group(std::string_view name) {
  group_name_ = name;
  group_.reset();
}

void MeshBuilder::set_material(std::string_view name) {
  material_name_ = name;
  material_.reset();
}

std::uint32_t MeshBuilder::vertex(radiometry::scene::Point point) {
  for (double& x : point) x += 0.0;  // -0 becomes 0
  return number_of(vertices_, mesh_.vertices, point);
}

void MeshBuilder::add_face(std::span<const std::uint32_t> vertices) {
  if (!group_) group_ = number_of(groups_, mesh_.group_names, group_name_);
  if (!material_) material_ = number_of(materials_, mesh_.material_names, material_name_);
  mesh_.add_face(vertices, *group_, *material_);
}

void MeshBuilder::note(const std::string& text) {
  if (std::find(mesh_.notes.begin(), mesh_.notes.end(), text) == mesh_.notes.end()) mesh_.notes.push_back(text);
}

}  // namespace apps::scene
