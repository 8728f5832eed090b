# SPDX-License-Identifier: MIT
# The three kinds of target: layers, tests, and shaders that are embedded in layers.

add_library(fanal_options INTERFACE)
target_compile_options(fanal_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wvla -fno-math-errno -ffp-contract=off)
target_compile_definitions(fanal_options INTERFACE _GNU_SOURCE)
target_include_directories(fanal_options INTERFACE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src
  ${PROJECT_SOURCE_DIR}/shaders)
if(FANAL_SANITIZE)
  target_compile_options(fanal_options INTERFACE -fsanitize=${FANAL_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(fanal_options INTERFACE -fsanitize=${FANAL_SANITIZE})
endif()
set_property(GLOBAL PROPERTY fanal_layers "")

# fanal_layer(base SOURCES a.c b.c LINKS m) makes the object library fanal_base: one layer of the design's diagram.
function(fanal_layer name)
  cmake_parse_arguments(layer "" "" "SOURCES;LINKS" ${ARGN})
  add_library(fanal_${name} OBJECT ${layer_SOURCES})
  target_link_libraries(fanal_${name} PUBLIC fanal_options ${layer_LINKS})
  set_property(GLOBAL APPEND PROPERTY fanal_layers fanal_${name})
endfunction()

# fanal_test(maths SOURCES maths_test.c LAYERS base) makes the cmocka program test_maths and its CTest entry. LAYERS lists
# every layer whose objects the test needs.
function(fanal_test name)
  if(NOT FANAL_TESTS)
    return()
  endif()
  cmake_parse_arguments(test "" "TIMEOUT" "SOURCES;LAYERS;LINKS;ARGUMENTS" ${ARGN})
  add_executable(test_${name} ${test_SOURCES})
  foreach(layer ${test_LAYERS})
    target_link_libraries(test_${name} PRIVATE fanal_${layer})
  endforeach()
  target_link_libraries(test_${name} PRIVATE fanal_options cmocka ${test_LINKS} m)
  add_test(NAME ${name} COMMAND test_${name} ${test_ARGUMENTS} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  if(test_TIMEOUT)
    set_tests_properties(${name} PROPERTIES TIMEOUT ${test_TIMEOUT})
  endif()
endfunction()
