#pragma once

#include <optional>

#include "host/recording/mcap/records.h"

// Records to bytes and back, see records.h.
namespace stof::mcap {

void append(Buffer& to, const Header& value);
void append(Buffer& to, const Footer& value);
void append(Buffer& to, const Schema& value);
void append(Buffer& to, const Channel& value);
void append(Buffer& to, const Message& value);
void append(Buffer& to, const Chunk& value);
void append(Buffer& to, const MessageIndex& value);
void append(Buffer& to, const ChunkIndex& value);
void append(Buffer& to, const Attachment& value);
void append(Buffer& to, const AttachmentIndex& value);
void append(Buffer& to, const Metadata& value);
void append(Buffer& to, const MetadataIndex& value);
void append(Buffer& to, const Statistics& value);
void append_summary_offset(Buffer& to, Opcode group, std::uint64_t start, std::uint64_t length);
void append_data_end(Buffer& to, std::uint32_t data_crc);

std::optional<Header> parse_header(Bytes content);
std::optional<Footer> parse_footer(Bytes content);
std::optional<Schema> parse_schema(Bytes content);
std::optional<Channel> parse_channel(Bytes content);
std::optional<Message> parse_message(Bytes content);
std::optional<Chunk> parse_chunk(Bytes content);
std::optional<MessageIndex> parse_message_index(Bytes content);
std::optional<ChunkIndex> parse_chunk_index(Bytes content);
// Also empty where its CRC is another one.
std::optional<Attachment> parse_attachment(Bytes content);
std::optional<AttachmentIndex> parse_attachment_index(Bytes content);
std::optional<Metadata> parse_metadata(Bytes content);
std::optional<MetadataIndex> parse_metadata_index(Bytes content);
std::optional<Statistics> parse_statistics(Bytes content);

}  // namespace stof::mcap
