#include "host/recording/mcap/definitions.h"

#include <utility>

namespace stof::mcap {
namespace {

// But for the id.
bool is_same(const Schema& one, const Schema& other) {
  return one.name == other.name && one.encoding == other.encoding && one.data == other.data;
}
bool is_same(const Channel& one, const Channel& other) {
  return one.topic == other.topic && one.schema_id == other.schema_id &&
         one.message_encoding == other.message_encoding && one.metadata == other.metadata;
}

template <typename T>
std::optional<std::uint16_t> id_of(const T& value, const std::map<std::uint16_t, T>& all) {
  for (const auto& [id, one] : all) {
    if (is_same(one, value)) {
      return id;
    }
  }
  return std::nullopt;
}

template <typename T>
std::uint16_t free_id(const std::map<std::uint16_t, T>& all) {
  std::uint16_t id = 1;
  while (all.contains(id)) {
    ++id;
  }
  return id;
}

}  // namespace

void Definitions::forget() {
  schemas_.clear();
  channels_.clear();
}

template <typename T>
bool Definitions::place(std::uint16_t id, T value, std::map<std::uint16_t, T>& all,
                        std::map<std::uint16_t, std::uint16_t>& ids, const Limits& limits) {
  const auto there = all.find(id);
  if (there != all.end() && is_same(there->second, value)) {
    ids[id] = id;
    return true;
  }
  std::uint16_t place = id;
  if (there != all.end()) {
    as_in_file_ = false;
    if (const std::optional<std::uint16_t> known = id_of(value, all)) {
      ids[id] = *known;
      return true;
    }
    place = free_id(all);
  }
  if (all.size() >= limits.channels) {
    return false;
  }
  value.id = place;
  ids[id] = place;
  all.emplace(place, std::move(value));
  return true;
}

bool Definitions::take(Schema&& schema, FileIndex& index, const Limits& limits) {
  const std::uint16_t id = schema.id;
  return place(id, std::move(schema), index.schemas, schemas_, limits);
}

bool Definitions::take(Channel&& channel, FileIndex& index, const Limits& limits) {
  if (channel.schema_id != 0) {
    const auto schema = schemas_.find(channel.schema_id);
    if (schema == schemas_.end()) {
      return false;
    }
    channel.schema_id = schema->second;
  }
  const std::uint16_t id = channel.id;
  return place(id, std::move(channel), index.channels, channels_, limits);
}

std::optional<std::uint16_t> Definitions::channel(std::uint16_t id) const {
  const auto found = channels_.find(id);
  return found == channels_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace stof::mcap
