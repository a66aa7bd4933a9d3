#include "host/client/control/subscription.h"

#include <algorithm>

#include "firmware/wire/messages/subscribe.h"

namespace stof::client {

using wire::PacketType;
using wire::SubscribeResult;

namespace {

// Whether the streams come, for the lease; raw pictures may be refused.
bool granted(SubscribeResult result) {
  return result == SubscribeResult::kOk || result == SubscribeResult::kRawDenied ||
         result == SubscribeResult::kRawTaken;
}

}  // namespace

std::string other_tags_text(std::uint8_t tags) {
  return std::string("the sensor signs its streams as ") +
         (tags < wire::kStreamTags ? "an older release did: update the sensor (stof update)"
                                   : "a newer release does: update this program") +
         ", or receive without signatures";
}

Subscription::Subscription(const SubscriptionOptions& options, std::uint32_t first_request)
    : options_(options), request_(first_request), answered_(first_request) {
  if (options.signed_streams) {
    signer_.emplace(options.keys);
  }
}

std::span<const std::byte> Subscription::due(Time now) {
  if (now < next_due()) {
    return {};
  }
  if (state_ == State::kActive && now - heard_ >= kSilence) {
    state_ = State::kAsking;
  }
  // Each answer that gets lost costs another key.
  next_ = now + (wants_key_ ? kFullRepeat : kRepeat);
  ++request_;
  asked(request_) = now;
  return seal(PacketType::kSubscribe);
}

void Subscription::renew_key(Time now) {
  if (signs() && (!renewed_ || now - *renewed_ >= kFullRepeat)) {
    renewed_ = now;
    wants_key_ = true;
    next_ = now;
  }
}

void Subscription::doubt(Time now) {
  if (state_ == State::kActive) {
    next_ = std::min(next_, std::max(now, asked(request_) + kRepeat));
  }
}

Time Subscription::next_due() const {
  return state_ == State::kActive ? std::min(next_, heard_ + kSilence) : next_;
}

bool Subscription::take(std::span<const std::byte> datagram, Time now) {
  constexpr std::size_t kTypeAt = 5;  // spares frames the second parsing
  if (datagram.size() <= kTypeAt) {
    return false;
  }
  const auto type = static_cast<PacketType>(datagram[kTypeAt]);
  if (type != PacketType::kSubscribed && !(signs() && type == PacketType::kSignedAnswer)) {
    return false;
  }
  const auto packet = wire::parse_packet(datagram);
  if (!packet) {
    return false;
  }
  std::optional<wire::Subscribed> answer;
  const std::uint32_t device = packet->header.origin.device_id;
  const bool ours = !options_.device_id || device == *options_.device_id;
  if (!ours && state_ != State::kActive) {
    other_sensor_ = device;
  }
  if (ours && judge(*packet, datagram, answer)) {
    // Who signs lets nobody else use up a request.
    if (!signs() || type == PacketType::kSignedAnswer) {
      answered_ = answer->request_id;
      const Duration took = now - asked(answer->request_id);
      round_trip_ = std::min(round_trip_.value_or(took), took);
    }
    answerer_ = packet->header.origin;
    answered(*answer, now);
  }
  return true;
}

bool Subscription::judge(const wire::PacketView& packet, std::span<const std::byte> datagram,
                         std::optional<wire::Subscribed>& answer) {
  const auto read = [&](std::span<const std::byte> payload) {
    const Result<wire::Subscribed> decoded = wire::decode_subscribed(payload);
    if (decoded && request_ - decoded->request_id < std::min(kAnswerable, request_ - answered_)) {
      answer = *decoded;
    }
    return answer.has_value();
  };
  if (!signer_) {
    return read(packet.payload);
  }
  if (const std::optional<RequestSigner::Answer> opened = signer_->open(packet, datagram)) {
    if (!read(opened->payload)) {
      return false;
    }
    signer_->note_origin(packet.header.origin);
    signer_->note_highest(opened->highest);
    if (granted(answer->result)) {
      const wire::StreamKey key = signer_->open_stream_key(*opened);
      if (key.number != stream_key_.number ||
          !wire::equal_secrets(key.secret, stream_key_.secret)) {
        key_asked_ = asked(answer->request_id);
        wants_key_ = false;
      }
      stream_key_ = key;
      proven_key_ = signer_->key()->id;
      judge_tags(*opened);
    }
    return !granted(answer->result) || stream_key_.number != 0 || other_tags_ != wire::kStreamTags;
  }
  // What is not signed only says that a request was not judged.
  if (packet.header.type != PacketType::kSubscribed || !read(packet.payload)) {
    return false;
  }
  if (answer->result == SubscribeResult::kUnknownKey) {
    signer_->try_next_key();
    return true;
  }
  if (answer->result != SubscribeResult::kCookie) {
    return false;
  }
  signer_->note_origin(packet.header.origin);
  if (signer_->key() == nullptr) {
    answer->result = SubscribeResult::kUnknownKey;
  }
  return true;
}

// What cannot be verified is no stream: the sensor is asked again as one that has no place.
void Subscription::judge_tags(const RequestSigner::Answer& answer) {
  other_tags_ = RequestSigner::tags_of(answer).value_or(wire::kStreamTags);
}

void Subscription::answered(const wire::Subscribed& answer, Time now) {
  heard_ = now;
  cookie_ = answer.cookie;
  switch (answer.result) {
    case SubscribeResult::kOk:
    case SubscribeResult::kRawDenied:
    case SubscribeResult::kRawTaken: {
      raw_refusal_ = answer.result;
      if (other_tags_ != wire::kStreamTags) {
        state_ = State::kOtherTags;
        next_ = now + kFullRepeat;
        hurried_ = false;
        break;
      }
      const Duration third = std::chrono::milliseconds(answer.lease_ms) / 3;
      state_ = State::kActive;
      other_sensor_.reset();
      next_ = now + std::max<Duration>(third, kRepeat / 2);
      hurried_ = false;
      break;
    }
    case SubscribeResult::kCookie:
    case SubscribeResult::kStale:
      hurry(now);
      break;
    case SubscribeResult::kUnknownKey:
      reread_keys(now);
      state_ = State::kNoKey;
      next_ = now + kFullRepeat;
      hurried_ = false;
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

// Anybody can say that a key is unknown: the file is not read for each of them.
void Subscription::reread_keys(Time now) {
  if (signer_ && options_.reread && (!reread_ || now - *reread_ >= kFullRepeat)) {
    reread_ = now;
    if (const std::optional<wire::KeyTable> keys = options_.reread()) {
      signer_->take_renewed(*keys);
    }
  }
}

// At once, but not twice: a sensor that takes no cookie must not keep us busy.
void Subscription::hurry(Time now) {
  hurried_ = !hurried_;
  if (hurried_) {
    next_ = now;
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
  wire::Subscribe request{.request_id = request_,
                          .lease_ms = static_cast<std::uint16_t>(lease),
                          .cookie = cookie_,
                          .raw = options_.raw};
  if (signer_ && signer_->key() != nullptr) {
    request.stream_key = wants_key_ ? 0 : stream_key_.number;
    return signer_->seal(type, request, buffer_);
  }
  if (signer_) {
    request.cookie = 0;  // asks who it is, and subscribes to nothing
  }
  wire::encode_subscribe(request, wire::payload_space(buffer_).first<wire::kSubscribeBytes>());
  // Without a cookie nothing is subscribed to: then any sensor may say who it is.
  const std::uint32_t device = request.cookie == 0 ? 0 : options_.device_id.value_or(0);
  return wire::seal_packet({.type = type, .origin = {.device_id = device}}, wire::kSubscribeBytes,
                           buffer_);
}

}  // namespace stof::client
