// SPDX-License-Identifier: Apache-2.0
#pragma once

// HTTP on 127.0.0.1: the page's files by GET, everything else by POST to a handler, after the checks of access.h.
// Pictures are pulled by the page, one request in flight: the next one is asked for when the last one is drawn, so that
// a picture is never older than one round trip and none queues up.

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "apps/live/session.h"

namespace apps::live {

/// A file of the page, built into the command.
struct PageFile {
  std::string_view path, type, text;
};

struct ServerOptions {
  int port = 0;  ///< 0: any that is free
  std::string token;
};

class Server {
 public:
  /// Listens at once; requests are answered from then on, `answer` from several threads. Throws RuntimeError where the
  /// port is taken.
  Server(const ServerOptions& options, std::function<const PageFile*(const std::string&)> find_file,
         std::function<Answer(const std::string& place, const std::string& body)> answer);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const;
  /// Seconds since the last request of a page that has the token; 0 while one waits for an answer. Pages keep a request
  /// open for as long as they are shown.
  double seconds_alone() const;
  /// Ends every connection that waits; the destructor does so too.
  void stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The files of the page, written into the command when it is built (EmbedFiles.cmake).

/// The file of that path, "/" for the page; null for any other. The list is all there is: no path reaches the disk.
const PageFile* find_page_file(const std::string& path);

}  // namespace apps::live
