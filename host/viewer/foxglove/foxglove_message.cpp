#include "host/viewer/foxglove/foxglove_message.h"

#include <limits>

#include <nlohmann/json.hpp>

#include "host/recording/topics.h"

namespace stof::viewer {
namespace {

using Json = nlohmann::json;

constexpr std::uint8_t kMessageData = 1;  // opcode
constexpr std::size_t kMostListed = 64;   // subscriptions in one message

template <typename T>
void append_number(T value, std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
}

std::optional<std::uint32_t> id_in(const Json& value) {
  if (!value.is_number_unsigned() ||
      value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) {
    return std::nullopt;
  }
  return static_cast<std::uint32_t>(value.get<std::uint64_t>());
}

// The member, where it is a list that is short enough.
const Json* list_in(const Json& said, const char* name) {
  const auto found = said.find(name);
  return found != said.end() && found->is_array() && found->size() <= kMostListed ? &*found
                                                                                  : nullptr;
}

std::optional<FoxgloveRequest> subscribe_of(const Json& said) {
  const Json* const list = list_in(said, "subscriptions");
  if (list == nullptr) {
    return std::nullopt;
  }
  Subscribe subscribe;
  for (const Json& one : *list) {
    if (!one.is_object() || !one.contains("id") || !one.contains("channelId")) {
      return std::nullopt;
    }
    const auto id = id_in(one["id"]);
    const auto channel = id_in(one["channelId"]);
    if (!id || !channel) {
      return std::nullopt;
    }
    subscribe.subscriptions.push_back({.id = *id, .channel = *channel});
  }
  return subscribe;
}

std::optional<FoxgloveRequest> unsubscribe_of(const Json& said) {
  const Json* const list = list_in(said, "subscriptionIds");
  if (list == nullptr) {
    return std::nullopt;
  }
  Unsubscribe unsubscribe;
  for (const Json& one : *list) {
    const auto id = id_in(one);
    if (!id) {
      return std::nullopt;
    }
    unsubscribe.ids.push_back(*id);
  }
  return unsubscribe;
}

}  // namespace

std::optional<bridge::Topic> topic_of_channel(std::uint32_t channel) noexcept {
  return channel >= 1 && channel <= bridge::kTopics
             ? std::optional(static_cast<bridge::Topic>(channel - 1))
             : std::nullopt;
}

std::string foxglove_topic(bridge::Topic topic) {
  const std::string_view name = bridge::info_of(topic).name;
  return name.starts_with('/') ? std::string(name) : "/stof/" + std::string(name);
}

std::string server_info_message(const std::string& name, const std::string& session) {
  return Json{
      {"op", "serverInfo"}, {"name", name}, {"capabilities", Json::array()}, {"sessionId", session}}
      .dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string advertise_message() {
  Json channels = Json::array();
  for (std::size_t i = 0; i < bridge::kTopics; ++i) {
    const auto topic = static_cast<bridge::Topic>(i);
    const mcap::Schema schema = bridge::info_of(topic).schema();
    channels.push_back({{"id", channel_of(topic)},
                        {"topic", foxglove_topic(topic)},
                        {"encoding", recording::kEncoding},
                        {"schemaName", schema.name},
                        {"schemaEncoding", schema.encoding},
                        {"schema", schema.data}});
  }
  return Json{{"op", "advertise"}, {"channels", std::move(channels)}}.dump();
}

std::string foxglove_status_message(StatusLevel level, const std::string& text) {
  return Json{{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}}.dump();
}

void append_message_data(std::uint32_t subscription, std::uint64_t time_ns,
                         recording::Bytes message, std::vector<std::uint8_t>& bytes) {
  bytes.reserve(bytes.size() + 1 + sizeof subscription + sizeof time_ns + message.size());
  bytes.push_back(kMessageData);
  append_number(subscription, bytes);
  append_number(time_ns, bytes);
  const auto* const begin = reinterpret_cast<const std::uint8_t*>(message.data());  // NOLINT
  bytes.insert(bytes.end(), begin, begin + message.size());
}

std::optional<FoxgloveRequest> parse_foxglove_message(std::string_view text) {
  const Json said = Json::parse(text, nullptr, false);
  if (!said.is_object() || !said.contains("op") || !said["op"].is_string()) {
    return std::nullopt;
  }
  const auto& operation = said["op"].get_ref<const std::string&>();
  if (operation == "subscribe") {
    return subscribe_of(said);
  }
  if (operation == "unsubscribe") {
    return unsubscribe_of(said);
  }
  return OtherOperation{};
}

}  // namespace stof::viewer
