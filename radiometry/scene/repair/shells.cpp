// SPDX-License-Identifier: Apache-2.0
#include "radiometry/scene/repair/shells.h"

#include <algorithm>

namespace radiometry::scene {
namespace {

/// An edge as one face runs through it.
struct EdgeUse {
  std::uint64_t edge;  ///< smaller vertex in the upper half, larger one in the lower
  std::uint32_t face;
  bool forward;  ///< from the smaller vertex to the larger one
};

std::vector<EdgeUse> edge_uses(const Polygons& faces) {
  std::vector<EdgeUse> uses;
  uses.reserve(faces.corners.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::uint64_t a = face[i], b = face[(i + 1) % face.size()];
      uses.push_back({std::min(a, b) << 32 | std::max(a, b), static_cast<std::uint32_t>(f), a < b});
    }
  }
  std::sort(uses.begin(), uses.end(),
            [](const EdgeUse& a, const EdgeUse& b) { return a.edge != b.edge ? a.edge < b.edge : a.face < b.face; });
  return uses;
}

/// Calls `work` with the uses of one edge after the other.
template <class Work>
void for_each_edge(std::span<const EdgeUse> uses, const Work& work) {
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].edge == uses[begin].edge) ++end;
    work(uses.subspan(begin, end - begin));
    begin = end;
  }
}

/// Two faces that share an edge, and whether one of them has to be turned to suit the other.
struct Joint {
  std::uint32_t face, other;
  bool turned;
};

/// Joints of each face: face i has [first[i], first[i + 1]).
struct Joints {
  std::vector<Joint> list;
  std::vector<std::size_t> first;
};

Joints joints_of(std::span<const EdgeUse> uses, std::size_t faces) {
  Joints joints;
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2 || edge[0].face == edge[1].face) return;
    const bool turned = edge[0].forward == edge[1].forward;
    joints.list.push_back({edge[0].face, edge[1].face, turned});
    joints.list.push_back({edge[1].face, edge[0].face, turned});
  });
  std::sort(joints.list.begin(), joints.list.end(),
            [](const Joint& a, const Joint& b) { return a.face != b.face ? a.face < b.face : a.other < b.other; });
  joints.first.assign(faces + 1, 0);
  for (const Joint& joint : joints.list) ++joints.first[joint.face + 1];
  for (std::size_t f = 0; f < faces; ++f) joints.first[f + 1] += joints.first[f];
  return joints;
}

/// Six times the volume between the face and `middle`, positive where the face is seen from outside.
double six_volumes(std::span<const std::uint32_t> face, std::span<const Point> vertices, const Point& middle) {
  double sum = 0.0;
  const Vector a = vertices[face[0]] - middle;
  for (std::size_t i = 1; i + 1 < face.size(); ++i)
    sum += dot(a, cross(vertices[face[i]] - middle, vertices[face[i + 1]] - middle));
  return sum;
}

}  // namespace

FaceShells shells_of(const Polygons& faces, std::span<const Point> vertices, Winding winding) {
  const std::vector<EdgeUse> uses = edge_uses(faces);
  const Joints joints = joints_of(uses, faces.size());
  FaceShells shells{.shell_of = std::vector<std::uint32_t>(faces.size(), kNone),
                    .turn = std::vector<char>(faces.size(), 0)};
  std::vector<std::vector<std::uint32_t>> members;
  for (std::uint32_t seed = 0; seed < faces.size(); ++seed) {
    if (shells.shell_of[seed] != kNone) continue;
    const auto shell = static_cast<std::uint32_t>(members.size());
    std::vector<std::uint32_t> queue{seed};
    shells.shell_of[seed] = shell;
    bool consistent = true;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      const std::uint32_t face = queue[at];
      for (std::size_t j = joints.first[face]; j < joints.first[face + 1]; ++j) {
        const std::uint32_t other = joints.list[j].other;
        const auto turn = static_cast<char>(shells.turn[face] ^ static_cast<char>(joints.list[j].turned));
        if (shells.shell_of[other] == kNone) {
          shells.shell_of[other] = shell;
          shells.turn[other] = turn;
          queue.push_back(other);
        } else if (shells.turn[other] != turn) {
          consistent = false;
        }
      }
    }
    const auto turned = std::count_if(queue.begin(), queue.end(), [&](std::uint32_t f) { return shells.turn[f] != 0; });
    if (2 * static_cast<std::size_t>(turned) > queue.size())
      for (const std::uint32_t f : queue) shells.turn[f] ^= 1;
    shells.closed.push_back(static_cast<char>(consistent));
    shells.one_sided += consistent ? 0 : 1;
    members.push_back(std::move(queue));
  }

  std::vector<int> net(members.size(),
                       0);  // of one edge: times that each shell runs through it forwards, less backwards
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    for (const EdgeUse& use : edge)
      net[shells.shell_of[use.face]] += use.forward != (shells.turn[use.face] != 0) ? 1 : -1;
    for (const EdgeUse& use : edge) {
      int& sum = net[shells.shell_of[use.face]];
      if (sum != 0) shells.closed[shells.shell_of[use.face]] = 0;
      sum = 0;
    }
  });

  for (std::size_t shell = 0; shell < members.size(); ++shell) {
    double volumes = 0.0;
    if (shells.closed[shell] != 0) {
      const Point& middle = vertices[faces[members[shell].front()].front()];
      for (const std::uint32_t f : members[shell])
        volumes += (shells.turn[f] != 0 ? -1.0 : 1.0) * six_volumes(faces[f], vertices, middle);
      if (volumes < 0.0 && winding == Winding::outward) {
        volumes = -volumes;
        for (const std::uint32_t f : members[shell]) shells.turn[f] ^= 1;
      }
    }
    shells.outward.push_back(volumes > 0.0 ? 1 : 0);
  }
  return shells;
}

}  // namespace radiometry::scene
