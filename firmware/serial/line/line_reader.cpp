#include "firmware/serial/line/line_reader.h"

#include <optional>

namespace stof::firmware {
namespace {

constexpr std::size_t kBytesPerTick = 65'536;  // less than a millisecond's work

}  // namespace

Result<std::span<const std::byte>> LineReader::read(hal::SerialPort& port,
                                                    settings::SerialMode mode,
                                                    hal::Time now) noexcept {
  std::span<const std::byte> answer;
  std::size_t total = 0;
  while (answer.empty() && total < kBytesPerTick) {
    if (unread_.empty()) {
      const Result<std::size_t> count = port.read(input_);
      if (!count) {
        return fail(Status::kDeviceLost);
      }
      if (*count == 0) {
        break;
      }
      unread_ = std::span<const std::byte>(input_).first(*count);
      total += *count;
    }
    answer = take(mode, now);
  }
  return answer;
}

std::span<const std::byte> LineReader::take(settings::SerialMode mode, hal::Time now) noexcept {
  std::span<const std::byte> answer;
  if (mode == settings::SerialMode::kMavlink) {
    while (const std::optional<mavlink::Message> message = messages_.take(unread_)) {
      mavlink::note_message(*message, now, autopilot_);
    }
  } else if (const std::optional<std::span<const std::byte>> frame = packets_.take(unread_)) {
    answer = requests_.take(*frame, now);
  }
  refused_.store(requests_.counters().refused + packets_.counters().broken +
                     packets_.counters().too_long + messages_.counters().damaged,
                 std::memory_order_relaxed);
  return answer;
}

void LineReader::reset() noexcept {
  packets_.reset();
  messages_.reset();
  unread_ = {};
}

}  // namespace stof::firmware
