#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "dsp/base/status.h"
#include "hal/linux/camera/exposure_matcher.h"
#include "hal/linux/camera/exposures.h"
#include "hal/linux/libcamera/libcamera_buffer_queue.h"

namespace stof::hal::linux {

inline constexpr std::size_t kLeft = 0;
inline constexpr std::size_t kRight = 1;

// Sends a slot of one side to its camera again.
class LibcameraRequeuer {
 public:
  virtual ~LibcameraRequeuer() = default;
  virtual void requeue(std::size_t side, int slot) noexcept = 0;
};

// As LibcameraOptions.
struct LibcameraMatching {
  Duration exposure{0};
  Exposures* exposures = nullptr;
  Duration most_delay{0};
  Duration most_skew{0};
};

// Frames of two cameras, matched by exposure, and the pairs that are lent. For the loop's thread,
// except the queues; allocates nothing of its own.
class LibcameraPairs {
 public:
  struct Frame {
    int slot = 0;
    Exposure exposure{};
    std::uint32_t sequence = 0;
  };
  struct Pair {
    int number = 0;               // for give_back()
    std::array<Frame, 2> frames;  // kLeft, kRight
  };

  // Both must outlive this.
  LibcameraPairs(const LibcameraMatching& matching, LibcameraRequeuer& requeuer) noexcept
      : matching_(matching), requeuer_(requeuer) {
    if (matching.exposures != nullptr) {
      for (std::optional<ExposureMatcher>& matcher : matchers_) {
        matcher.emplace(*matching.exposures, matching.most_delay);
      }
    }
  }

  LibcameraBufferQueue& queue(std::size_t side) noexcept { return queues_[side]; }

  // The oldest pair that is here. The older of two frames that do not belong together goes back; a
  // frame without an exposure goes back. kWouldBlock: none yet. kCorrupt: a damaged frame went
  // back. kDeviceLost: too many in a row that nobody can place: open the cameras anew.
  Result<Pair> next() noexcept;
  // The slots go to their cameras, unless those were opened again since.
  void give_back(int number) noexcept;

  // Slots are about to be others: what waits is forgotten, what is lent stays so.
  void start_over() noexcept;
  // Something is lent from before start_over().
  bool old_ones_out() const noexcept;

 private:
  struct Lent {
    bool out = false;
    bool old = false;
    std::array<int, 2> slots{};
  };

  Status fill(std::size_t side) noexcept;
  void send_home(std::size_t side, int slot) noexcept;
  std::optional<Exposure> exposure_of(std::size_t side, const LibcameraArrival& arrival) noexcept;

  LibcameraMatching matching_;
  LibcameraRequeuer& requeuer_;
  std::array<std::optional<ExposureMatcher>, 2> matchers_;  // none: the cameras run freely
  std::array<LibcameraBufferQueue, 2> queues_;
  std::array<std::optional<Frame>, 2> heads_;  // without a partner yet
  // Twice the slots: old ones may still be out.
  std::array<Lent, 2 * std::size_t{LibcameraBufferQueue::kMostSlots}> lent_{};
};

}  // namespace stof::hal::linux
