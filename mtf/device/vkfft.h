// SPDX-License-Identifier: Apache-2.0
#pragma once

// VkFFT (D. Tolmachev, MIT licence), one header for all backends, compiled into each module with its VKFFT_BACKEND.

#include <vkFFT.h>

#include <string>

#include "mtf/device/backend.h"

namespace mtf {

/// Of real planes in place, without a backend. Tables in place of the device's sine and cosine, whose errors are its
/// own.
inline VkFFTConfiguration vkfft_planes(const FftShape& shape) {
  VkFFTConfiguration plan{};
  plan.FFTdim = 2;
  plan.size[0] = static_cast<std::uint64_t>(shape.width);
  plan.size[1] = static_cast<std::uint64_t>(shape.height);
  plan.numberBatches = static_cast<std::uint64_t>(shape.batch);
  plan.performR2C = 1;
  plan.useLUT = 1;
  plan.makeForwardPlanOnly = shape.forward ? 1 : 0;
  plan.makeInversePlanOnly = shape.forward ? 0 : 1;
  return plan;
}

/// Bytes of the planes.
inline std::uint64_t vkfft_bytes(const FftShape& shape) {
  return 8 * static_cast<std::uint64_t>((shape.width / 2 + 1) * shape.height * shape.batch);
}

/// A plan. What the configuration points to has to stay.
class VkFftPlan {
 public:
  explicit VkFftPlan(const VkFFTConfiguration& plan) { require(initializeVkFFT(&application_, plan), "prepare"); }
  ~VkFftPlan() { deleteVkFFT(&application_); }
  VkFftPlan(const VkFftPlan&) = delete;
  VkFftPlan& operator=(const VkFftPlan&) = delete;

  void run(VkFFTLaunchParams launch, bool forward) {
    require(VkFFTAppend(&application_, forward ? -1 : 1, &launch), "run");
  }

 private:
  static void require(VkFFTResult result, const char* what) {
    if (result == VKFFT_SUCCESS) return;
    const std::string text = std::string("VkFFT cannot ") + what + " a transform (its error " +
                             std::to_string(static_cast<int>(result)) + ")";
    if (result == VKFFT_ERROR_MALLOC_FAILED || result == VKFFT_ERROR_FAILED_TO_ALLOCATE) throw DeviceMemoryError(text);
    throw DeviceError(text);
  }
  VkFFTApplication application_{};
};

}  // namespace mtf
