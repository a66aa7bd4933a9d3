#include "host/recording/raw_reader.h"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <utility>

#include "firmware/wire/bytes.h"
#include "firmware/wire/calibration/calibration_packet.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/frame/raw_packets.h"

namespace stof::recording {
namespace {

bool same_session(const wire::Origin& a, const wire::Origin& b) {
  return a.device_id == b.device_id && a.session_id == b.session_id;
}

// Times that can be told apart and subtracted: a file may hold any.
bool sane(const wire::RawInfo& info) {
  constexpr std::int64_t kMost = std::int64_t{1} << 61;  // 73 years
  const auto good = [](const wire::Window& window) {
    return window.begin_ns >= 0 && window.begin_ns <= window.end_ns && window.end_ns < kMost;
  };
  return info.edge_ns >= 0 && info.edge_ns < kMost &&
         std::ranges::all_of(info.pair_exposures, good) &&
         std::ranges::all_of(info.pmd_exposures, good);
}

std::optional<wire::RawInfo> raw_info_of(const Packet& packet) {
  if (packet.type != wire::PacketType::kRawInfo) {
    return std::nullopt;
  }
  const Result<wire::RawInfo> info = wire::decode_raw_info(packet.payload);
  return info && sane(*info) ? std::optional(*info) : std::nullopt;
}

void note_timing(const wire::RawInfo& info, RawSummary& summary) {
  const auto note = [&](const wire::Window& window) {
    summary.from_edge_ns =
        std::max<std::int64_t>(summary.from_edge_ns, std::llabs(window.begin_ns - info.edge_ns));
  };
  if ((info.pictures & (wire::kRawLeft | wire::kRawRight)) != 0) {
    for (const wire::Window& window : info.pair_exposures) {
      note(window);
      summary.pair_exposure_ns =
          std::max<std::int64_t>(summary.pair_exposure_ns, window.end_ns - window.begin_ns);
    }
  }
  if ((info.pictures & wire::kRawPmd) != 0) {
    const std::int64_t begin = info.pmd_exposures.front().begin_ns;
    summary.pmd_exposure_ns =
        std::max<std::int64_t>(summary.pmd_exposure_ns, info.pmd_exposures.back().end_ns - begin);
    if (info.pmd_every == 1) {  // else they may be of an edge before
      note(info.pmd_exposures.front());
    }
  }
}

void note_edge(const Packet& packet, RawSummary& summary) {
  const std::optional<wire::RawInfo> info = raw_info_of(packet);
  if (!info) {
    return;
  }
  if (summary.exposures == 0) {
    summary.origin = packet.origin;
    summary.first = *info;
  }
  if (!same_session(packet.origin, summary.origin)) {
    ++summary.other_sessions;
    return;
  }
  ++summary.exposures;
  note_timing(*info, summary);
}

void note_message(Topic topic, const mcap::Message& message, RawSummary& summary) {
  if (topic == Topic::kSettings) {
    if (std::optional<std::string> document = decode_string(message.data)) {
      if (summary.first_settings.empty()) {
        summary.first_settings = *document;
      }
      const std::uint32_t fingerprint = wire::crc32c(std::as_bytes(std::span(*document)));
      summary.settings.emplace(fingerprint, std::move(*document));
    }
    return;
  }
  if (topic != Topic::kRawEdge && topic != Topic::kCalibration) {
    return;
  }
  const std::optional<Packet> packet = decode_packet(message.data);
  if (!packet) {
    return;
  }
  if (topic == Topic::kRawEdge) {
    note_edge(*packet, summary);
  } else if (const auto calibration = wire::read_calibration_packet(packet->payload);
             calibration && !summary.packet) {
    summary.packet = *calibration;
  }
}

RawSummary summarise_raw(mcap::StreamReader& reader) {
  RawSummary summary;
  for (auto item = reader.next(); !item || *item; item = reader.next()) {
    if (!item) {
      continue;  // said when it is read
    }
    if (const auto* const message = std::get_if<mcap::Message>(&**item)) {
      if (const auto topic = topic_of(reader.index(), message->channel_id)) {
        note_message(*topic, *message, summary);
      }
    } else if (const auto* const attachment = std::get_if<mcap::Attachment>(&**item)) {
      if (attachment->name == kCalibrationAttachment && summary.calibration.empty()) {
        summary.calibration.assign(reinterpret_cast<const char*>(attachment->data.data()),
                                   attachment->data.size());
      }
    }
  }
  return summary;
}

std::unexpected<Problem> problem_of(const std::filesystem::path& file, const std::string& line) {
  return std::unexpected(Problem{file.string() + ": " + line});
}

// Of the size that the edge told; else it is missing.
std::vector<std::uint8_t> eye_of(const Image& image, const wire::RawInfo& info) {
  std::vector<std::uint8_t> pixels;
  if (image.encoding == "mono8" && image.width == info.width && image.height == info.height) {
    pixels.resize(image.data.size());
    wire::get_pixels(image.data, std::span(pixels));
  }
  return pixels;
}

void take_samples(const Image& image, RawInput& input) {
  const wire::RawInfo& info = input.info;
  const std::size_t pixels = std::size_t{info.pmd_width} * info.pmd_height;
  if (image.encoding != "16UC1" || image.width != info.pmd_width ||
      image.height != wire::kRawSamples * info.pmd_height || pixels == 0) {
    return;
  }
  for (std::size_t k = 0; k < input.pmd.size(); ++k) {
    input.pmd[k].resize(pixels);
    wire::get_pixels(image.data.subspan(2 * pixels * k, 2 * pixels), std::span(input.pmd[k]));
  }
}

void note_missing(RawInput& input) {
  const auto note = [&](std::uint8_t bit, bool empty) {
    input.missing |= static_cast<std::uint8_t>(empty ? input.info.pictures & bit : 0);
  };
  note(wire::kRawLeft, input.left.empty());
  note(wire::kRawRight, input.right.empty());
  note(wire::kRawPmd, input.pmd.front().empty());
}

}  // namespace

std::expected<RawReader, Problem> RawReader::open(const std::filesystem::path& file) {
  auto source = mcap::FileSource::open(file);
  if (!source) {
    return std::unexpected(source.error());
  }
  auto kept = std::make_unique<mcap::FileSource>(std::move(*source));
  auto first = mcap::StreamReader::open(*kept);
  if (!first) {
    return problem_of(file, first.error().message);
  }
  RawSummary summary = summarise_raw(*first);
  if (summary.exposures == 0) {
    return problem_of(file, "holds no raw pictures: record them with stof record --raw");
  }
  if (summary.calibration.empty() || summary.first_settings.empty()) {
    return problem_of(file, std::string("lacks the sensor's ") +
                                (summary.calibration.empty() ? "calibration file" : "settings") +
                                ", which it did not give: record anew");
  }
  auto reader = mcap::StreamReader::open(*kept);
  auto frames = FrameReader::open(file);
  if (!reader || !frames) {
    return problem_of(file, (reader ? frames.error() : reader.error()).message);
  }
  return RawReader(std::move(summary), std::move(kept), std::move(*reader), std::move(*frames));
}

std::unique_ptr<RawInput> RawReader::next() {
  while (!whole_) {
    const auto item = reader_.next();
    if (!item) {
      ++damaged_;
      continue;
    }
    if (!*item) {
      whole_ = std::exchange(input_, nullptr);
      if (!whole_) {
        return nullptr;
      }
      break;
    }
    const auto* const message = std::get_if<mcap::Message>(&**item);
    const std::optional<Topic> topic =
        message != nullptr ? topic_of(reader_.index(), message->channel_id) : std::nullopt;
    if (topic) {
      take(*topic, *message);
    }
  }
  note_missing(*whole_);
  find_frame(*whole_);
  return std::exchange(whole_, nullptr);
}

void RawReader::take(Topic topic, const mcap::Message& message) {
  if (topic == Topic::kRawEdge) {
    const std::optional<Packet> packet = decode_packet(message.data);
    const std::optional<wire::RawInfo> info = packet ? raw_info_of(*packet) : std::nullopt;
    if (!info) {
      ++damaged_;
    } else if (same_session(packet->origin, summary_.origin)) {
      whole_ = std::exchange(input_, std::make_unique<RawInput>());
      input_->stamp = packet->stamp;
      input_->info = *info;
    }
    return;
  }
  const bool picture =
      topic == Topic::kRawLeft || topic == Topic::kRawRight || topic == Topic::kRawPmd;
  if (!picture || !input_ || message.sequence != input_->stamp.number) {
    return;
  }
  const std::optional<Image> image = decode_image(message.data);
  if (!image) {
    ++damaged_;
  } else if (topic == Topic::kRawLeft) {
    input_->left = eye_of(*image, input_->info);
  } else if (topic == Topic::kRawRight) {
    input_->right = eye_of(*image, input_->info);
  } else {
    take_samples(*image, *input_);
  }
}

// Frames lie in the order of their exposures, as these do.
void RawReader::find_frame(RawInput& input) {
  while (!frame_ || !same_session(frame_->origin, summary_.origin) ||
         frame_->stamp.freshness < input.stamp.freshness) {
    frame_ = frames_.next();
    if (!frame_) {
      return;
    }
  }
  if (frame_->stamp.freshness == input.stamp.freshness) {
    input.frame = std::exchange(frame_, std::nullopt);
  }
}

}  // namespace stof::recording
