#include "host/cli/view/raw_flags.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "firmware/wire/frame/raw_packets.h"
#include "host/cli/failure.h"

namespace stof::host {
namespace {

const std::vector<std::pair<std::string, std::uint8_t>> kPictures{
    {"left", wire::kRawLeft}, {"right", wire::kRawRight}, {"pmd", wire::kRawPmd}};

// X,Y,WIDTH,HEIGHT.
void take_part(const std::vector<std::uint16_t>& part, wire::RawRequest& raw) {
  raw.column = part[0];
  raw.row = part[1];
  raw.width = part[2];
  raw.height = part[3];
}

}  // namespace

void add_raw_flags(CLI::App& command, ViewOptions& options) {
  wire::RawRequest& raw = options.raw;
  const auto take_pictures = [&raw](const std::vector<std::string>& names) {
    raw.pictures = wire::kRawWhole;
    for (const std::string& name : names) {
      for (const auto& [known, bit] : kPictures) {
        raw.pictures = static_cast<std::uint8_t>(raw.pictures | (name == known ? bit : 0));
      }
    }
  };
  CLI::Option* const pictures =
      command
          .add_option_function<std::vector<std::string>>(
              "--raw", take_pictures,
              "What the cameras gave, bit for bit, of exposures that have all of these: left, "
              "right, "
              "pmd, with commas between; --out gets a PGM of each. A paired sensor gives them to "
              "--signed alone")
          ->delimiter(',')
          ->check(CLI::IsMember({"left", "right", "pmd"}));
  command.add_option("--raw-every", raw.every, "Of --raw: one exposure of so many frames")
      ->needs(pictures)
      ->check(CLI::Range(1, 65535));
  command.add_option("--raw-step", raw.step, "Of --raw: one column and row of the pair of so many")
      ->needs(pictures)
      ->check(CLI::Range(1, 255));
  command
      .add_option_function<std::vector<std::uint16_t>>(
          "--raw-part", [&raw](const std::vector<std::uint16_t>& part) { take_part(part, raw); },
          "X,Y,WIDTH,HEIGHT of the pair's pictures, of --raw; WIDTH or HEIGHT 0: all that follows")
      ->needs(pictures)
      ->delimiter(',')
      ->expected(4);
  command
      .add_option("--raw-count", options.raw_count,
                  "Of --raw: end after so many exposures that came whole; 0: as --frames says")
      ->needs(pictures)
      ->capture_default_str();
}

void check_raw_flags(const ViewOptions& options) {
  if (options.raw.pictures != 0 && options.sensor.empty()) {
    throw Failure(Exit::kBadInput, "--raw: takes a SENSOR to subscribe at");
  }
}

}  // namespace stof::host
