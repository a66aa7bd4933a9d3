#pragma once

#include <cstdint>

namespace stof::hal::linux {

// How often the watched thread called the heap since it asked to be watched: malloc and its like,
// and operator new as far as the C++ library is linked statically; free is not counted. Counting
// takes a program that is linked with stof_heap_watch (heap_wrap.cpp); else `counted` is false.
struct HeapCounts {
  bool counted = false;
  std::uint64_t calls = 0;   // outside of every MarkedHeap
  std::uint64_t marked = 0;  // inside one
};

// From now on this thread's calls count, and no other's; the counts begin at 0.
void watch_heap_of_this_thread() noexcept;
// Any thread may ask.
HeapCounts heap_counts() noexcept;

// A scope in which a library allocates by its nature: libusb for each transfer, libcamera for each
// request. They nest.
class MarkedHeap {
 public:
  MarkedHeap() noexcept;
  ~MarkedHeap();
  MarkedHeap(const MarkedHeap&) = delete;
  MarkedHeap& operator=(const MarkedHeap&) = delete;
};

// heap_wrap.cpp calls it before each call.
void note_heap_call() noexcept;

}  // namespace stof::hal::linux
