// SPDX-License-Identifier: Apache-2.0
#include "apps/live/server.h"

#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "apps/live/access.h"
#include "mtf/error.h"

namespace apps::live {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{5};  ///< for a peer that sends or reads slowly
constexpr std::chrono::seconds kIdle{1};      ///< an open connection without a request; the end waits for them
constexpr std::chrono::seconds kPresence{5};  ///< a page's open request is answered so late, and asked anew
constexpr int kMostThreads = 1200;            ///< each waits for one connection
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A thread for each open connection, made when all others are at work: connections that are held open without a
/// request do not keep others waiting.
class ConnectionThreads : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> job) override {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back(std::move(job));
    if (idle_ < jobs_.size() && threads_.size() < static_cast<std::size_t>(kMostThreads)) try {
        threads_.emplace_back([this] { work(); });
      } catch (const std::system_error&) {
        if (threads_.empty()) throw;  // the present ones will do it
      }
    wake_.notify_one();
  }
  void shutdown() override {
    {
      const std::scoped_lock lock(mutex_);
      ended_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  void work() {
    for (;;) {
      std::unique_lock lock(mutex_);
      ++idle_;
      wake_.wait(lock, [&] { return !jobs_.empty() || ended_; });
      --idle_;
      if (jobs_.empty()) return;
      const std::function<void()> job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      job();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> jobs_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool ended_ = false;
};

RequestHead head_of(const httplib::Request& request) {
  RequestHead head{.method = request.method,
                   .path = request.path,
                   .host = request.get_header_value("Host"),
                   .origin = request.get_header_value("Origin"),
                   .token = request.get_header_value("X-Mtf-Token"),
                   .has_length = request.has_header("Content-Length"),
                   .chunked = request.has_header("Transfer-Encoding"),
                   .ranged = request.has_header("Range")};
  const std::string length = request.get_header_value("Content-Length");
  // More digits than the limit has are more than the limit.
  const bool digits = !length.empty() && length.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || request.get_header_value_count("Content-Length") != 1) head.has_length = false;
  head.length = digits ? (length.size() > 12 ? kMostBody + 1 : std::stoull(length)) : 0;
  return head;
}

void answer_text(httplib::Response& response, int status, const std::string& text) {
  response.status = status;
  response.set_content(text + "\n", "text/plain; charset=utf-8");
}

/// Sends `bytes` as they are, without a copy; `owner` keeps them. A body that httplib holds itself it would compress,
/// which within one machine only takes time: 0.16 s of the page's script. httplib does not compare a range with the
/// size.
void provide(httplib::Response& response, std::string_view bytes, const std::string& type,
             std::shared_ptr<const void> owner = nullptr) {
  response.set_content_provider(
      bytes.size(), type, [bytes, owner](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return offset <= bytes.size() && sink.write(bytes.data() + offset, std::min(length, bytes.size() - offset));
      });
}

}  // namespace

struct Server::State {
  std::function<const PageFile*(const std::string&)> find_file;
  std::function<Answer(const std::string&, const std::string&)> answer;
  std::string token;
  httplib::Server http;
  std::thread listening;
  int port = 0;
  std::atomic<int> waiting{0};  ///< requests of pages at work or held open
  std::atomic<Clock::rep> last{Clock::now().time_since_epoch().count()};
  std::mutex mutex;
  std::condition_variable ending;
  bool stopped = false;
  std::atomic<bool> listened{false};  ///< and ends

  void serve(const httplib::Request& request, httplib::Response& response);
  /// Holds a page's request open, as a sign that the page is there.
  void presence();
};

void Server::State::presence() {
  std::unique_lock lock(mutex);
  ending.wait_for(lock, kPresence, [&] { return stopped; });
}

void Server::State::serve(const httplib::Request& request, httplib::Response& response) {
  struct Counted {
    State& state;
    explicit Counted(State& s) : state(s) { ++state.waiting; }
    ~Counted() {
      state.last = Clock::now().time_since_epoch().count();
      --state.waiting;
    }
  } counted(*this);
  const std::string place = request.path.substr(1);
  if (place == "here") {
    presence();
    response.set_content("{}", "application/json");
    return;
  }
  Answer made = answer(place, request.body);
  response.status = made.status;
  if (!made.body->empty()) provide(response, *made.body, made.type, made.body);
}

Server::Server(const ServerOptions& options, std::function<const PageFile*(const std::string&)> find_file,
               std::function<Answer(const std::string&, const std::string&)> answer)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.find_file = std::move(find_file);
  state.answer = std::move(answer);
  state.token = options.token;
  httplib::Server& http = state.http;
  http.new_task_queue = [] { return new ConnectionThreads; };  // httplib deletes it
  http.set_tcp_nodelay(true);
  http.set_keep_alive_max_count(1'000'000'000);
  http.set_keep_alive_timeout(kIdle.count());
  http.set_read_timeout(kPatience);
  http.set_write_timeout(kPatience);
  http.set_payload_max_length(kMostBody);
  http.set_default_headers({{"Content-Security-Policy", kPolicy},
                            {"Cross-Origin-Resource-Policy", "same-origin"},
                            {"Cross-Origin-Opener-Policy", "same-origin"},
                            {"X-Content-Type-Options", "nosniff"},
                            {"Referrer-Policy", "no-referrer"},
                            {"Cache-Control", "no-store"}});
  // Before the body is read: what is refused costs nothing.
  http.set_pre_routing_handler([&state](const httplib::Request& request, httplib::Response& response) {
    const PageFile* file = request.method == "GET" ? state.find_file(request.path) : nullptr;
    if (const auto refusal = refused(head_of(request), state.token, file != nullptr)) {
      answer_text(response, refusal->status, refusal->text);
      response.set_header("Connection", "close");
      return httplib::Server::HandlerResponse::Handled;
    }
    if (file == nullptr) return httplib::Server::HandlerResponse::Unhandled;
    provide(response, file->text, std::string(file->type));
    return httplib::Server::HandlerResponse::Handled;
  });
  http.Post("/[a-z]+",
            [&state](const httplib::Request& request, httplib::Response& response) { state.serve(request, response); });
  http.set_exception_handler([](const httplib::Request&, httplib::Response& response, std::exception_ptr) {
    answer_text(response, 500, "the request could not be answered");
  });
  const std::string address = "127.0.0.1";
  // httplib would let a second server share the port, and lets five connections wait: more lose a second each.
  socket_t listener = INVALID_SOCKET;
  http.set_socket_options([&listener](socket_t socket) {
    const int yes = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    listener = socket;
  });
  if (options.port == 0) {
    state.port = http.bind_to_any_port(address);
  } else if (http.bind_to_port(address, options.port)) {
    state.port = options.port;
  }
  if (state.port <= 0)
    throw mtf::RuntimeError("port " + std::to_string(options.port) +
                            " of 127.0.0.1 cannot be used; leave --port out for a free one");
  ::listen(listener, kMostThreads);
  http.set_socket_options([](socket_t) {});
  state.listening = std::thread([&state] {
    state.http.listen_after_bind();
    state.listened = true;
  });
}

Server::~Server() {
  stop();
  if (state_->listening.joinable()) state_->listening.join();
}

void Server::stop() {
  {
    const std::scoped_lock lock(state_->mutex);
    if (state_->stopped) return;
    state_->stopped = true;
  }
  state_->ending.notify_all();
  // A server that has not begun to listen yet would not hear it; one that cannot listen has ended already.
  while (!state_->listened && !state_->http.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  state_->http.stop();
}

int Server::port() const { return state_->port; }

double Server::seconds_alone() const {
  if (state_->waiting > 0) return 0.0;
  const Clock::time_point last{Clock::duration{state_->last.load()}};
  return std::chrono::duration<double>(Clock::now() - last).count();
}

}  // namespace apps::live
