#include "firmware/update/boot_sector.h"

namespace stof::update {

std::optional<BootSector> BootSector::find(hal::Slots& slots) {
  std::array<std::byte, kSectorBytes> sector{};
  for (std::size_t at = 0; at + kSectorBytes <= slots.bytes(hal::DiskPart::kBoot);
       at += kSectorBytes) {
    if (slots.read(hal::DiskPart::kBoot, at, sector) != Status::kOk) {
      return std::nullopt;
    }
    if (const std::optional<BootChoice> choice = read_choice(sector)) {
      return BootSector(slots, at, *choice);
    }
  }
  return std::nullopt;
}

Status BootSector::set(const BootChoice& choice) noexcept {
  if (!under_way_ && choice == choice_) {
    return Status::kOk;
  }
  if (!under_way_) {
    write_choice(choice, sector_);
    slots_->write(hal::DiskPart::kBoot, offset_, sector_);
    under_way_ = true;
  }
  const Status status = slots_->progress();
  if (status == Status::kTimeout) {
    return status;
  }
  under_way_ = false;
  if (status == Status::kOk) {
    choice_ = choice;
  }
  return status;
}

}  // namespace stof::update
