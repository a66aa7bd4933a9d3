#include "board/board.h"

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "board/devices/connections.h"
#include "board/devices/device_options.h"
#include "board/devices/hotplug_camera.h"
#include "board/devices/nominal_rig.h"
#include "board/devices/wiring.h"
#include "hal/linux/gpio/gpio_button.h"
#include "hal/linux/gpio/gpio_trigger.h"
#include "hal/linux/libcamera/libcamera_stereo.h"
#include "hal/linux/system/clock.h"
#include "hal/linux/system/file_disk.h"
#include "hal/linux/system/file_lock.h"
#include "hal/linux/system/file_slots.h"
#include "hal/linux/system/file_store.h"
#include "hal/linux/system/heap_watch.h"
#include "hal/linux/system/realtime.h"
#include "hal/linux/system/restart.h"
#include "hal/linux/system/watchdog.h"
#include "hal/linux/usb/usb_pmd.h"
#include "hal/linux/v4l2/v4l2_pmd.h"
#include "hal/linux/v4l2/v4l2_stereo.h"

namespace stof::board {
namespace {

namespace linux = hal::linux;

using Stereo = HotplugCamera<hal::StereoCamera, hal::StereoFrame>;
using Pmd = HotplugCamera<hal::PmdCamera, hal::PmdFrame>;

// A PMD camera that leaves out edges looks like one that lost them.
static_assert(kTiming.pmd_every == 1);

bool has_pmd(const DeviceOptions& device_options) { return device_options.pmd != "none"; }

PictureSize stereo_size(const DeviceOptions& device_options) {
  return device_options.size.value_or(PictureSize{kConfig.stereo.width, kConfig.stereo.height});
}

PictureSize pmd_size(const DeviceOptions& device_options) {
  return has_pmd(device_options)
             ? device_options.pmd_size.value_or(PictureSize{kConfig.pmd.width, kConfig.pmd.height})
             : PictureSize{};
}

// Everything that the board is made of, as long as the program lives.
class Rig {
 public:
  Rig(DeviceOptions&& device_options, OpenConnections&& connections,
      std::unique_ptr<linux::GpioTrigger> trigger)
      : options_(std::move(device_options)),
        connections_(std::move(connections)),
        trigger_(std::move(trigger)),
        stereo_exposures_(trigger_->edges(), kTiming.stereo_exposure),
        pmd_exposures_(trigger_->edges(), kTiming.pmd_integration),
        left_strobe_(*trigger_, 0),
        right_strobe_(*trigger_, strobe_lines(options_)[0].empty() ? 0 : 1),
        stereo_([this] { return open_stereo(); }) {
    if (has_pmd(options_)) {
      pmd_.emplace([this] { return open_pmd(); });
    }
    open_watchdog();
    open_button();
    assemble();
  }

