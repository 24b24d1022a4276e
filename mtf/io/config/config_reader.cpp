// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/config/config_reader.h"

#include <algorithm>
#include <tuple>

#include "mtf/error.h"
#include "mtf/words.h"

namespace mtf::io::cfg {
namespace {

constexpr std::size_t kMaxDiagnostics = 1000;
// Longer words are never a slip of the finger, and the edit distance is quadratic.
constexpr std::size_t kMaxGuess = 64;

bool is_axis_part(std::string_view path) { return path.ends_with("_x") || path.ends_with("_y"); }

}  // namespace

void Reader::error(Position position, std::string path, std::string text) {
  failed.insert(path);
  if (is_axis_part(path)) failed.insert(path.substr(0, path.size() - 2));
  if (diagnostics.size() < kMaxDiagnostics)
    diagnostics.push_back({.error = true, .position = position, .path = std::move(path), .text = std::move(text)});
}

void Reader::note(Position position, std::string path, std::string text, bool remark) {
  if (diagnostics.size() < kMaxDiagnostics)
    diagnostics.push_back(
        {.error = false, .position = position, .path = std::move(path), .text = std::move(text), .remark = remark});
}

bool Reader::has_failed(std::string_view path) const {
  for (;;) {
    if (failed.contains(path)) return true;
    const std::size_t dot = path.rfind('.');
    if (dot == std::string_view::npos) return false;
    path = path.substr(0, dot);
  }
}

Position Reader::position_of(std::string path) const {
  while (!path.empty()) {
    for (const std::string& candidate : {path, is_axis_part(path) ? path.substr(0, path.size() - 2) : path})
      if (const auto found = positions.find(candidate); found != positions.end()) return found->second;
    const std::size_t dot = path.rfind('.');
    path = dot == std::string::npos ? "" : path.substr(0, dot);
  }
  return {};
}

void Section::error(std::string_view key, std::string text) const {
  const Node* node = find(key);
  reader.error(node != nullptr ? node->position : table.position, at(key), std::move(text));
}

std::string suggestion(std::string_view word, std::span<const std::string_view> known) {
  std::string text;
  if (word.size() <= kMaxGuess)
    if (const auto guess = nearest(word, known)) text += "; did you mean \"" + *guess + "\"?";
  text += text.empty() ? "; known: " : " (known: ";
  return text + joined(known) + (text.find("(known: ") != std::string::npos ? ")" : "");
}

void check_keys(const Section& section, std::span<const std::string_view> known) {
  for (const Member& member : section.table.members) {
    if (section.reader.diagnostics.size() >= kMaxDiagnostics) return;  // nothing more would be shown
    const std::string path = section.at(printable(member.key, kMaxGuess));
    const auto is = [&](std::string_view key) { return key == member.key; };
    if (std::any_of(known.begin(), known.end(), is)) continue;
    section.reader.error(
        member.position, path,
        "unknown key" + (section.title.empty() ? "" : " in " + section.title) + suggestion(member.key, known));
    // The key that was meant is missing for this reason.
    if (member.key.size() > kMaxGuess) continue;
    if (const auto guess = nearest(std::string_view(member.key), known))
      if (section.find(*guess) == nullptr) section.reader.failed.insert(section.at(*guess));
  }
}

void check_keys(const Section& section, const std::vector<std::string>& known) {
  check_keys(section, std::vector<std::string_view>(known.begin(), known.end()));
}

const Node* find_table(const Section& parent, std::string_view key) {
  const Node* node = parent.find(key);
  if (node == nullptr) return nullptr;
  const std::string path = parent.at(key);
  parent.reader.positions[path] = node->position;
  if (node->kind == Node::Kind::table) return node;
  parent.reader.error(node->position, path,
                      std::string(kind_word(node->kind)) + " where a table belongs; write [" + std::string(key) +
                          "] on a line of its own and its keys below it");
  return nullptr;
}

const Node* find_tables(const Section& parent, std::string_view key) {
  const Node* list = parent.find(key);
  if (list == nullptr) return nullptr;
  parent.reader.positions[parent.at(key)] = list->position;
  const auto is_table = [](const Node& item) { return item.kind == Node::Kind::table; };
  if (list->kind == Node::Kind::array && std::all_of(list->items.begin(), list->items.end(), is_table)) return list;
  parent.error(key, "has to be a list of tables; write [[" + std::string(key) + "]] with double brackets");
  return nullptr;
}

std::string missing_text(const FieldInfo& info) {
  return "missing; write for example " + std::string(info.name) + " = " + std::string(info.example) +
         (info.doc.empty() ? "" : " (" + std::string(info.doc) + ")");
}

std::string lacks_unit_text(const Node& node, const FieldInfo& info) {
  std::string example(info.example);
  if (!example.starts_with('"')) {  // a number of the study's own, whose row has none with a unit
    const bool frequency = info.dimension == Dimension::frequency || info.dimension == Dimension::cutoff;
    example = "\"1 " + std::string(!info.unit.empty() ? info.unit : frequency ? "cy/mm" : "um") + "\"";
  }
  return shown(node) + " has no unit; write it with its unit, such as " + example;
}

std::string folder_of(const std::string& file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string::npos ? "" : file.substr(0, slash + 1);
}

std::string beside(const std::string& folder, const std::string& name) {
  return name.starts_with('/') ? name : folder + name;
}

std::string Reader::file(const std::string& name) {
  const std::string path = beside(folder, name);
  if (std::find(files.begin(), files.end(), path) == files.end()) files.push_back(path);
  return path;
}

std::string another_kind(const std::vector<Diagnostic>& diagnostics, const std::string& text, std::string_view ours) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kKinds{
      {{"frame", "a sensor file, for it has [frame]"},
       {"mesh", "the file of a 3-D scene, for it has [[mesh]]"},
       {"sensor", "a study, for it names a sensor"}}};
  if (std::none_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& one) { return one.error; })) return {};
  const Node root = read_tree(text).root;
  if (root.find(ours) != nullptr) return {};
  for (const auto& [mark, kind] : kKinds)
    if (root.find(mark) != nullptr) return std::string(kind);
  return {};
}

void sort_diagnostics(std::vector<Diagnostic>& diagnostics) {
  std::stable_sort(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::tuple(!a.error, a.position.line, a.position.column) <
           std::tuple(!b.error, b.position.line, b.position.column);
  });
}

void require_no_errors(const std::vector<Diagnostic>& diagnostics, const std::string& file) {
  std::string errors;
  for (const Diagnostic& diagnostic : diagnostics)
    if (diagnostic.error) errors += (errors.empty() ? "" : "\n") + format_diagnostic(diagnostic, file);
  if (!errors.empty()) throw UsageError(errors);
}

}  // namespace mtf::io::cfg
