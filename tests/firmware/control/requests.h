#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/wire/messages/discover.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "firmware/wire/messages/subscribe.h"
#include "firmware/wire/messages/subscribed.h"
#include "firmware/wire/packet.h"
#include "hal/datagram_port.h"

// Requests as a receiver makes them, answers as it reads them.
namespace stof::test {

using Bytes = std::vector<std::byte>;

inline hal::Peer peer(std::uint8_t last, std::uint16_t port = 5000) {
  return {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 192, 168, 1, last}, .port = port};
}

inline Bytes sealed(wire::PacketType type, std::span<const std::byte> payload,
                    std::uint32_t device_id = 0, std::uint32_t session_id = 0) {
  wire::DatagramBuffer buffer;
  std::ranges::copy(payload, wire::payload_space(buffer).begin());
  const std::span<const std::byte> datagram = wire::seal_packet(
      {.type = type, .origin = {.device_id = device_id, .session_id = session_id}}, payload.size(),
      buffer);
  return {datagram.begin(), datagram.end()};
}

inline Bytes subscribe(const wire::Subscribe& request,
                       wire::PacketType type = wire::PacketType::kSubscribe,
                       std::uint32_t device_id = 0) {
  std::array<std::byte, wire::kSubscribeBytes> payload;
  wire::encode_subscribe(request, payload);
  return sealed(type, payload, device_id);
}

inline Bytes settings(const wire::SettingsRequest& request, std::string_view text = {}) {
  Bytes payload(wire::kSettingsRequestBytes + text.size());
  wire::encode_settings_request(request, std::span(payload).first<wire::kSettingsRequestBytes>());
  std::ranges::copy(std::as_bytes(std::span(text)), payload.begin() + wire::kSettingsRequestBytes);
  return sealed(wire::PacketType::kSettingsRequest, payload);
}

inline Bytes discover(std::uint32_t request_id) {
  std::array<std::byte, wire::kDiscoverBytes> payload;
  wire::encode_discover({.request_id = request_id}, payload);
  return sealed(wire::PacketType::kDiscover, payload);
}

inline std::optional<wire::Subscribed> subscribed(std::span<const std::byte> datagram) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet || packet->header.type != wire::PacketType::kSubscribed) {
    return std::nullopt;
  }
  const Result<wire::Subscribed> answer = wire::decode_subscribed(packet->payload);
  return answer ? std::optional(*answer) : std::nullopt;
}

struct SettingsReply {
  wire::SettingsAnswer answer;
  std::string text;
};
inline std::optional<SettingsReply> settings_reply(std::span<const std::byte> datagram) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet || packet->header.type != wire::PacketType::kSettingsAnswer) {
    return std::nullopt;
  }
  const Result<wire::SettingsAnswer> answer = wire::decode_settings_answer(packet->payload);
  if (!answer) {
    return std::nullopt;
  }
  SettingsReply reply{.answer = *answer, .text = {}};
  for (const std::byte byte : packet->payload.subspan(wire::kSettingsAnswerBytes)) {
    reply.text += static_cast<char>(byte);
  }
  return reply;
}

// Counts that take minutes in full: set STOF_LONG=1.
inline int long_or(int full, int usual) {
  const char* const wanted = std::getenv("STOF_LONG");  // NOLINT(concurrency-mt-unsafe)
  return wanted != nullptr && std::string_view(wanted) == "1" ? full : usual;
}

}  // namespace stof::test
