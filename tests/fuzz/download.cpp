#include "host/client/control/download.h"

#include <algorithm>
#include <memory>

#include "firmware/wire/calibration/calibration_file.h"
#include "tests/fuzz/control_answers.h"

// What a sensor answers to who downloads its calibration file: a file whose CRC and fingerprint are
// right, or one line.
void stof::fuzz::run(std::span<const std::byte> input) {
  client::ControlClient client(std::make_unique<Answers>(input));
  const auto file = client::download_calibration(client);
  if (!file) {
    require(!file.error().message.empty());
    require(file.error().message.find('\n') == std::string::npos);
    return;
  }
  const auto bytes = std::as_bytes(std::span(*file));
  require(bytes.size() > sizeof(std::uint32_t) && bytes.size() <= input.size());
  require(wire::calibration_fingerprint(bytes) ==
          wire::crc32c(bytes.first(bytes.size() - sizeof(std::uint32_t))));
}
