// SPDX-License-Identifier: Apache-2.0

// apps/sensor/sensor_kinds.h: every kind and table, and values that a sensor file takes.

#include <gtest/gtest.h>

#include <algorithm>

#include "apps/sensor/sensor_kinds.h"
#include "mtf/error.h"
#include "mtf/io/config/config.h"
#include "radiometry/chain/sensor_settings.h"
#include "tests/apps/command.h"

namespace apps {
namespace {

const std::string kSensor =
    "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\nintegration_time = \"10 ms\"\n[optics]\n"
    "f_number = 2.0\n[band]\nwavelength = [\"3.4 um\", \"4.8 um\"]\n";

const Parameter& named(const std::vector<Parameter>& parameters, std::string_view name) {
  const auto found =
      std::find_if(parameters.begin(), parameters.end(), [&](const Parameter& p) { return p.name == name; });
  if (found == parameters.end()) throw std::runtime_error("no parameter " + std::string(name));
  return *found;
}

TEST(SensorKinds, ComponentsAreThoseOfTheList) {
  const SensorKinds kinds = sensor_kinds();
  const auto names = mtf::component_kinds();
  ASSERT_EQ(kinds.components.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const ComponentKind& kind = kinds.components[i];
    EXPECT_EQ(kind.kind, names[i]);
    EXPECT_FALSE(kind.doc.empty() || kind.notes.empty() || kind.parameters.empty()) << kind.kind;
    EXPECT_EQ(kind.parameters.size(), mtf::Component<double>::make(names[i]).fields().size());
    for (const Parameter& parameter : kind.parameters) {
      EXPECT_FALSE(parameter.doc.empty() || parameter.example.empty()) << kind.kind << "." << parameter.name;
      const bool or_word = kind.kind == "defocus" && parameter.name == "distance";  // "range" in place of a number
      EXPECT_EQ(parameter.type == mtf::FieldType::word || or_word, !parameter.words.empty())
          << kind.kind << parameter.name;
    }
  }
}

TEST(SensorKinds, RowsAreThoseOfTheFieldTable) {
  const ComponentKind jitter = component_kind("jitter");
  EXPECT_TRUE(jitter.stages.presample && !jitter.stages.readout);
  EXPECT_EQ(jitter.part, mtf::SensorPart::motion);
  const Parameter& rms = named(jitter.parameters, "rms");
  EXPECT_EQ(rms.type, mtf::FieldType::size);
  EXPECT_EQ(rms.unit, "um, urad or px");
  EXPECT_EQ(rms.hi, 1e9);
  EXPECT_EQ(rms.presence, mtf::Presence::required);
  EXPECT_EQ(rms.default_value, "");
  EXPECT_EQ(named(component_kind("gaussian").parameters, "part").default_value, "\"unspecified\"");
  EXPECT_EQ(named(component_kind("unsharp").parameters, "size").default_value, "3");
  EXPECT_EQ(named(component_kind("vibration").parameters, "phase").default_value, "\"0 deg\"");
  EXPECT_EQ(named(component_kind("rc_highpass").parameters, "cutoff").type, mtf::FieldType::frequency);
  EXPECT_EQ(named(component_kind("fir").parameters, "taps").type, mtf::FieldType::rows);
  EXPECT_EQ(named(component_kind("curve").parameters, "file").type, mtf::FieldType::file);
  EXPECT_EQ(named(component_kind("diffraction").parameters, "f_number").presence, mtf::Presence::shared);
}

// Where a default is written out it changes nothing: the file is still accepted and gives the same OTF.
TEST(SensorKinds, DefaultsSayWhatCountsWhereNothingIsGiven) {
  int compared = 0;
  for (const ComponentKind& kind : sensor_kinds().components) {
    const mtf::io::ConfigResult plain = mtf::io::parse_config(kSensor + kind.example, "");
    ASSERT_EQ(plain.ok(), kind.traits.has_value()) << kind.kind;
    for (const Parameter& parameter : kind.parameters) {
      const std::string key = std::string(parameter.name) + " = ";
      if (parameter.default_value.empty() || !plain.ok() || kind.example.find("\n" + key) != std::string::npos)
        continue;
      const mtf::io::ConfigResult written =
          mtf::io::parse_config(kSensor + kind.example + key + parameter.default_value + "\n", "");
      if (!written.ok()) continue;  // it qualifies a parameter that the example does without
      ++compared;
      for (const mtf::Freq<double>& f : {mtf::Freq<double>{7.0, 3.0}, {-20.0, 11.0}}) {
        const auto a = plain.config.system.otf(f), b = written.config.system.otf(f);
        EXPECT_TRUE(a.re == b.re && a.im == b.im) << kind.kind << "." << parameter.name;
      }
    }
  }
  EXPECT_GE(compared, 20);
}

/// Keys that take each other's place say so of each other, and the reader refuses both of them.
TEST(SensorKinds, KeysThatExcludeEachOtherDoNotStandTogether) {
  int pairs = 0;
  const auto check = [&](const std::vector<Parameter>& rows, const std::string& owner, const std::string& head) {
    for (const Parameter& row : rows)
      for (const std::string_view key : mtf::words_in(row.excludes)) {
        const Parameter& other = named(rows, key);
        const auto back = mtf::words_in(other.excludes);
        EXPECT_NE(std::find(back.begin(), back.end(), row.name), back.end()) << owner << "." << row.name;
        std::string text = head;
        const auto add = [&](const Parameter& each) {  // the example of unsharp's size is what counts without it
          text += std::string(each.name) + " = " + (each.name == "size" ? "5" : std::string(each.example)) + "\n";
        };
        for (const Parameter& each : rows)
          if (each.presence == mtf::Presence::required || &each == &row || &each == &other) add(each);
        if (row.name == "gsd" || key == "gsd") text += "range = \"5 km\"\n";
        EXPECT_FALSE(mtf::io::parse_config(text, "").ok()) << text;
        ++pairs;
      }
  };
  const SensorKinds kinds = sensor_kinds();
  for (const ComponentKind& kind : kinds.components) {
    const std::string list = kind.stages.presample ? "presample" : kind.stages.readout ? "readout" : "postsample";
    check(kind.parameters, std::string(kind.kind),
          kSensor + "[[" + list + "]]\nkind = \"" + std::string(kind.kind) + "\"\n");
  }
  const std::string frame = "schema = 1\n[frame]\nfocal_length = \"100 mm\"\npitch = \"15 um\"\n";
  for (const TableKind& table : kinds.own_tables)
    if (table.name != "frame")
      check(table.parameters, std::string(table.name), frame + "[" + std::string(table.name) + "]\n");
  EXPECT_GE(pairs, 30);
}

TEST(SensorKinds, TablesAreThoseOfTheChain) {
  const SensorKinds kinds = sensor_kinds();
  const auto tables = radiometry::sensor_tables();
  ASSERT_EQ(kinds.tables.size(), tables.size());
  for (std::size_t i = 0; i < tables.size(); ++i) {
    EXPECT_EQ(kinds.tables[i].name, tables[i].name);
    ASSERT_EQ(kinds.tables[i].parameters.size(), tables[i].settings.size());
    for (std::size_t k = 0; k < tables[i].settings.size(); ++k) {
      const Parameter& parameter = kinds.tables[i].parameters[k];
      const mtf::FieldInfo& row = tables[i].settings[k];
      EXPECT_EQ(parameter.name, row.name);
      EXPECT_EQ(parameter.hi, row.hi);
      EXPECT_EQ(parameter.unit, row.unit);
      EXPECT_EQ(parameter.type == mtf::FieldType::flag, row.type == mtf::FieldType::flag);
      EXPECT_EQ(parameter.words.size(), row.words.size());
    }
  }
}

TEST(SensorKinds, TheCommandPrintsThem) {
  const apps_test::Scratch scratch;
  const std::string text = scratch.run("mtf config kinds").out;
  for (const ComponentKind& kind : sensor_kinds().components) {
    EXPECT_TRUE(says(text, std::string(kind.kind) + ": " + std::string(kind.doc))) << kind.kind;
    for (const Parameter& parameter : kind.parameters)
      EXPECT_TRUE(says(text, std::string(parameter.doc))) << kind.kind << "." << parameter.name;
  }
}

TEST(SensorKinds, AnUnknownKindIsRefusedWithTheNearest) {
  try {
    component_kind("jiter");
    FAIL();
  } catch (const mtf::UsageError& error) {
    EXPECT_TRUE(says(error.what(), "did you mean \"jitter\"")) << error.what();
  }
}

}  // namespace
}  // namespace apps
