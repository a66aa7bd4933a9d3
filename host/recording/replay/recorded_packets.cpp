#include "host/recording/replay/recorded_packets.h"

#include <span>

#include "firmware/wire/calibration/calibration_packet.h"
#include "firmware/wire/messages/calibration.h"

namespace stof::recording {
namespace {

template <typename T>
dsp::ImageView<const T> view_of(const std::vector<T>& pixels, int width, int height) {
  return pixels.empty() ? dsp::ImageView<const T>()
                        : dsp::ImageView<const T>(pixels.data(), width, height);
}

bool same(const wire::FrameSizes& a, const wire::FrameSizes& b) {
  return a.width == b.width && a.height == b.height && a.pmd_width == b.pmd_width &&
         a.pmd_height == b.pmd_height;
}

}  // namespace

wire::Header RecordedPackets::header(wire::PacketType type) const noexcept {
  return {.type = type, .origin = origin_, .frame = stamp_};
}

wire::FrameCoder& RecordedPackets::coder(const wire::FrameSizes& sizes) {
  if (!coder_ || !same(sizes, sizes_)) {
    constexpr std::int32_t kOne = 65536;  // no cloud is sent, and none is looked at
    const wire::CalibrationPacket lens{.fx = kOne, .fy = kOne};
    const std::size_t packets = wire::FrameCoder::most_packets(sizes);
    const std::size_t bytes = dsp::bytes_taken([&](dsp::Arena& arena) {
      static_cast<void>(wire::FrameCoder(origin_, sizes, lens, arena, packets));
    });
    coder_.reset();
    memory_.assign(bytes + dsp::Arena::kAlign, std::byte{0});
    void* begin = memory_.data();
    std::size_t room = memory_.size();
    std::byte* const aligned =
        static_cast<std::byte*>(std::align(dsp::Arena::kAlign, bytes, begin, room));
    dsp::Arena arena(std::span(aligned, room));
    coder_.emplace(origin_, sizes, lens, arena, packets);
    sizes_ = sizes;
  }
  return *coder_;
}

std::optional<wire::Datagrams> RecordedPackets::frame(const RecordedFrame& frame) {
  if (frame.missing_packets != 0 || !frame.info || frame.depth.empty()) {
    return std::nullopt;
  }
  const int w = frame.width;
  const int h = frame.height;
  // The coder reads a map through views that others could write through.
  const auto writable = [w, h]<typename T>(const std::vector<T>& pixels) {
    return pixels.empty() ? dsp::ImageView<T>()
                          : dsp::ImageView<T>(const_cast<T*>(pixels.data()), w, h);
  };
  wire::FrameImages images{.map = {.depth = writable(frame.depth),
                                   .width = writable(frame.interval_width),
                                   .source = writable(frame.source),
                                   .cause = writable(frame.cause)},
                           .disparity = view_of(frame.disparity, w, h),
                           .left = view_of(frame.left, frame.left_width, frame.left_height),
                           .right = view_of(frame.right, frame.left_width, frame.left_height)};
  for (std::size_t k = 0; k < images.pmd.size(); ++k) {
    images.pmd[k] = view_of(frame.pmd[k], frame.pmd_width, frame.pmd_height);
  }
  wire::StreamChoice choice;
  choice.coding.fill(wire::Coding::kRvl);
  choice.of(wire::Stream::kCloud) = wire::Coding::kOff;
  stamp_ = frame.stamp;
  stamp_.clock = wire::ClockState::kRecorded;
  const wire::FrameSizes sizes{
      .width = w, .height = h, .pmd_width = frame.pmd_width, .pmd_height = frame.pmd_height};
  auto datagrams = coder(sizes).code(stamp_, *frame.info, images, choice);
  return datagrams ? std::optional(*datagrams) : std::nullopt;
}

std::span<const std::byte> RecordedPackets::calibration(const RecordedFrame& frame) {
  if (!frame.calibration) {
    return {};
  }
  wire::encode_calibration_packet(
      *frame.calibration, wire::payload_space(buffer_).first<wire::kCalibrationPacketBytes>());
  return wire::seal_packet(header(wire::PacketType::kCalibration), wire::kCalibrationPacketBytes,
                           buffer_);
}

std::span<const std::byte> RecordedPackets::health(const wire::HealthReport& health) {
  wire::encode_health_report(health,
                             wire::payload_space(buffer_).first<wire::kHealthReportBytes>());
  return wire::seal_packet(header(wire::PacketType::kHealth), wire::kHealthReportBytes, buffer_);
}

std::span<const std::byte> RecordedPackets::event(const wire::EventReport& event) {
  wire::encode_event_report(event, wire::payload_space(buffer_).first<wire::kEventReportBytes>());
  return wire::seal_packet(header(wire::PacketType::kEvent), wire::kEventReportBytes, buffer_);
}

}  // namespace stof::recording
