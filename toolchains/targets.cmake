# The builds for ARM have most objects in common.
if(CMAKE_CROSSCOMPILING AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(STOF_CCACHE ccache)
  if(STOF_CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_DIR=${PROJECT_SOURCE_DIR}/build/ccache CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros ${STOF_CCACHE})
  endif()
endif()

# It links in a third of the time. The cross build names it in its toolchain file.
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND NOT CMAKE_CROSSCOMPILING)
  find_program(STOF_LLD ld.lld-19)
  if(STOF_LLD)
    add_link_options(-fuse-ld=lld-19)
  endif()
endif()

# What every target of the project has in common.
add_library(stof_options INTERFACE)
target_include_directories(stof_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(stof_options INTERFACE
  -Wall -Wextra -Wconversion -Wsign-conversion -Wold-style-cast -Wnon-virtual-dtor
  -Woverloaded-virtual -Wundef -Wcast-align -Wimplicit-fallthrough
  # Not of what sources of a unity build hide from each other.
  $<$<NOT:$<BOOL:${CMAKE_UNITY_BUILD}>>:-Wshadow>
  # g++ 12 says it of its own std::streambuf.
  $<$<CXX_COMPILER_ID:Clang>:-Wnull-dereference>
  $<$<BOOL:${STOF_WERROR}>:-Werror>
  # Whatever names a source, in what CHECK says and in debug information, names its place in the tree, wherever that was built.
  -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=
  # Host and board must compute the same bits.
  -ffp-contract=off)

# The appliance: dsp, hal, board, firmware. Neither exceptions nor RTTI.
add_library(stof_appliance_options INTERFACE)
target_link_libraries(stof_appliance_options INTERFACE stof_options)
target_compile_options(stof_appliance_options INTERFACE -fno-exceptions -fno-rtti)

# An appliance for ARM alone chooses no variants of kernels at run time (dsp/base/target.h): it has NEON.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64" AND NOT (STOF_HOST OR STOF_TESTS OR STOF_BENCH))
  target_compile_definitions(stof_options INTERFACE STOF_NEON_ALONE)
endif()

# Mutation testing: kernels store a wrong byte, and their tests must notice.
if(STOF_MUTATE_STORES)
  target_compile_definitions(stof_options INTERFACE STOF_MUTATE_STORES)
endif()

# stof_add_kernels(TARGET stereo/rectify/rectify AVX2 fusion/project/footprint ...): the variants of kernels, x_ref.cpp and
# x_neon.cpp, on x86 also x_avx2.cpp and x_avx512.cpp of what is named so. A target calls it once.
function(stof_add_kernels target)
  set(kernels)
  set(sources)
  foreach(word IN LISTS ARGN)
    if(word MATCHES "^AVX")
      if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
        string(TOLOWER ${word} variant)
        list(APPEND sources ${kernel}_${variant}.cpp)
      endif()
    else()
      set(kernel ${word})
      list(APPEND kernels ${kernel})
      list(APPEND sources ${kernel}_ref.cpp ${kernel}_neon.cpp)
    endif()
  endforeach()
  target_sources(${target} PRIVATE ${sources})
  # Each calls its lanes and steps alike: none is part of a unity build.
  set_source_files_properties(${sources} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  # stof_add_kernel_tests() adds a test of each.
  set_property(TARGET ${target} PROPERTY STOF_KERNELS ${kernels})
  # Those alone need wide vectors; they are chosen at start. g++ 12 warns of its own header for AVX-512: of what
  # an intrinsic leaves undefined on purpose.
  set(avx2 -mavx2 -mtune=haswell)
  set(avx512 ${avx2} -mavx512f -mavx512bw -mavx512vl
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized> $<$<CXX_COMPILER_ID:GNU>:-Wno-uninitialized>)
  foreach(source IN LISTS sources)
    if(source MATCHES "_(avx2|avx512)\\.cpp$")
      set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "${${CMAKE_MATCH_1}}" SKIP_PRECOMPILE_HEADERS ON)
    elseif(STOF_MUTATE_STORES AND source MATCHES "_neon\\.cpp$")
      set_source_files_properties(${source} PROPERTIES SKIP_PRECOMPILE_HEADERS ON COMPILE_OPTIONS
        "-include;${PROJECT_SOURCE_DIR}/tests/support/mutated_stores.h")
    endif()
  endforeach()
  if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
    find_path(SIMDE_INCLUDE_DIR simde/arm/neon.h REQUIRED)
    target_include_directories(${target} SYSTEM PRIVATE ${SIMDE_INCLUDE_DIR})
    # Byte shuffles, population count, u16 minimum: every x86 processor since 2009.
    target_compile_options(${target} PRIVATE -march=x86-64-v2)
    # SIMDe takes most of the time of a kernel; the header of ARM's compilers is short. g++ forgets that it is a system's header,
    # and warns of it.
    if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
      target_precompile_headers(${target} PRIVATE
        <algorithm> <array> <bit> <cmath> <cstdint> <cstring> <memory> <span> "${PROJECT_SOURCE_DIR}/dsp/base/simd.h")
    endif()
  endif()
endfunction()

# The programs whose label is `kernel`: all that the builds `mutation` and `arm64-ubsan` need.
add_custom_target(stof_kernel_tests)
# What step `emu-rest` runs beside the product: the programs of labels `kernel` and `slow`, and what tests of label `plain` start.
add_custom_target(stof_rest_tests)

# Tests are compiled often and run once: without optimisation, which halves the time of the compiler. What has a label
# has loops of its own. What is tested keeps its own optimisation.
set(STOF_TEST_OPTIONS -O0)
set(STOF_LABELLED_TEST_OPTIONS -O1)
# Nor do they tell lines but where sanitizers print them.
string(TOUPPER "${CMAKE_BUILD_TYPE}" STOF_BUILD_TYPE)
set(STOF_SANITIZED OFF)
if(CMAKE_CXX_FLAGS_${STOF_BUILD_TYPE} MATCHES "-fsanitize")
  set(STOF_SANITIZED ON)
else()
  list(APPEND STOF_TEST_OPTIONS -g0)
  list(APPEND STOF_LABELLED_TEST_OPTIONS -g0)
endif()

# stof_add_test(NAME sad_test SOURCES ... LIBRARIES ... [ALONE ...] [LABELS kernel]): a GoogleTest program. A room has one for all of
# its tests that need the same libraries and label. SOURCES are compiled together, which takes less than half of the time; a source
# that gives a name of its own another meaning than its neighbours do is named behind ALONE. ctest runs the program whole, as one test
# of its name (a process for each of 3,000 cases, and their list made by every program, took a third of a run with sanitizers), through
# the emulator where the build is a cross build; scripts/test counts its cases from cases/NAME.xml.
# LABELS kernel: runs at every level of vectors (tests/support/kernel_check.h). With sanitizers stof_kernel_tests alone builds it.
# LABELS slow: seconds on scenes or recorded data; left out where it would be minutes (sanitizers, qemu: not even built).
# LABELS scenes: renders scenes, in floating point; left out of qemu. What is called ...OnEveryMachine runs there too.
# HOST_CASES Suite.Case[:Suite.Case]: these are a test of their own, NAME.host, with label `host`. They take seconds of plain C++,
# in which 64-bit ARM cannot differ; left out of qemu.
# SLOW_CASES Suite.Case[:Suite.Case]: NAME.slow, with label `slow`.
function(stof_add_test)
  cmake_parse_arguments(ARG "" "NAME;LABELS;HOST_CASES;SLOW_CASES" "SOURCES;ALONE;LIBRARIES" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "stof_add_test(${ARG_NAME}): unknown ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  if(ARG_LABELS STREQUAL "slow" AND (CMAKE_CROSSCOMPILING OR STOF_SANITIZED))
    return()
  endif()
  add_executable(${ARG_NAME} ${ARG_SOURCES} ${ARG_ALONE})
  set_source_files_properties(${ARG_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set(main GTest::gtest_main)
  if(ARG_LABELS STREQUAL "kernel")
    set(main stof_kernel_check)
    add_dependencies(stof_kernel_tests ${ARG_NAME})
    set_target_properties(${ARG_NAME} PROPERTIES EXCLUDE_FROM_ALL ${STOF_SANITIZED})
  endif()
  if(ARG_LABELS MATCHES "^(kernel|slow)$" OR ARG_SLOW_CASES)
    add_dependencies(stof_rest_tests ${ARG_NAME})
  endif()
  target_link_libraries(${ARG_NAME} PRIVATE stof_options ${ARG_LIBRARIES} GTest::gtest ${main})
  if(ARG_LABELS)
    target_compile_options(${ARG_NAME} PRIVATE ${STOF_LABELLED_TEST_OPTIONS})
    target_precompile_headers(${ARG_NAME} REUSE_FROM stof_labelled_test_headers)
  else()
    target_compile_options(${ARG_NAME} PRIVATE ${STOF_TEST_OPTIONS})
    target_precompile_headers(${ARG_NAME} REUSE_FROM stof_test_headers)
  endif()
  set_target_properties(${ARG_NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  set(properties)
  if(ARG_LABELS)
    # Begins early: what takes long would end alone.
    set(properties LABELS ${ARG_LABELS} COST 10)
    if(ARG_LABELS STREQUAL "slow")
      list(APPEND properties TIMEOUT 1800)  # all its cases, on a busy machine
    endif()
  endif()
  if(ARG_LABELS STREQUAL "scenes")
    stof_add_cases(${ARG_NAME}.every_machine ${ARG_NAME} *OnEveryMachine)
    stof_add_cases(${ARG_NAME} ${ARG_NAME} -*OnEveryMachine ${properties})
  elseif(ARG_HOST_CASES)
    stof_add_cases(${ARG_NAME}.host ${ARG_NAME} ${ARG_HOST_CASES} LABELS host COST 10)
    stof_add_cases(${ARG_NAME} ${ARG_NAME} -${ARG_HOST_CASES} ${properties})
  elseif(ARG_SLOW_CASES)
    stof_add_cases(${ARG_NAME}.slow ${ARG_NAME} ${ARG_SLOW_CASES} LABELS slow COST 10)
    stof_add_cases(${ARG_NAME} ${ARG_NAME} -${ARG_SLOW_CASES} ${properties})
  else()
    stof_add_cases(${ARG_NAME} ${ARG_NAME} * ${properties})
  endif()
endfunction()

# stof_add_cases(TEST PROGRAM FILTER [PROPERTIES...]): the cases of a program that GoogleTest's filter lets through, as one test.
function(stof_add_cases test program filter)
  add_test(NAME ${test}
    COMMAND ${program} --gtest_filter=${filter} --gtest_output=xml:${PROJECT_BINARY_DIR}/cases/${test}.xml)
  set_tests_properties(${test} PROPERTIES TIMEOUT 900 ${ARGN})
endfunction()

# stof_add_kernel_tests(TARGET): stereo/rectify/rectify of stof_add_kernels() has stereo/rectify/rectify_test.cpp in this folder.
function(stof_add_kernel_tests target)
  get_target_property(kernels ${target} STOF_KERNELS)
  foreach(kernel IN LISTS kernels)
    get_filename_component(name ${kernel} NAME)
    stof_add_test(NAME ${name}_test SOURCES ${kernel}_test.cpp LIBRARIES ${target} LABELS kernel)
  endforeach()
endfunction()

# Reads every source of this build with clang-tidy; what has not changed is not read again.
add_custom_target(stof_tidy
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/tidy --build-dir ${PROJECT_BINARY_DIR}
  USES_TERMINAL VERBATIM)

# stof_install_says_what_is_missing(COMPONENT TARGET...): `cmake --install` takes of a component what was built, by OPTIONAL of its
# install(TARGETS) lines; a line each says what was not, and how to build it.
function(stof_install_says_what_is_missing component)
  foreach(target IN LISTS ARGN)
    install(CODE "
      if(NOT EXISTS \"$<TARGET_FILE:${target}>\")
        message(NOTICE \"-- Not installed, for it is not built: $<TARGET_FILE_NAME:${target}>. To build it: cmake --build ${PROJECT_BINARY_DIR} --target ${target}\")
      endif()" COMPONENT ${component})
  endforeach()
endfunction()
