#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/emu/recorded_clock.h"
#include "board/replay.h"
#include "dsp/calib/calibration.h"
#include "hal/borrowed_frame.h"
#include "hal/pmd_camera.h"
#include "hal/stereo_camera.h"
#include "hal/trigger.h"
#include "host/recording/raw_reader.h"

namespace stof::board {

// The devices of a rig that was recorded (stof record --raw). pulse() gives the next recorded edge,
// on a clock of its own; the cameras give what they gave for it, with its stamps and numbers, and
// kTimeout where a picture was lost. `paced`: on this machine's clock an edge follows the first one
// after the time that it did; else at once. Exposures behind a restart of the sensor are not given:
// the verdict says so. Allocates while it runs.
class RecordedRig final : public Replay, public hal::Trigger {
 public:
  static std::expected<std::unique_ptr<RecordedRig>, std::string> open(
      const std::filesystem::path& file, bool paced);
  ~RecordedRig() override;

  hal::Clock& clock() noexcept { return clock_; }
  hal::StereoCamera& stereo() noexcept { return stereo_; }
  hal::PmdCamera& pmd() noexcept { return pmd_; }
  const dsp::Calibration& calibration() const noexcept { return calibration_; }
  // That the search had where settings leave it to the rig; else what settings say.
  int disparities() const noexcept { return reader_.summary().first.disparities; }
  std::vector<std::string> notes() const;

  // hal::Trigger. kDeviceError: the recording is over.
  Result<hal::Time> pulse() noexcept override;

  // Replay.
  std::optional<hal::Time> next_edge() noexcept override;
  Change take_change() override;
  bool forgets_past() noexcept override;
  void note_streams(const Sent& sent) noexcept override { sent_ = sent; }
  void computed(hal::Time edge, const dsp::DepthMap& map) noexcept override;
  TimingConfig timing(const TimingConfig& own) const noexcept override;
  const std::string& settings() const noexcept override;
  Verdict verdict() const override;

 private:
  using Input = std::shared_ptr<const recording::RawInput>;
  static constexpr std::size_t kSlots = 4;

  // What a camera has lent; a frame lives until all that borrow it have given it back.
  class Lent : public hal::SlotOwner {
   public:
    // The slot; none: all are lent.
    std::optional<int> lend(const Input& input) noexcept;
    void give_back(int slot) noexcept override { slots_[static_cast<std::size_t>(slot)].reset(); }

   private:
    std::array<Input, kSlots> slots_;
  };
  class Stereo final : public hal::StereoCamera {
   public:
    explicit Stereo(RecordedRig& rig) noexcept : rig_(rig) {}
    Result<hal::BorrowedFrame<hal::StereoFrame>> wait_frame(hal::Time deadline) noexcept override;
    bool taken = true;  // that of the last edge

   private:
    RecordedRig& rig_;
    Lent lent_;
  };
  class Pmd final : public hal::PmdCamera {
   public:
    explicit Pmd(RecordedRig& rig) noexcept : rig_(rig) {}
    Result<hal::BorrowedFrame<hal::PmdFrame>> wait_frame(hal::Time deadline) noexcept override;
    bool taken = true;

   private:
    RecordedRig& rig_;
    Lent lent_;
  };
  // Of exposures that were computed.
  struct Counts {
    std::uint64_t equal = 0;
    std::uint64_t different = 0;
    std::uint64_t not_compared = 0;  // the recorded depth is not there as a whole
    std::uint64_t missing = 0;       // exposures that miss a picture
    std::uint64_t unsent = 0;        // exposures that the sensor, or the link, lost
    std::uint64_t unknown_settings = 0;
    std::uint64_t other_calibration = 0;
    std::uint64_t failures = 0;                    // edges that should have a frame, and have none
    std::optional<std::uint32_t> first_different;  // frame number of the recording
  };

  RecordedRig(recording::RawReader&& reader, const dsp::Calibration& calibration, bool paced);
  void advance() noexcept;
  void count_input(const recording::RawInput& input);
  Input read();

  recording::RawReader reader_;
  dsp::Calibration calibration_;
  std::vector<std::int16_t> pattern_;  // that it refers to
  RecordedClock clock_;
  Stereo stereo_{*this};
  Pmd pmd_{*this};
  Input now_;              // of the last edge
  Input next_;             // nullptr: none follows
  bool changed_ = false;   // the change of next_ was taken
  bool awaiting_ = false;  // now_ was pulsed, and not computed yet
  std::uint32_t settings_ = 0;
  std::optional<wire::RawInfo> before_;  // of the last that was read
  std::uint32_t frame_before_ = 0;       // its frame's number
  Sent sent_;
  Counts counts_;
};

}  // namespace stof::board
