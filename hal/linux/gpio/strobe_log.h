#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/time.h"

namespace stof::hal::linux {

// The last exposures that a sensor told on its strobe line: high while it collects light. Edges
// come with a number that advances by one, so that a lost one is noticed. Allocates nothing.
class StrobeLog {
 public:
  static constexpr std::size_t kDepth = 32;

  void note_rise(Time at, std::uint64_t number) noexcept;
  // Without its rise it says nothing.
  void note_fall(Time at, std::uint64_t number) noexcept;
  // Forgets a rise that waits for its fall: numbers begin anew.
  void restart() noexcept { rise_.reset(); }
  // The newest exposure that had ended at `stamp`, if it is remembered.
  std::optional<Exposure> ended_at(Time stamp) const noexcept;

 private:
  std::array<Exposure, kDepth> exposures_{};
  std::size_t count_ = 0;
  std::optional<Time> rise_;
  std::uint64_t rise_number_ = 0;
};

}  // namespace stof::hal::linux