  // An orderly end, also of a start that was refused: nothing is to be restarted.
  ~Rig() {
    if (watchdog_) {
      static_cast<void>(watchdog_->disarm());
    }
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  Board& board() { return *board_; }
  int priority() const { return priority_of(options_); }

  // The serial line is the control thread's, which reopens it.
  Status reopen(Device device) noexcept {
    switch (device) {
      case Device::kTrigger:
        return trigger_->reopen();
      case Device::kStereo:
        return stereo_.reopen();
      case Device::kPmd:
        return pmd_ ? pmd_->reopen() : Status::kOk;
    }
    return Status::kOk;
  }

 private:
  std::expected<Stereo::Opened, linux::OpenError> open_stereo();
  std::expected<Pmd::Opened, linux::OpenError> open_pmd();
  void open_watchdog();
  void open_button();
  void assemble();

  // What a sensor says itself, where it is wired, else what it was told.
  std::array<linux::Exposures*, 2> stereo_exposures() {
    linux::Exposures* const told = &stereo_exposures_;
    const std::array<std::string, 2> lines = strobe_lines(options_);
    return {lines[0].empty() ? told : &left_strobe_, lines[1].empty() ? told : &right_strobe_};
  }

  DeviceOptions options_;
  OpenConnections connections_;
  linux::Clock clock_;
  std::unique_ptr<linux::GpioTrigger> trigger_;
  linux::EdgeExposures stereo_exposures_;
  linux::EdgeExposures pmd_exposures_;
  linux::StrobeExposures left_strobe_;  // used where it is wired
  linux::StrobeExposures right_strobe_;
  Stereo stereo_;
  std::optional<Pmd> pmd_;
  std::unique_ptr<linux::WatchdogDevice> watchdog_;
  std::unique_ptr<linux::GpioButton> button_;
  std::vector<std::string> notes_;
  std::optional<Board> board_;
};

// A camera of a kind that is opened by `make`, as one that may be missing.
template <typename Opened, typename Made>
std::expected<Opened, linux::OpenError> opened(Made&& made) {
  if (!made) {
    return std::unexpected(std::move(made.error()));
  }
  auto* const camera = made->get();
  return Opened{.camera = std::move(*made), .reopen = [camera] { return camera->reopen(); }};
}

std::string or_table(const std::string& wanted, const char* table) {
  return wanted.empty() ? std::string(table) : wanted;
}

std::expected<Stereo::Opened, linux::OpenError> Rig::open_stereo() {
  const PairConfig& pair = pair_of(options_);
  const PictureSize size = stereo_size(options_);
  const std::string left = or_table(options_.left, pair.left);
  std::string right = or_table(options_.right, pair.right);
  if (right == "none") {
    right.clear();
  }
  if (options_.cameras == PairKind::kLibcamera) {
    linux::LibcameraOptions options;
    options.left = left;
    options.right = right;
    options.width = size.width;
    options.height = size.height;
    options.exposure = kTiming.stereo_exposure;
    options.gain = static_cast<float>(options_.gain.value_or(0));
    options.exposures = &stereo_exposures_;
    options.most_delay = pair.most_delay;
    options.most_skew = kTiming.edge_tolerance;
    return opened<Stereo::Opened>(linux::open_libcamera(options));
  }
  return opened<Stereo::Opened>(linux::V4l2Stereo::open(linux::kernel_calls(), clock_,
                                                        {.nodes = {left, right},
                                                         .width = size.width,
                                                         .height = size.height,
                                                         .exposure = kTiming.stereo_exposure,
                                                         .gain = options_.gain,
                                                         .exposures = stereo_exposures(),
                                                         .most_delay = pair.most_delay}));
}

std::expected<Pmd::Opened, linux::OpenError> Rig::open_pmd() {
  const PictureSize size = pmd_size(options_);
  if (options_.pmd != "usb") {
    return opened<Pmd::Opened>(linux::V4l2Pmd::open(linux::kernel_calls(), clock_,
                                                    {.node = options_.pmd,
                                                     .width = size.width,
                                                     .height = size.height,
                                                     .exposures = &pmd_exposures_,
                                                     .integration = kTiming.pmd_integration,
                                                     .most_delay = pair_of(options_).most_delay}));
  }
  linux::UsbPmdOptions options;
  options.id.vendor = kDevices.pmd.usb_vendor;
  options.id.product = kDevices.pmd.usb_product;
  options.config.modulation_khz = kDevices.pmd.modulation_khz;
  options.config.integration_us = kDevices.pmd.integration_us;
  options.width = size.width;
  options.height = size.height;
  options.edge_tolerance = kDevices.pmd.edge_tolerance;
  return opened<Pmd::Opened>(linux::UsbPmd::open(options, trigger_->edges()));
}

void Rig::open_watchdog() {
  const std::string device = or_table(options_.watchdog, kDevices.watchdog);
  if (device.empty() || device == "none") {
    return;
  }
  auto opened = linux::WatchdogDevice::open(
      {.device = device,
       .timeout = std::chrono::duration_cast<std::chrono::seconds>(kDevices.watchdog_timeout)});
  if (opened) {
    watchdog_ = std::move(*opened);
  } else {
    notes_.push_back("no watchdog: " + opened.error().message);
  }
}

// Without it a sensor pairs over its cable or with the code of its label.
void Rig::open_button() {
  const std::string line = button_line(options_);
  if (line.empty()) {
    return;
  }
  auto opened = linux::GpioButton::open({.line = line});
  if (opened) {
    button_ = std::move(*opened);
  } else {
    notes_.push_back("no button for pairing: " + opened.error().message);
  }
}

void Rig::assemble() {
  const PairConfig& pair = pair_of(options_);
  notes_.insert(notes_.end(), connections_.notes.begin(), connections_.notes.end());
  if (!stereo_.why().empty()) {
    notes_.push_back("waiting for the stereo cameras: " + stereo_.why());
  }
  if (pmd_ && !pmd_->why().empty()) {
    notes_.push_back("waiting for the PMD camera: " + pmd_->why());
  }
  if (!pmd_) {
    notes_.emplace_back("no PMD camera (--pmd none): depth from stereo alone");
  }
  board_.emplace(
      Board{.clock = clock_,
            .trigger = *trigger_,
            .stereo = stereo_,
            .pmd = pmd_ ? &*pmd_ : nullptr,
            .port = *connections_.port,
            .serial = connections_.serial ? &*connections_.serial : nullptr,
            .to = connections_.to,
            .network = *connections_.network,
            .beacon = connections_.beacon.get(),
            .mdns = connections_.mdns.get(),
            .watchdog = watchdog_.get(),
            .button = button_.get(),
            .calibration = nominal_rig(kConfig, stereo_size(options_), pmd_size(options_)),
            .nominal_calibration = true,
            .allow_nominal_calibration = options_.uncalibrated,
            .disparities = kConfig.stereo.disparities,
            .least_period = least_period(pair, kTiming),
            .emulated_time = false,
            .other_port = connections_.other_port,
            .notes = notes_});
}

std::optional<Rig> rig;

}  // namespace

std::expected<Board*, Refusal> open(const Connections& connections,
                                    std::span<const std::string_view> arguments) {
  std::expected<DeviceOptions, Refusal> device_options = parse_device_options(arguments);
  if (!device_options) {
    return std::unexpected(device_options.error());
  }
  std::expected<OpenConnections, Refusal> talks = open_connections(connections);
  if (!talks) {
    return std::unexpected(talks.error());
  }
  auto trigger = linux::GpioTrigger::open(trigger_options(*device_options));
  if (!trigger) {
    return std::unexpected(Refusal{.message = trigger.error().message, .device = true});
  }
  rig.emplace(std::move(*device_options), std::move(*talks), std::move(*trigger));
  return &rig->board();
}

std::unique_ptr<hal::Store> make_store(std::string_view name) {
  return std::make_unique<linux::FileStore>(std::string(name));
}

std::unique_ptr<hal::Store> make_secret_store(std::string_view name) {
  return std::make_unique<linux::FileStore>(std::string(name), linux::FileStore::Readers::kOwner);
}

Status hold_alone(std::string_view name, bool make) {
  return linux::hold_file(std::string(name), make, std::chrono::seconds(2));
}

Result<std::unique_ptr<hal::Disk>> make_disk(std::string_view name) {
  return linux::FileDisk::open(std::string(name));
}

Result<std::unique_ptr<hal::Slots>> make_slots(std::string_view prefix) {
  return linux::FileSlots::open(std::string(prefix));
}

// The firmware of a Raspberry Pi takes the number of a partition, 0: as autoboot.txt says.
Status restart_machine(bool trial) noexcept {
  return linux::restart_machine(trial ? "0 tryboot" : "");
}

Status reopen(Board& /*board*/, Device device) noexcept { return rig->reopen(device); }

void keep_memory_private() noexcept { linux::keep_memory_private(); }

std::optional<std::string> lock_memory() {
  if (rig->priority() == 0) {
    return std::nullopt;
  }
  std::optional<std::string> refused = linux::lock_memory();
  linux::prefault_stack();
  return refused;
}

std::optional<std::string> set_realtime_priority(bool realtime) {
  if (rig->priority() == 0) {
    return std::nullopt;
  }
  return realtime ? linux::set_fifo_priority(rig->priority()) : linux::set_ordinary_priority();
}

void count_heap_calls() noexcept { linux::watch_heap_of_this_thread(); }

HeapCalls heap_calls() noexcept {
  const linux::HeapCounts counts = linux::heap_counts();
  return {.counted = counts.counted, .own = counts.calls, .libraries = counts.marked};
}

}  // namespace stof::board
