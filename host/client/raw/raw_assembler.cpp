#include "host/client/raw/raw_assembler.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::client {
namespace {

std::size_t place_of(wire::Stream stream) {
  return static_cast<std::size_t>(stream) - static_cast<std::size_t>(wire::Stream::kRawLeft);
}

// Whether a raw tile's stream and codec are known here.
bool known(const wire::Header& header) {
  switch (header.stream) {
    case wire::Stream::kRawLeft:
    case wire::Stream::kRawRight:
      return header.codec == wire::Codec::kRaw8;
    case wire::Stream::kRawPmd:
      return header.codec == wire::Codec::kRaw16;
    default:
      return false;
  }
}

bool same_exposure(const wire::FrameStamp& a, const wire::FrameStamp& b) {
  return a.number == b.number && a.freshness == b.freshness &&
         a.exposure_middle_ns == b.exposure_middle_ns;
}

}  // namespace

void RawAssembler::Picture::begin() {
  mask.begin();
  pixels = 0;
}

bool RawAssembler::Picture::whole(int width, int height) const noexcept {
  return mask.open() && pixels == mask.pixels() && mask.columns() == width && mask.rows() == height;
}

RawOutcome RawAssembler::push(const wire::PacketView& packet, Time arrived) {
  const wire::Header& header = packet.header;
  const bool tile = header.type == wire::PacketType::kRawTile;
  if (most_pixels_ == 0 || (tile && !known(header))) {
    return RawOutcome::kUnknown;
  }
  if (tile ? !wire::consistent_raw_tile(packet) || header.index == 0
           : header.index != 0 || !wire::decode_raw_info(packet.payload)) {
    return RawOutcome::kContradicting;
  }
  if (tile && std::size_t{header.image_width} * header.image_height > most_pixels_) {
    return RawOutcome::kOversized;
  }
  if (contradicts(packet)) {
    ++lies_;
    return RawOutcome::kContradicting;
  }
  Slot* const slot = slot_of(header, arrived);
  if (slot == nullptr) {
    return RawOutcome::kLate;
  }
  if (slot->packets.has(header.index)) {
    return RawOutcome::kDuplicate;
  }
  const RawOutcome placed = place(*slot, packet);
  if (placed != RawOutcome::kTaken) {
    ++lies_;
    return placed;
  }
  slot->packets.insert(header.index, packet);
  slot->last = arrived;
  if (++slot->arrived == header.count) {
    finish_up_to(slot->order);
  }
  return RawOutcome::kTaken;
}

// Freshness is the exposure's id.
bool RawAssembler::contradicts(const wire::PacketView& packet) const noexcept {
  const wire::Header& header = packet.header;
  for (const Slot& slot : slots_) {
    if (slot.state == State::kOpen && slot.header.frame.freshness == header.frame.freshness) {
      return !same_exposure(slot.header.frame, header.frame) || slot.header.count != header.count ||
             slot.packets.differs(header.index, packet);
    }
  }
  const auto closed = std::ranges::find(closed_, header.frame.freshness,
                                        [](const Closed& one) { return one.stamp.freshness; });
  return closed != closed_.end() &&
         (!same_exposure(closed->stamp, header.frame) || closed->mark.contradicts(packet));
}

// nullptr: it is over.
RawAssembler::Slot* RawAssembler::slot_of(const wire::Header& header, Time arrived) {
  for (Slot& slot : slots_) {
    if (slot.state == State::kOpen && same_exposure(slot.header.frame, header.frame)) {
      return &slot;
    }
  }
  for (const Closed& closed : closed_) {
    if (same_exposure(closed.stamp, header.frame)) {
      return nullptr;
    }
  }
  const auto open = std::ranges::count(slots_, State::kOpen, &Slot::state);
  if (static_cast<std::size_t>(open) == kOpen) {
    finish(*oldest(State::kOpen));
  }
  Slot* free = oldest(State::kFree);
  if (free == nullptr) {
    free = oldest(State::kFinished);
    ++statistics_.untaken;
  }
  free->state = State::kOpen;
  free->order = ++begun_;
  free->header = header;
  free->packets.begin(header.count);
  free->arrived = 0;
  free->info.reset();
  for (Picture& picture : free->pictures) {
    picture.begin();
  }
  free->last = arrived;
  return free;
}

RawOutcome RawAssembler::place(Slot& slot, const wire::PacketView& packet) {
  const wire::Header& header = packet.header;
  if (header.type == wire::PacketType::kRawInfo) {
    slot.info = *wire::decode_raw_info(packet.payload);
    return RawOutcome::kTaken;
  }
  Picture& picture = slot.pictures[place_of(header.stream)];
  const std::size_t first =
      std::size_t{header.first_row} * header.image_width + header.first_column;
  const std::size_t count = header.pixel_count;
  if (!picture.mask.fits(header) || !picture.mask.vacant(first, count, 1)) {
    return RawOutcome::kContradicting;
  }
  picture.mask.mark(first, count, 1);
  picture.pixels += count;
  if (header.stream == wire::Stream::kRawPmd) {
    picture.words.resize(picture.mask.pixels());
    wire::get_pixels(packet.payload, std::span(picture.words).subspan(first, count));
  } else {
    picture.bytes.resize(picture.mask.pixels());
    wire::get_pixels(packet.payload, std::span(picture.bytes).subspan(first, count));
  }
  return RawOutcome::kTaken;
}

