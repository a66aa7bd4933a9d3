#include "firmware/settings/settings_trial.h"

namespace stof::settings {

void SettingsTrial::tick(hal::Time now, std::uint64_t published,
                         const Settings* in_force) noexcept {
  if (in_force == nullptr || published == 0) {
    since_.reset();
    return;
  }
  if (*in_force != settings_) {
    settings_ = *in_force;
    proven_ = false;
    since_.reset();
  }
  if (proven_) {
    return;
  }
  if (!since_) {
    since_ = now;
    first_ = published;
  }
  if (now - *since_ >= kProof && published > first_) {
    proven_ = true;
    static_cast<void>(save_document(stores_.good, settings_));  // else the next start is on trial
  }
}

void SettingsTrial::end(std::uint64_t published) noexcept {
  const int failed = failed_starts(stores_.trial, settings_);
  if (!proven_ && published > 0 && failed > 0) {
    static_cast<void>(count_failed_starts(stores_.trial, settings_, failed - 1));
  }
}

}  // namespace stof::settings
