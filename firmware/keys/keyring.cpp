#include "firmware/keys/keyring.h"

#include <algorithm>
#include <array>

#include "firmware/wire/keys/key_text.h"

namespace stof::keys {
namespace {

// Room for a key file, wiped when it goes.
struct KeySpace {
  KeySpace() = default;
  ~KeySpace() { wire::wipe(std::as_writable_bytes(std::span(text))); }
  KeySpace(const KeySpace&) = delete;
  KeySpace& operator=(const KeySpace&) = delete;
  std::array<char, wire::kMostKeyText> text{};
};

void wipe_copy(wire::Key& key) noexcept {
  wire::wipe(key.secret);
  if (key.former) {
    wire::wipe(*key.former);
  }
}

const char* what_is_wrong(Status read, bool regular) noexcept {
  if (!regular) {
    return read == Status::kUnsupported ? "no regular file" : "cannot be read";
  }
  return read == Status::kUnsupported ? "of a later version" : "no key file, or damaged";
}

}  // namespace

void Keyring::load(std::string_view place, settings::PagedWriter& line) noexcept {
  if (store_ == nullptr) {
    return;
  }
  KeySpace space;
  const Result<std::optional<std::size_t>> loaded =
      store_->load(std::as_writable_bytes(std::span(space.text)));
  if (loaded && !*loaded) {
    return;
  }
  const bool regular = loaded.has_value() || loaded.error() == Status::kTooLarge;
  const Status read =
      loaded ? wire::read_keys({space.text.data(), **loaded}, keys_) : loaded.error();
  if (read == Status::kOk && keys_.count() <= kMostKeys) {
    return;
  }
  keys_.clear();
  lost_ = true;
  damaged_ = regular;
  line << place << ": " << what_is_wrong(read, regular)
       << ": no client's key is known, nobody may change anything; pair again over the cable or "
          "with the button, it is left alone until then";
}

Status Keyring::add(const wire::Key& key) noexcept {
  if (keys_.count() >= kMostKeys) {
    return Status::kTooLarge;
  }
  wire::KeyTable next = keys_;
  const Status added = next.add(key);
  return added == Status::kOk ? become(next) : added;
}

Status Keyring::remove(std::uint32_t id) noexcept {
  wire::KeyTable next = keys_;
  return next.remove(id) ? become(next) : Status::kInvalidArgument;
}

Status Keyring::replace(std::uint32_t id, const wire::Secret& secret, Shown shown) noexcept {
  const wire::Key* const old = keys_.find(id);
  if (old == nullptr) {
    return Status::kInvalidArgument;
  }
  wire::KeyTable next;
  for (wire::Key key : keys_.all()) {
    if (key.id == id) {
      // Renewed again by whoever has the one of before: the last one never arrived, and is
      // forgotten.
      key.former = shown == Shown::kFormer ? key.former.value_or(key.secret) : key.secret;
      key.secret = secret;
    }
    static_cast<void>(next.add(key));
    wipe_copy(key);
  }
  return become(next);
}

void Keyring::settle(std::uint32_t id) noexcept {
  wire::KeyTable next;
  for (wire::Key key : keys_.all()) {
    if (key.id == id && key.former) {
      wire::wipe(*key.former);
      key.former.reset();
    }
    static_cast<void>(next.add(key));
    wipe_copy(key);
  }
  if (become(next) != Status::kOk) {
    keys_ = next;
  }
}

// A copy: whatever happens meanwhile, the file is there, so that keys never turn from lost to none.
Status Keyring::keep_damaged() noexcept {
  KeySpace space;
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(space.text));
  const Result<std::optional<std::size_t>> loaded = store_->load(bytes);
  if (!loaded) {
    return Status::kDeviceError;
  }
  return aside_ == nullptr || !*loaded ? Status::kOk : aside_->save(bytes.first(**loaded));
}

Status Keyring::become(const wire::KeyTable& next) noexcept {
  if (store_ != nullptr) {
    if (damaged_ && keep_damaged() != Status::kOk) {
      return Status::kDeviceError;
    }
    KeySpace space;
    const Status saved = store_->save(std::as_bytes(wire::write_keys(next, space.text)));
    if (saved != Status::kOk) {
      return saved;
    }
  }
  damaged_ = false;
  lost_ = false;
  keys_ = next;
  return Status::kOk;
}

Pairing Keyring::pairing() const noexcept {
  if (keys_.count() > 0) {
    return Pairing::kPaired;
  }
  return lost_ ? Pairing::kLost : Pairing::kUnpaired;
}

}  // namespace stof::keys
