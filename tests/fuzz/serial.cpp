#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "firmware/serial/line/serial_request_handler.h"
#include "firmware/wire/messages/announce.h"
#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/messages/sectors.h"
#include "firmware/wire/messages/settings_answer.h"
#include "firmware/wire/messages/settings_request.h"
#include "hal/framing/cobs.h"
#include "tests/fuzz/fuzz_input.h"

// Bytes of a serial line. First byte even: what follows is the line. Odd: what follows is a frame,
// which must come back from the line.
namespace stof {
namespace {

using Frame = std::span<const std::byte>;

// What decodes, encodes and decodes to the same bytes.
template <typename T, std::size_t kBytes>
void decode(Frame payload, Result<T> (*read)(Frame) noexcept,
            void (*write)(const T&, std::span<std::byte, kBytes>) noexcept) {
  const Result<T> value = read(payload);
  fuzz::require(value.has_value() == (payload.size() >= kBytes));
  if (value) {
    std::array<std::byte, kBytes> once{};
    std::array<std::byte, kBytes> twice{};
    write(*value, once);
    const Result<T> again = read(once);
    fuzz::require(again.has_value());
    write(*again, twice);
    fuzz::require(once == twice);
  }
}

// Whatever it is, the answer to it is a packet.
void ask(Frame frame) {
  firmware::SerialRequestHandler requests({.device_id = 0x0A0B0C0D, .session_id = 1}, nullptr);
  const Frame answer = requests.take(frame, hal::Time{});
  fuzz::require(answer.empty() || wire::parse_packet(answer).has_value());
  fuzz::require(requests.counters().answered + requests.counters().refused == 1);
}

void judge(Frame frame) {
  ask(frame);
  const auto packet = wire::parse_packet(frame);
  if (!packet) {
    fuzz::touch(frame);
    return;
  }
  fuzz::touch(packet->payload);
  static_cast<void>(wire::consistent_tile(*packet));
  decode(packet->payload, wire::decode_announce, wire::encode_announce);
  decode(packet->payload, wire::decode_calibration_packet, wire::encode_calibration_packet);
  decode(packet->payload, wire::decode_event_report, wire::encode_event_report);
  decode(packet->payload, wire::decode_frame_info, wire::encode_frame_info);
  decode(packet->payload, wire::decode_health_report, wire::encode_health_report);
  decode(packet->payload, wire::decode_sector_report, wire::encode_sector_report);
  decode(packet->payload, wire::decode_settings_answer, wire::encode_settings_answer);
  decode(packet->payload, wire::decode_settings_request, wire::encode_settings_request);
}

void read_line(Frame line) {
  hal::CobsReader reader;
  std::size_t piece = 1;
  while (!line.empty()) {
    // Pieces of 1, 2, 4, ... bytes: frames begin and end anywhere in them.
    Frame now = line.first(std::min(piece, line.size()));
    line = line.subspan(now.size());
    piece = piece % 64 * 2 + 1;
    while (const std::optional<Frame> frame = reader.take(now)) {
      fuzz::require(frame->size() <= hal::CobsReader::kMaxFrame);
      judge(*frame);
    }
    fuzz::require(now.empty());
  }
}

void go_round(Frame frame) {
  const Frame sent = frame.first(std::min(frame.size(), hal::CobsReader::kMaxFrame));
  std::vector<std::byte> line(hal::cobs_bound(sent.size()) + 1);
  const std::size_t bytes = hal::cobs_encode(sent, line);
  fuzz::require(bytes < line.size() &&
                std::ranges::find(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(bytes),
                                  std::byte{0}) ==
                    line.begin() + static_cast<std::ptrdiff_t>(bytes));
  line[bytes] = std::byte{0};
  line.resize(bytes + 1);
  hal::CobsReader reader;
  Frame rest(line);
  const std::optional<Frame> came = reader.take(rest);
  fuzz::require(came && std::ranges::equal(*came, sent));

  wire::DatagramBuffer space{};
  judge(fuzz::sealed(sent, space));
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (!input.empty()) {
    const Frame rest = input.subspan(1);
    const bool line = wire::get_u8(input.first<1>()) % 2 == 0;
    line ? read_line(rest) : go_round(rest);
  }
}
