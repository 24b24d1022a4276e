// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/heat/npy_rows.h"

#include "apps/text/message_words.h"
#include "mtf/error.h"

namespace apps::scene {

NpyRows::NpyRows(const std::string& path) : file_(path) {
  const auto refuse = [&](const std::string& what) { throw mtf::UsageError(one_line(path) + ": " + what); };
  if (!file_.is_float()) refuse("float32 or float64 in C order belongs here, as numpy.save writes it");
  const std::vector<std::uint64_t>& sizes = file_.shape();
  if (sizes.empty() || sizes.size() > 2) refuse("a table of facets, or of times x facets, belongs here");
  columns_ = sizes.back();
  if (sizes.size() == 2) rows_ = sizes.front();
}

std::vector<float> NpyRows::row(std::uint64_t row) {
  std::vector<float> values(columns_);
  file_.read(row * columns_, values);
  return values;
}

}  // namespace apps::scene
