#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "dsp/base/image.h"
#include "dsp/base/status.h"

// Threads that are there from the start, for work that splits by rows. A job's result must not
// depend on which thread does a part, nor on the order of parts; then it never depends on how many
// threads there are.
namespace stof::dsp {

// Refers to a callable `void(int part, int thread) noexcept`, which outlives it. thread: 0 is the
// caller of run(); two parts that run at the same time have two threads, so that memory for each
// thread is never shared.
class PartJob {
 public:
  constexpr PartJob() noexcept = default;
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

 private:
  void* object_ = nullptr;
  void (*call_)(void*, int, int) noexcept = nullptr;
};

class Workers {
 public:
  static constexpr int kMost = 8;

  struct Params {
    int threads = 1;                        // 1 .. kMost; whoever calls run() is one of them
    const char* name = "stof-work";         // and a number; up to 12 bytes
    void (*prepare)(int thread) = nullptr;  // what each new thread does first
    std::size_t stack_bytes = std::size_t{256} << 10;
  };

  // Starts the threads, which have the scheduling of the caller's. Allocates nothing later.
  explicit Workers(const Params& params) noexcept;
  // Ends them. Not while run() is.
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  // How many there are, the caller of run() included.
  int threads() const noexcept { return threads_; }
  // kDeviceError: the system refused some; those that started do the work.
  Status status() const noexcept { return status_; }

  // Calls job for parts 0 .. parts - 1, by threads 0 .. threads - 1 of these; returns when all are
  // done. Each thread goes through neighbouring parts upwards, then takes over the last that
  // another has left, one at a time. One caller at a time. Waits, on either side, spin for some
  // microseconds, then sleep.
  void run(int parts, int threads, PartJob job) noexcept;

 private:
  struct alignas(64) Share {
    std::atomic<std::uint64_t> left{0};
  };
  struct Start {
    Workers* workers;
    int thread;
  };

  void serve(int thread) noexcept;
  void work(int thread) noexcept;
  bool take(int thread, int& part) noexcept;

  Params params_;
  int threads_ = 1;
  Status status_ = Status::kOk;
  PartJob job_;
  std::array<Share, kMost> shares_;                  // parts that nobody has begun
  alignas(64) std::atomic<std::uint32_t> runs_{0};   // changes when there is work
  alignas(64) std::atomic<std::uint32_t> parts_{0};  // that are not done
  std::atomic<bool> ending_{false};
  std::array<Start, kMost> starts_{};
  std::array<unsigned long, kMost> handles_{};  // pthread_t
};

// The threads that one user may have: of nobody's, just the caller.
class Crew {
 public:
  Crew() noexcept = default;
  Crew(Workers& workers, int threads) noexcept
      : workers_(&workers), threads_(std::clamp(threads, 1, workers.threads())) {}

  int threads() const noexcept { return threads_; }

  void run(int parts, PartJob job) const noexcept {
    if (workers_ != nullptr) {
      workers_->run(parts, threads_, job);
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
  Workers* workers_ = nullptr;
  int threads_ = 1;
};

}  // namespace stof::dsp
