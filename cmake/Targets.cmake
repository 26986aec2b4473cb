# How every library, program and test of Raywalk is declared.

# Warnings are errors; the include root is the repository, so that an include names its folder.
add_library(raywalk_options INTERFACE)
target_compile_options(raywalk_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow
                       -Wnon-virtual-dtor -Woverloaded-virtual -Werror)
# GCC 12 warns falsely of overlapping copies in std::string (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(raywalk_options INTERFACE -Wno-restrict)
endif()
target_include_directories(raywalk_options INTERFACE ${PROJECT_SOURCE_DIR})
if(RAYWALK_SANITIZE)
  # GCC documents that sanitizers make some warnings false (-Wmaybe-uninitialized in <regex>,
  # -Wstringop-overflow in <vector>); the release build has them as errors.
  target_compile_options(raywalk_options INTERFACE -Wno-error
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
  target_compile_options(raywalk_options INTERFACE -fsanitize=${RAYWALK_SANITIZE}
                         -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(raywalk_options INTERFACE -fsanitize=${RAYWALK_SANITIZE})
endif()

# raywalk_library(<name> SOURCES ... LINK ...): one static library of a folder.
function(raywalk_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC raywalk_options ${ARG_LINK})
endfunction()

# raywalk_test(<name> [TOGETHER] SOURCES ... LINK ...): one GoogleTest executable, every case known to
# ctest. TOGETHER: cases that share what is costly to make run in one process, known as one test.
function(raywalk_test name)
  if(NOT RAYWALK_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "TOGETHER" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gmock GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  if(ARG_TOGETHER)
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES COST 100)  # long: begun first
  else()
    gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST)
  endif()
endfunction()
