#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/bridge/topics.h"

// The Foxglove WebSocket protocol, version 1, as its published specification has it, as far as a
// server needs it that only sends. docs: docs/VIEWER.md.
namespace stof::viewer {

// One protocol under two names: of Foxglove's SDK, and of before it.
inline constexpr std::array<std::string_view, 2> kFoxgloveSubprotocols{"foxglove.sdk.v1",
                                                                       "foxglove.websocket.v1"};

// The first message. session: another one for each start of the server.
std::string server_info_message(const std::string& name, const std::string& session);

// The channel of a topic, from 1.
constexpr std::uint32_t channel_of(bridge::Topic topic) noexcept {
  return static_cast<std::uint32_t>(topic) + 1;
}
std::optional<bridge::Topic> topic_of_channel(std::uint32_t channel) noexcept;
// "/stof/depth/image_raw": within the namespace `stof`.
std::string foxglove_topic(bridge::Topic topic);

// The second message: all channels, with their definitions.
std::string advertise_message();

enum class StatusLevel : std::uint8_t { kInfo = 0, kWarning = 1, kError = 2 };
std::string foxglove_status_message(StatusLevel level, const std::string& text);

// Appends a binary message: what a subscription gets. time_ns: when it was received, since 1970.
void append_message_data(std::uint32_t subscription, std::uint64_t time_ns,
                         recording::Bytes message, std::vector<std::uint8_t>& bytes);

// What a client says.
struct Subscription {
  std::uint32_t id = 0;  // of the client's choice
  std::uint32_t channel = 0;
};
struct Subscribe {
  std::vector<Subscription> subscriptions{};
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids{};
};
struct OtherOperation {};  // of the protocol or not: nothing of what this server offers
using FoxgloveRequest = std::variant<Subscribe, Unsubscribe, OtherOperation>;

// Any bytes. None: it means nothing.
std::optional<FoxgloveRequest> parse_foxglove_message(std::string_view text);

}  // namespace stof::viewer
