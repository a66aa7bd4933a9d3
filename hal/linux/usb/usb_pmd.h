#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/frame_slots.h"
#include "hal/linux/camera/exposures.h"
#include "hal/linux/open_error.h"
#include "hal/linux/usb/pmd_wire.h"
#include "hal/linux/usb/usb_clock_reader.h"
#include "hal/linux/usb/usb_find.h"
#include "hal/linux/usb/usb_link.h"
#include "hal/pmd_camera.h"

struct libusb_transfer;  // NOLINT(readability-identifier-naming): libusb's own

namespace stof::hal::linux {

struct UsbPmdOptions {
  UsbId id{.vendor = 0x1209, .product = 0x0050, .serial = {}};
  UsbRoots roots;
  // Within what the camera can; open() fails else.
  PmdConfig config{.modulation_khz = 20'000, .integration_us = 1'000, .delay_us = 0};
  // Pixels that the rig was built for; 0: any.
  int width = 0;
  int height = 0;
  // A frame whose edge lies this close to one of the log is that one's, and its exposures count
  // from there. Less than half of the time between two edges.
  Duration edge_tolerance = std::chrono::milliseconds(2);
};

// A PMD camera on USB (docs/HARDWARE.md). A frame's edge comes on the camera's clock, is converted
// and moved to the nearest edge of the log; where none is near, exposures stay as converted, and
// belong to no edge. For one thread, that of the trigger. Calls of libusb allocate (MarkedHeap),
// nothing else does after open().
class UsbPmd final : public hal::PmdCamera, private SlotOwner {
 public:
  static constexpr std::size_t kSlots = 4;

  // `edges` must outlive it. Blocks for up to some seconds with a camera that does not answer. An
  // error is one line.
  static std::expected<std::unique_ptr<UsbPmd>, OpenError> open(const UsbPmdOptions& options,
                                                                const EdgeLog& edges);
  // Stops the camera; returns in about a second also where that is gone.
  ~UsbPmd() override;
  UsbPmd(const UsbPmd&) = delete;
  UsbPmd& operator=(const UsbPmd&) = delete;

  // Returns within 2 ms of the deadline. kDeviceError also: the camera stalled and was set going
  // again, which may take as long as its answer. kDeviceLost also: kMostDamaged frames in a row
  // were no good.
  Result<BorrowedFrame<PmdFrame>> wait_frame(Time deadline) noexcept override;
  // In place; frames that are lent stay readable. Blocks as open(). kDeviceLost: not back yet, or
  // not the same kind of camera; trouble() says why.
  Status reopen() noexcept;
  const std::string& trouble() const noexcept { return trouble_; }

  const PmdInfo& info() const noexcept { return info_; }

 private:
  static constexpr std::size_t kFrameTransfers = 4;
  static constexpr int kMostDamaged = 16;
  using Slots = FrameSlots<kSlots, kFrameTransfers>;
  // One under way, or idle.
  struct Transfer {
    UsbPmd* camera = nullptr;
    libusb_transfer* libusb = nullptr;
    int buffer = -1;  // that it fills; -1: idle
  };

  // The state of the stream since it was started.
  struct Stream {
    bool lost = false;
    bool stalled = false;
    bool closing = false;
    int damaged = 0;         // to be reported
    int damaged_in_row = 0;  // since the last good frame
  };

  UsbPmd(UsbPmdOptions options, const EdgeLog& edges);
  void give_back(int slot) noexcept override { slots_.release(slot); }

  std::expected<void, OpenError> start();
  std::expected<void, OpenError> greet();  // INFO and CONFIG
  bool make_transfers();
  void shut() noexcept;

  static void on_frame(libusb_transfer* done);
  void submit(Transfer& transfer) noexcept;
  void submit_idle() noexcept;
  void take_in(Transfer& transfer) noexcept;
  bool accept(int buffer, std::size_t bytes) noexcept;
  void run(Duration at_most) noexcept;
  std::optional<Status> trouble_now() noexcept;
  std::span<std::byte> space(int buffer) noexcept;

  UsbPmdOptions options_;
  const EdgeLog& edges_;
  UsbLink link_;
  PmdInfo info_;
  UsbClockReader clock_;
  std::string trouble_;

  std::vector<std::uint16_t> memory_;  // of all buffers
  std::size_t buffer_bytes_ = 0;
  Slots slots_;
  std::array<PmdFrame, Slots::kBuffers> frames_{};
  std::array<Transfer, kFrameTransfers> transfers_{};

  int progress_ = 0;  // something was done since it was set to 0
  Stream stream_;
  std::uint32_t last_sequence_ = 0;
};

}  // namespace stof::hal::linux
