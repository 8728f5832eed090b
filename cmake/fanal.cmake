# SPDX-License-Identifier: MIT
# The kinds of target: layers, the library made of them, tests and fuzzers.

# How all code is compiled …
add_library(fanal_flags INTERFACE)
target_compile_options(fanal_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes> $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes> -Wvla
  -fno-math-errno -ffp-contract=off)
target_compile_definitions(fanal_flags INTERFACE _GNU_SOURCE)
if(FANAL_SANITIZE)
  target_compile_options(fanal_flags INTERFACE -fsanitize=${FANAL_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(fanal_flags INTERFACE -fsanitize=${FANAL_SANITIZE})
endif()
if(FANAL_FUZZ)
  target_compile_options(fanal_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# … and what the inside of the library sees on top of that.
add_library(fanal_options INTERFACE)
target_link_libraries(fanal_options INTERFACE fanal_flags)
target_include_directories(fanal_options INTERFACE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src
  ${PROJECT_SOURCE_DIR}/shaders)

set_property(GLOBAL PROPERTY fanal_layers "")
set_property(GLOBAL PROPERTY fanal_links "")

# fanal_layer(base SOURCES a.c b.c LINKS m) makes the object library fanal_base: one layer of the design's diagram.
function(fanal_layer name)
  cmake_parse_arguments(layer "" "" "SOURCES;LINKS" ${ARGN})
  add_library(fanal_${name} OBJECT ${layer_SOURCES})
  target_link_libraries(fanal_${name} PUBLIC fanal_options ${layer_LINKS})
  set_property(GLOBAL APPEND PROPERTY fanal_layers fanal_${name})
  list(FILTER layer_LINKS EXCLUDE REGEX "^fanal_")
  set_property(GLOBAL APPEND PROPERTY fanal_links ${layer_LINKS})
endfunction()

# fanal_library() makes libfanal of all layers; BUILD_SHARED_LIBS picks the kind.
function(fanal_library)
  get_property(layers GLOBAL PROPERTY fanal_layers)
  get_property(links GLOBAL PROPERTY fanal_links)
  list(REMOVE_DUPLICATES links)
  add_library(fanal)
  add_library(fanal::fanal ALIAS fanal)
  foreach(layer ${layers})
    target_sources(fanal PRIVATE $<TARGET_OBJECTS:${layer}>)
  endforeach()
  target_link_libraries(fanal PRIVATE $<BUILD_INTERFACE:fanal_flags> ${links})
  target_include_directories(fanal INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(fanal PROPERTIES LINKER_LANGUAGE C VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}
    ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR} LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  if(NOT FANAL_SANITIZE)
    target_link_options(fanal PRIVATE -Wl,--no-undefined)
  endif()
  if(FANAL_HAS_DRACO AND BUILD_SHARED_LIBS) # the C++ library's templates are visible whatever the compiler is told
    target_link_options(fanal PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/exports.map)
    set_property(TARGET fanal APPEND PROPERTY LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/exports.map)
  endif()
endfunction()

# CTest starts the tests of tests/slow.txt first, the longest before the others, so that no core waits for one of them at the end. Call it in
# the directory that adds the tests.
function(fanal_test_costs)
  file(STRINGS ${PROJECT_SOURCE_DIR}/tests/slow.txt lines REGEX "^[a-z]")
  foreach(line ${lines})
    string(REGEX MATCH "^([a-z0-9_]+) +([0-9]+)( all)?$" line "${line}")
    if(NOT line)
      message(FATAL_ERROR "tests/slow.txt: a line is not NAME SECONDS [all]")
    endif()
    if(CMAKE_MATCH_1 IN_LIST ARGN)
      set_tests_properties(${CMAKE_MATCH_1} PROPERTIES COST ${CMAKE_MATCH_2})
    endif()
  endforeach()
endfunction()

# fanal_test(maths SOURCES maths_test.c LAYERS base) makes the cmocka program test_maths and its CTest entry. LAYERS lists
# every layer whose objects the test needs; HELPERS are those of tests/CMakeLists.txt, SHADERS the test's own.
function(fanal_test name)
  if(NOT FANAL_TESTS)
    return()
  endif()
  cmake_parse_arguments(test "" "" "SOURCES;LAYERS;HELPERS;SHADERS;LINKS;ARGUMENTS" ${ARGN})
  add_executable(test_${name} ${test_SOURCES})
  foreach(layer ${test_LAYERS})
    target_link_libraries(test_${name} PRIVATE fanal_${layer})
  endforeach()
  foreach(helper ${test_HELPERS})
    target_link_libraries(test_${name} PRIVATE fanal_helper_${helper})
  endforeach()
  fanal_shaders(test_${name} ${test_SHADERS})
  target_link_libraries(test_${name} PRIVATE fanal_options PkgConfig::cmocka ${test_LINKS} m)
  target_include_directories(test_${name} PRIVATE ${PROJECT_SOURCE_DIR}) # "tests/render_harness.h"
  fanal_test_entry(${name} test_${name} ${test_ARGUMENTS})
endfunction()

# A CTest entry that runs a cmocka program.
function(fanal_test_entry name program)
  add_test(NAME ${name} COMMAND ${program} ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  # cmocka's exit status leaves out what the group's own functions find: messages of the validation layers, memory not given back.
  set_tests_properties(${name} PROPERTIES FAIL_REGULAR_EXPRESSION "FAILED  . GROUP (SETUP|TEARDOWN)")
  if(FANAL_SANITIZE)
    target_sources(${program} PRIVATE ${PROJECT_SOURCE_DIR}/tests/keep_loaded.c)
    target_link_options(${program} PRIVATE -Wl,--export-dynamic-symbol=dlclose)
    set_tests_properties(${name} PROPERTIES
      ENVIRONMENT LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/lsan.supp:print_suppressions=0)
  endif()
  fanal_test_costs(${name})
endfunction()

# Tests that render wait for the CPU driver's compiler most of the time. Without optimisation, and for vectors of four, it takes less than half as long,
# and what it makes is fast enough; pictures are right or wrong all the same. (Variables of Mesa's gallivm. Tests that measure keep the defaults.) The
# cache folder is theirs alone: the driver would give this code from it to others.
function(fanal_test_renders name)
  set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT
    GALLIVM_PERF=nopt LP_NATIVE_VECTOR_WIDTH=128 MESA_SHADER_CACHE_DIR=${PROJECT_BINARY_DIR}/driver_cache_4)
  if(FANAL_SANITIZE)
    set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/lsan.supp:print_suppressions=0)
  endif()
endfunction()

# fanal_render_test(tiled SOURCES tiled_test.c HELPERS list_bench) is a test of all layers that renders (tests/render_harness.h). It is a part of
# the program tests/test_render, whose parts share one device: making pipelines takes longer than all they draw. The CTest entries of
# tests/CMakeLists.txt each run the parts of a few groups; `test_render tiled` runs this one alone. GROUP: instead of the group named as the folder.
# OWN_DEVICE: a program of its own, for tests that make the device in their own way, or must see how its objects are made.
function(fanal_render_test name)
  if(NOT FANAL_TESTS)
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 test "OWN_DEVICE" "GROUP" "SOURCES;HELPERS;SHADERS")
  if(test_OWN_DEVICE)
    fanal_test(${name} SOURCES ${test_SOURCES} HELPERS render_harness stand_in ${test_HELPERS} SHADERS ${test_SHADERS}
      LAYERS base image scene ray gpu graph passes render)
    fanal_test_renders(${name})
    return()
  endif()
  add_library(part_${name} OBJECT EXCLUDE_FROM_ALL ${test_SOURCES})
  fanal_shaders(part_${name} ${test_SHADERS})
  target_compile_definitions(part_${name} PRIVATE main=part_${name})
  set_source_files_properties(${test_SOURCES} PROPERTIES COMPILE_OPTIONS -Wno-missing-prototypes) # of what is called main there
  target_link_libraries(part_${name} PRIVATE fanal_options PkgConfig::cmocka)
  target_include_directories(part_${name} PRIVATE ${PROJECT_SOURCE_DIR}) # "tests/render_harness.h"
  if(NOT test_GROUP)
    cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME test_GROUP)
  endif()
  set_property(GLOBAL APPEND PROPERTY fanal_render_parts ${name})
  set_property(GLOBAL APPEND PROPERTY fanal_render_parts_${test_GROUP} ${name})
  set_property(GLOBAL APPEND PROPERTY fanal_render_helpers ${test_HELPERS})
