#include "host/cli/recording/reading_progress.h"

#include "host/client/printable.h"
#include "host/text/printed.h"

namespace stof::host {
ReadingProgress::ReadingProgress(const std::string& file, bool json)
    : file_(client::printable(file)), line_(json, kLongWork) {}

void ReadingProgress::show(std::uint64_t bytes, std::uint64_t total) {
  constexpr std::uint64_t kWhole = 100;
  if (line_.due()) {
    line_.show(
        printed("reading %s: %llu %%", file_.c_str(),
                static_cast<unsigned long long>(total == 0 ? kWhole : bytes * kWhole / total)));
  }
}

mcap::Progress ReadingProgress::callback() {
  return [this](std::uint64_t bytes, std::uint64_t total) { show(bytes, total); };
}

}  // namespace stof::host
