#pragma once

#include <optional>
#include <string>

#include "firmware/wire/messages/health.h"
#include "host/client/session/link_watch.h"

namespace stof::host {

// "0.4 s"; "unknown" where there is none.
std::string age_text(const std::optional<client::Duration>& age);

// Tells at once, and once each, that a sensor fell silent, sends again, or started again.
class LinkTeller {
 public:
  // A line where something changed since the last call, with the age of the last health; else
  // empty. Nothing is told before its first
  // frame or health.
  std::string look(const client::LinkState& link, const std::optional<wire::HealthReport>& health);

  unsigned silences() const noexcept { return silences_; }
  unsigned restarts() const noexcept { return restarts_; }

 private:
  bool begun_ = false;  // something of it has come
  bool silent_ = false;
  bool restarted_ = false;
  unsigned silences_ = 0;
  unsigned restarts_ = 0;
};

}  // namespace stof::host
