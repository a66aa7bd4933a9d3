// What strings of GCC 13 and later call in the C++ library, once more in libstof: it then loads
// where that library is older, on Ubuntu 22.04 with GCC 12's.
#include <cstddef>
#include <string>

#if defined(_GLIBCXX_RELEASE) && _GLIBCXX_RELEASE >= 13 && _GLIBCXX_USE_CXX11_ABI
template void std::basic_string<char>::_M_replace_cold(char*, std::size_t, const char*, std::size_t,
                                                       std::size_t);
#endif
