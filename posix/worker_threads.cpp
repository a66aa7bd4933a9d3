#include "posix/worker_threads.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <type_traits>

#include <pthread.h>

namespace stof::posix {
namespace {

constexpr int kSpins = 500;  // some microseconds

// Parts [begin, end), of a run by so many threads. One word, so that whoever changes it has seen
// all of it: a thread that comes late finds nothing, or the next run.
struct Parts {
  int begin;
  int end;
  int threads;

  int count() const noexcept { return end - begin; }
};
constexpr int kPartBits = 28;
constexpr std::uint64_t kPartMask = (std::uint64_t{1} << kPartBits) - 1;
static_assert(2 * kPartBits + 8 == 64 && WorkerThreads::kMost < 256);

std::uint64_t pack(const Parts& parts) noexcept {
  return static_cast<std::uint64_t>(parts.threads) << (2 * kPartBits) |
         static_cast<std::uint64_t>(parts.end) << kPartBits |
         static_cast<std::uint64_t>(parts.begin);
}

Parts unpack(std::uint64_t word) noexcept {
  return {.begin = static_cast<int>(word & kPartMask),
          .end = static_cast<int>((word >> kPartBits) & kPartMask),
          .threads = static_cast<int>(word >> (2 * kPartBits))};
}

void relax() noexcept {
#if defined(__x86_64__)
  asm volatile("pause");
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Until the value is another. What changes it must be sequentially consistent and notify.
void wait_for_change(const std::atomic<std::uint32_t>& value, std::uint32_t from) noexcept {
  for (int spin = 0; spin < kSpins; ++spin) {
    if (value.load(std::memory_order_acquire) != from) {
      return;
    }
    relax();
  }
  value.wait(from, std::memory_order_acquire);
}

// Memory of the stack is there from the start, not when a job goes deep for the first time.
[[gnu::noinline]] void touch_stack() noexcept {
  constexpr std::size_t kDeep = std::size_t{128} << 10;
  constexpr std::size_t kPage = 4096;
  std::array<volatile char, kDeep> stack;  // NOLINT(cppcoreguidelines-pro-type-member-init): below
  for (std::size_t at = 0; at < kDeep; at += kPage) {
    stack[at] = 0;
  }
}

// A precondition: whoever breaks it has a bug.
void require(bool holds) noexcept {
  if (!holds) [[unlikely]] {
    std::abort();
  }
}

std::size_t place(int thread) noexcept { return static_cast<std::size_t>(thread); }

}  // namespace

WorkerThreads::WorkerThreads(const Params& params) noexcept : params_(params) {
  require(params.threads >= 1 && params.threads <= kMost);
  static_assert(std::is_same_v<pthread_t, unsigned long>);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  error_ = pthread_attr_setstacksize(&attributes, params.stack_bytes);
  for (int thread = 1; thread < params.threads && error_ == 0; ++thread) {
    Start& start = starts_[place(thread)];
    start = {.workers = this, .thread = thread};
    const auto enter = [](void* at) -> void* {
      const Start& mine = *static_cast<Start*>(at);
      mine.workers->serve(mine.thread);
      return nullptr;
    };
    error_ = pthread_create(&handles_[place(thread)], &attributes, enter, &start);
    threads_ += error_ == 0 ? 1 : 0;
  }
  pthread_attr_destroy(&attributes);
}

WorkerThreads::~WorkerThreads() {
  ending_.store(true, std::memory_order_relaxed);
  runs_.fetch_add(1);
  runs_.notify_all();
  for (int thread = 1; thread < threads_; ++thread) {
    pthread_join(handles_[place(thread)], nullptr);
  }
}

void WorkerThreads::serve(int thread) noexcept {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%.12s-%d", params_.name, thread);
  pthread_setname_np(pthread_self(), name.data());
  if (params_.prepare != nullptr) {
    params_.prepare(thread);
  }
  touch_stack();
  // threads_ is not looked at before the first run.
  for (std::uint32_t seen = 0;;) {
    wait_for_change(runs_, seen);
    seen = runs_.load();
    if (ending_.load(std::memory_order_relaxed)) {
      return;
    }
    work(thread);
  }
}

// Until there is nothing left to begin.
void WorkerThreads::work(int thread) noexcept {
  for (int part = 0; take(thread, part);) {
    call_(object_, part, thread);
    if (parts_.fetch_sub(1) == 1) {
      parts_.notify_one();
    }
  }
}

// call_ and object_ are those of the part for as long as the part is not done.
bool WorkerThreads::take(int thread, int& part) noexcept {
  std::atomic<std::uint64_t>& own = shares_[place(thread)].left;
  std::uint64_t word = own.load(std::memory_order_acquire);
  for (Parts mine = unpack(word); mine.count() > 0; mine = unpack(word)) {
    part = mine.begin++;
    if (own.compare_exchange_weak(word, pack(mine), std::memory_order_acq_rel,
                                  std::memory_order_acquire)) {
      return true;
    }
  }
  for (int step = 1; step < kMost; ++step) {
    std::atomic<std::uint64_t>& other = shares_[place((thread + step) % kMost)].left;
    word = other.load(std::memory_order_acquire);
    for (Parts theirs = unpack(word); theirs.count() > 0 && thread < theirs.threads;
         theirs = unpack(word)) {
      part = --theirs.end;  // one at a time: only run() fills shares
      if (other.compare_exchange_weak(word, pack(theirs), std::memory_order_acq_rel,
                                      std::memory_order_acquire)) {
        return true;
      }
    }
  }
  return false;
}

void WorkerThreads::run(int parts, int threads, Call* call, void* object) noexcept {
  require(parts >= 0 && static_cast<std::uint64_t>(parts) <= kPartMask && threads >= 1);
  threads = std::min({threads, threads_, parts});
  if (threads <= 1) {
    for (int part = 0; part < parts; ++part) {
      call(object, part, 0);
    }
    return;
  }
  call_ = call;
  object_ = object;
  parts_.store(static_cast<std::uint32_t>(parts), std::memory_order_relaxed);
  const auto begin = [&](int thread) noexcept {
    return static_cast<int>(std::int64_t{parts} * thread / threads);
  };
  for (int thread = 0; thread < threads; ++thread) {
    const Parts share{.begin = begin(thread), .end = begin(thread + 1), .threads = threads};
    shares_[place(thread)].left.store(pack(share), std::memory_order_release);
  }
  runs_.fetch_add(1);
  runs_.notify_all();
  work(0);
  while (const std::uint32_t left = parts_.load()) {
    wait_for_change(parts_, left);
  }
}

}  // namespace stof::posix
