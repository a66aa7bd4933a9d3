#include "firmware/settings/saved_settings.h"

#include <array>
#include <cstddef>
#include <span>

#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"

namespace stof::settings {
namespace {

// Room for a file that somebody wrote by hand.
constexpr std::size_t kMostFile = 4 * kMostDocumentBytes;

bool understand(std::span<const std::byte> bytes, Limits* limits, Settings& settings,
                PagedWriter& why) noexcept {
  // Bytes may be looked at as char.
  const auto* const text = reinterpret_cast<const char*>(bytes.data());
  if (!parse({text, bytes.size()}, settings, why)) {
    return false;
  }
  fit_blocks(settings, why);
  return usable(settings, limits, why);
}

}  // namespace

Settings load_settings(hal::Store& store, std::string_view place, Limits* limits, PagedWriter& line,
                       bool* fell_back) noexcept {
  std::array<std::byte, kMostFile> bytes;
  const Result<std::size_t> loaded = store.load(bytes);
  if (loaded && *loaded == 0) {
    return {};
  }
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  if (!loaded && loaded.error() == Status::kTooLarge) {
    why << "longer than " << kMostFile << " bytes";
  } else if (!loaded) {
    why << "cannot be read";
  } else {
    Settings settings;
    if (understand(std::span(bytes).first(*loaded), limits, settings, why)) {
      if (!why.text().empty()) {
        line << place << ": " << why.text();
      }
      if (fell_back != nullptr) {
        *fell_back = !why.text().empty();
      }
      return settings;
    }
  }
  const bool aside = store.set_aside() == Status::kOk;
  line << place << ": " << why.text() << ": the defaults hold"
       << (aside ? ", the file is kept as .bad" : "");
  return {};
}

}  // namespace stof::settings
