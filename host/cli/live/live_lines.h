#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace stof::host {

// What guides whoever holds a board or a wall: lines on stdout; aside: on stderr, because stdout
// holds JSON.
class LiveLines {
 public:
  explicit LiveLines(bool aside = false) : aside_(aside) {}
  // At once.
  void note(const std::string& line) const;
  // What repeats itself: at once where it is another state than before, but never two lines within
  // a second, and else every five seconds.
  void tell(int state, const std::string& line);

 private:
  bool aside_;
  int told_ = -1;
  std::optional<std::chrono::steady_clock::time_point> at_;
};

}  // namespace stof::host
