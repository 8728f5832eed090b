# SPDX-License-Identifier: MIT
# GLSL to SPIR-V that is embedded in the library, and the check of the structs that C and GLSL share.

# Where what the build writes lies: the embedded shaders, and shaders.h, which declares them.
set(FANAL_GENERATED ${PROJECT_BINARY_DIR}/generated)
# A second build of the same sources, by another compiler or with sanitizers, can take the shaders from the first, whose target
# fanal_shader_files makes them: they take as long to compile as the library.
set(FANAL_SHADERS "" CACHE PATH "The folder 'generated' of a build to take the shaders from; empty: they are compiled")
if(FANAL_SHADERS AND FANAL_TESTS)
  message(FATAL_ERROR "FANAL_SHADERS goes without tests, which have shaders of their own: add -DFANAL_TESTS=OFF")
endif()
target_include_directories(fanal_options INTERFACE ${FANAL_SHADERS} ${FANAL_GENERATED}) # its own may have older ones

# Programs of the build itself: never sanitised.
add_executable(fanal_spirv_embed ${PROJECT_SOURCE_DIR}/tools/spirv_embed.c)
target_link_libraries(fanal_spirv_embed PRIVATE PkgConfig::libzstd)
add_executable(fanal_layout_check ${PROJECT_SOURCE_DIR}/tools/layout_check.c)

set_property(GLOBAL PROPERTY fanal_shader_names "")
set_property(GLOBAL PROPERTY fanal_shader_modules "")
set_property(GLOBAL PROPERTY fanal_shader_files "")
set_property(GLOBAL PROPERTY fanal_shader_targets "")

# What -O of spirv-opt does, in another order: local variables become values in each function before functions are inlined, not after it. On shaders
# that inline thousands of calls that takes a third of the time. The result is a few percent longer, and gpu/specialise.c shortens it in any case.
set(FANAL_SPIRV_VALUES --eliminate-local-single-store --scalar-replacement=100 --convert-local-access-chains --eliminate-local-single-store)
set(FANAL_SPIRV_PASSES
  --eliminate-local-single-store --ssa-rewrite ${FANAL_SPIRV_VALUES} --ssa-rewrite --eliminate-dead-branches --simplify-instructions
  --wrap-opkill --merge-return --inline-entry-points-exhaustive --eliminate-dead-functions
  --private-to-local --eliminate-local-single-block ${FANAL_SPIRV_VALUES} --eliminate-dead-code-aggressive --ssa-rewrite --eliminate-dead-code-aggressive
  --ccp --loop-unroll --eliminate-dead-branches --redundancy-elimination --simplify-instructions --eliminate-dead-code-aggressive --merge-blocks
  --remove-unused-interface-variables --eliminate-dead-variables)

# fanal_shaders(fanal_passes_lights tiled_bounds.comp.glsl …) compiles each file (STEM.vert.glsl, .geom.glsl, .mesh.glsl, .frag.glsl or
# .comp.glsl) and embeds it in the target as `shader_STEM_STAGE`. Stems are unique in the whole project. Call it in the
# directory that makes the target. Includes are looked for beside the including file, in shaders/ and in src/.
# Shaders with includes enable GL_GOOGLE_include_directive (Debian 12's glslang has no preamble option for it).
function(fanal_shaders target)
  foreach(file ${ARGN})
    cmake_path(GET file STEM stem)
    fanal_shader_variant(${target} ${stem} FROM ${file})
  endforeach()
endfunction()

