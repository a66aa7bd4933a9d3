#include "firmware/settings/text/json.h"

#include <algorithm>
#include <array>
#include <span>

#include "firmware/settings/text/utf8.h"

#define JSMN_STATIC  // NOLINT(readability-identifier-naming): names of jsmn.h
#define JSMN_STRICT  // NOLINT(readability-identifier-naming)
#include <jsmn.h>

namespace stof::settings {
namespace {

// jsmn finds where values begin and end. It minds neither what stands between them nor what stands
// in numbers and words, and stops at a 0: the walk looks at every byte that it leaves out.

constexpr std::size_t kMostTokens = 512;
constexpr std::size_t kMostPath = 64;
constexpr std::string_view kSpace = " \t\r\n";

bool all_digits(std::string_view text) noexcept {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

bool is_number(std::string_view text) noexcept {
  if (text.starts_with('-')) {
    text.remove_prefix(1);
  }
  if (const std::size_t e = text.find_first_of("eE"); e != std::string_view::npos) {
    std::string_view exponent = text.substr(e + 1);
    if (exponent.starts_with('-') || exponent.starts_with('+')) {
      exponent.remove_prefix(1);
    }
    if (!all_digits(exponent)) {
      return false;
    }
    text = text.substr(0, e);
  }
  if (const std::size_t dot = text.find('.'); dot != std::string_view::npos) {
    if (!all_digits(text.substr(dot + 1))) {
      return false;
    }
    text = text.substr(0, dot);
  }
  return all_digits(text) && (text.size() == 1 || text[0] != '0');
}

bool is_name(std::string_view text) noexcept {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

class Walk {
 public:
  Walk(std::string_view text, std::span<const jsmntok_t> tokens, JsonVisitor& visitor,
       PagedWriter& why) noexcept
      : text_(text), tokens_(tokens), visitor_(visitor), why_(why) {}

  bool document() noexcept {
    if (tokens_.empty() || tokens_[0].type != JSMN_OBJECT) {
      why_ << "the settings are not a JSON object: write {\"name\": value, ...}";
      return false;
    }
    return skip_to(begin(0), "") && object(0, 1) && skip_to(text_.size(), "");
  }

 private:
  static std::size_t at(int position) noexcept { return static_cast<std::size_t>(position); }

  // Of strings with their quotes.
  std::size_t begin(std::size_t token) const noexcept {
    return at(tokens_[token].start) - (tokens_[token].type == JSMN_STRING ? 1 : 0);
  }
  std::size_t end(std::size_t token) const noexcept {
    return at(tokens_[token].end) + (tokens_[token].type == JSMN_STRING ? 1 : 0);
  }
  std::string_view text_of(std::size_t token) const noexcept {
    return text_.substr(at(tokens_[token].start), at(tokens_[token].end - tokens_[token].start));
  }

  // Between here and `to` stands white space, and `separator` in it.
  bool skip_to(std::size_t to, std::string_view separator) noexcept {
    std::string_view between = text_.substr(here_, to - std::min(to, here_));
    const std::size_t found = std::min(between.find_first_not_of(kSpace), between.size());
    between.remove_prefix(found);
    if (to < here_ || !between.starts_with(separator) ||
        between.substr(separator.size()).find_first_not_of(kSpace) != std::string_view::npos) {
      return broken(here_ + found);
    }
    here_ = to;
    return true;
  }

  bool broken(std::size_t where) noexcept {
    why_ << "not JSON from byte " << where << " on: \"";
    write_clipped(text_.substr(std::min(where, text_.size())), why_);
    why_ << '"';
    return false;
  }

  // Whether an earlier member of the object that begins at token `first` has that name.
  bool seen(std::size_t first, std::size_t name) const noexcept {
    std::size_t limit = 0;
    for (std::size_t token = first; token < name; ++token) {
      if (begin(token) >= limit) {
        if (text_of(token) == text_of(name)) {
          return true;
        }
        limit = end(token + 1);
      }
    }
    return false;
  }

  // The object of that token; next_ is the token after it then.
  bool object(std::size_t token, int depth) noexcept {
    here_ = begin(token) + 1;
    next_ = token + 1;
    const std::size_t first = next_;
    const std::size_t inside = end(token) - 1;
    for (bool any = false; next_ < tokens_.size() && begin(next_) < inside; any = true) {
      if (!skip_to(begin(next_), any ? "," : "") || !member(first, depth)) {
        return false;
      }
    }
    if (!skip_to(inside, "")) {
      return false;
    }
    ++here_;
    return true;
  }

  bool member(std::size_t first, int depth) noexcept {
    const std::size_t name = next_;
    const std::size_t value = next_ + 1;
    if (tokens_[name].type != JSMN_STRING || tokens_[name].size != 1 || value >= tokens_.size()) {
      return broken(begin(name));
    }
    const std::size_t length = path_bytes_;
    if (!enter(text_of(name))) {
      return false;
    }
    if (seen(first, name)) {
      why_ << path() << ": stands there twice";
      return false;
    }
    here_ = end(name);
    if (!skip_to(begin(value), ":") || !visit(value, depth)) {
      return false;
    }
    path_bytes_ = length;
    return true;
  }

  bool visit(std::size_t token, int depth) noexcept {
    const jsmntype_t type = tokens_[token].type;
    if (type == JSMN_OBJECT && visitor_.is_group(path())) {
      if (depth == kMostJsonDepth) {
        why_ << path() << ": objects lie too deep in each other";
        return false;
      }
      return object(token, depth + 1);
    }
    const std::string_view text = text_of(token);
    Written written = Written::kArray;
    if (type == JSMN_OBJECT) {
      written = Written::kObject;
    } else if (type == JSMN_STRING) {
      written = Written::kString;
      if (!plain_utf8(text)) {
        why_ << path() << ": takes UTF-8 without escapes and control characters, not \"";
        write_clipped(text, why_);
        why_ << '"';
        return false;
      }
    } else if (type == JSMN_PRIMITIVE && !primitive(text, written)) {
      return broken(begin(token));
    }
    next_ = token + 1;
    here_ = end(token);
    // What lies in a value that nobody takes is not looked at: the visitor refuses it.
    return visitor_.member(path(), {.written = written, .text = text}) && type != JSMN_OBJECT &&
           type != JSMN_ARRAY;
  }

  static bool primitive(std::string_view text, Written& written) noexcept {
    if (text == "true" || text == "false") {
      written = Written::kBoolean;
    } else if (text == "null") {
      written = Written::kNull;
    } else {
      written = Written::kNumber;
      return is_number(text);
    }
    return true;
  }

  bool enter(std::string_view name) noexcept {
    if (!is_name(name) || path_bytes_ + 1 + name.size() > path_.size()) {
      why_ << '"';
      write_clipped(name, why_);
      why_ << "\": there is no such setting";
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
  std::span<const jsmntok_t> tokens_;
  JsonVisitor& visitor_;
  PagedWriter& why_;
  std::array<char, kMostPath> path_{};
  std::size_t path_bytes_ = 0;
  std::size_t here_ = 0;  // all before this byte has been looked at
  std::size_t next_ = 0;  // token
};

}  // namespace

bool walk_json(std::string_view text, JsonVisitor& visitor, PagedWriter& why) noexcept {
  if (text.size() > kMostJsonBytes) {
    why << text.size() << " bytes are more than the " << kMostJsonBytes
        << " that settings may have";
    return false;
  }
  std::array<jsmntok_t, kMostTokens> tokens;
  jsmn_parser parser;
  jsmn_init(&parser);
  const int found = jsmn_parse(&parser, text.data(), text.size(), tokens.data(), kMostTokens);
  if (found == JSMN_ERROR_NOMEM) {
    why << "more values than there are settings";
    return false;
  }
  if (found == JSMN_ERROR_PART) {
    why << "not JSON: it ends too early";
    return false;
  }
  if (found < 0) {
    why << "not JSON from about byte " << parser.pos << " on: \"";
    write_clipped(text.substr(std::min<std::size_t>(parser.pos, text.size())), why);
    why << '"';
    return false;
  }
  return Walk(text, std::span(tokens).first(static_cast<std::size_t>(found)), visitor, why)
      .document();
}

void write_clipped(std::string_view text, PagedWriter& out) noexcept {
  constexpr std::size_t kMost = 40;
  for (const char c : text.substr(0, kMost)) {
    out << (c < 0x20 || c == 0x7F || c == '"' ? '?' : c);
  }
  if (text.size() > kMost) {
    out << "...";
  }
}

}  // namespace stof::settings
