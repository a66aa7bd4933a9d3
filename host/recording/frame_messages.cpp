#include "host/recording/frame_messages.h"

#include <algorithm>
#include <array>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/messages/raw_info.h"

namespace stof::recording {
namespace {

// Without a calibration: what every sensor sends.
constexpr std::uint32_t kUnitUm = 250;

std::uint32_t unit_um(const client::Frame& frame) noexcept {
  return frame.calibration ? frame.calibration->depth_unit_um : kUnitUm;
}

// The messages of one frame: they share number, time and header.
class FrameMessages {
 public:
  FrameMessages(TopicMessages& to, const client::Frame& frame, std::uint64_t log_time)
      : to_(to), frame_(frame), log_time_(log_time) {}

  // value(pixel) is what is stored of it, std::uint8_t or std::uint16_t.
  template <typename T, typename Value>
  void image(Topic topic, dsp::ImageView<const T> image, const Value& value) {
    if (!image.empty()) {
      const std::array<dsp::ImageView<const T>, 1> one{image};
      stacked(topic, std::span<const dsp::ImageView<const T>>(one), value);
    }
  }

  // Images of one size below each other.
  template <typename T, typename Value>
  void stacked(Topic topic, std::span<const dsp::ImageView<const T>> images, const Value& value) {
    using Pixel = decltype(value(T{}));
    std::vector<Pixel> pixels;
    const dsp::ImageView<const T>& first = images.front();
    pixels.reserve(static_cast<std::size_t>(first.width()) *
                   static_cast<std::size_t>(first.height()) * images.size());
    for (const dsp::ImageView<const T>& image : images) {
      for (int y = 0; y < image.height(); ++y) {
        std::ranges::transform(image.row(y), std::back_inserter(pixels), value);
      }
    }
    const bool grey = topic == Topic::kLeft || topic == Topic::kRight || topic == Topic::kRawLeft ||
                      topic == Topic::kRawRight;
    const char* const narrow = grey ? "mono8" : "8UC1";
    add(topic, encode(Image{.header = header(),
                            .width = static_cast<std::uint32_t>(first.width()),
                            .height = static_cast<std::uint32_t>(first.height()) *
                                      static_cast<std::uint32_t>(images.size()),
                            .encoding = sizeof(Pixel) == 2 ? "16UC1" : narrow,
                            .data = std::as_bytes(std::span(pixels))}));
  }

  // Where each pixel has the source, in bits 0 to 3, and the cause, as in a tile.
  void sources() {
    if (frame_.source.empty()) {
      return;
    }
    std::vector<std::uint8_t> pixels;
    for (int y = 0; y < frame_.source.height(); ++y) {
      const std::span<const dsp::Source> source = frame_.source.row(y);
      for (std::size_t x = 0; x < source.size(); ++x) {
        const unsigned cause =
            frame_.cause.empty() ? 0U : static_cast<unsigned>(frame_.cause.row(y)[x]);
        pixels.push_back(static_cast<std::uint8_t>(static_cast<unsigned>(source[x]) | cause << 4U));
      }
    }
    add(Topic::kSource, encode(Image{.header = header(),
                                     .width = static_cast<std::uint32_t>(frame_.source.width()),
                                     .height = static_cast<std::uint32_t>(frame_.source.height()),
                                     .encoding = "8UC1",
                                     .data = std::as_bytes(std::span(pixels))}));
  }

  void info() {
    std::array<std::byte, wire::kFrameInfoBytes> payload{};
    if (frame_.info) {
      wire::encode_frame_info(*frame_.info, payload);
    }
    add(Topic::kFrameInfo, encode(Packet{.header = header(),
                                         .origin = frame_.origin,
                                         .stamp = frame_.stamp,
                                         .type = wire::PacketType::kFrameInfo,
                                         .packets = frame_.packets,
                                         .missing_packets = frame_.missing_packets,
                                         .recovered_packets = frame_.recovered_packets,
                                         .payload = frame_.info ? Bytes(payload) : Bytes()}));
  }

  MessageHeader header() const { return {.stamp_ns = frame_.stamp.exposure_middle_ns}; }
  void add(Topic topic, Buffer data) {
    to_.push_back({.topic = topic,
                   .sequence = frame_.stamp.number,
                   .log_time = log_time_,
                   .data = std::move(data)});
  }

 private:
  TopicMessages& to_;
  const client::Frame& frame_;
  std::uint64_t log_time_;
};

}  // namespace

LogClock::LogClock()
    : began_(client::Time::clock::now()),
      wall_ns_(std::chrono::duration_cast<std::chrono::nanoseconds>(
                   std::chrono::system_clock::now().time_since_epoch())
                   .count()) {}

std::uint64_t LogClock::at(client::Time time) const noexcept {
  const std::chrono::nanoseconds since = time - began_;
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, wall_ns_ + since.count()));
}

