#include "host/client/control/subscription.h"

#include <algorithm>

#include "firmware/wire/messages/subscribe.h"

namespace stof::client {

using wire::PacketType;
using wire::SubscribeResult;

std::span<const std::byte> Subscription::due(Time now) {
  if (now < next_due()) {
    return {};
  }
  if (state_ == State::kActive && now - heard_ >= kSilence) {
    state_ = State::kAsking;
  }
  next_ = now + kRepeat;
  ++request_;
  return seal(PacketType::kSubscribe);
}

Time Subscription::next_due() const {
  return state_ == State::kActive ? std::min(next_, heard_ + kSilence) : next_;
}

bool Subscription::take(std::span<const std::byte> datagram, Time now) {
  constexpr std::size_t kTypeAt = 5;  // spares frames the second parsing
  if (datagram.size() <= kTypeAt ||
      static_cast<PacketType>(datagram[kTypeAt]) != PacketType::kSubscribed) {
    return false;
  }
  const auto packet = wire::parse_packet(datagram);
  if (!packet) {
    return false;
  }
  const Result<wire::Subscribed> answer = wire::decode_subscribed(packet->payload);
  const bool ours = !options_.device_id || packet->header.origin.device_id == *options_.device_id;
  if (answer && ours &&
      request_ - answer->request_id < std::min(kAnswerable, request_ - answered_)) {
    answered_ = answer->request_id;
    answered(*answer, now);
  }
  return true;
}

void Subscription::answered(const wire::Subscribed& answer, Time now) {
  heard_ = now;
  cookie_ = answer.cookie;
  switch (answer.result) {
    case SubscribeResult::kOk: {
      const Duration third = std::chrono::milliseconds(answer.lease_ms) / 3;
      state_ = State::kActive;
      next_ = now + std::max<Duration>(third, kRepeat / 2);
      hurried_ = false;
      break;
    }
    case SubscribeResult::kCookie:
      // At once, but not twice: a sensor that takes no cookie must not keep us busy.
      if (!hurried_) {
        hurried_ = true;
        next_ = now;
      } else {
        hurried_ = false;
      }
      break;
    case SubscribeResult::kFull:
      state_ = State::kFull;
      next_ = now + kFullRepeat;
      hurried_ = false;
      break;
    case SubscribeResult::kEnded:
    default:  // of a newer sensor
      break;
  }
}

std::span<const std::byte> Subscription::farewell() {
  if (cookie_ == 0) {
    return {};
  }
  ++request_;
  return seal(PacketType::kUnsubscribe);
}

std::span<const std::byte> Subscription::seal(PacketType type) {
  const auto lease = std::clamp<std::int64_t>(options_.lease.count(), 0, 65535);
  wire::encode_subscribe(
      {.request_id = request_, .lease_ms = static_cast<std::uint16_t>(lease), .cookie = cookie_},
      wire::payload_space(buffer_).first<wire::kSubscribeBytes>());
  return wire::seal_packet({.type = type, .origin = {.device_id = options_.device_id.value_or(0)}},
                           wire::kSubscribeBytes, buffer_);
}

}  // namespace stof::client
