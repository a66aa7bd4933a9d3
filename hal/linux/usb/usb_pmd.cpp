#include "hal/linux/usb/usb_pmd.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <utility>

#include <libusb-1.0/libusb.h>

#include "hal/linux/system/clock.h"
#include "hal/linux/system/heap_watch.h"

namespace stof::hal::linux {
namespace {

static_assert(std::endian::native == std::endian::little, "pictures are read as they come");

constexpr Duration kClockEvery = std::chrono::seconds(1);

}  // namespace

UsbPmd::UsbPmd(UsbPmdOptions options, const EdgeLog& edges)
    : options_(std::move(options)), edges_(edges) {}

std::expected<std::unique_ptr<UsbPmd>, OpenError> UsbPmd::open(const UsbPmdOptions& options,
                                                               const EdgeLog& edges) {
  std::unique_ptr<UsbPmd> camera(new UsbPmd(options, edges));
  if (const auto started = camera->start(); !started) {
    return std::unexpected(started.error());
  }
  return camera;
}

UsbPmd::~UsbPmd() { shut(); }

Status UsbPmd::reopen() noexcept {
  shut();
  const auto started = start();
  trouble_ = started ? std::string() : started.error().message;
  return started ? Status::kOk : Status::kDeviceLost;
}

std::span<std::byte> UsbPmd::space(int buffer) noexcept {
  return std::as_writable_bytes(std::span(memory_))
      .subspan(static_cast<std::size_t>(buffer) * buffer_bytes_, buffer_bytes_);
}

void UsbPmd::submit(Transfer& transfer) noexcept {
  const MarkedHeap libusb;
  transfer.buffer = slots_.take_free();
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): libusb's bytes
  transfer.libusb->buffer = reinterpret_cast<unsigned char*>(space(transfer.buffer).data());
  if (libusb_submit_transfer(transfer.libusb) != 0) {
    slots_.put_back(std::exchange(transfer.buffer, -1));
    lost_ = true;  // NO_DEVICE, or a system that has no memory for it: both take a new beginning
  }
}

void UsbPmd::submit_idle() noexcept {
  for (Transfer& transfer : transfers_) {
    if (transfer.buffer < 0 && !lost_) {
      submit(transfer);
    }
  }
}

void UsbPmd::ask_clock() noexcept {
  const Time now = Clock().now();
  if (clock_pending_ || lost_ || now - clock_asked_ < kClockEvery) {
    return;
  }
  const MarkedHeap libusb;
  clock_asked_ = now;
  clock_pending_ = libusb_submit_transfer(clock_transfer_) == 0;
}

// libusb calls it from within run(), or shut().
void UsbPmd::on_clock(libusb_transfer* done) {
  UsbPmd& camera = *static_cast<UsbPmd*>(done->user_data);
  camera.clock_pending_ = false;
  camera.progress_ = 1;
  const auto answer = std::as_bytes(std::span(camera.clock_space_)).last<kPmdClockBytes>();
  if (done->status == LIBUSB_TRANSFER_COMPLETED &&
      done->actual_length == static_cast<int>(kPmdClockBytes)) {
    camera.clock_.sync(camera.clock_asked_, *parse_pmd_clock(answer), Clock().now());
  }
}

void UsbPmd::on_frame(libusb_transfer* done) {
  Transfer& transfer = *static_cast<Transfer*>(done->user_data);
  transfer.camera->take_in(transfer);
}

void UsbPmd::take_in(Transfer& transfer) noexcept {
  progress_ = 1;
  const int buffer = std::exchange(transfer.buffer, -1);
  const libusb_transfer_status status = transfer.libusb->status;
  const bool good = status == LIBUSB_TRANSFER_COMPLETED && !closing_ &&
                    accept(buffer, static_cast<std::size_t>(transfer.libusb->actual_length));
  if (good) {
    damaged_in_row_ = 0;
    lost_frames_ += slots_.push(buffer) ? 0U : 1U;
  } else {
    slots_.put_back(buffer);
  }
  if (closing_ || status == LIBUSB_TRANSFER_CANCELLED) {
    return;
  }
  lost_ = lost_ || status == LIBUSB_TRANSFER_NO_DEVICE;
  stalled_ = stalled_ || status == LIBUSB_TRANSFER_STALL;
  if (!good && !lost_) {
    ++damaged_in_row_;
    damaged_ += status == LIBUSB_TRANSFER_STALL ? 0 : 1;
    lost_ = damaged_in_row_ >= kMostDamaged;
  }
  if (!lost_ && !stalled_) {
    submit(transfer);
  }
}

