# What every target of the project has in common.
add_library(stof_options INTERFACE)
target_include_directories(stof_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(stof_options INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast -Wnon-virtual-dtor
  -Woverloaded-virtual -Wundef -Wcast-align -Wnull-dereference -Wimplicit-fallthrough
  $<$<BOOL:${STOF_WERROR}>:-Werror>
  # Host and board must compute the same bits.
  -ffp-contract=off)

# The appliance: dsp, hal, board, firmware. Neither exceptions nor RTTI.
add_library(stof_appliance_options INTERFACE)
target_link_libraries(stof_appliance_options INTERFACE stof_options)
target_compile_options(stof_appliance_options INTERFACE -fno-exceptions -fno-rtti)

# stof_add_test(NAME sad_test SOURCES ... LIBRARIES ... [LABELS ...]): a GoogleTest program whose
# cases ctest runs one by one, through the emulator where the build is a cross build.
function(stof_add_test)
  cmake_parse_arguments(ARG "" "NAME" "SOURCES;LIBRARIES;LABELS" ${ARGN})
  add_executable(${ARG_NAME} ${ARG_SOURCES})
  target_link_libraries(${ARG_NAME} PRIVATE stof_options ${ARG_LIBRARIES} GTest::gtest GTest::gtest_main)
  set_target_properties(${ARG_NAME} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  gtest_discover_tests(${ARG_NAME} DISCOVERY_TIMEOUT 120 PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 300)
endfunction()
