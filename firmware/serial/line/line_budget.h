#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/time.h"

namespace stof::firmware {

// When a line of a given baud rate has carried its bytes: ten bits a byte (8N1). For the sender,
// which does not see the line's queues.
class LineBudget {
 public:
  // baud: 1 or more. Time that was spent before stays spent.
  void set_baud(std::uint32_t baud) noexcept { baud_ = baud; }
  // How long all that was spent still takes.
  hal::Duration backlog(hal::Time now) const noexcept;
  void spend(std::size_t bytes, hal::Time now) noexcept;

 private:
  std::uint32_t baud_ = 921'600;
  hal::Time free_at_{};
};

}  // namespace stof::firmware