void RawAssembler::finish_up_to(std::uint64_t order) {
  for (Slot* slot = oldest(State::kOpen); slot != nullptr && slot->order <= order;
       slot = oldest(State::kOpen)) {
    finish(*slot);
  }
}

// In the order of beginning.
void RawAssembler::finish(Slot& slot) {
  closed_.resize(std::min(closed_count_ + 1, kClosed));
  closed_[closed_count_++ % kClosed] = {.stamp = slot.header.frame,
                                        .mark = slot.packets.mark(slot.header.frame.number)};
  if (!slot.info) {  // counted with the next one
    slot.state = State::kFree;
    return;
  }
  count(*slot.info);
  slot.state = State::kFinished;
}

// What its numbers tell of those before it.
void RawAssembler::count(const wire::RawInfo& info) {
  const bool anew = info.number <= number_ || number_ == 0;
  statistics_.lost += anew ? 0 : info.number - number_ - 1;
  statistics_.dropped += anew || info.dropped < dropped_ ? info.dropped : info.dropped - dropped_;
  number_ = info.number;
  dropped_ = info.dropped;
}

void RawAssembler::expire(Time now) {
  for (Slot* slot = oldest(State::kOpen); slot != nullptr && now - slot->last >= kTimeout;
       slot = oldest(State::kOpen)) {
    finish(*slot);
  }
}

std::optional<Time> RawAssembler::next_expiry() const {
  std::optional<Time> first;
  std::uint64_t order = 0;
  for (const Slot& slot : slots_) {
    if (slot.state == State::kOpen && (!first || slot.order < order)) {
      first = slot.last + kTimeout;
      order = slot.order;
    }
  }
  return first;
}

void RawAssembler::restart() {
  for (Slot& slot : slots_) {
    if (slot.state == State::kOpen || slot.state == State::kFinished) {
      ++statistics_.untaken;
      slot.state = State::kFree;
    }
  }
  closed_.clear();
  closed_count_ = 0;
  number_ = 0;
  dropped_ = 0;
}

std::optional<RawExposure> RawAssembler::take() {
  for (Slot& slot : slots_) {
    slot.state = slot.state == State::kOut ? State::kFree : slot.state;
  }
  Slot* const slot = oldest(State::kFinished);
  if (slot == nullptr) {
    return std::nullopt;
  }
  slot->state = State::kOut;
  const RawExposure exposure = view(*slot);
  ++(exposure.complete() ? statistics_.complete : statistics_.incomplete);
  return exposure;
}

RawExposure RawAssembler::view(const Slot& slot) {
  const wire::RawInfo& info = *slot.info;
  const auto& [left, right, pmd] = slot.pictures;
  RawExposure out{.origin = slot.header.origin,
                  .stamp = slot.header.frame,
                  .info = info,
                  .missing = static_cast<std::uint8_t>(info.pictures & wire::kRawPictures),
                  .last_packet = slot.last};
  const auto take_eye = [&](const Picture& picture, std::uint8_t bit) {
    if ((info.pictures & bit) == 0 || !picture.whole(info.width, info.height)) {
      return dsp::ImageView<const std::uint8_t>{};
    }
    out.missing = static_cast<std::uint8_t>(out.missing & ~bit);
    return dsp::ImageView<const std::uint8_t>{picture.bytes.data(), info.width, info.height};
  };
  out.left = take_eye(left, wire::kRawLeft);
  out.right = take_eye(right, wire::kRawRight);
  const int samples_height = static_cast<int>(wire::kRawSamples) * info.pmd_height;
  if ((info.pictures & wire::kRawPmd) != 0 && pmd.whole(info.pmd_width, samples_height)) {
    out.missing = static_cast<std::uint8_t>(out.missing & ~wire::kRawPmd);
    const std::size_t pixels = std::size_t{info.pmd_width} * info.pmd_height;
    for (std::size_t k = 0; k < wire::kRawSamples; ++k) {
      out.pmd[k] = {pmd.words.data() + k * pixels, info.pmd_width, info.pmd_height};
    }
  }
  return out;
}

RawAssembler::Slot* RawAssembler::oldest(State state) {
  Slot* found = nullptr;
  for (Slot& slot : slots_) {
    if (slot.state == state && (found == nullptr || slot.order < found->order)) {
      found = &slot;
    }
  }
  return found;
}

}  // namespace stof::client
