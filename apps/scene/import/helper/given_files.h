// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files that Assimp may open: the mesh file, which is open already, and the buffers of a .gltf file, which have to
// be ordinary files in the same folder. Everything else, such as the material library of an OBJ file, is not there.

#include <assimp/IOSystem.hpp>
#include <filesystem>
#include <string>

namespace apps::scene {

class GivenFiles : public Assimp::IOSystem {
 public:
  /// `content`: of the mesh file, which Assimp knows as `name`; `folder`: of its buffers, empty when it may have none.
  GivenFiles(std::string name, std::string content, std::filesystem::path folder);

  bool Exists(const char* file) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;

 private:
  std::string name_, content_;
  std::filesystem::path folder_;
};

/// All that can be read from the descriptor. Throws std::runtime_error.
std::string read_all(int descriptor);

}  // namespace apps::scene
