// For LD_PRELOAD: a LAPACK whose singular values are none, as where a number that is none reaches
// it. It tells so as LAPACK does.
#include <cstddef>

extern "C" {

void xerbla_(const char* routine, const int* parameter, std::size_t routine_length);

void dgesdd_() {
  const int parameter = 4;
  xerbla_("DLASCL", &parameter, 6);
}
}
