#pragma once

#include <cstddef>

// What LAPACK calls where a routine is given what it cannot take, such as a number that is none.
// LAPACK's own prints a line on stdout and ends the program with code 0, as if all were done; its
// manual leaves it to programs to bring another. Whatever links stof_calibrate has this one: the
// program ends with code 1 and one line on stderr. It does not return: what calls LAPACK would
// compute on with numbers that nobody made.
extern "C" [[noreturn]] void xerbla_(const char* routine, const int* parameter,
                                     std::size_t routine_length);
