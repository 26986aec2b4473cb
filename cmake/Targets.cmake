# How every library, program and test of Raywalk is declared.

# Most of a unit's time goes into the headers of OpenCV, Eigen and the standard library, so several
# files of a target are compiled as one unit (docs/development.md has the figures). What is compiled
# together shares its anonymous namespace: a name is defined once per target there.
option(RAYWALK_UNITY "Compile several files of a target as one unit" ON)
option(RAYWALK_PRECOMPILE "Parse the headers of most units once; clang-tidy reads none by GCC" ON)
set(RAYWALK_UNITY_BATCH 16 CACHE STRING "How many files are compiled as one unit")

# Last among the options of tests: under sanitizers tests are compiled without optimisation, which
# takes half of the time, as it is what they test that has to be fast.
set(RAYWALK_TEST_OPTIONS "" CACHE STRING "Further compile options of tests, for example -O0")

option(RAYWALK_WERROR "Warnings are errors" OFF)

# The include root is the repository, so that an include names its folder.
add_library(raywalk_options INTERFACE)
target_compile_options(raywalk_options INTERFACE -Wall -Wextra -Wpedantic -Wnon-virtual-dtor
                       -Woverloaded-virtual $<$<BOOL:${RAYWALK_WERROR}>:-Werror>)
