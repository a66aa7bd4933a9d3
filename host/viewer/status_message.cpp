#include "host/viewer/status_message.h"

#include <chrono>

#include <nlohmann/json.hpp>

#include "firmware/wire/messages/conditions.h"
#include "host/client/value_names.h"
#include "host/picture/source_colours.h"

namespace stof::viewer {
namespace {

// More than an eye tells apart, so that a colour of the page is that of the PNG within 1 of 255.
constexpr int kScaleColours = 1024;

template <typename Time>
std::int64_t milliseconds(Time time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
}

nlohmann::json colour_text(host::Rgb colour) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text = "#";
  for (const std::uint8_t part : {colour.red, colour.green, colour.blue}) {
    text += kDigits[part >> 4];
    text += kDigits[part & 15];
  }
  return text;
}

nlohmann::json active_of(const wire::HealthReport& health) {
  nlohmann::json all = nlohmann::json::array();
  for (std::uint8_t k = 0; k < 32; ++k) {
    if (((health.active >> k) & 1) == 0) {
      continue;
    }
    const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(k));
    all.push_back({{"name", info != nullptr ? info->name : "condition " + std::to_string(k)},
                   {"text", info != nullptr ? info->text : "told by a newer sensor"},
                   {"severity", info != nullptr ? info->severity : wire::Severity::kMajor}});
  }
  return all;
}

nlohmann::json link_of(const client::LinkState& link) {
  nlohmann::json all = nlohmann::json::array();
  for (const auto& [is, name] : {std::pair{link.silent, "silent"},
                                 {link.restarted, "restarted"},
                                 {link.forged_traffic, "forged traffic"},
                                 {link.delayed, "delayed"},
                                 {link.no_key, "no key"}}) {
    if (is) {
      all.push_back(name);
    }
  }
  return all;
}

// Other programs' text may be no UTF-8.
std::string dumped(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string hello_message(const std::string& sensor, const host::ColourScale& scale,
                          bool recording) {
  nlohmann::json colours = nlohmann::json::array();
  for (int i = 0; i < kScaleColours; ++i) {
    colours.push_back(colour_text(host::scale_colour(i / double{kScaleColours - 1})));
  }
  nlohmann::json sources = nlohmann::json::array();
  for (std::size_t i = 0; i < host::kSourceColours.size(); ++i) {
    sources.push_back({{"name", client::name_in(client::kSourceNames, i)},
                       {"colour", colour_text(host::kSourceColours[i])}});
  }
  return dumped({{"type", "hello"},
                 {"sensor", sensor},
                 {"recording", recording},
                 {"near_m", scale.near_m},
                 {"far_m", scale.far_m},
                 {"colours", colours},
                 {"sources", sources}});
}

std::string status_message(const Status& status) {
  const client::Statistics& counts = status.statistics;
  nlohmann::json json = {{"type", "status"},
                         {"at_ms", milliseconds(std::chrono::steady_clock::now())},
                         {"frames", counts.frames_complete + counts.frames_incomplete},
                         {"incomplete", counts.frames_incomplete},
                         {"lost", lost_frames(counts)},
                         {"late", late_frames(counts)},
                         {"dropped", counts.frames_dropped},
                         {"packets_missing", counts.packets_missing},
                         {"recovered", counts.recovered},
                         {"socket_drops", counts.socket_drops},
                         {"link", link_of(status.link)},
                         {"waiting", status.waiting},
                         {"health", nullptr}};
  if (status.health) {
    const wire::HealthReport& health = *status.health;
    json["health"] = {{"text", status.health_text},
                      {"severity", health.severity},
                      {"reaction", health.reaction},
                      {"uptime_s", static_cast<double>(health.uptime_ms) / 1e3},
                      {"rate_hz", health.rate_millihertz / 1e3},
                      {"latency_ms", health.latency_us / 1e3},
                      {"subscribers", health.subscribers},
                      {"active", active_of(health)}};
  }
  return dumped(json);
}

std::string event_message(const wire::EventReport& event, const std::string& text,
                          std::uint64_t at_ms) {
  return dumped({{"type", "event"},
                 {"text", text},
                 {"condition", event.condition},
                 {"severity", event.severity},
                 {"active", event.active != 0},
                 {"count", event.count},
                 {"time_ms", at_ms}});
}

std::string event_message(const LinkEvent& event, std::uint64_t at_ms) {
  return dumped({{"type", "event"},
                 {"text", event.text},
                 {"condition", nullptr},
                 {"severity", event.severity},
                 {"active", event.active},
                 {"count", 1},
                 {"time_ms", at_ms}});
}

}  // namespace stof::viewer
