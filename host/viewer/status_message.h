#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/session/link_watch.h"
#include "host/client/statistics.h"
#include "host/picture/colour_scale.h"

// What the page is told beside frames, as JSON. docs: docs/VIEWER.md.
namespace stof::viewer {

// The colours of depths and sources, the ends of the fixed scale, the sensor's address or the
// recording's name.
std::string hello_message(const std::string& sensor, const host::ColourScale& scale,
                          bool recording);

struct Status {
  const client::Statistics& statistics;
  const client::LinkState& link;
  const std::optional<wire::HealthReport>& health;
  std::string health_text{};  // one line
  std::string waiting{};      // why no frame comes, and what to do; empty: they come
};
std::string status_message(const Status& status);

// Frames that never reached the user: nothing of them came, or they came too late.
constexpr std::uint64_t late_frames(const client::Statistics& counts) noexcept {
  return counts.frames_stale + counts.frames_old;
}
constexpr std::uint64_t lost_frames(const client::Statistics& counts) noexcept {
  return counts.frames_lost + late_frames(counts);
}

// text: the line that is printed. at_ms: when it was heard of (Unix).
std::string event_message(const wire::EventReport& event, const std::string& text,
                          std::uint64_t at_ms);

// What is known of the link alone: the sensor fell silent, started again or sends again.
struct LinkEvent {
  std::string text{};  // the line that is printed
  wire::Severity severity = wire::Severity::kInfo;
  bool active = false;  // it began
};
std::string event_message(const LinkEvent& event, std::uint64_t at_ms);

}  // namespace stof::viewer
