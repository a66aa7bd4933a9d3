// How a PMD camera on USB is set going, and stopped.

#include <array>
#include <chrono>

#include <libusb-1.0/libusb.h>

#include "hal/linux/system/clock.h"
#include "hal/linux/system/heap_watch.h"
#include "hal/linux/usb/usb_pmd.h"

namespace stof::hal::linux {
namespace {

constexpr int kClockTries = 8;
constexpr Duration kPatience = std::chrono::seconds(1);  // for cancelled transfers
constexpr unsigned kClockMs = 1000;
// The largest packet of a bulk endpoint (USB 3.2, 9.6.6); the smaller ones divide it.
constexpr std::size_t kMostPacket = 1024;

constexpr std::uint8_t number(PmdRequest request) noexcept {
  return static_cast<std::uint8_t>(request);
}

// Whole packets, or a message could be too long for the last one; and room for one more, or the
// end of a message of whole packets could not be told.
std::size_t buffer_size(const PmdInfo& info) noexcept {
  const std::size_t most = kPmdMostHeaderBytes + pmd_picture_bytes(info);
  return (most / kMostPacket + 2) * kMostPacket;
}

std::string span_of(std::uint32_t least, std::uint32_t most, const char* unit) {
  return std::to_string(least) + " to " + std::to_string(most) + unit;
}

// One line, if the camera cannot.
std::string judge(const PmdInfo& info, const UsbPmdOptions& options) {
  const PmdConfig& config = options.config;
  if ((options.width != 0 && options.width != info.width) ||
      (options.height != 0 && options.height != info.height)) {
    return "has " + std::to_string(info.width) + " x " + std::to_string(info.height) +
           " pixels; the board's table names " + std::to_string(options.width) + " x " +
           std::to_string(options.height);
  }
  if (config.modulation_khz < info.least_khz || config.modulation_khz > info.most_khz) {
    return "does not modulate at " + std::to_string(config.modulation_khz) + " kHz; give " +
           span_of(info.least_khz, info.most_khz, " kHz");
  }
  if (config.integration_us < info.least_integration_us ||
      config.integration_us > info.most_integration_us) {
    return "does not integrate for " + std::to_string(config.integration_us) + " us; give " +
           span_of(info.least_integration_us, info.most_integration_us, " us");
  }
  return {};
}

}  // namespace

std::expected<void, OpenError> UsbPmd::start() {
  const std::expected<std::string, OpenError> node = find_usb(options_.id, options_.roots);
  if (!node) {
    return std::unexpected(node.error());
  }
  if (auto opened = link_.open(*node, {.kind = kPmdInterfaceClass,
                                       .subkind = kPmdInterfaceSubclass,
                                       .protocol = kPmdInterfaceProtocol});
      !opened) {
    return opened;
  }
  auto greeted = greet();
  if (!greeted) {
    shut();
    return greeted;
  }
  lost_ = false;
  stalled_ = false;
  damaged_ = 0;
  damaged_in_row_ = 0;
  last_sequence_ = 0;
  if (make_transfers()) {
    submit_idle();
  } else {
    lost_ = true;
  }
  if (lost_) {
    shut();
    return std::unexpected(OpenError{
        "PMD camera: the system gives USB too little memory; raise usbcore.usbfs_memory_mb"});
  }
  if (!link_.tell(number(PmdRequest::kStream), 1, {})) {
    const std::string why = link_.error();
    shut();
    return std::unexpected(
        OpenError{"PMD camera: does not begin: " + why + "; unplug it and plug it in again"});
  }
  return {};
}

std::expected<void, OpenError> UsbPmd::greet() {
  const auto refused = [&](const std::string& why) {
    return std::unexpected(OpenError{"PMD camera " + to_string(options_.id) + ": " + why});
  };
  // One that a program before us left running; one that was not running may refuse.
  static_cast<void>(link_.tell(number(PmdRequest::kStream), 0, {}));
  std::array<std::byte, kPmdInfoBytes> answer{};
  if (!link_.ask(number(PmdRequest::kInfo), answer)) {
    return refused(std::string("does not say what it is: ") + link_.error() +
                   "; unplug it and plug it in again");
  }
  const std::optional<PmdInfo> info = parse_pmd_info(answer);
  if (!info) {
    return refused("says of itself what nobody understands; update its firmware");
  }
  if (const std::string cannot = judge(*info, options_); !cannot.empty()) {
    return refused(cannot);
  }
  if (!memory_.empty() && (info->width != info_.width || info->height != info_.height)) {
    return refused("has another size than the one before it; restart the program");
  }
  info_ = *info;
  std::array<std::byte, kPmdConfigBytes> config = compose_pmd_config(options_.config);
  if (!link_.tell(number(PmdRequest::kSetConfig), 0, config)) {
    return refused(std::string("does not take frequency and integration: ") + link_.error() +
                   "; choose others");
  }
  if (!sync_now()) {
    return refused(std::string("does not tell its clock: ") + link_.error() +
                   "; update its firmware");
  }
  if (memory_.empty()) {
    buffer_bytes_ = buffer_size(info_);
    memory_.resize(buffer_bytes_ / sizeof(std::uint16_t) * Slots::kBuffers);
  }
  return {};
}

bool UsbPmd::sync_now() noexcept {
  clock_.reset();
  for (int i = 0; i < kClockTries; ++i) {
    std::array<std::byte, kPmdClockBytes> answer{};
    const Time before = Clock().now();
    if (!link_.ask(number(PmdRequest::kClock), answer)) {
      return false;
    }
    const Time after = Clock().now();
    clock_.sync(before, *parse_pmd_clock(answer), after);
    clock_asked_ = after;
  }
  return true;
}

bool UsbPmd::make_transfers() {
  for (Transfer& transfer : transfers_) {
    transfer.camera = this;
    transfer.libusb = libusb_alloc_transfer(0);
    if (transfer.libusb == nullptr) {
      return false;
    }
    // The buffer comes with each submission.
    libusb_fill_bulk_transfer(transfer.libusb, link_.device(), kPmdEndpoint, nullptr,
                              static_cast<int>(buffer_bytes_), on_frame, &transfer, 0);
  }
  clock_transfer_ = libusb_alloc_transfer(0);
  if (clock_transfer_ == nullptr) {
    return false;
  }
  libusb_fill_control_setup(clock_space_.data(), kPmdRequestIn, number(PmdRequest::kClock), 0,
                            link_.interface(), kPmdClockBytes);
  libusb_fill_control_transfer(clock_transfer_, link_.device(), clock_space_.data(), on_clock, this,
                               kClockMs);
  return true;
}

void UsbPmd::shut() noexcept {
  if (!link_.is_open()) {
    return;
  }
  const MarkedHeap libusb;
  if (!lost_) {
    static_cast<void>(link_.tell(number(PmdRequest::kStream), 0, {}));
  }
  closing_ = true;
  const auto under_way = [&] {
    bool any = clock_pending_;
    for (const Transfer& transfer : transfers_) {
      any = any || transfer.buffer >= 0;
    }
    return any;
  };
  for (const Transfer& transfer : transfers_) {
    if (transfer.buffer >= 0) {
      static_cast<void>(libusb_cancel_transfer(transfer.libusb));
    }
  }
  if (clock_pending_) {
    static_cast<void>(libusb_cancel_transfer(clock_transfer_));
  }
  Clock clock;
  const Time patience = clock.now() + kPatience;
  while (under_way() && clock.now() < patience) {
    run(std::chrono::milliseconds(20));
  }
  // What has not come back by now stays with libusb: to free it would be worse than to lose it.
  for (Transfer& transfer : transfers_) {
    if (transfer.buffer < 0) {
      libusb_free_transfer(transfer.libusb);
    } else {
      slots_.put_back(transfer.buffer);
    }
    transfer = {};
  }
  if (!clock_pending_) {
    libusb_free_transfer(clock_transfer_);
  }
  clock_transfer_ = nullptr;
  clock_pending_ = false;
  link_.close();
  slots_.drop_waiting();
  closing_ = false;
}

}  // namespace stof::hal::linux
