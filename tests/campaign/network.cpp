#include "tests/campaign/network.h"

#include <utility>

namespace stof::campaign {
namespace {

constexpr client::Duration kWire = std::chrono::microseconds(100);

}  // namespace

void Network::inject(Arrival arrival) { arrivals_.emplace(arrival.at, std::move(arrival.bytes)); }

void Network::to_sensor(std::span<const std::byte> bytes, const hal::Peer& from) {
  port_.inject(bytes, from);
}

std::optional<hal::Time> Network::time_of_call(std::uint32_t call) const noexcept {
  return call < call_times_.size() ? std::optional(call_times_[call]) : std::nullopt;
}

Status Network::send(const hal::Peer& to, std::span<const std::span<const std::byte>> datagrams,
                     std::size_t& sent) noexcept {
  sent = 0;
  if (fault.span.holds(clock_.peek())) {
    if (fault.kind == emu::FaultKind::kVanish) {
      return Status::kDeviceError;
    }
    if (fault.kind == emu::FaultKind::kDrop) {
      return Status::kWouldBlock;
    }
  }
  for (const std::span<const std::byte>& datagram : datagrams) {
    if (call_times_.size() < kTimedCalls) {
      call_times_.push_back(clock_.peek());
    }
    std::size_t one = 0;
    const Status status = port_.send(to, std::span(&datagram, 1), one);
    carry();
    sent += one;
    if (status != Status::kOk) {
      return status;
    }
  }
  return Status::kOk;
}

void Network::carry() {
  while (const auto datagram = port_.take_sent()) {
    overheard_.emplace_back(datagram->bytes.begin(), datagram->bytes.end());
    if (overheard_.size() > kOverheard) {
      overheard_.pop_front();
    }
    const client::Time now = client_time(clock_.peek());
    if (impairment_ && bad_.holds(clock_.peek())) {
      impairment_->push(datagram->bytes, now);
    } else {
      arrivals_.emplace(now + kWire, overheard_.back());
    }
  }
}

std::optional<Network::Arrival> Network::next(client::Time until) {
  while (impairment_) {
    const std::optional<netem::Time> due = impairment_->next();
    if (!due || *due > until) {
      break;
    }
    while (const auto bytes = impairment_->pop(*due)) {
      arrivals_.emplace(*due + kWire, std::vector<std::byte>(bytes->begin(), bytes->end()));
    }
  }
  if (arrivals_.empty() || arrivals_.begin()->first > until) {
    return std::nullopt;
  }
  auto first = arrivals_.extract(arrivals_.begin());
  return Arrival{.at = first.key(), .bytes = std::move(first.mapped())};
}

}  // namespace stof::campaign
