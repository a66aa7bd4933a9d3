#include "host/calibrate/lapack_errors.h"

#include <cmath>

#include <dlfcn.h>
#include <gtest/gtest.h>

namespace stof::host {
namespace {

// a *= to / from. LAPACK's own, as the libraries below find it; no header of it is needed.
using Dlascl = void(const char* type, const int* kl, const int* ku, const double* from,
                    const double* to, const int* m, const int* n, double* a, const int* lda,
                    int* info, std::size_t type_length);

Dlascl* dlascl() { return reinterpret_cast<Dlascl*>(dlsym(RTLD_DEFAULT, "dlascl_")); }

int scaled_from(double from, double& element) {
  const int none = 0;
  const int one = 1;
  const double to = 2;
  int info = -1;
  dlascl()("G", &none, &none, &from, &to, &one, &one, &element, &one, &info, 1);
  return info;
}

TEST(LapackErrors, LapackTakesTheProgramsXerbla) {
  ASSERT_NE(dlascl(), nullptr);
  double element = 3;
  EXPECT_EQ(scaled_from(1, element), 0);
  EXPECT_EQ(element, 6);
  EXPECT_EQ(dlsym(RTLD_DEFAULT, "xerbla_"), reinterpret_cast<void*>(&xerbla_));
}

TEST(LapackErrors, EndTheProgramWithCodeOneAndALine) {
  ASSERT_NE(dlascl(), nullptr);
  double element = 3;
  EXPECT_EXIT(scaled_from(std::nan(""), element), testing::ExitedWithCode(1),
              "^stof: LAPACK's DLASCL refuses its parameter 4, [^\n]*: [^\n]*\n$");
}

}  // namespace
}  // namespace stof::host
