#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/wire/messages/health.h"
#include "host/client/session/link_watch.h"

namespace stof::host {

// "0.4 s"; "unknown" where there is none.
std::string age_text(const std::optional<client::Duration>& age);

// Tells at once that a sensor fell silent or started again, or that somebody forges its traffic,
// and that it sends again when it did so for kSettled: one whose frames come late again and again
// is two lines, not two for each gap.
class LinkTeller {
 public:
  // The age of the last health, in lines that tell a begin.
  enum class Health : std::uint8_t { kTold, kLeftOut };
  explicit LinkTeller(Health health = Health::kTold) noexcept : health_(health) {}

  static constexpr client::Duration kSettled = std::chrono::seconds(1);

  struct Change {
    std::string text{};      // one line
    const char* state = "";  // in JSON: silent, restarted, forged_traffic, sends_again
    wire::Severity severity = wire::Severity::kInfo;
    bool active = false;  // it began
  };

  // A line where something is to be told since the last call, with the age of the last health; else
  // empty. Nothing is told before its first frame or health, but for forged traffic. `now` never
  // goes back.
  std::string look(const client::LinkState& link, const std::optional<wire::HealthReport>& health,
                   client::Time now);
  // Its lines one by one.
  const std::vector<Change>& changes() const noexcept { return changes_; }

  unsigned silences() const noexcept { return silences_; }
  unsigned restarts() const noexcept { return restarts_; }

 private:
  Health health_;
  bool begun_ = false;  // something of it has come
  bool silent_ = false;
  bool silence_told_ = false;  // until "sends again"
  bool before_first_ = false;  // that silence was before any frame
  bool restarted_ = false;
  bool forged_ = false;
  client::Time sends_since_{};
  unsigned silences_ = 0;
  unsigned told_silences_ = 0;  // silences_ when the last one was told
  unsigned restarts_ = 0;
  std::vector<Change> changes_;  // of the last look
};

}  // namespace stof::host
