// SPDX-License-Identifier: Apache-2.0

// JSON as it is written and read, against nlohmann/json by itself.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/text/json.h"
#include "mtf/error.h"

namespace apps {
namespace {

using Oracle = nlohmann::ordered_json;

TEST(Json, WritesWhatIsPutIntoIt) {
  Json json{{"b", 1}, {"a", {{"x", -2.5}, {"y", nullptr}}}, {"list", {1, "two", true}}, {"one", Json{1}}};
  json["values"] = std::vector<double>{0.1, 1.0 / 3.0};
  json["map"] = std::map<std::string, int>{{"z", 1}, {"k", 2}};
  json["pairs"] = std::vector<std::pair<std::string, double>>{{"p", 1.0}};
  json["empty"] = {{"list", Json::array()}, {"object", Json::object()}, {"null", Json()}};
  json["a"]["x"] = 3;
  EXPECT_EQ(json_document(json, -1),
            R"({"b":1,"a":{"x":3,"y":null},"list":[1,"two",true],"one":[1],"values":[0.1,0.3333333333333333],)"
            R"("map":{"k":2,"z":1},"pairs":[["p",1.0]],"empty":{"list":[],"object":{},"null":null}})"
            "\n");
  json.sort();
  EXPECT_EQ(json_document(json), Oracle(nlohmann::json::parse(json_document(json))).dump(2) + "\n");
}

TEST(Json, NumbersReadBackAsTheSame) {
  constexpr double kMost = std::numeric_limits<double>::max(), kLeast = std::numeric_limits<double>::denorm_min();
  const std::array values{0.0, -0.0, 1e-300, 0.1, 123456789.125, 1e22, kMost, kLeast, std::nextafter(1.0, 2.0)};
  for (const double value : values) {
    const double read = parse_json(json_document(Json{value}))[0].get<double>();
    EXPECT_EQ(read, value);
    EXPECT_EQ(std::signbit(read), std::signbit(value));
  }
  const auto whole = [](auto value) { return parse_json(json_document(Json{value}))[0].get<decltype(value)>(); };
  EXPECT_EQ(whole(std::numeric_limits<std::int64_t>::min()), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(whole(std::numeric_limits<std::uint64_t>::max()), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(json_document(Json{std::nan(""), -INFINITY}, -1), "[null,null]\n");
}

TEST(Json, NamesThatAreNoUtf8AreReplaced) {
  EXPECT_EQ(json_document(Json{{"file", "caf\xe9.exr"}}, -1), "{\"file\":\"caf\xef\xbf\xbd.exr\"}\n");
}

TEST(Json, ReadsAndRefuses) {
  const Json json = parse_json(R"({"a": [1, -2, 3.5, "t", false, null], "a2": {}, "a": 4})");
  EXPECT_EQ(json.at("a").get<int>(), 4);
  EXPECT_EQ(json.items().size(), 2U);
  const Json list = parse_json("[1, -2, 3.5, \"t\", false, null, 5000000000]");
  EXPECT_EQ(list[2].get<double>(), 3.5);
  EXPECT_FALSE(list[4].get<bool>());
  EXPECT_TRUE(list[5].is_null());
  EXPECT_THROW(static_cast<void>(list[1].get<std::uint64_t>()), mtf::UsageError);
  EXPECT_THROW(static_cast<void>(list[6].get<int>()), mtf::UsageError);
  EXPECT_THROW(static_cast<void>(list[2].get<int>()), mtf::UsageError);
  EXPECT_THROW(static_cast<void>(list[3].get<double>()), mtf::UsageError);
  EXPECT_THROW(static_cast<void>(list.at("a")), mtf::UsageError);
  EXPECT_THROW(static_cast<void>(json.elements()), mtf::UsageError);
  for (const std::string wrong : {"", "{", "[1,]", "nan", "{\"a\" 1}", "[1] 2", "\"\xff\""})
    EXPECT_FALSE(parsed_json(wrong)) << wrong;
  EXPECT_TRUE(
      parsed_json(std::string(64, '[') + "\"[\\\"[{\"" + std::string(64, ']')));  // brackets of a text open nothing
  EXPECT_FALSE(parsed_json(std::string(65, '[') + std::string(65, ']')));
  EXPECT_FALSE(parsed_json(std::string(1'000'000, '[')));
}

}  // namespace
}  // namespace apps
