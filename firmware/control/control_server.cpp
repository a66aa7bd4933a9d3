#include "firmware/control/control_server.h"

namespace stof::firmware {

Status ControlServer::receive(hal::Duration wait, hal::Time (*now)() noexcept) noexcept {
  for (int i = 0; i < kDatagramsPerTurn; ++i) {
    const hal::Duration timeout = i == 0 ? wait : hal::Duration::zero();
    const Result<hal::Received> received = parts_.port.receive(space_, timeout);
    if (!received) {
      return received.error() == Status::kDeviceLost ? Status::kDeviceLost : Status::kOk;
    }
    if (received->bytes > space_.size()) {
      parts_.handler.take_oversized();
      continue;
    }
    const bool over_link =
        parts_.link != nullptr && received->link != 0 && received->from.port == kLinkPort;
    hal::Peer from = received->from;
    from.scope = over_link ? received->link : from.scope;
    const std::span<const std::byte> answer =
        parts_.handler.take(std::span(space_).first(received->bytes), from, now());
    if (!answer.empty()) {
      std::size_t sent = 0;
      static_cast<void>(
          over_link ? parts_.link->send(all_of_link(received->link), std::span(&answer, 1), sent)
                    : parts_.port.send(from, std::span(&answer, 1), sent));
    }
  }
  return Status::kOk;
}

void ControlServer::tick(hal::Time now) noexcept {
  hal::Peer peer;
  for (std::size_t i = 0; i < kMostSubscribers && parts_.port.take_unreachable(peer); ++i) {
    parts_.subscribers.refused(peer, now);
  }
  parts_.subscribers.expire(now);
  const ReceiverList list = parts_.subscribers.list();
  if (list != pushed_ && parts_.ring.push(list)) {
    pushed_ = list;
  }
  for (PeriodicTask* const task : parts_.tasks) {
    task->tick(now);
  }
}

wire::ControlCounters control_counters(const RequestHandler& handler,
                                       const hal::DatagramPort& port) noexcept {
  wire::ControlCounters counters = handler.counters();
  counters.overrun = port.overruns();
  return counters;
}

}  // namespace stof::firmware
