#include "host/cli/view/raw_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <system_error>

#include "dataset/files/pgm.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"

namespace stof::host {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// Seconds, all digits: a stamp is to be found again.
std::string seconds_text(std::int64_t ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  std::array<char, 40> text{};  // 20 digits at most
  std::snprintf(text.data(), text.size(), "%lld.%09lld s", static_cast<long long>(ns / kSecond),
                static_cast<long long>(ns % kSecond));
  return text.data();
}

// What became of a picture; nothing of one that was not sent.
std::string part_text(const client::RawExposure& exposure, std::uint8_t bit, const char* name,
                      const std::string& size) {
  if ((exposure.info.pictures & bit) == 0) {
    return "";
  }
  return std::string(", ") + name + " " + ((exposure.missing & bit) != 0 ? "missing" : size);
}

}  // namespace

dataset::Image<std::uint16_t> below_each_other(const client::RawExposure& exposure) {
  const int height = exposure.pmd.front().height();
  dataset::Image<std::uint16_t> image(exposure.pmd.front().width(),
                                      height * static_cast<int>(exposure.pmd.size()));
  int at = 0;
  for (const auto& sample : exposure.pmd) {
    for (int y = 0; y < height; ++y) {
      std::ranges::copy(sample.row(y), image.view().row(at++).begin());
    }
  }
  return image;
}

void write_raw(const client::RawExposure& exposure, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw Failure(Exit::kBadInput, folder.string() + ": cannot be made: " + error.message());
  }
  std::array<char, 16> name{};  // 10 digits at most
  std::snprintf(name.data(), name.size(), "raw_%010u", exposure.stamp.freshness);
  const auto file = [&](const char* end) { return folder / (std::string(name.data()) + end); };
  if (!exposure.left.empty()) {
    value_or_end(dataset::write_pgm8(file("_left.pgm"), copy_of(exposure.left)));
  }
  if (!exposure.right.empty()) {
    value_or_end(dataset::write_pgm8(file("_right.pgm"), copy_of(exposure.right)));
  }
  if (!exposure.pmd.front().empty()) {
    value_or_end(dataset::write_pgm16(file("_pmd.pgm"), below_each_other(exposure)));
  }
}

std::string raw_exposure_line(const client::RawExposure& exposure) {
  const wire::RawInfo& info = exposure.info;
  const std::string eye = size_text(info.width, info.height);
  const std::string parts = part_text(exposure, wire::kRawLeft, "left", eye) +
                            part_text(exposure, wire::kRawRight, "right", eye) +
                            part_text(exposure, wire::kRawPmd, "pmd",
                                      size_text(info.pmd_width, info.pmd_height) + " x 4");
  return "raw exposure " + std::to_string(exposure.stamp.freshness) + " of frame " +
         std::to_string(exposure.stamp.number) + ": " +
         (parts.empty() ? "nothing" : parts.substr(2)) + "; edge " + seconds_text(info.edge_ns) +
         ", sequences " + std::to_string(info.sequences[0]) + " " +
         std::to_string(info.sequences[1]) + " " + std::to_string(info.sequences[2]);
}

std::string raw_line(const client::RawStatistics& statistics) {
  return "raw exposures: " + std::to_string(statistics.complete) + " whole, " +
         std::to_string(statistics.incomplete) + " with a picture missing, " +
         std::to_string(statistics.lost) + " lost, " + std::to_string(statistics.untaken) +
         " not taken; " + std::to_string(statistics.dropped) + " dropped by the sensor";
}

std::string raw_absence(wire::SubscribeResult refusal, const std::string& to_do) {
  switch (refusal) {
    case wire::SubscribeResult::kRawDenied:
      return ": the sensor gives them to --signed alone, or, where limits.streams is fixed, to an "
             "admin's key";
    case wire::SubscribeResult::kRawTaken:
      return ": another subscriber has them: end that one";
    default:
      return ": the link is too slow" + (to_do.empty() ? "" : " (" + to_do + ")") +
             ", a camera is missing, or the sensor is older than raw pictures";
  }
}

}  // namespace stof::host
