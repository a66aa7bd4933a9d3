#pragma once

namespace stof::dsp {

// Reports a broken precondition on stderr in one line and aborts. Never returns.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace stof::dsp

// For our own bugs only: what a caller can get wrong at run time is a Status, bad pixels are "no
// value".
#define STOF_CHECK(condition)                                    \
  do {                                                           \
    if (!(condition)) [[unlikely]] {                             \
      ::stof::dsp::check_failed(#condition, __FILE__, __LINE__); \
    }                                                            \
  } while (false)
