// SPDX-License-Identifier: Apache-2.0
#include "apps/live/access.h"

#include <sys/random.h>

#include <algorithm>
#include <array>

#include "mtf/error.h"

namespace apps::live {
namespace {

/// In a time that does not tell where the two differ.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned different = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    different |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  return different == 0;
}

}  // namespace

std::string new_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw mtf::RuntimeError("the system gives no random numbers, which the token of the live view is made of");
  constexpr std::string_view digits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) {
    token += digits[byte >> 4U];
    token += digits[byte & 15U];
  }
  return token;
}

bool is_this_machine(std::string_view host) {
  for (const std::string_view name : {"127.0.0.1", "localhost", "[::1]"}) {
    if (!host.starts_with(name)) continue;
    const std::string_view port = host.substr(name.size());
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };
    if (port.empty()) return true;
    if (port.size() >= 2 && port.size() <= 6 && port[0] == ':' && std::all_of(port.begin() + 1, port.end(), digit))
      return true;
  }
  return false;
}

std::optional<Refusal> refused(const RequestHead& head, std::string_view token, bool is_page_file) {
  if (!is_this_machine(head.host)) return Refusal{421, "Host: not a name of this machine"};
  if (!head.origin.empty() && head.origin != "http://" + head.host)
    return Refusal{403, "Origin: requests of other pages are not answered"};
  if (head.ranged) return Refusal{416, "Range: files and answers are given whole"};
  if (head.method == "GET") {
    if (is_page_file) return std::nullopt;
    return Refusal{404, "there is no such file"};
  }
  if (head.method != "POST") return Refusal{405, "GET for the page, POST for all else"};
  if (!same_secret(head.token, token))
    return Refusal{403, "the token is missing or wrong; open the address as printed"};
  if (head.chunked || !head.has_length) return Refusal{411, "a request says the length of its body"};
  if (head.length > kMostBody) return Refusal{413, "a body has at most 65536 bytes"};
  return std::nullopt;
}

}  // namespace apps::live