// Whether the buffer holds a frame; then it is in frames_.
bool UsbPmd::accept(int buffer, std::size_t bytes) noexcept {
  const std::span<const std::byte> message = space(buffer).first(bytes);
  const std::optional<PmdHeader> header = parse_pmd_frame(message, info_);
  // Ahead of the last one, modulo 2^32.
  if (!header || header->modulation_khz != options_.config.modulation_khz ||
      static_cast<std::int32_t>(header->sequence - last_sequence_) <= 0) {
    return false;
  }
  std::optional<Time> edge = clock_.convert(header->edge);
  if (!edge) {
    return false;
  }
  const std::optional<Time> nearest = edges_.nearest(*edge);
  if (nearest && std::chrono::abs(*nearest - *edge) <= options_.edge_tolerance) {
    static_cast<void>(clock_.follow(*nearest, header->edge));
    edge = nearest;
  }
  last_sequence_ = header->sequence;
  temperature_ = header->temperature;
  flags_ = header->flags;
  const std::size_t at = (static_cast<std::size_t>(buffer) * buffer_bytes_ + header->bytes) / 2;
  const std::size_t picture = pmd_picture_bytes(info_) / 4 / sizeof(std::uint16_t);
  PmdFrame& frame = frames_[static_cast<std::size_t>(buffer)];
  frame.sequence = header->sequence;
  for (std::size_t k = 0; k < frame.samples.size(); ++k) {
    const Time begin = *edge + Duration(header->samples[k].begin_ns);
    frame.exposures[k] = {begin, begin + Duration(header->samples[k].length_ns)};
    frame.samples[k] = dsp::ImageView<const std::uint16_t>(memory_.data() + at + k * picture,
                                                           info_.width, info_.height);
  }
  return true;
}

void UsbPmd::run(Duration at_most) noexcept {
  progress_ = 0;
  const auto limit = std::chrono::duration_cast<std::chrono::microseconds>(at_most);
  if (!link_.run(std::max<std::int64_t>(limit.count(), 0), progress_)) {
    lost_ = true;
  }
}

// What there is to be told instead of a frame.
std::optional<Status> UsbPmd::trouble_now() noexcept {
  if (damaged_ > 0) {
    --damaged_;
    return Status::kCorrupt;
  }
  if (lost_ || !link_.is_open()) {
    return Status::kDeviceLost;
  }
  if (!stalled_) {
    return std::nullopt;
  }
  stalled_ = false;
  const MarkedHeap libusb;
  lost_ = libusb_clear_halt(link_.device(), kPmdEndpoint) != 0;
  submit_idle();
  return lost_ ? Status::kDeviceLost : Status::kDeviceError;
}

Result<Lease<PmdFrame>> UsbPmd::wait_frame(Time deadline) noexcept {
  Clock clock;
  if (link_.is_open()) {
    ask_clock();
    // All that has come, so that what is kept are the newest frames: each makes room for another.
    for (std::size_t i = 0; i < 2 * Slots::kBuffers; ++i) {
      run({});
      if (progress_ == 0) {
        break;
      }
    }
  }
  for (;;) {
    if (!slots_.empty()) {
      const int buffer = slots_.lease();
      return Lease<PmdFrame>(frames_[static_cast<std::size_t>(buffer)], *this, buffer);
    }
    if (const std::optional<Status> trouble = trouble_now()) {
      return fail(*trouble);
    }
    const Time now = clock.now();
    if (now >= deadline) {
      return fail(Status::kTimeout);
    }
    run(std::min<Duration>(deadline - now + std::chrono::microseconds(1), kClockEvery));
  }
}

}  // namespace stof::hal::linux
