#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/serial/mavlink/mavlink.h"
#include "hal/time.h"

namespace stof::firmware::mavlink {

struct Message {
  std::uint8_t version = 0;  // 1 or 2
  std::uint8_t sequence = 0;
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  bool has_signature = false;  // it is not verified
  std::uint32_t id = 0;
  std::span<const std::byte> payload;  // filled up with zeros to its whole length
};

// Any bytes into messages of versions 1 and 2. Knows HEARTBEAT and PING: the others' CRC cannot be
// verified without knowing their layout, so their bytes are passed over one by one, as is noise.
// After damage the first whole message is found, also inside what looked like another one.
class Reader {
 public:
  struct Counters {
    std::uint64_t messages = 0;  // handed out
    std::uint64_t damaged = 0;   // a known message's header, and another CRC
    std::uint64_t skipped = 0;   // bytes of others, and of noise
  };

  // Takes bytes from the front of `bytes` until a message ends, at most all of them. Call it again
  // while it returns one. The message is valid until the next call.
  std::optional<Message> take(std::span<const std::byte>& bytes) noexcept;
  void reset() noexcept { size_ = 0; }

  const Counters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::size_t kLongest = 10 + 14 + 2 + 13;  // PING with a signature

  // The message at the front of the buffer: `need` bytes, or 0 where there is none.
  struct Candidate {
    std::size_t need = 0;
    const MessageKind* kind = nullptr;
  };
  Candidate look() const noexcept;
  bool intact(const Candidate& candidate) const noexcept;
  Message open(const Candidate& candidate) noexcept;
  void drop(std::size_t count) noexcept;

  std::array<std::byte, kLongest> buffer_{};
  std::size_t size_ = 0;
  std::size_t used_ = 0;  // of a message that was handed out
  std::array<std::byte, 14> payload_{};
  Counters counters_;
};

// Whether there is an autopilot on the line.
struct Autopilot {
  std::uint8_t system = 0;  // 0: none was heard
  hal::Time last_heard{};
};

// Takes note of a heartbeat, if it is an autopilot's.
void note_message(const Message& message, hal::Time now, Autopilot& autopilot) noexcept;

}  // namespace stof::firmware::mavlink
