// SPDX-License-Identifier: Apache-2.0
#include "apps/live/server.h"

#include <httplib.h>
#include <malloc.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <list>
#include <mutex>
#include <optional>
#include <thread>

#include "apps/live/access.h"
#include "mtf/error.h"

namespace apps::live {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{5};     ///< for a peer that neither sends nor reads
constexpr std::chrono::seconds kRequest{10};     ///< for all of a request, and for an answer beside kSlowest
constexpr double kSlowest = 4096.0;              ///< bytes a second, at which an answer has to be read
constexpr std::chrono::seconds kIdle{1};         ///< an open connection without a request
constexpr std::chrono::seconds kSpare{2};        ///< a thread without a connection
constexpr std::chrono::milliseconds kLook{100};  ///< so often a waiting thread sees that the server ends
constexpr std::chrono::seconds kPresence{5};     ///< a page's open request is answered so late, and asked anew
constexpr int kMostThreads = 1200;               ///< each waits for one connection
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A thread for each open connection, made when all others are at work: connections that are held open without a
/// request do not keep others waiting. One that has had none for a while ends.
class ConnectionThreads : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> job) override {
    const std::scoped_lock lock(mutex_);
    for (std::thread& thread : ended_threads_) thread.join();
    ended_threads_.clear();
    jobs_.push_back(std::move(job));
    if (idle_ < jobs_.size() && threads_.size() < static_cast<std::size_t>(kMostThreads)) try {
        const auto place = threads_.emplace(threads_.end());
        *place = std::thread([this, place] { work(place); });
      } catch (const std::system_error&) {
        threads_.pop_back();
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
    std::unique_lock lock(mutex_);
    all_ended_.wait(lock, [&] { return threads_.empty(); });
    for (std::thread& thread : ended_threads_) thread.join();
    ended_threads_.clear();
  }

 private:
  void work(std::list<std::thread>::iterator place) {
    std::unique_lock lock(mutex_);
    for (;;) {
      ++idle_;
      wake_.wait_for(lock, kSpare, [&] { return !jobs_.empty() || ended_; });
      --idle_;
      if (jobs_.empty()) break;
      const std::function<void()> job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      job();
      lock.lock();
    }
    ended_threads_.splice(ended_threads_.end(), threads_, place);  // whose last step this is
    if (threads_.empty()) all_ended_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable wake_, all_ended_;
  std::deque<std::function<void()>> jobs_;
  std::list<std::thread> threads_, ended_threads_;
  std::size_t idle_ = 0;
  bool ended_ = false;
};

/// A connection whose requests come whole within a time, and whose answers are read: neither a byte every few seconds
/// nor nothing at all keeps a thread for long, and none outlasts the server.
class Connection : public httplib::Stream {
 public:
  Connection(socket_t socket, const std::atomic<bool>& ending) : socket_(socket), ending_(ending) {}

  bool wait_for_request() { return begin_ < end_ || ready(POLLIN, Clock::now() + kIdle); }
  void begin_request() {
    read_until_ = Clock::now() + kRequest;
    write_until_.reset();
  }

  bool is_readable() const override { return begin_ < end_ || ready(POLLIN, soon(read_until_)); }
  bool is_writable() const override {
    // From the first byte of the answer on, which may have taken long to make.
    if (!write_until_) write_until_ = Clock::now() + kRequest;
    return ready(POLLOUT, soon(*write_until_));
  }
  ssize_t read(char* to, std::size_t size) override {
    if (begin_ == end_) {
      if (!is_readable()) return -1;
      const ssize_t came = ::recv(socket_, bytes_.data(), bytes_.size(), 0);
      if (came <= 0) return came;
      begin_ = 0, end_ = static_cast<std::size_t>(came);
    }
    const std::size_t count = std::min(size, end_ - begin_);
    std::copy_n(bytes_.data() + begin_, count, to);
    begin_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, std::size_t size) override {
    if (!is_writable()) return -1;
    const ssize_t sent = ::send(socket_, from, size, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0) return errno == EAGAIN || errno == EINTR ? 0 : -1;
    *write_until_ += std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(static_cast<double>(sent) / kSlowest));
    return sent;
  }
  void get_remote_ip_and_port(std::string& address, int& port) const override { address = "127.0.0.1", port = 0; }
  void get_local_ip_and_port(std::string& address, int& port) const override { address = "127.0.0.1", port = 0; }
  socket_t socket() const override { return socket_; }

 private:
  static Clock::time_point soon(Clock::time_point until) { return std::min(until, Clock::now() + kPatience); }
  bool ready(short event, Clock::time_point until) const {
    while (!ending_) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
      if (left.count() <= 0) return false;
      pollfd end{socket_, event, 0};
      const int found = ::poll(&end, 1, static_cast<int>(std::min<std::int64_t>(left.count(), kLook.count())));
      if (found != 0) return found > 0 || errno == EINTR;
    }
    return false;
  }

  socket_t socket_;
  const std::atomic<bool>& ending_;
  Clock::time_point read_until_ = Clock::now() + kRequest;
  mutable std::optional<Clock::time_point> write_until_;
  std::array<char, 4096> bytes_{};
  std::size_t begin_ = 0, end_ = 0;
};

/// httplib's server over such connections.
class ConnectionServer : public httplib::Server {
 public:
  std::atomic<bool> ending{false};

 private:
  bool process_and_close_socket(socket_t socket) override {
    Connection connection(socket, ending);
    for (bool closed = false; !closed && !ending && connection.wait_for_request();) {
      connection.begin_request();
      if (!process_request(connection, false, closed, nullptr)) break;
    }
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return true;
  }
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
/// which within one machine only takes time: 0.16 s of the page's script. httplib does not check ranges.
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
  ConnectionServer http;
  std::thread listening;
  int port = 0;
  std::atomic<int> waiting{0};  ///< requests of pages at work or held open
  std::atomic<Clock::rep> last{Clock::now().time_since_epoch().count()};
  std::mutex mutex;
  std::condition_variable ending;
  bool stopped = false;
  std::atomic<bool> listened{false};  ///< and ends

  /// Holds a page's request open, as a sign that the page is there.
  void presence() {
    std::unique_lock lock(mutex);
    ending.wait_for(lock, kPresence, [&] { return stopped; });
    // The C library keeps what larger pictures needed, in holes between blocks that are in use.
    ::malloc_trim(0);
  }

  void serve(const httplib::Request& request, httplib::Response& response) {
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
};

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
  http.set_keep_alive_max_count(1'000'000'000);  // which answers name; connections end as ConnectionServer says
  http.set_keep_alive_timeout(kIdle.count());
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
  state_->http.ending = true;
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