endfunction()

# fanal_fuzz(image SOURCES fuzz_image.c LAYERS base image) makes the libFuzzer program fuzz/fuzz_image when FANAL_FUZZ
# is on; `./build.sh fuzz` runs all of them. With FANAL_TESTS it is the test fuzz_image instead, which runs the seeds (tests/fuzz/replay.c). SEEDS: the
# folders of other fuzzers whose seeds it uses, instead of its own; tools/fuzz.sh has the same.
if(FANAL_FUZZ)
  add_custom_target(fuzzers)
endif()
function(fanal_fuzz name)
  if(NOT FANAL_FUZZ AND NOT FANAL_TESTS)
    return()
  endif()
  cmake_parse_arguments(fuzz "" "" "SOURCES;LAYERS;LINKS;SEEDS" ${ARGN})
  if(NOT fuzz_SEEDS)
    set(fuzz_SEEDS ${name})
  endif()
  list(TRANSFORM fuzz_SEEDS PREPEND ${PROJECT_SOURCE_DIR}/tests/fuzz/seeds/)
  add_executable(fuzz_${name} ${fuzz_SOURCES})
  foreach(layer ${fuzz_LAYERS})
    target_link_libraries(fuzz_${name} PRIVATE fanal_${layer})
  endforeach()
  target_link_libraries(fuzz_${name} PRIVATE fanal_options ${fuzz_LINKS} m)
  target_include_directories(fuzz_${name} PRIVATE ${PROJECT_SOURCE_DIR}) # "tests/fuzz/fuzz.h"
  if(FANAL_FUZZ)
    target_link_options(fuzz_${name} PRIVATE -fsanitize=fuzzer)
    set_target_properties(fuzz_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/fuzz)
    add_dependencies(fuzzers fuzz_${name})
  else()
    target_sources(fuzz_${name} PRIVATE $<TARGET_OBJECTS:fanal_replay>)
    add_test(NAME fuzz_${name} COMMAND fuzz_${name} ${fuzz_SEEDS})
    fanal_test_renders(fuzz_${name})
    fanal_test_costs(fuzz_${name})
  endif()
endfunction()
