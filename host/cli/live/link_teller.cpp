#include "host/cli/live/link_teller.h"

#include <chrono>
#include <utility>

#include "host/cli/sensor_text.h"
#include "host/text/printed.h"

namespace stof::host {

std::string age_text(const std::optional<client::Duration>& age) {
  return age ? printed("%.1f s", std::chrono::duration<double>(*age).count()) : "unknown";
}

std::string LinkTeller::look(const client::LinkState& link,
                             const std::optional<wire::HealthReport>& health) {
  const auto last_health = [&] {
    return link.health_age && health ? "; last health " + age_text(link.health_age) +
                                           " ago: " + severity_text(health->severity)
                                     : std::string("; no health of it yet");
  };
  begun_ = begun_ || !link.silent;
  std::string line;
  const bool told = std::exchange(restarted_, link.restarted);
  if (link.restarted && !told && begun_) {
    ++restarts_;
    line = "link: the sensor started again" + last_health();
  }
  if (begun_ && link.silent != std::exchange(silent_, link.silent)) {
    silences_ += link.silent ? 1U : 0U;
    const std::string change = link.silent ? "link: the sensor is silent, its last frame is " +
                                                 age_text(link.frame_age) + " old" + last_health()
                                           : std::string("link: the sensor sends again");
    line += (line.empty() ? "" : "\n") + change;
  }
  return line;
}

}  // namespace stof::host
