// SPDX-License-Identifier: Apache-2.0
#include "apps/live/space/solved_scenes.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include "mtf/work/stop.h"

namespace apps::live {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kKept = 2;           ///< beside the start: each holds the temperatures of all its times
constexpr std::chrono::seconds kGone{10};  ///< a page that waits asks more often

}  // namespace

std::string stage_words(const std::string& step, double share) {
  const std::string words = step == "rays" ? "views between surfaces" : step == "heat" ? "temperatures" : step;
  return share > 0.0 ? words + ", " + std::to_string(static_cast<int>(100.0 * share)) + " %" : words;
}

/// One heat balance.
struct SolvedScenes::Work {
  std::string text, tab;
  const Clock::time_point begun = Clock::now();
  Clock::time_point asked = begun;  ///< the last time
  std::atomic<bool> ended{false};
  std::mutex mutex;
  std::string step = "meshes";
  double share = 0.0;
  std::shared_ptr<SolvedScene> scene{};
  std::exception_ptr problem{};
  bool finished = false;
  std::thread thread{};

  bool is_finished() {
    const std::scoped_lock guard(mutex);
    return finished;
  }
  std::exception_ptr what_was_wrong() {
    const std::scoped_lock guard(mutex);
    return problem;
  }
  /// What is going on.
  std::string words() {
    const std::scoped_lock guard(mutex);
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(Clock::now() - begun).count();
    return stage_words(step, share) + ", " + std::to_string(seconds) + " s";
  }
  ~Work() {
    ended = true;
    if (thread.joinable()) thread.join();
  }
};

SolvedScenes::SolvedScenes(std::string start_text, std::shared_ptr<SolvedScene> start, SolveScene solve)
    : start_text_(std::move(start_text)), start_(std::move(start)), solve_(std::move(solve)) {}
SolvedScenes::~SolvedScenes() = default;

SolvedScenes::Found SolvedScenes::find(const std::string& text, const std::string& tab) {
  const std::scoped_lock lock(mutex_);
  take_finished();
  const bool of_start = text.empty() || text == start_text_;
  const bool same = work_ && work_->text == text;
  if (work_ && !same && work_->tab == tab) end_work();  // its page wants another scene
  if (of_start) return {start_, ""};
  for (const Known& known : known_)
    if (known.text == text) return {known.scene, ""};
  const std::exception_ptr wrong = work_ ? work_->what_was_wrong() : nullptr;
  if (same) {
    work_->asked = Clock::now();
    if (wrong) std::rethrow_exception(wrong);
    return {nullptr, work_->words()};
  }
  const bool busy = work_ && !wrong && Clock::now() - work_->asked < kGone;
  if (busy) return {nullptr, "waits for another page's: " + work_->words()};
  end_work();
  const auto begun = std::make_shared<Work>();
  begun->text = text;
  begun->tab = tab;
  Work& work = *begun;
  work.thread = std::thread([this, &work] {
    const mtf::StopScope stop(&work.ended);
    std::shared_ptr<SolvedScene> scene;
    std::exception_ptr problem;
    try {
      scene = solve_(work.text, [&work](const std::string& step, double share) {
        const std::scoped_lock guard(work.mutex);
        work.step = step;
        work.share = share;
      });
    } catch (...) {
      problem = std::current_exception();
    }
    const std::scoped_lock guard(work.mutex);
    work.scene = std::move(scene);
    work.problem = problem;
    work.finished = true;
  });
  work_ = begun;
  return {nullptr, work.words()};
}

void SolvedScenes::end_work() {
  std::erase_if(ended_, [](const auto& work) { return work->is_finished(); });
  if (!work_) return;
  work_->ended = true;
  ended_.push_back(std::move(work_));
  work_.reset();
}

void SolvedScenes::take_finished() {
  if (!work_) return;
  {
    const std::scoped_lock guard(work_->mutex);
    if (!work_->finished || work_->problem) return;
    known_.push_back({work_->text, std::move(work_->scene)});
  }
  work_.reset();
  if (known_.size() > kKept) known_.erase(known_.begin());
}

}  // namespace apps::live
