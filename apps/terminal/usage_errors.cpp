// SPDX-License-Identifier: Apache-2.0
#include "apps/terminal/usage_errors.h"

#include <algorithm>

#include "apps/terminal/output.h"
#include "apps/text/message_words.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace apps {
namespace {

std::string meant(const std::string& word, const std::vector<std::string>& candidates) {
  const auto nearest = mtf::nearest(word, candidates);
  return nearest ? "; did you mean " + *nearest + "?" : "";
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

}  // namespace

std::string usage_complaint(const std::string& command, const std::vector<std::string>& remaining,
                            const std::vector<std::string>& options, const std::vector<std::string>& commands,
                            const std::string& otherwise) {
  const std::string help = " (see " + command + " --help)";
  const std::string where = command == "mtf" ? "" : command + ": ";
  for (const std::string& word : remaining) {
    if (word == "--") continue;
    const std::string shown = "'" + mtf::printable(word, 80) + "'";
    if (word.size() > 1 && word.front() == '-')
      return where + "unknown option " + shown + meant(word.substr(0, word.find('=')), options) + help;
    if (!commands.empty())
      return where + "unknown subcommand " + shown + meant(word, commands) + " (there are " + joined(commands) + ")";
    return where + "unexpected argument " + shown + help;
  }
  if (!commands.empty()) return where + "give a subcommand: " + joined(commands) + help;
  return where + otherwise + help;
}

std::string error_lines(std::string message, const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    const std::string value = argument.starts_with("--") && argument.find('=') != std::string::npos
                                  ? argument.substr(argument.find('=') + 1)
                                  : argument;
    if (const std::string harmless = one_line(value); harmless != value) replace_all(message, value, harmless);
  }
  if (message.find(": error: ") == std::string::npos) return "mtf: error: " + one_line(message);
  std::string lines;
  for (std::size_t at = 0; at <= message.size();) {
    const std::size_t end = std::min(message.find('\n', at), message.size());
    lines += (at > 0 ? "\n" : "") + one_line(message.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

}  // namespace apps
