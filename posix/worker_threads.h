#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace stof::posix {

// Threads that are there from the start, for work that splits into parts. A job's result must not
// depend on which thread does a part, nor on the order of parts; then it never depends on how many
// threads there are.
class WorkerThreads {
 public:
  static constexpr int kMost = 8;

  // Does one part. thread: 0 is the caller of run(); two parts that run at the same time have two
  // threads, so that memory for each thread is never shared.
  using Call = void(void* object, int part, int thread) noexcept;

  struct Params {
    int threads = 1;                        // 1 .. kMost; whoever calls run() is one of them
    const char* name = "stof-work";         // and a number; up to 12 bytes
    void (*prepare)(int thread) = nullptr;  // what each new thread does first
    std::size_t stack_bytes = std::size_t{256} << 10;
  };

  // Starts the threads, which have the scheduling of the caller's. Allocates nothing later.
  explicit WorkerThreads(const Params& params) noexcept;
  // Ends them. Not while run() is.
  ~WorkerThreads();
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  // How many there are, the caller of run() included.
  int threads() const noexcept { return threads_; }
  // Why the system refused some, an errno; those that started do the work. 0: there are all.
  int error() const noexcept { return error_; }

  // Calls call(object, part, thread) for parts 0 .. parts - 1, by threads 0 .. threads - 1 of
  // these; returns when all are done. Each thread goes through neighbouring parts upwards, then
  // takes over the last that another has left, one at a time. One caller at a time. Waits, on
  // either side, spin for some microseconds, then sleep.
  void run(int parts, int threads, Call* call, void* object) noexcept;

 private:
  struct alignas(64) Share {
    std::atomic<std::uint64_t> left{0};
  };
  struct Start {
    WorkerThreads* workers;
    int thread;
  };

  void serve(int thread) noexcept;
  void work(int thread) noexcept;
  bool take(int thread, int& part) noexcept;

  Params params_;
  int threads_ = 1;
  int error_ = 0;
  Call* call_ = nullptr;
  void* object_ = nullptr;
  std::array<Share, kMost> shares_;                  // parts that nobody has begun
  alignas(64) std::atomic<std::uint32_t> runs_{0};   // changes when there is work
  alignas(64) std::atomic<std::uint32_t> parts_{0};  // that are not done
  std::atomic<bool> ending_{false};
  std::array<Start, kMost> starts_{};
  std::array<unsigned long, kMost> handles_{};  // pthread_t
};

}  // namespace stof::posix
