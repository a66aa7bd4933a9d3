#pragma once

#include <chrono>
#include <expected>
#include <span>

#include <poll.h>

namespace stof::posix {

// Blocks until something happens at one of the entries or the time is over; does not block for a
// time of 0 or less. How many entries are ready, none too where a signal came; or an errno.
std::expected<int, int> wait_for(std::span<pollfd> entries,
                                 std::chrono::nanoseconds timeout) noexcept;

}  // namespace stof::posix
