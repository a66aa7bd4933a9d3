#include "firmware/keys/key_service.h"

#include <array>
#include <charconv>
#include <cstdio>

#include "firmware/settings/text/as_text.h"
#include "firmware/wire/keys/key_text.h"

namespace stof::keys {
namespace {

using firmware::Access;
using wire::SettingsOperation;
using wire::SettingsResult;

constexpr std::size_t kIdDigits = 8;

std::array<char, kIdDigits + 1> id_text(std::uint32_t id) noexcept {
  std::array<char, kIdDigits + 1> text{};
  std::snprintf(text.data(), text.size(), "%08x", id);
  return text;
}

// 0: no such text.
std::uint32_t id_of(std::string_view text) noexcept {
  std::uint32_t id = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), id, 16);
  const bool whole = read.ec == std::errc() && read.ptr == text.data() + text.size();
  return whole && text.size() == kIdDigits ? id : 0;
}

}  // namespace

wire::SettingsAnswer KeyService::serve(const wire::SettingsRequest& request,
                                       std::span<const std::byte> text,
                                       const firmware::Requester& by,
                                       std::span<std::byte> answer_text,
                                       std::size_t& answer_bytes) noexcept {
  if (request.operation != SettingsOperation::kKeys &&
      request.operation != SettingsOperation::kUnpair) {
    return settings_.serve(request, text, by, answer_text, answer_bytes);
  }
  if (request.operation == SettingsOperation::kKeys && by.access == Access::kAdmin) {
    return list(request.offset, answer_text, answer_bytes);
  }
  settings::PagedWriter why(settings::as_writable_text(answer_text));
  SettingsResult result = SettingsResult::kDenied;
  if (request.operation == SettingsOperation::kUnpair) {
    result = unpair(settings::as_text(text), by, why);
  } else {
    why << "keys: take a key with role admin";
  }
  answer_bytes = why.text().size();
  return {.result = result};
}

wire::SettingsAnswer KeyService::list(std::uint16_t offset, std::span<std::byte> answer_text,
                                      std::size_t& answer_bytes) const noexcept {
  settings::PagedWriter out(settings::as_writable_text(answer_text), offset);
  out << "[";
  const char* between = "";
  for (const wire::Key& key : ring_.keys().all()) {
    out << between << R"({"id": ")" << id_text(key.id).data() << R"(", "role": ")"
        << wire::role_text(key.role) << R"(", "name": ")" << key.name_text() << "\"}";
    between = ",\n";
  }
  out << "]";
  answer_bytes = out.text().size();
  return {.result = SettingsResult::kOk, .total = static_cast<std::uint16_t>(out.total())};
}

SettingsResult KeyService::unpair(std::string_view text, const firmware::Requester& by,
                                  settings::PagedWriter& why) noexcept {
  const std::uint32_t id = id_of(text);
  if (by.access != Access::kAdmin && (id == 0 || id != by.key_id)) {
    why << "unpair: takes a key with role admin, or that key itself";
    return SettingsResult::kDenied;
  }
  const wire::Key* const ended = ring_.keys().find(id);
  firmware::Event event{.value = id,
                        .role = ended == nullptr ? wire::Role::kNone : ended->role,
                        .address = by.peer ? by.peer->address : hal::Peer{}.address};
  switch (ring_.remove(id)) {
    case Status::kOk:
      event.kind = ring_.keys().count() > 0 ? firmware::EventKind::kKeyEnded
                                            : firmware::EventKind::kLastKeyEnded;
      if (changes_ != nullptr) {
        static_cast<void>(changes_->push(event));
      }
      return SettingsResult::kOk;
    case Status::kInvalidArgument:
      why << "unpair: there is no key \"" << id_text(id).data() << '"';
      return SettingsResult::kInvalid;
    default:
      why << "unpair: the keys cannot be saved, and stay as they are";
      return SettingsResult::kNotSaved;
  }
}

}  // namespace stof::keys
