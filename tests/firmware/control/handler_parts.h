#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <span>

#include "firmware/control/settings_service.h"
#include "firmware/wire/packet.h"
#include "hal/time.h"

// What tests of request handlers have in common.
namespace stof::test {

inline constexpr hal::Time kStart{std::chrono::seconds(1'000'000)};
inline constexpr wire::Origin kHere{.device_id = 1, .session_id = 77};

// Settings that count who comes, and answer with the text of the question.
class NotingSettings final : public firmware::SettingsService {
 public:
  wire::SettingsAnswer serve(const wire::SettingsRequest& /*request*/,
                             std::span<const std::byte> text, const firmware::Requester& by,
                             std::span<std::byte> answer_text,
                             std::size_t& answer_bytes) noexcept override {
    ++served;
    last = by;
    // An answer that is too long is cut off.
    answer_bytes = fill ? answer_text.size() + 5 : text.size();
    std::ranges::copy(text.first(std::min(text.size(), answer_text.size())), answer_text.begin());
    return {.result = wire::SettingsResult::kOk, .revision = 9};
  }

  int served = 0;
  bool fill = false;  // the answer is longer than there is room
  firmware::Requester last;
};

}  // namespace stof::test
