// What becomes of the frames that reassembler.cpp puts together: when they are opened, closed and
// delivered.
#include <algorithm>

#include "host/client/reassembler.h"

namespace stof::client {
namespace {

constexpr Duration kShortestTimeout = std::chrono::milliseconds(100);
constexpr Duration kLongestTimeout = std::chrono::seconds(10);

}  // namespace

// The slot of this packet's frame, begun when it is the frame's first.
FrameSlot& Reassembler::open(const wire::Header& header, Time now) {
  const std::uint32_t number = header.frame.number;
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen && slot.number() == number) {
      return slot;
    }
  }
  if (!newest_ || number_distance(number, *newest_) > 0) {
    newest_ = number;
    close_older_than(number - 1);
  }
  FrameSlot* slot = nullptr;
  for (FrameSlot& candidate : slots_) {
    if (candidate.state == FrameSlot::State::kFree) {
      slot = &candidate;
    }
  }
  if (slot == nullptr) {  // nobody took the finished ones
    slot = oldest(FrameSlot::State::kFinished);
    ++statistics_.frames_dropped;
  }
  slot->begin(header, parity_, now);
  return *slot;
}

void Reassembler::close_older_than(std::uint32_t number) {
  for (FrameSlot* slot = oldest(FrameSlot::State::kOpen);
       slot != nullptr && number_distance(slot->number(), number) < 0;
       slot = oldest(FrameSlot::State::kOpen)) {
    close(*slot);
  }
}

// Only ever of the oldest open frame: frames finish in the order of their numbers.
void Reassembler::close(FrameSlot& slot) {
  const std::uint32_t number = slot.number();
  if (last_closed_) {
    statistics_.frames_lost += number - *last_closed_ - 1;
  }
  last_closed_ = number;
  statistics_.packets_missing += slot.missing_packets();
  Closed& closed = closed_[closed_count_++ % kClosed];
  closed = {.number = number,
            .packets = slot.packets(),
            .parity = slot.parity_packets(),
            .parity_groups = wire::parity_groups(slot.count()),
            .whole = slot.complete()};

  // The first verified exposure is number 1.
  const bool fresh =
      freshness_ ? number_distance(slot.freshness(), *freshness_) > 0 : slot.freshness() != 0;
  if (!fresh) {
    ++statistics_.frames_stale;
    slot.state = FrameSlot::State::kFree;
    return;
  }
  freshness_ = slot.freshness();
  slot.finish();
  slot.keep_calibration(reports_.calibration());
  slot.order = ++finished_;
  slot.state = FrameSlot::State::kFinished;
}

std::optional<Frame> Reassembler::take() {
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOut) {
      slot.state = FrameSlot::State::kFree;
    }
  }
  FrameSlot* const slot = oldest(FrameSlot::State::kFinished);
  if (slot == nullptr) {
    return std::nullopt;
  }
  slot->state = FrameSlot::State::kOut;
  ++(slot->complete() ? statistics_.frames_complete : statistics_.frames_incomplete);
  return slot->view();
}

// In the order of finishing, or, of those that are not finished, of their numbers.
FrameSlot* Reassembler::oldest(FrameSlot::State state) {
  FrameSlot* found = nullptr;
  for (FrameSlot& slot : slots_) {
    if (slot.state != state) {
      continue;
    }
    const bool finished = state == FrameSlot::State::kFinished;
    if (found == nullptr || (finished ? slot.order < found->order
                                      : number_distance(slot.number(), found->number()) < 0)) {
      found = &slot;
    }
  }
  return found;
}

Duration Reassembler::frame_timeout() const {
  if (options_.frame_timeout) {
    return *options_.frame_timeout;
  }
  const std::int64_t period_ns = calibration() ? calibration()->period_ns : 0;
  const std::int64_t bounded = std::clamp<std::int64_t>(period_ns, 0, kLongestTimeout.count());
  return std::clamp(Duration(bounded + bounded / 2), kShortestTimeout, kLongestTimeout);
}

std::optional<Time> Reassembler::next_expiry() const {
  std::optional<Time> first;
  for (const FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen) {
      const Time expiry = slot.last_packet() + frame_timeout();
      first = first ? std::min(*first, expiry) : expiry;
    }
  }
  return first;
}

void Reassembler::expire(Time now) {
  const Duration timeout = frame_timeout();
  std::optional<std::uint32_t> expired;
  for (const FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen && now - slot.last_packet() >= timeout &&
        (!expired || number_distance(slot.number(), *expired) > 0)) {
      expired = slot.number();
    }
  }
  if (expired) {
    close_older_than(*expired + 1);
  }
}

}  // namespace stof::client
