#include "host/recording/frame_assembler.h"

#include <algorithm>

#include "firmware/wire/bytes.h"
#include "firmware/wire/calibration/calibration_packet.h"

namespace stof::recording {

client::Frame RecordedFrame::view() const {
  client::Frame frame{.origin = origin, .stamp = stamp};
  const auto sized = []<typename T>(const std::vector<T>& pixels, int columns, int rows) {
    return pixels.empty() ? dsp::ImageView<const T>()
                          : dsp::ImageView<const T>(pixels.data(), columns, rows);
  };
  const auto image = [&](const auto& pixels) { return sized(pixels, width, height); };
  frame.depth = image(depth);
  frame.interval_width = image(interval_width);
  frame.source = image(source);
  frame.cause = image(cause);
  frame.received = image(received);
  frame.left = sized(left, left_width, left_height);
  frame.packets = packets;
  frame.missing_packets = missing_packets;
  frame.info = info;
  frame.calibration = calibration;
  return frame;
}

client::Frame RecordedFrame::whole_view() const {
  const auto sized = []<typename T>(const std::vector<T>& pixels, int columns, int rows) {
    return pixels.empty() ? dsp::ImageView<const T>()
                          : dsp::ImageView<const T>(pixels.data(), columns, rows);
  };
  client::Frame frame = view();
  frame.right = sized(right, left_width, left_height);
  frame.disparity = sized(disparity, width, height);
  for (std::size_t k = 0; k < pmd.size(); ++k) {
    frame.pmd[k] = sized(pmd[k], pmd_width, pmd_height);
  }
  const auto mark = [&](wire::Stream stream, const auto& image) {
    if (image.empty() || frame.received.empty()) {
      return;
    }
    frame.marks[client::index_of(stream)] = frame.received;
    frame.missing[client::index_of(stream)] = static_cast<std::uint32_t>(std::ranges::count_if(
        received,
        [bit = client::mark_of(stream)](std::uint8_t marks) { return (marks & bit) == 0; }));
  };
  mark(wire::Stream::kDepth, frame.depth);
  mark(wire::Stream::kWidth, frame.interval_width);
  mark(wire::Stream::kSource, frame.source);
  return frame;
}

std::optional<wire::HealthReport> health_at(const Sights& sights, std::uint64_t log_time) {
  std::uint64_t began = 0;
  for (const std::uint64_t start : sights.starts) {
    began = start <= log_time ? std::max(began, start) : began;
  }
  for (std::size_t i = sights.health.size(); i > 0; --i) {
    const auto& [said, health] = sights.health[i - 1];
    if (said <= log_time) {
      const bool holds = said >= began && log_time - said <= kHealthHoldsNs;
      return holds ? std::optional(health) : std::nullopt;
    }
  }
  return std::nullopt;
}

namespace {

std::uint32_t named_by(const RecordedFrame& frame) {
  return frame.info ? frame.info->calibration_fingerprint : 0;
}

}  // namespace

std::optional<RecordedFrame> FrameAssembler::take(Topic topic, const mcap::Message& message) {
  switch (topic) {
    case Topic::kFrameInfo:
    case Topic::kCalibration:
    case Topic::kHealth:
    case Topic::kEvent: {
      const std::optional<Packet> packet = decode_packet(message.data);
      std::optional<RecordedFrame> ended;
      if (!packet) {
        ++damaged_;
      } else if (topic == Topic::kFrameInfo) {
        ended = std::exchange(frame_, RecordedFrame{});
      }
      if (packet) {
        take_packet(topic, message, *packet);
      }
      return ended;
    }
    case Topic::kDepth:
    case Topic::kWidth:
    case Topic::kSource:
    case Topic::kReceived:
    case Topic::kLeft:
    case Topic::kRight:
    case Topic::kDisparity:
    case Topic::kPmdRaw:
      if (const std::optional<Image> image = decode_image(message.data)) {
        if (frame_ && frame_->stamp.number == message.sequence) {
          take_image(topic, *image);
        }
      } else {
        ++damaged_;
      }
      return std::nullopt;
    default:
      return std::nullopt;  // says again what another topic says, or is not needed here
  }
}

void FrameAssembler::take_packet(Topic topic, const mcap::Message& message, const Packet& packet) {
  if (!origin_ || origin_->session_id != packet.origin.session_id ||
      origin_->device_id != packet.origin.device_id) {
    sights_.starts.push_back(message.log_time);
  }
  origin_ = packet.origin;
  if (topic == Topic::kCalibration) {
    if (const auto calibration = wire::read_calibration_packet(packet.payload)) {
      calibration_ = *calibration;
      lenses_.take(*calibration);
    }
  } else if (topic == Topic::kHealth) {
    if (const auto health = wire::decode_health_report(packet.payload)) {
      sights_.health.emplace_back(message.log_time, *health);
      sights_.health_sessions.push_back(packet.origin.session_id);
    }
  } else if (topic == Topic::kEvent) {
    if (const auto event = wire::decode_event_report(packet.payload)) {
      sights_.events.emplace_back(message.log_time, *event);
      sights_.event_sessions.push_back(packet.origin.session_id);
    }
  } else {
    frame_->log_time = message.log_time;
    frame_->origin = packet.origin;
    frame_->stamp = packet.stamp;
    frame_->packets = packet.packets;
    frame_->missing_packets = packet.missing_packets;
    if (const auto info = wire::read_frame_info(packet.payload)) {
      frame_->info = *info;
    }
    if (calibration_ && of_fingerprint(*calibration_, named_by(*frame_))) {
      frame_->calibration = calibration_;
    }
  }
}

// Of the cameras: of other sizes than depth.
void FrameAssembler::take_picture(Topic topic, const Image& image) {
  RecordedFrame& frame = *frame_;
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if ((topic == Topic::kPmdRaw) != (image.encoding == "16UC1")) {
    ++damaged_;
    return;
  }
  if (topic == Topic::kPmdRaw) {
    const std::size_t samples = frame.pmd.size();
    if (image.height % samples != 0) {
      ++damaged_;
      return;
    }
    frame.pmd_width = static_cast<int>(image.width);
    frame.pmd_height = static_cast<int>(image.height / samples);
    const std::size_t bytes = image.data.size() / samples;
    for (std::size_t k = 0; k < samples; ++k) {
      frame.pmd[k].resize(pixels / samples);
      wire::get_pixels(image.data.subspan(k * bytes, bytes), std::span(frame.pmd[k]));
    }
    return;
  }
  const bool other = !(topic == Topic::kLeft ? frame.right : frame.left).empty();
  const int width = static_cast<int>(image.width);
  const int height = static_cast<int>(image.height);
  if (other && (frame.left_width != width || frame.left_height != height)) {
    ++damaged_;
    return;
  }
  frame.left_width = width;
  frame.left_height = height;
  std::vector<std::uint8_t>& eye = topic == Topic::kLeft ? frame.left : frame.right;
  eye.resize(pixels);
  wire::get_pixels(image.data, std::span(eye));
}

void FrameAssembler::take_image(Topic topic, const Image& image) {
  RecordedFrame& frame = *frame_;
  const std::size_t pixels = std::size_t{image.width} * image.height;
  if (topic == Topic::kLeft || topic == Topic::kRight || topic == Topic::kPmdRaw) {
    take_picture(topic, image);
    return;
  }
  const bool first = frame.width == 0;
  if (!first && (frame.width != static_cast<int>(image.width) ||
                 frame.height != static_cast<int>(image.height))) {
    ++damaged_;  // planes of one frame have one size
    return;
  }
  const bool wide = topic == Topic::kDepth || topic == Topic::kWidth || topic == Topic::kDisparity;
  if (wide != (image.encoding == "16UC1")) {
    ++damaged_;
    return;
  }
  frame.width = static_cast<int>(image.width);
  frame.height = static_cast<int>(image.height);
  if (topic == Topic::kReceived) {
    frame.received.resize(pixels);
    wire::get_pixels(image.data, std::span(frame.received));
    return;
  }
  if (topic == Topic::kDisparity) {
    std::vector<std::uint16_t> values(pixels);
    wire::get_pixels(image.data, std::span(values));
    frame.disparity.resize(pixels);
    std::ranges::transform(values, frame.disparity.begin(), [](std::uint16_t value) {
      return dsp::Disparity::from_raw(static_cast<std::int16_t>(value - 32768));
    });
    return;
  }
  const auto arrived = [&](std::uint8_t bit) {
    frame.received.resize(pixels);
    for (std::uint8_t& mark : frame.received) {
      mark |= bit;
    }
  };
  if (topic == Topic::kSource) {
    frame.source.resize(pixels);
    frame.cause.resize(pixels);
    for (std::size_t k = 0; k < pixels; ++k) {
      const auto value = std::to_integer<unsigned>(image.data[k]);
      frame.source[k] = static_cast<dsp::Source>(value & 0x0FU);
      frame.cause[k] = static_cast<dsp::Cause>(value >> 4U);
    }
    arrived(client::kHasSource);
    return;
  }
  std::vector<dsp::QuarterMm>& plane = topic == Topic::kDepth ? frame.depth : frame.interval_width;
  plane.resize(pixels);
  wire::get_pixels(image.data, std::span(plane));
  arrived(topic == Topic::kDepth ? client::kHasDepth : client::kHasWidth);
}

}  // namespace stof::recording
