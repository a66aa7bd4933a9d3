#include "host/cli/live/link_teller.h"

#include <chrono>
#include <utility>

#include "host/cli/sensor_text.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

std::string last_health(const client::LinkState& link,
                        const std::optional<wire::HealthReport>& health) {
  return link.health_age && health ? "; last health " + age_text(link.health_age) +
                                         " ago: " + severity_text(health->severity)
                                   : std::string("; no health of it yet");
}

std::string silence(const client::LinkState& link) {
  return "link: the sensor is silent, " +
         (link.frame_age ? "its last frame is " + age_text(link.frame_age) + " old"
                         : std::string("no frame came yet"));
}

}  // namespace

std::string age_text(const std::optional<client::Duration>& age) {
  return age ? printed("%.1f s", std::chrono::duration<double>(*age).count()) : "unknown";
}

std::string LinkTeller::look(const client::LinkState& link,
                             const std::optional<wire::HealthReport>& health) {
  std::string line;
  begun_ = begun_ || link.frame_age || link.health_age;
  const bool told = std::exchange(restarted_, link.restarted);
  if (link.restarted && !told && begun_) {
    ++restarts_;
    line = "link: the sensor started again" + last_health(link, health);
  }
  if (begun_ && link.silent != std::exchange(silent_, link.silent)) {
    silences_ += link.silent ? 1U : 0U;
    add_to(line,
           link.silent ? silence(link) + last_health(link, health)
                       : std::string("link: the sensor sends again"),
           "\n");
  }
  return line;
}

}  // namespace stof::host
