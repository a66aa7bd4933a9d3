#include "host/viewer/page_message.h"

#include <string_view>
#include <variant>

#include "tests/fuzz/fuzz_input.h"

// What a page says to `stof view`: whatever it is, what is understood of it names no path, no
// second setting and no second order.
namespace stof {
namespace {

using namespace viewer;

bool has_only(std::string_view text, std::string_view alphabet) {
  return text.find_first_not_of(alphabet) == std::string_view::npos;
}

constexpr std::string_view kNames = "abcdefghijklmnopqrstuvwxyz0123456789_";

void judge(const ChangeSettings& change) {
  fuzz::require(!change.assignments.empty());
  for (const std::string_view one : change.assignments) {
    const std::size_t at = one.find('=');
    fuzz::require(at != std::string_view::npos && at > 0 && at + 1 < one.size());
    fuzz::require(has_only(one.substr(0, at), std::string(kNames) + ".-"));
    fuzz::require(one.find_first_of(std::string_view("\n\r\0", 3)) == std::string_view::npos);
  }
}

void judge(const GiveFault& fault) {
  fuzz::require(!fault.order.empty() && has_only(fault.order, std::string(kNames) + ":"));
}

void judge(const BeginPairing& pairing) {
  fuzz::require(pairing.role == "view" || pairing.role == "tune" || pairing.role == "admin");
  fuzz::require(has_only(pairing.code, "0123456789abcdefABCDEF- "));
}

void judge(const GiveDigits& given) { fuzz::require(has_only(given.digits, "0123456789 ")); }

void judge(const PutRelease& release) {
  fuzz::require(!release.file.empty() && release.file.front() != '.');
  fuzz::require(release.file.find('/') == std::string::npos);
}

template <typename Other>
void judge(const Other& /*wish*/) {}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  const auto message = viewer::parse_page_message(text);
  if (!message) {
    return;
  }
  if (const auto* const look = std::get_if<viewer::Look>(&*message)) {
    require(look->frames >= 0 && look->frames <= viewer::Look::kMostFrames);
    require((look->planes & ~viewer::kAllPlanes) == 0);
    return;
  }
  std::visit([](const auto& wish) { judge(wish); }, std::get<viewer::Request>(*message).wish);
}
