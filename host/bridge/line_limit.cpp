#include "host/bridge/line_limit.h"

#include "host/client/printable.h"

namespace stof::bridge {

std::optional<std::string> LineLimit::pass(std::string_view line, Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  if (!begin_ || now - *begin_ >= kWindow) {
    begin_ = now;
    passed_ = 0;
  }
  if (passed_ == kLines) {
    ++left_out_;
    return std::nullopt;
  }
  ++passed_;
  line = line.substr(0, line.find_last_not_of("\r\n") + 1);
  std::string text = client::printable(line);
  if (left_out_ > 0) {
    text += " (" + std::to_string(left_out_) + " lines before this one are left out)";
    left_out_ = 0;
  }
  return text;
}

}  // namespace stof::bridge
