#pragma once

#include <cstddef>
#include <utility>

#include "dsp/base/arena.h"
#include "tests/support/guarded_memory.h"

namespace stof::test {

// A part in exactly as much memory as it takes, which ends at an unreadable page:
//   GuardedPart<dsp::Fuser> fuser([&](dsp::Arena& arena) { return dsp::Fuser(..., arena); });
template <typename Part>
class GuardedPart {
 public:
  template <typename Make>
  explicit GuardedPart(const Make& make)
      : memory_(dsp::bytes_taken(make)), arena_(memory_.span()), part_(make(arena_)) {}
  GuardedPart(const GuardedPart&) = delete;
  GuardedPart& operator=(const GuardedPart&) = delete;

  Part& operator*() noexcept { return part_; }
  Part* operator->() noexcept { return &part_; }
  std::size_t bytes() const noexcept { return memory_.size(); }

 private:
  GuardedBuffer<std::byte> memory_;
  dsp::Arena arena_;
  Part part_;
};

}  // namespace stof::test
