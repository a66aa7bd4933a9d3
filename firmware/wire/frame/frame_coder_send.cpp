#include <algorithm>

#include "dsp/base/check.h"
#include "firmware/wire/frame/frame_coder.h"

// The way out: headers, checks, parity.
namespace stof::wire {

Header FrameCoder::header_of(std::size_t index, std::uint16_t count,
                             const FrameStamp& stamp) noexcept {
  const Part& part = store_.part(index);
  return {.type = part.type,
          .flags = part.flags,
          .origin = origin_,
          .frame = stamp,
          .stream = part.stream,
          .codec = part.codec,
          .index = static_cast<std::uint16_t>(index),
          .count = count,
          .image_width = part.image_width,
          .image_height = part.image_height,
          .first_row = part.first_row,
          .first_column = part.first_column,
          .pixel_count = part.pixel_count};
}

std::span<const std::byte> FrameCoder::seal_part(std::size_t index, std::uint16_t count,
                                                 const FrameStamp& stamp) noexcept {
  return seal_packet(header_of(index, count, stamp), store_.part(index).payload_bytes,
                     store_.buffer(index));
}

void FrameCoder::gather(ParityGroup& group, std::size_t index, std::uint16_t count,
                        const FrameStamp& stamp) noexcept {
  const std::size_t bytes = store_.part(index).payload_bytes;
  // A part of this coder is never longer than a group takes.
  STOF_CHECK(group.add(header_of(index, count, stamp), store_.payload(index).first(bytes)) ==
             Status::kOk);
}

std::span<const std::byte> FrameCoder::seal_parity(ParityGroup& group, std::uint16_t index,
                                                   std::uint16_t count, const FrameStamp& stamp,
                                                   DatagramBuffer& buffer) noexcept {
  const std::size_t bytes = group.write(count, payload_space(buffer));
  return seal_packet({.type = PacketType::kParity,
                      .origin = origin_,
                      .frame = stamp,
                      .index = index,
                      .count = parity_groups(count),
                      .image_width = store_.part(0).image_width,
                      .image_height = store_.part(0).image_height},
                     bytes, buffer);
}

Datagrams FrameCoder::seal_all(const FrameStamp& stamp, const StreamChoice& choice) noexcept {
  encode_frame_info(info_, store_.payload(0).first<kFrameInfoBytes>());
  const auto count = static_cast<std::uint16_t>(store_.size());
  for (std::size_t i = 0; i < count; ++i) {
    datagrams_[i] = seal_part(i, count, stamp);
  }
  if (!choice.parity) {
    return datagrams_.first(count);
  }
  const std::uint16_t groups = parity_groups(count);
  ParityGroup& sum = groups_.front();
  for (std::uint16_t group = 0; group < groups; ++group) {
    sum.clear();
    for (std::size_t i = group; i < count; i += groups) {
      gather(sum, i, count, stamp);
    }
    const std::size_t at = std::size_t{count} + group;
    datagrams_[at] = seal_parity(sum, group, count, stamp, store_.buffer(at));
  }
  return datagrams_.first(std::size_t{count} + groups);
}

Result<Datagrams> FrameCoder::code(const FrameStamp& stamp, const FrameInfo& info,
                                   const FrameImages& images, const StreamChoice& choice) noexcept {
  if (!fits(images) || !count(info, images, choice)) {
    return fail(Status::kTooLarge);
  }
  return seal_all(stamp, choice);
}

// Of a frame that is larger than the memory for it: it was counted, and is coded again meanwhile.
class FrameCoder::Passage final : public PartSink {
 public:
  Passage(FrameCoder& coder, const FrameStamp& stamp, bool parity, DatagramSink& sink) noexcept
      : coder_(coder),
        stamp_(stamp),
        sink_(sink),
        count_(static_cast<std::uint16_t>(coder.store_.size())),
        groups_(parity ? parity_groups(count_) : std::uint16_t{0}) {
    for (ParityGroup& group : coder_.groups_.first(groups_)) {
      group.clear();
    }
  }

  void take(std::size_t begin, std::size_t end) noexcept override {
    for (std::size_t i = begin; i < end; ++i) {
      coder_.datagrams_[i - begin] = coder_.seal_part(i, count_, stamp_);
      if (groups_ > 0) {
        coder_.gather(coder_.groups_[i % groups_], i, count_, stamp_);
      }
    }
    send(end - begin);
  }

  // After all parts.
  void send_parity() noexcept {
    const std::size_t most = coder_.store_.buffers();
    for (std::size_t begin = 0; begin < groups_; begin += most) {
      const std::size_t end = std::min<std::size_t>(begin + most, groups_);
      for (std::size_t i = begin; i < end; ++i) {
        coder_.datagrams_[i - begin] =
            coder_.seal_parity(coder_.groups_[i], static_cast<std::uint16_t>(i), count_, stamp_,
                               coder_.store_.buffer(i));
      }
      send(end - begin);
    }
  }

 private:
  void send(std::size_t datagrams) noexcept {
    sink_.take(coder_.datagrams_.first(datagrams), std::size_t{count_} + groups_);
  }

  FrameCoder& coder_;
  FrameStamp stamp_;
  DatagramSink& sink_;
  std::uint16_t count_;
  std::uint16_t groups_;
};

Status FrameCoder::code(const FrameStamp& stamp, const FrameInfo& info, const FrameImages& images,
                        const StreamChoice& choice, DatagramSink& sink) noexcept {
  if (!fits(images)) {
    return Status::kTooLarge;
  }
  if (count(info, images, choice)) {
    const Datagrams datagrams = seal_all(stamp, choice);
    sink.take(datagrams, datagrams.size());
    return Status::kOk;
  }
  Passage passage(*this, stamp, choice.parity, sink);
  const std::size_t counted = store_.size();
  store_.clear(&passage);
  add_info(images);
  add_streams(images, choice);
  STOF_CHECK(store_.size() == counted);
  store_.finish();
  store_.clear();
  passage.send_parity();
  return Status::kOk;
}

}  // namespace stof::wire
