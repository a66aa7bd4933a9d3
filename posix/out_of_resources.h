#pragma once

namespace stof::posix {

// For the first line of a program without exceptions: where the system refuses memory to `new`, or
// a thread to std::thread, the program ends with code 1 and one line, "<program>: what, and what to
// do", in place of an abort. Any other way to std::terminate is a bug of ours, and aborts.
// program: a literal.
void end_in_one_line_when_refused(const char* program) noexcept;

}  // namespace stof::posix
