#include "host/cli/live/wall_walk.h"

#include "host/cli/failure.h"
#include "host/cli/live/enter_wait.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {

std::optional<double> WallWalk::next() const {
  constexpr double kSameM = 1e-6;
  for (const double z : distances_) {
    const auto from = there_.lower_bound(z - kSameM);
    if (from == there_.end() || *from > z + kSameM) {
      return z;
    }
  }
  return std::nullopt;
}

std::size_t WallWalk::distances() const {
  std::set<double> all = there_;
  all.insert(distances_.begin(), distances_.end());
  return all.size();
}

std::string WallWalk::kept_text() const {
  return there_.empty()
             ? std::string("no wall was taken")
             : printed("walls in %s: %zu; run it again to go on", folder_.c_str(), there_.size());
}

void wait_for_wall(const WallWalk& walk) {
  switch (wait_for_enter(asked_to_stop)) {
    case Answer::kEnter:
      return;
    case Answer::kStopped:
      throw Failure(Exit::kFailure, "stopped: " + walk.kept_text());
    case Answer::kNobody:
      throw Failure(Exit::kFailure, "stdin ended, nobody presses Enter: " + walk.kept_text());
  }
}

}  // namespace stof::host
