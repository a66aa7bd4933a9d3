#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "firmware/wire/messages/health.h"
#include "host/client/receiver.h"

// What a sensor sends beside frames decides what is said where these stay away.
namespace stof::host {

enum class Comes : std::uint8_t {
  kFrames,
  kHealthAlone,  // it runs, and says why no frame comes
  kNothing,      // any more, or it never did
};

// A moment after frames stop it cannot be told apart whether health goes on, which comes once a
// second: what is silent for as long as this has ended.
inline constexpr client::Duration kSilenceThatLasts = std::chrono::seconds(3);

Comes what_comes(const client::LinkState& link) noexcept;

// ": its health comes, and no frame: no data, active: trigger_lost; stof health says ...".
// Empty where not health alone comes.
std::string health_alone_text(const client::LinkState& link,
                              const std::optional<wire::HealthReport>& health);

// Whether no frame came for timeout_s since the next one was due, or since `began` where none came
// since. Health and other messages do not count.
bool frames_stay_away(const client::Receiver& receiver, client::Time began, double timeout_s,
                      client::Time now);

}  // namespace stof::host
