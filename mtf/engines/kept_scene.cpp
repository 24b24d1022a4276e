// SPDX-License-Identifier: Apache-2.0
#include "mtf/engines/kept_scene.h"

#include "mtf/engines/kept_plane.h"
#include "mtf/error.h"

namespace mtf {

KeptScene::KeptScene() : planes_(std::make_shared<const std::vector<Image>>()) {}

KeptScene::KeptScene(std::shared_ptr<const std::vector<Image>> planes) : planes_(std::move(planes)) {
  if (!planes_) throw UsageError("a kept scene needs planes");
  kept_ = std::vector<KeptPlane>(planes_->size());
}

KeptScene::~KeptScene() = default;
KeptScene::KeptScene(KeptScene&&) noexcept = default;
KeptScene& KeptScene::operator=(KeptScene&&) noexcept = default;

const std::vector<Image>& KeptScene::planes() const { return *planes_; }

std::int64_t KeptScene::bytes() const {
  std::size_t sum = 0;
  for (const KeptPlane& plane : kept_) sum += plane.spectrum.numbers.size() + plane.flat.bytes();
  return static_cast<std::int64_t>(sum);
}

void KeptScene::forget() { kept_ = std::vector<KeptPlane>(planes_->size()); }

std::span<KeptPlane> KeptScene::kept() { return kept_; }

}  // namespace mtf
