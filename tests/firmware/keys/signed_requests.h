#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "firmware/wire/keys/signed_packet.h"
#include "tests/firmware/control/requests.h"

// Requests as whoever has a key makes them, answers as he reads them.
namespace stof::test {

inline Bytes signed_settings(const wire::Key& key, const wire::Origin& origin,
                             std::uint64_t counter, const wire::SettingsRequest& request,
                             std::string_view text = {}) {
  wire::DatagramBuffer buffer;
  const auto payload = wire::signed_space(buffer);
  wire::encode_settings_request(request, payload.first<wire::kSettingsRequestBytes>());
  std::ranges::copy(std::as_bytes(std::span(text)),
                    payload.subspan(wire::kSettingsRequestBytes).begin());
  const auto datagram =
      wire::seal_signed({.type = wire::PacketType::kSignedRequest, .origin = origin},
                        {.key_id = key.id,
                         .type = static_cast<std::uint8_t>(wire::PacketType::kSettingsRequest),
                         .counter = counter},
                        wire::kSettingsRequestBytes + text.size(), key.secret, buffer);
  return {datagram.begin(), datagram.end()};
}

inline Bytes signed_subscribe(const wire::Key& key, const wire::Origin& origin,
                              std::uint64_t counter, const wire::Subscribe& request,
                              wire::PacketType type = wire::PacketType::kSubscribe) {
  wire::DatagramBuffer buffer;
  wire::encode_subscribe(request, wire::signed_space(buffer).first<wire::kSubscribeBytes>());
  const auto datagram = wire::seal_signed(
      {.type = wire::PacketType::kSignedRequest, .origin = origin},
      {.key_id = key.id, .type = static_cast<std::uint8_t>(type), .counter = counter},
      wire::kSubscribeBytes, key.secret, buffer);
  return {datagram.begin(), datagram.end()};
}

struct SignedReply {
  wire::SignedFields fields;
  wire::SettingsAnswer answer;
  std::string text;
};
// None: nothing that this key signed.
inline std::optional<SignedReply> signed_reply(const wire::Key& key,
                                               std::span<const std::byte> datagram) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet || packet->header.type != wire::PacketType::kSignedAnswer) {
    return std::nullopt;
  }
  const auto view = wire::open_signed(*packet, datagram);
  if (!view || !wire::signed_with(key.secret, *view)) {
    return std::nullopt;
  }
  const auto answer = wire::decode_settings_answer(view->payload);
  if (!answer) {
    return std::nullopt;
  }
  SignedReply reply{.fields = view->fields, .answer = *answer, .text = {}};
  for (const std::byte byte : view->payload.subspan(wire::kSettingsAnswerBytes)) {
    reply.text += static_cast<char>(byte);
  }
  return reply;
}

}  // namespace stof::test
