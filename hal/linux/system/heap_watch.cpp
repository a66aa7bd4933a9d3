#include "hal/linux/system/heap_watch.h"

#include <atomic>
#include <cstdlib>

namespace stof::hal::linux {
namespace {

// volatile: compilers know malloc, and that it writes no variable of ours.
thread_local volatile std::uint32_t watched = 0;  // the generation that this thread asked for
thread_local volatile std::uint32_t depth = 0;    // of MarkedHeap
std::atomic<std::uint32_t> generation{0};
std::atomic<std::uint64_t> calls{0};
std::atomic<std::uint64_t> marked{0};
std::atomic<bool> counted{false};

void add_one(std::atomic<std::uint64_t>& count) noexcept {
  // One thread writes.
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

void note_heap_call() noexcept {
  const std::uint32_t mine = watched;
  if (mine == 0 || mine != generation.load(std::memory_order_relaxed)) {
    return;
  }
  add_one(depth == 0 ? calls : marked);
}

void watch_heap_of_this_thread() noexcept {
  watched = generation.fetch_add(1, std::memory_order_relaxed) + 1;
  const std::uint64_t before = calls.load(std::memory_order_relaxed);
  const std::uint32_t scopes = depth;
  depth = 0;
  // Does a call of the heap come by here? A compiler may leave out a block that nobody looks at.
  void* volatile const block = std::malloc(1);
  std::free(block);
  depth = scopes;
  counted.store(calls.load(std::memory_order_relaxed) != before, std::memory_order_relaxed);
  calls.store(0, std::memory_order_relaxed);
  marked.store(0, std::memory_order_relaxed);
}

HeapCounts heap_counts() noexcept {
  return {.counted = counted.load(std::memory_order_relaxed),
          .calls = calls.load(std::memory_order_relaxed),
          .marked = marked.load(std::memory_order_relaxed)};
}

MarkedHeap::MarkedHeap() noexcept { depth = depth + 1; }
MarkedHeap::~MarkedHeap() { depth = depth - 1; }

}  // namespace stof::hal::linux
