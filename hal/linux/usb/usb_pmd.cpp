#include "hal/linux/usb/usb_pmd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <utility>

#include <libusb-1.0/libusb.h>

#include "hal/linux/system/clock.h"
#include "hal/linux/system/heap_watch.h"

namespace stof::hal::linux {
namespace {

static_assert(std::endian::native == std::endian::little, "pictures are read as they come");

constexpr Duration kPatience = std::chrono::seconds(1);  // for cancelled transfers
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
  stream_ = {};
  last_sequence_ = 0;
  if (make_transfers()) {
    submit_idle();
  } else {
    stream_.lost = true;
  }
  if (stream_.lost) {
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
  if (!clock_.read_now(link_)) {
    return refused(std::string("does not tell its clock: ") + link_.error() +
                   "; update its firmware");
  }
  if (memory_.empty()) {
    buffer_bytes_ = buffer_size(info_);
    memory_.resize(buffer_bytes_ / sizeof(std::uint16_t) * Slots::kBuffers);
  }
  return {};
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
  return clock_.begin(link_, progress_);
}

void UsbPmd::shut() noexcept {
  if (!link_.is_open()) {
    return;
  }
  const MarkedHeap libusb;
  if (!stream_.lost) {
    static_cast<void>(link_.tell(number(PmdRequest::kStream), 0, {}));
  }
  stream_.closing = true;
  const auto under_way = [&] {
    bool any = clock_.pending();
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
  clock_.cancel();
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
  clock_.end();
  link_.close();
  slots_.drop_waiting();
  stream_.closing = false;
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
    stream_.lost =
        true;  // NO_DEVICE, or a system that has no memory for it: both take a new beginning
  }
}

void UsbPmd::submit_idle() noexcept {
  for (Transfer& transfer : transfers_) {
    if (transfer.buffer < 0 && !stream_.lost) {
      submit(transfer);
    }
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
  const bool good = status == LIBUSB_TRANSFER_COMPLETED && !stream_.closing &&
                    accept(buffer, static_cast<std::size_t>(transfer.libusb->actual_length));
  if (good) {
    stream_.damaged_in_row = 0;
    slots_.push(buffer);
  } else {
    slots_.put_back(buffer);
  }
  if (stream_.closing || status == LIBUSB_TRANSFER_CANCELLED) {
    return;
  }
  stream_.lost = stream_.lost || status == LIBUSB_TRANSFER_NO_DEVICE;
  stream_.stalled = stream_.stalled || status == LIBUSB_TRANSFER_STALL;
  if (!good && !stream_.lost) {
    ++stream_.damaged_in_row;
    stream_.damaged += status == LIBUSB_TRANSFER_STALL ? 0 : 1;
    stream_.lost = stream_.damaged_in_row >= kMostDamaged;
  }
  if (!stream_.lost && !stream_.stalled) {
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
  std::optional<Time> edge = clock_.clock().convert(header->edge);
  if (!edge) {
    return false;
  }
  const std::optional<Time> nearest = edges_.nearest(*edge);
  if (nearest && std::chrono::abs(*nearest - *edge) <= options_.edge_tolerance) {
    static_cast<void>(clock_.clock().correct_by_event(*nearest, header->edge));
    edge = nearest;
  }
  last_sequence_ = header->sequence;
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
    stream_.lost = true;
  }
}

// What there is to be told instead of a frame.
std::optional<Status> UsbPmd::trouble_now() noexcept {
  if (stream_.damaged > 0) {
    --stream_.damaged;
    return Status::kCorrupt;
  }
  if (stream_.lost || !link_.is_open()) {
    return Status::kDeviceLost;
  }
  if (!stream_.stalled) {
    return std::nullopt;
  }
  stream_.stalled = false;
  const MarkedHeap libusb;
  stream_.lost = libusb_clear_halt(link_.device(), kPmdEndpoint) != 0;
  submit_idle();
  return stream_.lost ? Status::kDeviceLost : Status::kDeviceError;
}

Result<BorrowedFrame<PmdFrame>> UsbPmd::wait_frame(Time deadline) noexcept {
  Clock clock;
  if (link_.is_open()) {
    if (!stream_.lost) {
      clock_.ask();
    }
    // All that has come, so that what is kept are the newest frames: each makes room for another.
    for (std::size_t i = 0; i < 2 * Slots::kBuffers; ++i) {
      run({});
      if (progress_ == 0) {
        break;
      }
    }
  }
  for (bool over = false;;) {
    if (!slots_.empty()) {
      const int buffer = slots_.lend();
      return BorrowedFrame<PmdFrame>(frames_[static_cast<std::size_t>(buffer)], *this, buffer);
    }
    if (const std::optional<Status> trouble = trouble_now()) {
      return fail(*trouble);
    }
    if (over) {
      return fail(Status::kTimeout);
    }
    // One more look behind the deadline: what came while the system ran others is there.
    const Time now = clock.now();
    over = now >= deadline;
    run(over ? Duration::zero()
             : std::min<Duration>(deadline - now + std::chrono::microseconds(1),
                                  UsbClockReader::kEvery));
  }
}

}  // namespace stof::hal::linux
