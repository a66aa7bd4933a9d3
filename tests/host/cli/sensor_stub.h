#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "firmware/settings/settings_server.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "firmware/wire/packet.h"
#include "hal/emu/devices/store.h"

namespace stof::host {

// A sensor's settings, without the sensor.
class SensorStub final : public settings::Limits, public settings::SettingsSink {
 public:
  bool accepts(const settings::Settings& settings, settings::PagedWriter& why) noexcept override {
    if (settings.depth.disparities > 128) {
      why << "300 disparities are more than the 128 of this board";
      return false;
    }
    return true;
  }
  bool apply(const settings::Settings& /*settings*/, std::uint32_t /*revision*/) noexcept override {
    return true;
  }

  // The answer to a request, as a packet.
  std::optional<std::vector<std::byte>> answer(std::span<const std::byte> packet) {
    const auto parsed = wire::parse_packet(packet);
    if (!parsed || parsed->header.type != wire::PacketType::kSettingsRequest) {
      return std::nullopt;
    }
    const Result<wire::SettingsRequest> request = wire::decode_settings_request(parsed->payload);
    if (!request) {
      return std::nullopt;
    }
    ++requests;
    wire::DatagramBuffer buffer;
    const auto payload = wire::payload_space(buffer);
    std::size_t bytes = 0;
    wire::SettingsAnswer answer =
        server.serve(*request, parsed->payload.subspan<wire::kSettingsRequestBytes>(),
                     {.peer = {}, .access = firmware::Access::kAdmin},
                     payload.subspan<wire::kSettingsAnswerBytes>(), bytes);
    answer.request_id = request->request_id;
    answer.cookie = 1;
    wire::encode_settings_answer(answer, payload.first<wire::kSettingsAnswerBytes>());
    const auto sealed = wire::seal_packet({.type = wire::PacketType::kSettingsAnswer},
                                          wire::kSettingsAnswerBytes + bytes, buffer);
    return std::vector<std::byte>(sealed.begin(), sealed.end());
  }

  int requests = 0;
  hal::emu::Store store;
  settings::SettingsServer server{{}, {}, {.limits = *this, .sink = *this, .store = &store}};
};

}  // namespace stof::host
