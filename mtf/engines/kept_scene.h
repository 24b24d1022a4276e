// SPDX-License-Identifier: Apache-2.0
#pragma once

// A scene that is filtered again and again while the OTF changes, as in a live view or a search over parameters. Of the
// work of a run only the product with the OTF and what follows it differ then: the statistics of the planes and their
// transform stay, and are kept here from the first run on.
//
//   KeptScene scene(planes);                                       // a std::shared_ptr<const std::vector<Image>>
//   for (;;) images = sensor_plan.with(next_system()).run(scene);  // SensorPlan::run, Plan::run
//
// It belongs to its caller, and holds the planes too, so that what is kept cannot meet another scene. A run takes what
// serves its plan and border value, and makes the rest anew: any plan may follow any other, and its image has the bits
// that it has without this. Not to be used by two runs at once.
//
// Memory: a plan of an FFT method keeps the spectrum, which is about as large as the planes, twice that in double
// precision, and up to nine times as large on the canvas of a border other than reflect (mtf/border.h). Other
// methods keep a byte for every 16 samples at most. A device keeps the planes themselves.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "mtf/image.h"

namespace mtf {

struct KeptPlane;

class KeptScene {
 public:
  KeptScene();
  /// Nobody may change the planes while this shares them. Throws UsageError for null.
  explicit KeptScene(std::shared_ptr<const std::vector<Image>> planes);
  ~KeptScene();
  KeptScene(KeptScene&&) noexcept;
  KeptScene& operator=(KeptScene&&) noexcept;

  /// None after KeptScene().
  const std::vector<Image>& planes() const;
  /// Bytes that are kept besides the planes.
  std::int64_t bytes() const;
  /// Gives them back; the next run starts from the planes.
  void forget();

  /// What is kept of each plane, for plans.
  std::span<KeptPlane> kept();

 private:
  std::shared_ptr<const std::vector<Image>> planes_;
  std::vector<KeptPlane> kept_;
};

}  // namespace mtf
