#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace stof::viewer {

enum class MessageKind : std::uint8_t { kText, kBinary };

// One page that is connected. The server's thread alone calls it.
class Conversation {
 public:
  virtual ~Conversation() = default;

  // A whole message of the page, at most kMaxPageMessage bytes. False: it means nothing; the
  // connection ends.
  virtual bool take(std::string_view message) = 0;

  // Appends the message that is due to `bytes`, which holds something else already. None: nothing
  // is due. Asked for once the one before has left this program.
  virtual std::optional<MessageKind> next(std::vector<std::uint8_t>& bytes) = 0;
};

// What a page may say at once.
inline constexpr std::size_t kMaxPageMessage = 2048;

}  // namespace stof::viewer
