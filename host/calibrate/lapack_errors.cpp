#include "host/calibrate/lapack_errors.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

void xerbla_(const char* routine, const int* parameter, std::size_t routine_length) {
  constexpr std::size_t kLongest = 16;  // names of LAPACK's have 6 to 12 characters
  std::fflush(stdout);
  std::fprintf(stderr,
               "stof: LAPACK's %.*s refuses its parameter %d, most likely a number that is none: "
               "nothing is written: try other views, and report this line\n",
               static_cast<int>(std::min(routine_length, kLongest)), routine, *parameter);
  // Without destructors: other threads may compute.
  std::_Exit(EXIT_FAILURE);
}
