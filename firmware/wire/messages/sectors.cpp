// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/sectors.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_sector_report(const SectorReport& value,
                          std::span<std::byte, kSectorReportBytes> out) noexcept {
  put_i32(out.subspan<0, 4>(), value.first_udeg);
  put_u32(out.subspan<4, 4>(), value.step_udeg);
  put_u16(out.subspan<8, 2>(), value.least_cm);
  put_u16(out.subspan<10, 2>(), value.most_cm);
  for (std::size_t i = 0; i < 72; ++i) {
    put_u16(out.subspan(12 + 2 * i).first<2>(), value.distances_cm[i]);
  }
}

Result<SectorReport> decode_sector_report(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kSectorReportBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kSectorReportBytes> in = payload.first<kSectorReportBytes>();
  SectorReport value;
  value.first_udeg = get_i32(in.subspan<0, 4>());
  value.step_udeg = get_u32(in.subspan<4, 4>());
  value.least_cm = get_u16(in.subspan<8, 2>());
  value.most_cm = get_u16(in.subspan<10, 2>());
  for (std::size_t i = 0; i < 72; ++i) {
    value.distances_cm[i] = get_u16(in.subspan(12 + 2 * i).first<2>());
  }
  return value;
}

}  // namespace stof::wire