# fanal_shader_variant(fanal_passes_shade forward_known FROM forward.frag.glsl DEFINES EARLY_DEPTH HOLES_ARE_CUT) compiles the file with these
# macros, NAME or NAME=VALUE, and embeds it as `shader_forward_known_frag`.
function(fanal_shader_variant target stem)
  cmake_parse_arguments(PARSE_ARGV 2 variant "" "FROM" "DEFINES")
  cmake_path(GET variant_FROM FILENAME filename)
  if(NOT filename MATCHES "^[a-z0-9_]+\\.(vert|geom|mesh|frag|comp)\\.glsl$" OR NOT stem MATCHES "^[a-z0-9_]+$")
    message(FATAL_ERROR "${stem} from ${variant_FROM}: shaders are called STEM.vert.glsl, STEM.geom.glsl, STEM.mesh.glsl, STEM.frag.glsl or STEM.comp.glsl")
  endif()
  string(REGEX REPLACE "^.*\\.([a-z]+)\\.glsl$" "\\1" stage ${filename})
  set(name ${stem}.${stage})
  get_property(names GLOBAL PROPERTY fanal_shader_names)
  if(name IN_LIST names)
    message(FATAL_ERROR "${variant_FROM}: there is another shader called ${name}")
  endif()
  set_property(GLOBAL APPEND PROPERTY fanal_shader_names ${name})

  if(FANAL_SHADERS)
    target_sources(${target} PRIVATE ${FANAL_SHADERS}/${name}.c)
    return()
  endif()

  cmake_path(ABSOLUTE_PATH variant_FROM BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE source)
  list(TRANSFORM variant_DEFINES PREPEND -D OUTPUT_VARIABLE defines)
  set(module ${FANAL_GENERATED}/${name}.spv)
  set(optimised ${FANAL_GENERATED}/${name}.opt.spv)
  set(embedded ${FANAL_GENERATED}/${name}.c)
  add_custom_command(OUTPUT ${module} DEPENDS ${source} DEPFILE ${module}.d VERBATIM COMMENT "Shader ${name}"
    COMMAND ${FANAL_GLSLANG} --quiet -V --target-env vulkan1.3 -S ${stage} ${defines} -I${PROJECT_SOURCE_DIR}/shaders
      -I${PROJECT_SOURCE_DIR}/src --depfile ${module}.d
      -o ${module} ${source}
    COMMAND ${FANAL_SPIRV_VAL} --target-env vulkan1.3 --scalar-block-layout ${module})
  add_custom_command(OUTPUT ${embedded} DEPENDS ${module} fanal_spirv_embed VERBATIM COMMENT "Embedding ${name}"
    BYPRODUCTS ${optimised}
    COMMAND ${FANAL_SPIRV_OPT} --target-env=vulkan1.3 --scalar-block-layout ${FANAL_SPIRV_PASSES} ${module} -o ${optimised}
    COMMAND ${FANAL_SPIRV_VAL} --target-env vulkan1.3 --scalar-block-layout ${optimised}
    COMMAND fanal_spirv_embed ${name} ${optimised} ${embedded})
  target_sources(${target} PRIVATE ${embedded})
  set_property(GLOBAL APPEND PROPERTY fanal_shader_modules ${module})
  set_property(GLOBAL APPEND PROPERTY fanal_shader_files ${embedded})
  set_property(GLOBAL APPEND PROPERTY fanal_shader_targets ${target})
endfunction()

# Called once, when every shader is known: writes shaders.h, and compiles the assertions that the structs of all
# *_shared.h are laid out in C as in the SPIR-V (tools/layout_check.c). A difference fails the build.
function(fanal_finish_shaders)
  if(FANAL_SHADERS)
    return() # the other build did this
  endif()
  get_property(names GLOBAL PROPERTY fanal_shader_names)
  list(SORT names)
  set(text "/* SPDX-License-Identifier: MIT */\n#ifndef FNL_SHADERS_H\n#define FNL_SHADERS_H\n\n")
  string(APPEND text "#include \"gpu/shader.h\"\n\n")
  foreach(name ${names})
    string(REPLACE "." "_" identifier ${name})
    string(APPEND text "extern const struct gpu_shader shader_${identifier};\n")
  endforeach()
  string(APPEND text "\n#endif\n")
  file(CONFIGURE OUTPUT ${FANAL_GENERATED}/shaders.h CONTENT "${text}" @ONLY)

  get_property(modules GLOBAL PROPERTY fanal_shader_modules)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/shaders/*_shared.h ${PROJECT_SOURCE_DIR}/src/*_shared.h)
  set(assertions ${FANAL_GENERATED}/layout_assertions.c)
  add_custom_command(OUTPUT ${assertions} DEPENDS ${modules} fanal_layout_check VERBATIM COMMENT "Layouts of shared structs"
    COMMAND fanal_layout_check ${assertions} ${headers} -- ${modules})
  add_library(fanal_layouts OBJECT ${assertions})
  target_link_libraries(fanal_layouts PRIVATE fanal_options)
  get_property(files GLOBAL PROPERTY fanal_shader_files)
  add_custom_target(fanal_shader_files DEPENDS ${files})
  get_property(targets GLOBAL PROPERTY fanal_shader_targets)
  list(REMOVE_DUPLICATES targets)
  add_dependencies(fanal_layouts ${targets}) # make knows how to build files of its own directory only
endfunction()
