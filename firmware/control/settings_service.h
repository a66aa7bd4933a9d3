#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/control/access.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "firmware/wire/packet.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::firmware {

// Room for the text of an answer, bytes.
inline constexpr std::size_t kSettingsTextBytes = wire::kMaxPayload - wire::kSettingsAnswerBytes;

// Who asks, and when.
struct Requester {
  // Proven by its cookie; hal::kAllOfLink: somebody of that link; none: the serial line.
  std::optional<hal::Peer> peer;
  hal::Time now{};
  Access access = Access::kRead;
  std::uint32_t key_id = 0;  // that signed; 0: none
};

// Answers requests for settings. For the control thread alone.
class SettingsService {
 public:
  virtual ~SettingsService() = default;
  // Serves one request. `text`: what followed the request, any bytes. Writes the answer's text into
  // `answer_text` (kSettingsTextBytes) and its length into `answer_bytes`. The caller fills in
  // request_id and cookie of the answer. May block for as long as saving a file takes.
  virtual wire::SettingsAnswer serve(const wire::SettingsRequest& request,
                                     std::span<const std::byte> text, const Requester& by,
                                     std::span<std::byte> answer_text,
                                     std::size_t& answer_bytes) noexcept = 0;
};

}  // namespace stof::firmware
