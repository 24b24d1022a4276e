// SPDX-License-Identifier: Apache-2.0
// A mesh from a file: the program that parses it is found in an installation that was moved.
#include <fstream>
#include <iostream>

#include "apps/scene/import/import_mesh.h"
#include "mtf/error.h"

int main() {
  std::ofstream("square.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  try {
    const radiometry::scene::Mesh mesh = apps::scene::import_mesh("square.obj", 1.0);
    std::cout << mesh.faces() << " face of " << mesh.corners.size() << " corners\n";
    return mesh.corners.size() == 4 ? 0 : 1;
  } catch (const mtf::Error& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
