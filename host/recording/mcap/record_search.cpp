#include "host/recording/mcap/record_search.h"

#include <algorithm>
#include <array>

#include "host/recording/mcap/chunk.h"
#include "host/recording/mcap/record_bytes.h"

namespace stof::mcap {
namespace {

// Bytes of the smallest content; nothing: no record of a data section.
std::optional<std::uint64_t> smallest_content(Opcode opcode) {
  switch (opcode) {
    case Opcode::kSchema:
      return 14;
    case Opcode::kChannel:
      return 16;
    case Opcode::kMessage:
      return 22;
    case Opcode::kChunk:
      return 40;
    case Opcode::kMessageIndex:
      return 6;
    case Opcode::kAttachment:
      return 36;
    case Opcode::kMetadata:
      return 8;
    case Opcode::kDataEnd:
      return 4;
    default:
      return std::nullopt;
  }
}

bool is_magic(Bytes bytes) {
  return bytes.size() >= kMagic.size() &&
         std::ranges::equal(bytes.first(kMagic.size()), std::as_bytes(std::span(kMagic)));
}

template <typename Record>
bool has_size(const std::optional<Record>& record, Bytes content) {
  if (!record) {
    return false;
  }
  Buffer again;
  append(again, *record);
  return again.size() == kRecordHead + content.size();
}

bool is_of_a_summary(Opcode opcode) {
  constexpr unsigned kPrivate = 0x80;
  switch (opcode) {
    case Opcode::kSchema:
    case Opcode::kChannel:
    case Opcode::kChunkIndex:
    case Opcode::kAttachmentIndex:
    case Opcode::kStatistics:
    case Opcode::kMetadataIndex:
    case Opcode::kSummaryOffset:
      return true;
    default:
      return static_cast<unsigned>(opcode) >= kPrivate;
  }
}

}  // namespace

bool fields_fill(Opcode opcode, Bytes content) {
  switch (opcode) {
    case Opcode::kSchema:
      return has_size(parse_schema(content), content);
    case Opcode::kChannel:
      return has_size(parse_channel(content), content);
    case Opcode::kMessageIndex:
      return has_size(parse_message_index(content), content);
    case Opcode::kMetadata:
      return has_size(parse_metadata(content), content);
    case Opcode::kMessage:
      return parse_message(content).has_value();
    default:
      return false;
  }
}

bool is_exactly(const Chunk& chunk, Bytes content) {
  constexpr std::size_t kFixed = 8 + 8 + 8 + 4 + 4 + 8;
  return content.size() == kFixed + chunk.compression.size() + chunk.records.size();
}

bool is_exactly(const Attachment& attachment, Bytes content) {
  constexpr std::size_t kFixed = 8 + 8 + 4 + 4 + 8 + 4;
  return content.size() ==
         kFixed + attachment.name.size() + attachment.media_type.size() + attachment.data.size();
}

FileEnd end_of_file(const ByteSource& source, std::uint64_t from) {
  std::array<std::byte, kRecordHead> head{};
  while (source.read(from, head)) {
    Cursor cursor(head);
    const auto opcode = static_cast<Opcode>(cursor.number<std::uint8_t>());
    const auto length = cursor.number<std::uint64_t>();
    const std::uint64_t content = from + kRecordHead;
    const bool footer = opcode == Opcode::kFooter && length >= kFooterContent;
    if (length > source.size() - content || !(footer || is_of_a_summary(opcode))) {
      break;
    }
    if (footer) {
      std::array<std::byte, kMagic.size()> magic{};
      if (!source.read(content + length, magic) || !is_magic(magic)) {
        break;
      }
      return {.whole = true, .at = content + length + magic.size()};
    }
    from = content + length;
  }
  return {.at = from};
}

RecordSearch::RecordSearch(const ByteSource& source, const Limits& limits)
    : source_(&source),
      limits_(limits),
      work_left_((std::uint64_t{64} << 20) + 8 * source.size()) {}

std::optional<RecordSearch::Head> RecordSearch::head_at(std::uint64_t offset) const {
  std::array<std::byte, kRecordHead> bytes{};
  if (!source_->read(offset, bytes)) {
    return std::nullopt;
  }
  Cursor from(bytes);
  const auto opcode = static_cast<Opcode>(from.number<std::uint8_t>());
  return Head{.opcode = opcode, .length = from.number<std::uint64_t>()};
}

bool RecordSearch::possible(const Head& head, std::uint64_t offset) const {
  const std::optional<std::uint64_t> least = smallest_content(head.opcode);
  return least && head.length >= *least && head.length <= limits_.record_bytes &&
         head.length <= source_->size() - offset - kRecordHead;
}

bool RecordSearch::file_begins(std::uint64_t offset) const {
  constexpr std::uint64_t kLongest = std::uint64_t{1} << 16;
  std::array<std::byte, kMagic.size()> magic{};
  if (!source_->read(offset, magic) || !is_magic(magic)) {
    return false;
  }
  const std::optional<Head> head = head_at(offset + magic.size());
  if (!head || head->opcode != Opcode::kHeader || head->length > kLongest) {
    return false;
  }
  Buffer content(static_cast<std::size_t>(head->length));
  return source_->read(offset + magic.size() + kRecordHead, content) &&
         parse_header(content).has_value();
}

bool RecordSearch::credible(std::uint64_t offset) const {
  if (offset == source_->size()) {
    return true;
  }
  const std::optional<Head> head = head_at(offset);
  return (head && possible(*head, offset)) || file_begins(offset);
}

bool RecordSearch::spend(std::uint64_t bytes) noexcept {
  work_left_ -= std::min(bytes, work_left_);
  return work_left_ != 0;
}

bool RecordSearch::sound_chunk() {
  const std::optional<Chunk> chunk = parse_chunk(buffer_);
  Buffer content;
  if (!chunk || !is_exactly(*chunk, buffer_) ||
      !spend(std::min(chunk->uncompressed_size, limits_.chunk_bytes)) ||
      !unpack(*chunk, limits_, content)) {
    return false;
  }
  // Without a CRC its records have to follow each other.
  Bytes left = chunk->uncompressed_crc != 0 ? Bytes() : Bytes(content);
  while (!left.empty()) {
    const std::optional<RecordAt> record = first_record(left);
    if (!record) {
      return false;
    }
    left = left.subspan(static_cast<std::size_t>(record->length));
  }
  return true;
}

bool RecordSearch::sound(std::uint64_t offset) {
  constexpr std::uint64_t kEach = 64;  // a record costs more than its bytes
  constexpr int kInARow = 4;
  for (int row = 1;; ++row) {
    if (file_begins(offset)) {
      return true;
    }
    const std::optional<Head> head = head_at(offset);
    if (!head || !possible(*head, offset) || !spend(kEach + head->length)) {
      return false;
    }
    buffer_.resize(static_cast<std::size_t>(head->length));
    if (!source_->read(offset + kRecordHead, buffer_)) {
      return false;
    }
    if (head->opcode == Opcode::kChunk) {
      return sound_chunk();
    }
    if (head->opcode == Opcode::kAttachment) {
      const std::optional<Attachment> attachment = parse_attachment(buffer_);
      return attachment && is_exactly(*attachment, buffer_);
    }
    if (!fields_fill(head->opcode, buffer_)) {
      return false;
    }
    offset += kRecordHead + head->length;
    if ((head->opcode == Opcode::kMetadata || row == kInARow) && credible(offset)) {
      return true;
    }
  }
}

std::optional<std::uint64_t> RecordSearch::next(std::uint64_t from) {
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;
  Buffer block;
  while (from < source_->size() && source_->size() - from >= kRecordHead) {
    block.resize(static_cast<std::size_t>(std::min(kBlock, source_->size() - from)));
    if (!source_->read(from, block)) {
      return std::nullopt;
    }
    const std::size_t heads = block.size() - (kRecordHead - 1);
    for (std::size_t k = 0; k < heads; ++k) {
      const auto opcode = static_cast<Opcode>(block[k]);
      const bool magic = std::to_integer<std::uint8_t>(block[k]) == kMagic.front();
      if (!magic && !smallest_content(opcode)) {
        continue;
      }
      Head head{.opcode = opcode};
      std::memcpy(&head.length, block.data() + k + 1, sizeof head.length);
      if ((magic || possible(head, from + k)) && sound(from + k)) {
        return from + k;
      }
      if (gave_up()) {
        return std::nullopt;
      }
    }
    from += heads;
  }
  return std::nullopt;
}

}  // namespace stof::mcap
