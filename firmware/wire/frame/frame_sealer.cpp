#include "firmware/wire/frame/frame_sealer.h"

#include "dsp/base/check.h"

namespace stof::wire {

Header FrameSealer::header_of(std::size_t index) const noexcept {
  const Part& part = store_.part(index);
  return {.type = part.type,
          .flags = part.flags,
          .origin = origin_,
          .frame = stamp_,
          .stream = part.stream,
          .codec = part.codec,
          .index = static_cast<std::uint16_t>(index),
          .count = parts_,
          .image_width = part.image_width,
          .image_height = part.image_height,
          .first_row = part.first_row,
          .first_column = part.first_column,
          .pixel_count = part.pixel_count};
}

std::span<const std::byte> FrameSealer::sealed(std::size_t index) noexcept {
  return seal_packet(header_of(index), store_.part(index).payload_bytes, store_.buffer(index));
}

void FrameSealer::gather(ParityGroup& group, std::size_t index) noexcept {
  const std::size_t bytes = store_.part(index).payload_bytes;
  // A part of this coder is never longer than a group takes.
  STOF_CHECK(group.add(header_of(index), store_.payload(index).first(bytes)) == Status::kOk);
}

std::span<const std::byte> FrameSealer::sealed(ParityGroup& group, std::size_t index,
                                               DatagramBuffer& buffer) noexcept {
  const std::size_t bytes = group.write(parts_, payload_space(buffer));
  return seal_packet({.type = PacketType::kParity,
                      .origin = origin_,
                      .frame = stamp_,
                      .index = static_cast<std::uint16_t>(index),
                      .count = parity_groups(parts_),
                      .image_width = store_.part(0).image_width,
                      .image_height = store_.part(0).image_height},
                     bytes, buffer);
}

Datagrams FrameSealer::seal_all() noexcept {
  for (std::size_t i = 0; i < parts_; ++i) {
    memory_.datagrams[i] = sealed(i);
  }
  ParityGroup& sum = memory_.groups.front();
  for (std::size_t group = 0; group < groups_; ++group) {
    sum.clear();
    for (std::size_t i = group; i < parts_; i += groups_) {
      gather(sum, i);
    }
    const std::size_t at = parts_ + group;
    memory_.datagrams[at] = sealed(sum, group, store_.buffer(at));
  }
  return memory_.datagrams.first(all());
}

void FrameSealer::begin_parity() const noexcept {
  for (ParityGroup& group : memory_.groups.first(groups_)) {
    group.clear();
  }
}

Datagrams FrameSealer::seal_parts(std::size_t begin, std::size_t end) noexcept {
  for (std::size_t i = begin; i < end; ++i) {
    memory_.datagrams[i - begin] = sealed(i);
    if (groups_ > 0) {
      gather(memory_.groups[i % groups_], i);
    }
  }
  return memory_.datagrams.first(end - begin);
}

Datagrams FrameSealer::seal_parity(std::size_t begin, std::size_t end) noexcept {
  for (std::size_t i = begin; i < end; ++i) {
    memory_.datagrams[i - begin] = sealed(memory_.groups[i], i, store_.buffer(i));
  }
  return memory_.datagrams.first(end - begin);
}

}  // namespace stof::wire
