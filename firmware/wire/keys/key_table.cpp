#include "firmware/wire/keys/key_table.h"

#include <algorithm>
#include <iterator>

namespace stof::wire {
namespace {

void wipe_key(Key& key) noexcept {
  wipe(key.secret);
  if (key.former) {
    wipe(*key.former);
  }
  key = {};
}

bool stands_in_names(char c) noexcept {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '@' || c == '-';
}

}  // namespace

std::string_view Key::name_text() const noexcept {
  return {name.data(), static_cast<std::size_t>(std::ranges::find(name, '\0') - name.begin())};
}

std::array<char, kKeyNameBytes> key_name(std::string_view text) noexcept {
  std::array<char, kKeyNameBytes> name{};
  const std::string_view used = text.empty() ? "-" : text.substr(0, kKeyNameBytes);
  std::ranges::transform(used, name.begin(), [](char c) { return stands_in_names(c) ? c : '-'; });
  return name;
}

Status KeyTable::add(const Key& key) noexcept {
  if (key.id == 0 || key.role == Role::kNone || key.role > Role::kAdmin ||
      find(key.id) != nullptr) {
    return Status::kInvalidArgument;
  }
  if (count_ == kMost) {
    return Status::kTooLarge;
  }
  keys_[count_++] = key;
  return Status::kOk;
}

bool KeyTable::remove(std::uint32_t id) noexcept {
  Key* const end = keys_.data() + count_;
  Key* const found = std::ranges::find(keys_.data(), end, id, &Key::id);
  if (found == end) {
    return false;
  }
  std::move(found + 1, end, found);
  wipe_key(keys_[--count_]);
  return true;
}

void KeyTable::clear() noexcept {
  std::ranges::for_each(std::span(keys_).first(count_), wipe_key);
  count_ = 0;
}

const Key* KeyTable::find(std::uint32_t id) const noexcept {
  const auto keys = all();
  const auto found = std::ranges::find(keys, id, &Key::id);
  return found == keys.end() ? nullptr : &*found;
}

}  // namespace stof::wire
