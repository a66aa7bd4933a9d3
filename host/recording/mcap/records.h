#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/recording/mcap/bytes.h"

// The records of an MCAP file, as https://mcap.dev/spec has them. A record is an opcode (u8), the
// length of its content (u64) and the content. append() writes a whole record, parse_...() reads a
// content: any bytes; empty when they are not one. What follows the known fields is of a newer
// writer and ignored.
namespace stof::mcap {

inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
inline constexpr std::size_t kRecordHead = 9;  // opcode and length

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

using TextMap = std::map<std::string, std::string>;

struct Header {
  std::string profile{};
  std::string library{};
};

struct Footer {
  std::uint64_t summary_start = 0;         // 0: no summary
  std::uint64_t summary_offset_start = 0;  // 0: no summary offsets
  std::uint32_t summary_crc = 0;           // of all from summary_start up to this field; 0: none
};
inline constexpr std::size_t kFooterContent = 20;

struct Schema {
  std::uint16_t id = 0;  // never 0
  std::string name{};
  std::string encoding{};
  std::string data{};
};

struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  // 0: none
  std::string topic{};
  std::string message_encoding{};
  TextMap metadata{};
};

// Times are nanoseconds since 1970.
struct Message {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  std::uint64_t publish_time = 0;
  Bytes data{};  // borrowed
};

struct Chunk {
  std::uint64_t start_time = 0;  // of the earliest message
  std::uint64_t end_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;  // 0: none
  std::string compression{};           // "", "zstd", or one that is not known here
  Bytes records{};                     // borrowed
};

struct IndexEntry {
  std::uint64_t log_time = 0;
  std::uint64_t offset = 0;  // of the message's record in the uncompressed chunk
  friend bool operator==(const IndexEntry&, const IndexEntry&) = default;
};
struct MessageIndex {
  std::uint16_t channel_id = 0;
  std::vector<IndexEntry> entries{};
};

struct ChunkIndex {
  std::uint64_t start_time = 0;
  std::uint64_t end_time = 0;
  std::uint64_t chunk_offset = 0;  // of the record in the file
  std::uint64_t chunk_length = 0;  // of the whole record
  std::map<std::uint16_t, std::uint64_t> message_index_offsets{};
  std::uint64_t message_index_length = 0;
  std::string compression{};
  std::uint64_t compressed_size = 0;
  std::uint64_t uncompressed_size = 0;
};

struct Attachment {
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::string name{};
  std::string media_type{};
  Bytes data{};  // borrowed
};

struct AttachmentIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t log_time = 0;
  std::uint64_t create_time = 0;
  std::uint64_t data_size = 0;
  std::string name{};
  std::string media_type{};
};

struct Metadata {
  std::string name{};
  TextMap entries{};
};

struct MetadataIndex {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::string name{};
};

struct Statistics {
  std::uint64_t message_count = 0;
  std::uint16_t schema_count = 0;
  std::uint32_t channel_count = 0;
  std::uint32_t attachment_count = 0;
  std::uint32_t metadata_count = 0;
  std::uint32_t chunk_count = 0;
  std::uint64_t start_time = 0;  // 0 without messages
  std::uint64_t end_time = 0;
  std::map<std::uint16_t, std::uint64_t> messages_by_channel{};
};

}  // namespace stof::mcap
