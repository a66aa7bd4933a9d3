#include "host/cli/live/frame_wait.h"

#include <algorithm>
#include <chrono>

#include "host/cli/sensor_text.h"

namespace stof::host {

Comes what_comes(const client::LinkState& link) noexcept {
  // One comes a second; two may be lost.
  constexpr client::Duration kHealthEnded = std::chrono::milliseconds(2500);
  if (!link.silent) {
    return Comes::kFrames;
  }
  const bool after_frames =
      link.health_age && (!link.frame_age || *link.health_age < *link.frame_age);
  return after_frames && *link.health_age < kHealthEnded ? Comes::kHealthAlone : Comes::kNothing;
}

std::string health_alone_text(const client::LinkState& link,
                              const std::optional<wire::HealthReport>& health) {
  if (!health || what_comes(link) != Comes::kHealthAlone) {
    return "";
  }
  return std::string(": its health comes, and no frame: ") + severity_text(health->severity) +
         active_text(*health) + "; stof health says what each means";
}

bool frames_stay_away(const client::Receiver& receiver, client::Time began, double timeout_s,
                      client::Time now) {
  const client::LinkState link = receiver.link();
  const client::Time newest = link.frame_age ? std::max(began, now - *link.frame_age) : began;
  return now - newest > std::chrono::duration<double>(timeout_s) + receiver.period();
}

}  // namespace stof::host
