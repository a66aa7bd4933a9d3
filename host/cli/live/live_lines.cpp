#include "host/cli/live/live_lines.h"

#include "host/cli/output.h"

namespace stof::host {

void LiveLines::note(const std::string& line) const {
  if (aside_) {
    say_aside(line);
  } else {
    say(line);
  }
}

void LiveLines::tell(int state, const std::string& line) {
  constexpr std::chrono::seconds kAnother{1};
  constexpr std::chrono::seconds kSame{5};
  const auto now = std::chrono::steady_clock::now();
  if (at_ && now - *at_ < (state == told_ ? kSame : kAnother)) {
    return;
  }
  note(line);
  told_ = state;
  at_ = now;
}

}  // namespace stof::host
