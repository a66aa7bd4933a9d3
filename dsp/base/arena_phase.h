#pragma once

#include <cstddef>

#include "dsp/base/arena.h"

namespace stof::dsp {

// A phase of every frame, as an argument in place of the arena: what a constructor takes in passing
// is free again behind it, for the phase that is laid out next. A phase may have phases of its own;
// what it took before these lives as long as all of them.
//   search_(params, ArenaPhase(arena)), checks_(params, ArenaPhase(arena))
class ArenaPhase {
 public:
  explicit ArenaPhase(Arena& arena) noexcept
      : arena_(arena), end_(arena.memory_.data() + arena.end_) {}
  ~ArenaPhase() { arena_.end_ = static_cast<std::size_t>(end_ - arena_.memory_.data()); }
  ArenaPhase(const ArenaPhase&) = delete;
  ArenaPhase& operator=(const ArenaPhase&) = delete;

  operator Arena&() const noexcept { return arena_; }  // NOLINT(google-explicit-constructor)

 private:
  Arena& arena_;
  std::byte* end_;
};

}  // namespace stof::dsp