Buffer encode_depth_mm(const MessageHeader& header, const client::Frame& frame) {
  const std::uint32_t unit = unit_um(frame);
  std::vector<std::uint16_t> pixels;
  pixels.reserve(static_cast<std::size_t>(frame.depth.width()) *
                 static_cast<std::size_t>(frame.depth.height()));
  for (int y = 0; y < frame.depth.height(); ++y) {
    for (const dsp::QuarterMm depth : frame.depth.row(y)) {
      pixels.push_back(millimetres(depth, unit));
    }
  }
  return encode(Image{.header = header,
                      .width = static_cast<std::uint32_t>(frame.depth.width()),
                      .height = static_cast<std::uint32_t>(frame.depth.height()),
                      .encoding = "16UC1",
                      .data = std::as_bytes(std::span(pixels))});
}

void append_frame(TopicMessages& to, const client::Frame& frame, std::uint64_t log_time) {
  FrameMessages messages(to, frame, log_time);
  messages.info();
  const auto as_it_is = [](auto pixel) { return pixel; };
  if (!frame.depth.empty()) {
    messages.add(Topic::kDepthMm, encode_depth_mm(messages.header(), frame));
  }
  messages.image(Topic::kDepth, frame.depth, as_it_is);
  messages.image(Topic::kWidth, frame.interval_width, as_it_is);
  messages.sources();
  if (!frame.complete()) {
    messages.image(Topic::kReceived, frame.received, as_it_is);
  }
  messages.image(Topic::kDisparity, frame.disparity, [](dsp::Disparity disparity) {
    return static_cast<std::uint16_t>(disparity.valid() ? 32768 + disparity.raw : 0);
  });
  if (!frame.pmd.front().empty()) {
    messages.stacked(Topic::kPmdRaw,
                     std::span<const dsp::ImageView<const std::uint16_t>>(frame.pmd), as_it_is);
  }
  messages.image(Topic::kLeft, frame.left, as_it_is);
  messages.image(Topic::kRight, frame.right, as_it_is);
  if (frame.calibration && !frame.depth.empty()) {
    messages.add(Topic::kCameraInfo, encode_camera_info(messages.header(), *frame.calibration));
  }
}

void append_calibration(TopicMessages& to, const client::Frame& beside, std::uint64_t log_time) {
  std::array<std::byte, wire::kCalibrationPacketBytes> payload{};
  wire::encode_calibration_packet(*beside.calibration, payload);
  FrameMessages messages(to, beside, log_time);
  messages.add(Topic::kCalibration, encode(Packet{.header = messages.header(),
                                                  .origin = beside.origin,
                                                  .stamp = beside.stamp,
                                                  .type = wire::PacketType::kCalibration,
                                                  .payload = payload}));
}

void append_health(TopicMessages& to, wire::Origin origin, const wire::HealthReport& health,
                   std::uint64_t log_time) {
  std::array<std::byte, wire::kHealthReportBytes> payload{};
  wire::encode_health_report(health, payload);
  // Health has the sensor's uptime, not its clock: on the wall clock, as log_time.
  const MessageHeader header{.stamp_ns = static_cast<std::int64_t>(log_time)};
  to.push_back({.topic = Topic::kHealth,
                .log_time = log_time,
                .data = encode(Packet{.header = header,
                                      .origin = origin,
                                      .type = wire::PacketType::kHealth,
                                      .payload = payload})});
  const std::array status{health_status("stof: health", origin.device_id, health)};
  to.push_back({.topic = Topic::kDiagnostics,
                .log_time = log_time,
                .data = encode_diagnostics(header, status)});
}

void append_event(TopicMessages& to, wire::Origin origin, const wire::EventReport& event,
                  std::uint64_t log_time) {
  std::array<std::byte, wire::kEventReportBytes> payload{};
  wire::encode_event_report(event, payload);
  to.push_back({.topic = Topic::kEvent,
                .sequence = event.sequence,
                .log_time = log_time,
                .data = encode(Packet{.header = {.stamp_ns = event.at_ns},
                                      .origin = origin,
                                      .type = wire::PacketType::kEvent,
                                      .payload = payload})});
}

void append_settings(TopicMessages& to, std::string_view document, std::uint64_t log_time) {
  to.push_back({.topic = Topic::kSettings, .log_time = log_time, .data = encode_string(document)});
}

void append_raw(TopicMessages& to, const client::RawExposure& exposure, std::uint64_t log_time) {
  const client::Frame named{.origin = exposure.origin, .stamp = exposure.stamp};
  FrameMessages messages(to, named, log_time);
  std::array<std::byte, wire::kRawInfoBytes> payload{};
  wire::encode_raw_info(exposure.info, payload);
  messages.add(Topic::kRawEdge, encode(Packet{.header = messages.header(),
                                              .origin = exposure.origin,
                                              .stamp = exposure.stamp,
                                              .type = wire::PacketType::kRawInfo,
                                              .payload = payload}));
  const auto as_it_is = [](auto pixel) { return pixel; };
  messages.image(Topic::kRawLeft, exposure.left, as_it_is);
  messages.image(Topic::kRawRight, exposure.right, as_it_is);
  if (!exposure.pmd.front().empty()) {
    messages.stacked(Topic::kRawPmd,
                     std::span<const dsp::ImageView<const std::uint16_t>>(exposure.pmd), as_it_is);
  }
}

}  // namespace stof::recording
