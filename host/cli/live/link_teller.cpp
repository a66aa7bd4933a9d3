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

// One that starts tells its health before its first frame: that is no silence yet to a reader.
std::string silence(const client::LinkState& link) {
  return link.frame_age
             ? "link: the sensor is silent, its last frame is " + age_text(link.frame_age) + " old"
             : std::string("link: no frame came yet");
}

std::string sends_again(bool first, unsigned further) {
  return (first ? std::string("link: frames come") : std::string("link: the sensor sends again")) +
         (further == 0
              ? ""
              : printed(", it was silent %u %s more", further, further == 1 ? "time" : "times"));
}

}  // namespace

std::string age_text(const std::optional<client::Duration>& age) {
  return age ? printed("%.1f s", std::chrono::duration<double>(*age).count()) : "unknown";
}

std::string LinkTeller::look(const client::LinkState& link,
                             const std::optional<wire::HealthReport>& health, client::Time now) {
  changes_.clear();
  begun_ = begun_ || link.frame_age || link.health_age || link.forged_traffic;
  const std::string told_health =
      health_ == Health::kTold ? last_health(link, health) : std::string();
  const bool told = std::exchange(restarted_, link.restarted);
  if (link.restarted && !told && begun_) {
    ++restarts_;
    changes_.push_back({.text = "link: the sensor started again" + told_health,
                        .state = "restarted",
                        .severity = wire::Severity::kMinor,
                        .active = true});
  }
  if (begun_ && link.silent != std::exchange(silent_, link.silent)) {
    silences_ += link.silent ? 1U : 0U;
    sends_since_ = now;
    if (link.silent && !std::exchange(silence_told_, true)) {
      told_silences_ = silences_;
      before_first_ = !link.frame_age;
      changes_.push_back({.text = silence(link) + told_health,
                          .state = "silent",
                          .severity = wire::Severity::kMajor,
                          .active = true});
    }
  }
  if (begun_ && link.forged_traffic && !std::exchange(forged_, link.forged_traffic)) {
    changes_.push_back({.text = "link: forged traffic: somebody speaks in the sensor's name, or it "
                                "is faulty; what was found out is not believed",
                        .state = "forged_traffic",
                        .severity = wire::Severity::kMajor,
                        .active = true});
  }
  forged_ = link.forged_traffic;
  if (silence_told_ && !silent_ && now - sends_since_ >= kSettled) {
    silence_told_ = false;
    changes_.push_back(
        {.text = sends_again(before_first_, silences_ - told_silences_), .state = "sends_again"});
  }
  std::string lines;
  for (const Change& change : changes_) {
    add_to(lines, change.text, "\n");
  }
  return lines;
}

}  // namespace stof::host
