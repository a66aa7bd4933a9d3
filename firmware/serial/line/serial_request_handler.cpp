#include "firmware/serial/line/serial_request_handler.h"

#include <algorithm>
#include <expected>
#include <optional>

#include "firmware/wire/messages/discover.h"

namespace stof::firmware {

using wire::PacketType;

void SerialRequestHandler::set_announce(const wire::Announce& announce,
                                        wire::Health health) noexcept {
  announce_ = announce;
  health_ = health;
}

std::span<const std::byte> SerialRequestHandler::take(std::span<const std::byte> bytes,
                                                      hal::Time now) noexcept {
  const std::expected<wire::PacketView, wire::PacketFault> packet = wire::parse_packet(bytes);
  if (!packet) {
    return refuse();
  }
  const std::uint32_t meant = packet->header.origin.device_id;
  if (meant != 0 && meant != origin_.device_id) {
    return refuse();
  }
  switch (packet->header.type) {
    case PacketType::kDiscover:
      return discover(packet->payload);
    case PacketType::kSettingsRequest:
      return remote_ ? pass_on(bytes, now) : serve_settings(packet->payload, now);
    case PacketType::kSignedRequest:
      return pass_on(bytes, now);  // by its key, which a renewal over the cable has to show
    case PacketType::kPairRequest:
      return remote_ ? refuse() : pair(packet->payload, now);
    default:
      return refuse();
  }
}

std::span<const std::byte> SerialRequestHandler::pair(std::span<const std::byte> payload,
                                                      hal::Time now) noexcept {
  const Result<wire::PairRequest> asked = wire::decode_pair_request(payload);
  if (!asked || pairing_ == nullptr) {
    return refuse();
  }
  wire::PairAnswer out = pairing_->serve(*asked, keys::PairingWay::kCable, now);
  out.request_id = asked->request_id;
  wire::encode_pair_answer(out, wire::payload_space(buffer_).first<wire::kPairAnswerBytes>());
  return seal(PacketType::kPairAnswer, wire::kPairAnswerBytes);
}

std::span<const std::byte> SerialRequestHandler::discover(
    std::span<const std::byte> payload) noexcept {
  const Result<wire::Discover> asked = wire::decode_discover(payload);
  if (!asked) {
    return refuse();
  }
  announce_.request_id = asked->request_id;
  wire::encode_announce(announce_, wire::payload_space(buffer_).first<wire::kAnnounceBytes>());
  return seal(PacketType::kAnnounce, wire::kAnnounceBytes);
}

// The line itself is the source that cookies are of: no address of the network is all zeros.
std::span<const std::byte> SerialRequestHandler::pass_on(std::span<const std::byte> bytes,
                                                         hal::Time now) noexcept {
  const std::span<const std::byte> answer =
      strangers_ == nullptr ? std::span<const std::byte>{} : strangers_->take(bytes, {}, now);
  if (answer.empty()) {
    return refuse();
  }
  ++counters_.answered;
  return answer;
}

std::span<const std::byte> SerialRequestHandler::serve_settings(std::span<const std::byte> payload,
                                                                hal::Time now) noexcept {
  const Result<wire::SettingsRequest> asked = wire::decode_settings_request(payload);
  if (!asked) {
    return refuse();
  }
  const std::span<std::byte> text =
      wire::payload_space(buffer_).subspan<wire::kSettingsAnswerBytes>();
  std::size_t text_bytes = 0;
  wire::SettingsAnswer answer{.result = wire::SettingsResult::kUnsupported};
  if (settings_ != nullptr) {
    answer = settings_->serve(*asked, payload.subspan(wire::kSettingsRequestBytes),
                              {.peer = std::nullopt, .now = now, .access = Access::kAdmin}, text,
                              text_bytes);
  }
  answer.request_id = asked->request_id;
  wire::encode_settings_answer(answer,
                               wire::payload_space(buffer_).first<wire::kSettingsAnswerBytes>());
  return seal(PacketType::kSettingsAnswer,
              wire::kSettingsAnswerBytes + std::min(text_bytes, text.size()));
}

std::span<const std::byte> SerialRequestHandler::seal(PacketType type,
                                                      std::size_t payload_bytes) noexcept {
  ++counters_.answered;
  return wire::seal_packet({.type = type, .origin = origin_, .frame = {.health = health_}},
                           payload_bytes, buffer_);
}

std::span<const std::byte> SerialRequestHandler::refuse() noexcept {
  ++counters_.refused;
  return {};
}

}  // namespace stof::firmware
