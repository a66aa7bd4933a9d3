#include "host/client/control/request_signer.h"

#include <algorithm>
#include <chrono>

#include "firmware/wire/keys/signed_packet.h"
#include "firmware/wire/messages/subscribed.h"

namespace stof::client {
namespace {

using wire::PacketType;

// What several programs of a user share: none has to know which counters the others used.
std::uint64_t microseconds_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace

RequestSigner::RequestSigner(const wire::KeyTable& keys) : keys_(keys) {
  static_cast<void>(wire::start_crypto());
}

void RequestSigner::note_origin(const wire::Origin& origin) {
  const bool same = origin.device_id == origin_.device_id;
  if ((same && origin.session_id == origin_.session_id) || (!same && at_ >= 0)) {
    return;
  }
  origin_ = origin;
  counter_ = 0;
  if (!same) {
    at_ = last_key_before(static_cast<int>(keys_.count()));
  }
}

// The newest first.
int RequestSigner::last_key_before(int end) const {
  int at = end - 1;
  while (at >= 0 && keys_.all()[static_cast<std::size_t>(at)].device != origin_.device_id) {
    --at;
  }
  return at;
}

bool RequestSigner::drop_key() {
  at_ = at_ < 0 ? -1 : last_key_before(at_);
  return at_ >= 0;
}

void RequestSigner::try_next_key() {
  if (!drop_key()) {
    at_ = last_key_before(static_cast<int>(keys_.count()));
  }
}

void RequestSigner::take_renewed(const wire::KeyTable& keys) {
  wire::KeyTable renewed;
  for (wire::Key key : keys_.all()) {
    const wire::Key* const there = keys.find(key.id);
    if (there != nullptr && there->device == key.device) {
      key.secret = there->secret;
    }
    static_cast<void>(renewed.add(key));
    wire::wipe(key.secret);
  }
  keys_ = renewed;
}

void RequestSigner::note_highest(std::uint64_t highest) { counter_ = std::max(counter_, highest); }

std::span<const std::byte> RequestSigner::seal(const wire::SettingsRequest& request,
                                               std::string_view text,
                                               wire::DatagramBuffer& buffer) {
  const std::span<std::byte, wire::kMaxSignedPayload> payload = wire::signed_space(buffer);
  wire::encode_settings_request(request, payload.first<wire::kSettingsRequestBytes>());
  std::ranges::copy(std::as_bytes(std::span(text)),
                    payload.subspan<wire::kSettingsRequestBytes>().begin());
  answer_ = PacketType::kSettingsAnswer;
  return seal(PacketType::kSettingsRequest, wire::kSettingsRequestBytes + text.size(), buffer);
}

std::span<const std::byte> RequestSigner::seal(PacketType type, const wire::Subscribe& request,
                                               wire::DatagramBuffer& buffer) {
  wire::encode_subscribe(request, wire::signed_space(buffer).first<wire::kSubscribeBytes>());
  answer_ = PacketType::kSubscribed;
  return seal(type, wire::kSubscribeBytes, buffer);
}

std::span<const std::byte> RequestSigner::seal(PacketType type, std::size_t payload_bytes,
                                               wire::DatagramBuffer& buffer) {
  const wire::Key& key = *this->key();
  counter_ = std::max(counter_ + 1, microseconds_now());
  std::ranges::rotate(sealed_, sealed_.end() - 1);
  sealed_.front() = {.session = origin_.session_id, .counter = counter_};
  return wire::seal_signed(
      {.type = PacketType::kSignedRequest, .origin = origin_},
      {.key_id = key.id, .type = static_cast<std::uint8_t>(type), .counter = counter_},
      payload_bytes, key.secret, buffer);
}

std::optional<RequestSigner::Answer> RequestSigner::open(
    const wire::PacketView& packet, std::span<const std::byte> datagram) const {
  const wire::Origin& origin = packet.header.origin;
  const wire::Key* const key = this->key();
  if (key == nullptr || packet.header.type != PacketType::kSignedAnswer ||
      origin.device_id != origin_.device_id) {
    return std::nullopt;
  }
  const Result<wire::SignedView> view = wire::open_signed(packet, datagram);
  if (!view || view->fields.key_id != key->id || view->fields.counter == 0 ||
      std::ranges::find(sealed_, Sealed{origin.session_id, view->fields.counter}) ==
          sealed_.end() ||
      view->fields.type != static_cast<std::uint8_t>(answer_) ||
      !wire::signed_with(key->secret, *view)) {
    return std::nullopt;
  }
  return Answer{
      .payload = view->payload, .highest = view->fields.highest, .counter = view->fields.counter};
}

std::optional<std::uint8_t> RequestSigner::tags_of(const Answer& answer) {
  if (answer.payload.size() < wire::kSubscribedBytes) {
    return std::nullopt;
  }
  const Result<wire::StreamKeyFields> fields =
      wire::decode_stream_key_fields(answer.payload.subspan(wire::kSubscribedBytes));
  return fields && fields->number != 0 ? std::optional(fields->tags) : std::nullopt;
}

wire::StreamKey RequestSigner::open_stream_key(const Answer& answer) const {
  if (answer.payload.size() < wire::kSubscribedBytes) {
    return {};
  }
  const Result<wire::StreamKeyFields> fields =
      wire::decode_stream_key_fields(answer.payload.subspan(wire::kSubscribedBytes));
  return fields ? wire::open_stream_key(
                      *fields, {.sensor = origin_, .key = *key(), .counter = answer.counter})
                : wire::StreamKey{};
}

}  // namespace stof::client
