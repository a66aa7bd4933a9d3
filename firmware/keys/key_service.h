#pragma once

#include "firmware/control/settings_service.h"
#include "firmware/events/events.h"
#include "firmware/keys/keyring.h"

namespace stof::keys {

// Serves the operations about keys, and leaves all others to who serves settings. For the control
// thread alone.
class KeyService final : public firmware::SettingsService {
 public:
  // All outlive it. changes: gets each end of a key; nullptr: nobody does.
  KeyService(Keyring& ring, firmware::SettingsService& settings,
             firmware::ChangeRing* changes = nullptr) noexcept
      : ring_(ring), settings_(settings), changes_(changes) {}

  // kDenied: another's keys are an admin's matter. kInvalid: no such key. kNotSaved.
  wire::SettingsAnswer serve(const wire::SettingsRequest& request, std::span<const std::byte> text,
                             const firmware::Requester& by, std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override;

 private:
  wire::SettingsAnswer list(std::uint16_t offset, std::span<std::byte> answer_text,
                            std::size_t& answer_bytes) const noexcept;
  wire::SettingsResult unpair(std::string_view text, const firmware::Requester& by,
                              settings::PagedWriter& why) noexcept;

  Keyring& ring_;
  firmware::SettingsService& settings_;
  firmware::ChangeRing* changes_;
};

}  // namespace stof::keys
