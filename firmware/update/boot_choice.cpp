#include "firmware/update/boot_choice.h"

#include <algorithm>
#include <string_view>

namespace stof::update {
namespace {

// '#' is the number of a partition: slot A is the second one, slot B the third. scripts/image
// writes the same.
constexpr std::string_view kText =
    "[all]\ntryboot_a_b=1\nboot_partition=#\n[tryboot]\nboot_partition=#\n";
constexpr char kPlace = '#';
constexpr std::size_t kUsualAt = kText.find(kPlace);
constexpr std::size_t kTrialAt = kText.rfind(kPlace);
static_assert(kUsualAt < kTrialAt && kText.size() < kSectorBytes);

constexpr std::byte number_of(Slot slot) noexcept {
  return std::byte{static_cast<unsigned char>(slot == Slot::kA ? '2' : '3')};
}

std::optional<Slot> slot_of(std::byte number) noexcept {
  if (number == number_of(Slot::kA)) {
    return Slot::kA;
  }
  return number == number_of(Slot::kB) ? std::optional(Slot::kB) : std::nullopt;
}

}  // namespace

std::optional<BootChoice> read_choice(ConstSector sector) noexcept {
  for (std::size_t i = 0; i < sector.size(); ++i) {
    const char wanted = i < kText.size() ? kText[i] : '\0';
    if (wanted != kPlace && std::to_integer<char>(sector[i]) != wanted) {
      return std::nullopt;
    }
  }
  const std::optional<Slot> usual = slot_of(sector[kUsualAt]);
  const std::optional<Slot> trial = slot_of(sector[kTrialAt]);
  return usual && trial ? std::optional(BootChoice{.usual = *usual, .trial = *trial})
                        : std::nullopt;
}

void write_choice(const BootChoice& choice, Sector sector) noexcept {
  std::ranges::fill(sector, std::byte{0});
  std::ranges::transform(kText, sector.begin(),
                         [](char c) { return std::byte{static_cast<unsigned char>(c)}; });
  sector[kUsualAt] = number_of(choice.usual);
  sector[kTrialAt] = number_of(choice.trial);
}

}  // namespace stof::update
