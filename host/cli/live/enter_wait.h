#pragma once

#include <cstdint>
#include <functional>

namespace stof::host {

enum class Answer : std::uint8_t { kEnter, kStopped, kNobody };

// Until a line comes on stdin (kEnter; one line each call, so that a script may write several),
// stdin ends (kNobody), or `stop` is true, which is asked ten times a second.
Answer wait_for_enter(const std::function<bool()>& stop);

}  // namespace stof::host
