#pragma once

#include <stdexcept>
#include <string>

namespace stof::host {

// The exit codes of `stof`. docs: docs/TOOL.md, "Exit codes".
enum class Exit : int { kOk = 0, kFailure = 1, kBadInput = 2 };

// Ends the program with this code and one line on stderr.
class Failure : public std::runtime_error {
 public:
  Failure(Exit code, const std::string& line) : std::runtime_error(line), code_(code) {}
  Exit code() const noexcept { return code_; }

 private:
  Exit code_;
};

// The value, or Failure with bad input.
template <typename Expected>
auto value_or_fail(Expected&& result) {
  if (!result) {
    throw Failure(Exit::kBadInput, result.error().message);
  }
  if constexpr (!std::is_void_v<typename std::remove_cvref_t<Expected>::value_type>) {
    return std::move(*std::forward<Expected>(result));
  }
}

}  // namespace stof::host
