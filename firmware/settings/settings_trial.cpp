#include "firmware/settings/settings_trial.h"

#include <utility>

namespace stof::settings {

void SettingsTrial::tick(hal::Time now, std::uint64_t published, bool changed) noexcept {
  if (over_ || changed || published == 0) {
    over_ = over_ || changed;
    return;
  }
  if (!since_) {
    since_ = now;
    first_ = published;
  }
  if (now - *since_ >= kProof && published > first_) {
    over_ = true;
    static_cast<void>(save_document(stores_.good, settings_));  // else the next start is on trial
  }
}

void SettingsTrial::end(std::uint64_t published) noexcept {
  const int failed = failed_starts(stores_.trial, settings_);
  if (!std::exchange(over_, true) && published > 0 && failed > 0) {
    static_cast<void>(count_failed_starts(stores_.trial, settings_, failed - 1));
  }
}

}  // namespace stof::settings
