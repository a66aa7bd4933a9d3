#pragma once

#include <algorithm>
#include <memory>
#include <type_traits>

#include "dsp/base/image.h"

// Work that splits by rows, for threads that somebody else owns. A job's result must not depend on
// which thread does a part, nor on the order of parts.
namespace stof::dsp {

// Refers to a callable `void(int part, int thread) noexcept`, which outlives it. thread: 0 is the
// caller of run(); two parts that run at the same time have two threads, so that memory for each
// thread is never shared.
class PartJob {
 public:
  using Call = void(void* object, int part, int thread) noexcept;

  template <typename F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, PartJob> &&
             std::is_nothrow_invocable_v<F&, int, int>)
  // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload): a reference
  PartJob(F&& job) noexcept
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(job)))),  // NOLINT: type
        call_([](void* object, int part, int thread) noexcept {                     // comes back
          (*static_cast<std::remove_reference_t<F>*>(object))(part, thread);
        }) {}

  void operator()(int part, int thread) const noexcept { call_(object_, part, thread); }
  Call* call() const noexcept { return call_; }
  void* object() const noexcept { return object_; }

 private:
  void* object_;
  Call* call_;
};

// The threads that one user may have: by itself, just the caller.
class Crew {
 public:
  static constexpr int kMost = 8;

  Crew() noexcept = default;
  // Up to so many of those that `pool` has. Pool: posix::WorkerThreads or alike, outlives this;
  // threads() says how many there are, run(parts, threads, call, object) has them do the parts.
  template <typename Pool>
  Crew(Pool& pool, int threads) noexcept
      : pool_(&pool),
        run_([](void* at, int parts, int used, PartJob job) noexcept {
          static_cast<Pool*>(at)->run(parts, used, job.call(), job.object());
        }),
        threads_(std::clamp(threads, 1, pool.threads())) {
    static_assert(Pool::kMost <= kMost);
  }

  // Stands for so many where memory is measured; the caller does all the work.
  static Crew standing_for(int threads) noexcept {
    Crew crew;
    crew.threads_ = threads;
    return crew;
  }

  // At most so many of these.
  Crew first(int threads) const noexcept {
    Crew fewer = *this;
    fewer.threads_ = std::clamp(threads, 1, threads_);
    return fewer;
  }
  int threads() const noexcept { return threads_; }

  void run(int parts, PartJob job) const noexcept {
    if (run_ != nullptr) {
      run_(pool_, parts, threads_, job);
      return;
    }
    for (int part = 0; part < parts; ++part) {
      job(part, 0);
    }
  }

  // job(Rows, thread) for stripes of `step` rows, the last one perhaps of fewer.
  template <typename Job>
  void run_rows(Rows rows, int step, Job&& job) const noexcept {
    const auto stripe = [&](int part, int thread) noexcept {
      const int begin = rows.begin + part * step;
      job(Rows{begin, std::min(begin + step, rows.end)}, thread);
    };
    run((rows.count() + step - 1) / step, stripe);
  }

 private:
  void* pool_ = nullptr;
  void (*run_)(void* pool, int parts, int threads, PartJob job) noexcept = nullptr;
  int threads_ = 1;
};

}  // namespace stof::dsp
