#include "firmware/events/events.h"

namespace stof::firmware {

void Events::note(const Event& event) noexcept {
  const std::uint32_t at = noted_.load(std::memory_order_relaxed);
  if (at - taken_.load(std::memory_order_acquire) >= kCapacity) {
    ++counters.lost_events;
    return;
  }
  ring_[at % kCapacity] = event;
  noted_.store(at + 1, std::memory_order_release);
}

std::optional<Event> Events::take() noexcept {
  const std::uint32_t at = taken_.load(std::memory_order_relaxed);
  if (at == noted_.load(std::memory_order_acquire)) {
    return std::nullopt;
  }
  const Event event = ring_[at % kCapacity];
  taken_.store(at + 1, std::memory_order_release);
  return event;
}

}  // namespace stof::firmware
