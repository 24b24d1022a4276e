// SPDX-License-Identifier: Apache-2.0
#pragma once

// A TOML document as a small tree with the position of every key and value. config_tree.cpp makes it and is the only
// file that sees toml++; everything else about sensor files works on this tree.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/io/config/config.h"

namespace mtf::io::cfg {

/// Largest sensor file, and deepest nesting of brackets and of dotted keys in one.
inline constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
inline constexpr int kMaxBrackets = 32;
inline constexpr int kMaxDots = 16;

struct Member;

struct Node {
  enum class Kind { string, integer, real, boolean, date, array, table };
  Kind kind = Kind::table;
  Position position;
  std::string text;             ///< string; date or time as RFC 3339 writes it
  double number = 0.0;          ///< real, and integer as a real
  std::int64_t integer = 0;     ///< integer
  bool boolean = false;         ///< boolean
  std::vector<Node> items;      ///< array
  std::vector<Member> members;  ///< table, in the order of the file

  bool is_number() const { return kind == Kind::integer || kind == Kind::real; }
  const Node* find(std::string_view key) const;
};

struct Member {
  std::string key;
  Position position;
  Node value;
};

/// "a string", "a whole number", …
std::string_view kind_word(Node::Kind kind);

/// A short form of the value for messages and tables: `"15 um"`, `2.5`, `[640, 512]`.
std::string shown(const Node& node);

struct Tree {
  Node root{};
  std::optional<Diagnostic> error;  ///< syntax, size or nesting: the tree is then empty
};

/// Never throws for what is in the text.
Tree read_tree(const std::string& text);

}  // namespace mtf::io::cfg
