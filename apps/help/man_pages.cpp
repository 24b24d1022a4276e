// SPDX-License-Identifier: Apache-2.0
#include "apps/help/man_pages.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <utility>

#include "apps/terminal/output.h"
#include "apps/terminal/today.h"
#include "mtf/version.h"

namespace apps {
namespace {

/// Text in which roff sees nothing of its own.
std::string plain(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    constexpr std::array characters{std::pair{'\\', "\\e"},  std::pair{'-', "\\-"},   std::pair{'\'', "\\(aq"},
                                    std::pair{'"', "\\(dq"}, std::pair{'`', "\\(ga"}, std::pair{'^', "\\(ha"},
                                    std::pair{'~', "\\(ti"}};
    const auto found = std::ranges::find(characters, c, [](const auto& pair) { return pair.first; });
    escaped += found != characters.end() ? found->second : std::string(1, c);
  }
  return (escaped.starts_with('.') ? "\\&" : "") + escaped;
}

std::string bold(const std::string& text) { return "\\fB" + plain(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + plain(text) + "\\fR"; }

/// In lines of moderate length.
std::string flowing(const std::string& text) {
  constexpr std::size_t width = 72;
  std::istringstream words(text);
  std::string lines, line;
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + word.size() >= width) lines += plain(std::exchange(line, "")) + "\n";
    line += (line.empty() ? "" : " ") + word;
  }
  return lines + (line.empty() ? "" : plain(line) + "\n");
}

/// Paragraphs as help has them, below a heading: indented lines stand as they are, an empty line ends a paragraph.
std::string paragraphs(const std::string& text) {
  std::istringstream lines(text);
  std::string roff, paragraph;
  bool as_it_is = false;
  const auto end = [&] {
    if (as_it_is) roff += ".fi\n.RE\n";
    if (!paragraph.empty()) roff += ".PP\n" + flowing(std::exchange(paragraph, ""));
    as_it_is = false;
  };
  for (std::string line; std::getline(lines, line);) {
    const bool indented = line.starts_with("  ");
    if (line.empty() || indented != as_it_is) end();
    if (indented && !std::exchange(as_it_is, true)) roff += ".PP\n.RS 2\n.nf\n";
    if (indented)
      roff += plain(line.substr(2)) + "\n";
    else if (!line.empty())
      paragraph += line + "\n";
  }
  end();
  return roff.substr(roff.find('\n') + 1);  // the first needs no .PP
}

std::string listed(const OptionSpec& option) {
  const auto shown = [](const std::string& name) { return name.front() == '-' ? bold(name) : italic(name); };
  const bool argument = option.names.front() != '-';
  return ".TP\n" + joined(names_of(option), shown) + (option.flag || argument ? "" : " " + italic(option.type)) + "\n" +
         flowing(option.doc + (option.required && !argument ? " (required)" : ""));
}

std::string synopsis(const std::string& name, const Command& command) {
  std::string text = bold(name) + " [" + italic("options") + "]";
  if (!command.commands.empty())
    text += command.run ? " [" + italic("command") + "]" : " " + italic("command") + " ...";
  for (const OptionSpec& option : command.options) {
    const bool argument = option.names.front() != '-';
    if (!argument && !option.required) continue;
    std::string word = argument ? italic(option.names) : bold(names_of(option).front()) + " " + italic(option.type);
    if (option.repeats) word += "...";
    text += option.required ? " " + word : " [" + word + "]";
  }
  return text + "\n";
}

std::string dashed(std::string name) {
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string page(const Command& root, const Command& command, const std::string& name) {
  const bool is_root = name == root.name;
  std::string title = dashed(name), sentence = command.doc;
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
  sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
  if (!sentence.ends_with('.')) sentence += ".";
  std::string text = ".TH " + plain(title) + " 1 " + today() + " \"mtfkit " + mtf::version + "\" mtfkit\n";
  text += ".SH NAME\n" + flowing(dashed(name) + " - " + command.doc);
  text += ".SH SYNOPSIS\n" + synopsis(name, command);
  text += ".SH DESCRIPTION\n" + paragraphs(sentence + "\n\n" + command.details);
  std::string related = is_root ? "" : ".BR " + plain(dashed(name.substr(0, name.rfind(' ')))) + " (1)";
  if (!command.commands.empty()) text += ".SH COMMANDS\n";
  for (const Command& inner : command.commands) {
    const std::string inner_name = dashed(name + " " + inner.name);
    text += ".TP\n" + bold(inner_name) + "(1)\n" + flowing(inner.doc);
    related += (related.empty() ? "" : ",\n") + (".BR " + plain(inner_name)) + " (1)";
  }
  text += ".SH OPTIONS\n";
  for (const OptionSpec& option : command.options) text += listed(option);
  text += ".TP\n" + bold("-h") + ", " + bold("--help") + "\nshow options and examples\n";
  if (!is_root) {
    text += ".SS Global options\n";
    for (const OptionSpec& option : root.options) text += listed(option);
  }
  text += ".SH EXIT STATUS\n" + flowing(std::string(kExitCodes));
  text += ".SH EXAMPLES\n" + paragraphs(command.examples);
  return text + ".SH SEE ALSO\n" + related + "\n";
}

void write_pages(const Command& root, const Command& command, const std::string& name, const std::string& folder) {
  emit(folder + "/" + dashed(name) + ".1", page(root, command, name));
  for (const Command& inner : command.commands) write_pages(root, inner, name + " " + inner.name, folder);
}

}  // namespace

void write_man_pages(const Command& root, const std::string& folder) { write_pages(root, root, root.name, folder); }

}  // namespace apps
