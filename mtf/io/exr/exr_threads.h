// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <thread>

namespace mtf::io {

/// The library's pool of threads is one for the whole process; it only grows here. 0 = all cores.
inline void use_exr_threads(int threads) {
  const int wanted = threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (Imf::globalThreadCount() < wanted) Imf::setGlobalThreadCount(wanted);
}

}  // namespace mtf::io
