// SPDX-License-Identifier: Apache-2.0
#pragma once

// Who may ask. The server listens on the loopback interface, where every user and every web page of this machine can
// reach it. A request has to come from the page itself:
//   token    128 random bits, in the fragment of the address, which a browser sends to nobody; the page sends it as a
//            header, which pages of other origins cannot do without a permission that is never given
//   Host     a name of this machine: a foreign name that resolves to 127.0.0.1 (DNS rebinding) is another one
//   Origin   where a browser names it, the server itself
// Requests with effects are POST, have a length of at most 64 KiB, and name no file.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace apps::live {

inline constexpr std::size_t kMostBody = std::size_t{64} << 10;

/// 32 hexadecimal digits of the system's random numbers. Throws RuntimeError where there are none.
std::string new_token();

struct RequestHead {
  std::string method, path;
  std::string host, origin, token;           ///< as sent; "" where there is none
  bool has_length = false, chunked = false;  ///< Content-Length is there; Transfer-Encoding is there
  bool ranged = false;                       ///< Range is there
  std::uint64_t length = 0;
};

struct Refusal {
  int status = 0;
  std::string text;
};

/// Why a request is not answered; nothing where it may be. `pages`: GET of that path is one of the files of the page.
std::optional<Refusal> refused(const RequestHead& head, std::string_view token, bool is_page_file);

/// True for 127.0.0.1, localhost and [::1], with any port: a tunnel has another one.
bool is_this_machine(std::string_view host);

}  // namespace apps::live
