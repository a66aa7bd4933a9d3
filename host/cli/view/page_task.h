#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <expected>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <utility>

#include "host/viewer/requests.h"

namespace stof::host {

// What a page begins and that takes a while: one at a time, in a thread of its own, with a state
// that all pages are told, each change in its order. It is the page's that began it: no other one
// goes on with it or ends it. State has the members `by` (viewer::BegunBy), `step` and `text`. For
// any thread, but one alone starts. Waits: start() for work done; the destructor, which ends it.
template <typename State>
class PageTask {
 public:
  using Tell = std::function<void(const State& state)>;  // must not call back
  using Done = std::expected<void, std::string>;         // one line: why not
  struct End {
    std::string step{};
    std::string text{};
  };

  PageTask(State state, Tell tell) : tell_(std::move(tell)), state_(std::move(state)) {}
  ~PageTask() {
    {
      const std::scoped_lock lock(mutex_);
      ends_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) {
      thread_.join();
    }
  }
  PageTask(const PageTask&) = delete;
  PageTask& operator=(const PageTask&) = delete;

  // how: makes the state that it begins with. work: blocks as long as it likes, and looks at
  // goes_on(); where it throws, it ends with step "failed". busy: why not, where one is under way.
  template <typename Change>
  Done start(const viewer::Page& page, const char* busy, Change&& how, std::function<End()> work) {
    {
      const std::scoped_lock lock(mutex_);
      if (under_way_) {
        return std::unexpected(busy);
      }
      under_way_ = true;
      ends_ = false;
      state_.by = {.page = page.number, .place = page.place};
    }
    if (thread_.joinable()) {
      thread_.join();  // it has ended
    }
    change(std::forward<Change>(how));
    thread_ = std::thread([this, job = std::move(work)] { run(job); });
    return {};
  }

  template <typename Change>
  void change(Change&& how) {
    const std::scoped_lock lock(mutex_);
    std::forward<Change>(how)(state_);
    tell_(state_);
  }

  // By a page: where something is under way, by the one that began it. how: changes the state, or
  // returns why not.
  template <typename Change>
  Done change_by(const viewer::Page& page, Change&& how) {
    const std::scoped_lock lock(mutex_);
    const Done done = owns(page) ? std::forward<Change>(how)(state_) : refusal();
    if (done) {
      tell_(state_);
      wake_.notify_all();
    }
    return done;
  }

  // The same: ends it soon. none: why not, where nothing is under way.
  Done end_by(const viewer::Page& page, const char* none) {
    const std::scoped_lock lock(mutex_);
    if (!under_way_) {
      return std::unexpected(none);
    }
    if (!owns(page)) {
      return refusal();
    }
    ends_ = true;
    wake_.notify_all();
    return {};
  }

  bool under_way() const {
    const std::scoped_lock lock(mutex_);
    return under_way_;
  }
  bool goes_on() const {
    const std::scoped_lock lock(mutex_);
    return !ends_;
  }
  State state() const {
    const std::scoped_lock lock(mutex_);
    return state_;
  }
  // Of `work`: until the state `is` so, it is ended, or that long; whether it is so.
  template <typename Is>
  bool await(std::chrono::milliseconds longest, Is&& is) {
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, longest, [&] { return ends_ || is(state_); });
    return is(state_);
  }

 private:
  bool owns(const viewer::Page& page) const { return !under_way_ || state_.by.page == page.number; }
  Done refusal() const {
    return std::unexpected("another page, of " + state_.by.place +
                           ", began this: only that page goes on with it or ends it");
  }
  void run(const std::function<End()>& work) {
    End end{.step = "failed"};
    try {
      end = work();
    } catch (const std::exception& problem) {
      end.text = problem.what();
    }
    change([&](State& state) {
      std::tie(state.step, state.text) = std::tie(end.step, end.text);
      under_way_ = false;
    });
  }

  const Tell tell_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  State state_;
  bool under_way_ = false;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace stof::host
