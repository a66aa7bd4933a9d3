#include "firmware/settings/text/json.h"

#include <algorithm>
#include <array>
#include <span>

#include "firmware/settings/text/utf8.h"

namespace stof::settings {
namespace {

constexpr std::size_t kMostNames = 256;  // of all objects that are open
constexpr std::size_t kMostPath = 64;

bool is_number(std::string_view text) noexcept {
  const auto starts_with_any = [&text](std::string_view chars) {
    return !text.empty() && chars.contains(text[0]);
  };
  const auto digits = [&text] {
    const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
    text.remove_prefix(count);
    return count;
  };
  text.remove_prefix(starts_with_any("-") ? 1 : 0);
  const bool zero = starts_with_any("0");
  if (const std::size_t whole = digits(); whole == 0 || (zero && whole > 1)) {
    return false;
  }
  if (starts_with_any(".")) {
    text.remove_prefix(1);
    if (digits() == 0) {
      return false;
    }
  }
  if (starts_with_any("eE")) {
    text.remove_prefix(1);
    text.remove_prefix(starts_with_any("+-") ? 1 : 0);
    return digits() > 0 && text.empty();
  }
  return text.empty();
}

bool is_name(std::string_view text) noexcept {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

// One pass from the first byte to the last. What is open is bounded, so is the recursion: objects
// alone lie in each other, kMostJsonDepth of them.
class Walk {
 public:
  Walk(std::string_view text, JsonVisitor& visitor, PagedWriter& why) noexcept
      : text_(text), visitor_(visitor), why_(why) {}

  bool document() noexcept {
    skip_space();
    if (!take('{')) {
      why_ << "the settings are not a JSON object: write {\"name\": value, ...}";
      return false;
    }
    const bool whole = object(1);
    skip_space();
    return whole && (here_ == text_.size() || broken());
  }

 private:
  void skip_space() noexcept {
    here_ = std::min(text_.find_first_not_of(" \t\r\n", here_), text_.size());
  }
  bool next_is(char c) const noexcept { return here_ < text_.size() && text_[here_] == c; }
  bool take(char c) noexcept {
    const bool there = next_is(c);
    here_ += there ? 1 : 0;
    return there;
  }
  bool take_between_space(char c) noexcept {
    skip_space();
    const bool there = take(c);
    skip_space();
    return there;
  }

  bool broken() noexcept {
    if (here_ >= text_.size()) {
      why_ << "not JSON: it ends too early";
      return false;
    }
    why_ << "not JSON from byte " << here_ << " on: ";
    write_quoted(text_.substr(here_), why_);
    return false;
  }

  // What follows its brace.
  bool object(int depth) noexcept {
    const std::size_t first = names_;
    skip_space();
    if (!take('}')) {
      do {
        if (!member(first, depth)) {
          return false;
        }
      } while (take_between_space(','));
      if (!take('}')) {
        return broken();
      }
    }
    names_ = first;
    return true;
  }

  // `first`: of the names of this object.
  bool member(std::size_t first, int depth) noexcept {
    std::string_view name;
    const std::size_t length = path_bytes_;
    if (!quoted(name) || !enter(name)) {
      return false;
    }
    const auto known = std::span(known_).subspan(first, names_ - first);
    if (std::ranges::find(known, name) != known.end()) {
      why_ << path() << ": stands there twice";
      return false;
    }
    if (names_ == known_.size()) {
      why_ << "more values than there are settings";
      return false;
    }
    known_[names_++] = name;
    if (!take_between_space(':')) {
      return broken();
    }
    if (!value(depth)) {
      return false;
    }
    path_bytes_ = length;
    return true;
  }

  bool value(int depth) noexcept {
    if (next_is('{') && visitor_.is_group(path())) {
      if (depth == kMostJsonDepth) {
        why_ << path() << ": objects lie too deep in each other";
        return false;
      }
      ++here_;
      return object(depth + 1);
    }
    if (next_is('{') || next_is('[')) {
      return nested(next_is('{') ? Written::kObject : Written::kArray);
    }
    return next_is('"') ? string() : word();
  }

  // What lies in a value that nobody takes is not looked at.
  bool nested(Written written) noexcept {
    if (visitor_.member(path(), {.written = written, .text = text_.substr(here_)})) {
      why_ << path() << ": takes neither an object nor an array";
    }
    return false;
  }

  bool string() noexcept {
    std::string_view text;
    if (!quoted(text)) {
      return false;
    }
    if (!plain_utf8(text)) {
      why_ << path() << ": takes UTF-8 without escapes and control characters, not ";
      write_quoted(text, why_);
      return false;
    }
    return visitor_.member(path(), {.written = Written::kString, .text = text});
  }

  // A number, true, false or null.
  bool word() noexcept {
    const std::size_t end = std::min(text_.find_first_of(" \t\r\n,:{}[]\"", here_), text_.size());
    const std::string_view text = text_.substr(here_, end - here_);
    Written written = Written::kNumber;
    if (text == "true" || text == "false") {
      written = Written::kBoolean;
    } else if (text == "null") {
      written = Written::kNull;
    } else if (!is_number(text)) {
      return broken();
    }
    here_ = end;
    return visitor_.member(path(), {.written = written, .text = text});
  }

  // Between quotes; an escaped quote does not end it.
  bool quoted(std::string_view& text) noexcept {
    if (!next_is('"')) {
      return broken();
    }
    const std::size_t begin = here_ + 1;
    std::size_t end = begin;
    while (end < text_.size() && text_[end] != '"') {
      end += text_[end] == '\\' ? 2U : 1U;
    }
    if (end >= text_.size()) {
      here_ = text_.size();
      return broken();
    }
    text = text_.substr(begin, end - begin);
    here_ = end + 1;
    return true;
  }

  bool enter(std::string_view name) noexcept {
    if (!is_name(name) || path_bytes_ + 1 + name.size() > path_.size()) {
      write_quoted(name, why_);
      why_ << ": there is no such setting";
      return false;
    }
    if (path_bytes_ > 0) {
      path_[path_bytes_++] = '.';
    }
    std::ranges::copy(name, path_.begin() + static_cast<std::ptrdiff_t>(path_bytes_));
    path_bytes_ += name.size();
    return true;
  }

  std::string_view path() const noexcept { return {path_.data(), path_bytes_}; }

  std::string_view text_;
  JsonVisitor& visitor_;
  PagedWriter& why_;
  std::array<char, kMostPath> path_{};
  std::size_t path_bytes_ = 0;
  std::array<std::string_view, kMostNames> known_{};  // of the objects that are open
  std::size_t names_ = 0;
  std::size_t here_ = 0;  // all before this byte has been looked at
};

}  // namespace

bool walk_json(std::string_view text, JsonVisitor& visitor, PagedWriter& why) noexcept {
  if (text.size() > kMostJsonBytes) {
    why << text.size() << " bytes are more than the " << kMostJsonBytes
        << " that settings may have";
    return false;
  }
  return Walk(text, visitor, why).document();
}

}  // namespace stof::settings
