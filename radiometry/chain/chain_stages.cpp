// SPDX-License-Identifier: Apache-2.0

// The table of the stages of the chain, and what reports and drivers ask of it.

#include <array>

#include "radiometry/chain/steps/stage_rows.h"

namespace radiometry {

std::vector<StageRow> stage_table() {
  std::vector<StageRow> table;
  for (const auto rows : {optics_rows(), light_rows(), charge_rows(), count_rows()})
    table.insert(table.end(), rows.begin(), rows.end());
  return table;
}

bool goes_through(StageRow::Part part, OutputStage stage) {
  constexpr std::array kFirst{OutputStage::radiance, OutputStage::electrons, OutputStage::dn, OutputStage::display,
                              OutputStage::display};
  return stage >= kFirst[static_cast<std::size_t>(part)];
}

std::string whole_image_stages(const System& system, const Sensor& sensor, OutputStage stage) {
  std::string text;
  for (const StageRow& row : stage_table())
    if (!row.whole_image.empty() && goes_through(row.part, stage) && row.words(system, sensor).on)
      text += (text.empty() ? "" : ", ") + std::string(row.name) + " (" + std::string(row.whole_image) + ")";
  return text;
}

std::vector<ChainStage> chain_stages(const System& system, const Sensor& sensor) {
  std::vector<ChainStage> stages;
  const auto add = [&](std::string_view name, StageWords words) {
    stages.push_back({std::string(name), words.on, std::move(words.what)});
  };
  if (!sensor.settings.detector) {
    for (const mtf::Stage stage : mtf::kStages) add(mtf::stage_name(stage), filters(system, stage));
    add("electrons", {false, "no [detector]: the output stays in the quantity of the scene"});
    return stages;
  }
  for (const StageRow& row : stage_table())
    if (row.words != nullptr) add(row.name, row.words(system, sensor));
  return stages;
}

std::vector<StageRow> stages_to_run(const System& system, const Sensor& sensor) {
  std::vector<StageRow> stages;
  for (const StageRow& row : stage_table())
    if (row.step != nullptr && (row.words == nullptr || row.words(system, sensor).on)) stages.push_back(row);
  return stages;
}

}  // namespace radiometry