# In a unity build the files of a unit see each other's names, so that -Wshadow would compare with the
# globals of other files.
if(RAYWALK_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(raywalk_options INTERFACE -Wshadow=local)
else()
  target_compile_options(raywalk_options INTERFACE -Wshadow)
endif()
# GCC 12 warns falsely of overlapping copies in std::string (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(raywalk_options INTERFACE -Wno-restrict)
  # Collecting its garbage takes the compiler a tenth of its time where memory is plenty.
  target_compile_options(raywalk_options INTERFACE "SHELL:--param ggc-min-heapsize=524288")
  # Takes every file of a unity build for a header, in which anonymous types would be a mistake.
  if(RAYWALK_UNITY)
    target_compile_options(raywalk_options INTERFACE -Wno-subobject-linkage)
  endif()
endif()
target_include_directories(raywalk_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_definitions(raywalk_options INTERFACE RAYWALK_VERSION="${PROJECT_VERSION}")
if(RAYWALK_SANITIZE)
  # GCC documents that sanitizers make some warnings false (-Wmaybe-uninitialized in <regex>,
  # -Wstringop-overflow in <vector>); the tests' own build has them as errors.
  target_compile_options(raywalk_options INTERFACE -Wno-error
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>)
  target_compile_options(raywalk_options INTERFACE -fsanitize=${RAYWALK_SANITIZE}
                         -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(raywalk_options INTERFACE -fsanitize=${RAYWALK_SANITIZE})
endif()

# The Python module links the libraries into a shared one. Without the second option, GCC would not
# inline functions there that another library could replace.
set(RAYWALK_BUILD_PYTHON AUTO CACHE STRING
    "Build the Python module: ON, OFF or AUTO (where pybind11 is there)")
function(raywalk_link_into_module name)
  if(NOT RAYWALK_BUILD_PYTHON STREQUAL "OFF")
    target_compile_options(${name} PRIVATE -fPIC -fno-semantic-interposition)
  endif()
endfunction()

# raywalk_precompile(<name> <header> [OPTIONS ...] LINK ...): the headers that nearly every unit
# includes, parsed once. What uses them has to be compiled with the same options.
function(raywalk_precompile name header)
  cmake_parse_arguments(ARG "" "" "OPTIONS;LINK" ${ARGN})
  file(CONFIGURE OUTPUT ${name}.cc CONTENT "// Only carries the precompiled header.\n")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cc)
  target_link_libraries(${name} PRIVATE raywalk_options ${ARG_LINK})
  target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
  target_precompile_headers(${name} PRIVATE ${PROJECT_SOURCE_DIR}/${header})
endfunction()

# raywalk_sources(<result> <pattern>... [EXCEPT <pattern>...]): the files that match.
function(raywalk_sources result)
  cmake_parse_arguments(ARG "" "" "EXCEPT" ${ARGN})
  set(sources "")
  if(ARG_UNPARSED_ARGUMENTS)
    file(GLOB sources CONFIGURE_DEPENDS ${ARG_UNPARSED_ARGUMENTS})
  endif()
  if(ARG_EXCEPT)
    file(GLOB left_out CONFIGURE_DEPENDS ${ARG_EXCEPT})
    list(REMOVE_ITEM sources "" ${left_out})
  endif()
  set(${result} ${sources} PARENT_SCOPE)
endfunction()

# raywalk_compile_together(<name> <precompiled>): applies both to a target. Each unit that includes one
# of these headers compiles their templates anew, so files that do are brought together.
function(raywalk_compile_together name precompiled)
  if(NOT RAYWALK_UNITY)
    return()
  endif()
  get_target_property(rest ${name} SOURCES)
  set(sorted "")
  foreach(header CLI/ ceres/ nlohmann/json.hpp)
    foreach(source IN LISTS rest)
      file(STRINGS ${source} found REGEX "^#include <${header}" LIMIT_COUNT 1)
      if(found)
        list(APPEND sorted ${source})
      endif()
    endforeach()
    list(REMOVE_ITEM rest "" ${sorted})
  endforeach()
  set_target_properties(${name} PROPERTIES SOURCES "${sorted};${rest}" UNITY_BUILD ON
                        UNITY_BUILD_BATCH_SIZE ${RAYWALK_UNITY_BATCH})
  if(RAYWALK_PRECOMPILE)
    target_precompile_headers(${name} REUSE_FROM ${precompiled})
  endif()
endfunction()

# raywalk_library(<name> SOURCES <pattern>... [EXCEPT <pattern>...] LINK ...): a static library, one of
# a stage or a few. Tests and fakes beside the code are not in it, but fakes that are named.
function(raywalk_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;EXCEPT;LINK" ${ARGN})
  raywalk_sources(sources ${ARG_SOURCES} EXCEPT ${ARG_EXCEPT})
  list(FILTER sources EXCLUDE REGEX "_test\\.cc$")
  add_library(${name} STATIC ${sources})
  raywalk_compile_together(${name} raywalk_precompiled)
  raywalk_link_into_module(${name})
  # How Raywalk itself is compiled is no matter of those who use its libraries.
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:raywalk_options> ${ARG_LINK})
endfunction()

# raywalk_program(<name> [COMPONENT <name>] SOURCES <pattern>... LINK ...): a program that is installed,
# with component runtime unless another is named. Its command line is compiled as one unit, as CLI11 is
# compiled anew by each that includes it.
function(raywalk_program name)
  cmake_parse_arguments(ARG "" "COMPONENT" "SOURCES;LINK" ${ARGN})
  raywalk_sources(sources ${ARG_SOURCES})
  list(FILTER sources EXCLUDE REGEX "_test\\.cc$")
  add_executable(${name} ${sources})
  raywalk_compile_together(${name} raywalk_precompiled)
  raywalk_link_into_module(${name})
  target_link_libraries(${name} PRIVATE raywalk_command_line ${ARG_LINK})
  if(NOT ARG_COMPONENT)
    set(ARG_COMPONENT runtime)
  endif()
  raywalk_install_program(${name} ${ARG_COMPONENT})
endfunction()

add_custom_target(memory-tests)
add_custom_target(parallel-tests)

# raywalk_test(<name> [UNSANITIZED] [APART] [LONG] [WAITS] [PARALLEL] SOURCES <pattern>...
#              [EXCEPT <pattern>...] [LINK ...] [PROGRAMS ...]): one GoogleTest executable, known to ctest
# as one test: to load OpenCV and what it needs takes 0.1 s, more than most cases. APART: cases that are
# long, run programs or wait for devices are tests of their own, which run beside each other. LONG: begun
# first. WAITS: begun next, as they leave processors to others. Its label tells which tests a sanitizer
# runs, targets build these: "memory" and memory-tests (AddressSanitizer) those without UNSANITIZED,
# "parallel" and parallel-tests (ThreadSanitizer) those with PARALLEL, which run code on several threads.
# docs/development.md says what is left out and why. PROGRAMS it runs are built before;
# RAYWALK_BUILD_LF is the path of raywalk-build-lf.
function(raywalk_test name)
  if(NOT RAYWALK_BUILD_TESTS)
    return()
  endif()
  cmake_parse_arguments(ARG "UNSANITIZED;APART;LONG;WAITS;PARALLEL" "" "SOURCES;EXCEPT;LINK;PROGRAMS"
                        ${ARGN})
  raywalk_sources(sources ${ARG_SOURCES} EXCEPT ${ARG_EXCEPT})
  add_executable(${name} ${sources})
  target_compile_options(${name} PRIVATE ${RAYWALK_TEST_OPTIONS})
  raywalk_compile_together(${name} raywalk_precompiled_test)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} raywalk_core GTest::gmock GTest::gtest_main)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  target_compile_definitions(${name} PRIVATE
                             RAYWALK_CONFIGS="${PROJECT_SOURCE_DIR}/configs"
                             RAYWALK_DOCS="${PROJECT_SOURCE_DIR}/docs"
                             RAYWALK_TEST_ROOM="${PROJECT_SOURCE_DIR}/tests/data/white-room")
  foreach(program IN LISTS ARG_PROGRAMS)
    add_dependencies(${name} ${program})
    string(TOUPPER ${program} macro)
    string(REPLACE - _ macro ${macro})
    target_compile_definitions(${name} PRIVATE ${macro}="$<TARGET_FILE:${program}>")
  endforeach()
  set(label unsanitized)
  if(NOT ARG_UNSANITIZED)
    set(label memory)
    add_dependencies(memory-tests ${name})
  endif()
  if(ARG_PARALLEL)
    string(APPEND label -parallel)
    add_dependencies(parallel-tests ${name})
  endif()
  set(cost 0)
  if(ARG_LONG)
    set(cost 100)
  elseif(ARG_WAITS)
    set(cost 50)
  endif()
  if(ARG_APART)
    gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST
                         PROPERTIES LABELS "${label}" COST ${cost})
    return()
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS "${label}" COST ${cost})
endfunction()
