# SPDX-License-Identifier: MIT
# What `cmake --install` lays down: headers, library, command, CMake package and pkg-config file.
include(CMakePackageConfigHelpers)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/fanal)
install(DIRECTORY include/fanal DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(TARGETS fanal EXPORT fanal LIBRARY COMPONENT program NAMELINK_COMPONENT Unspecified)
if(TARGET fanal_cli)
  set_target_properties(fanal_cli PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
  install(TARGETS fanal_cli COMPONENT program)
  install(FILES ${PROJECT_BINARY_DIR}/fanal.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL) # all but the target fanal_cli alone makes it
  install(FILES cli/completion/fanal.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME fanal)
  install(FILES cli/completion/_fanal DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
  install(FILES cli/completion/fanal.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
  install(FILES docs/stats.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/fanal) # of what `fanal render --stats` writes
endif()
install(EXPORT fanal NAMESPACE fanal:: FILE fanal-targets.cmake DESTINATION ${package_folder})

# A shared library brings its dependencies itself; users of a static one must find and link them.
if(BUILD_SHARED_LIBS)
  set(FANAL_CONFIG_DEPENDENCIES "")
  set(FANAL_PC_REQUIRES "")
  set(FANAL_PC_LIBS "")
else()
  set(FANAL_CONFIG_DEPENDENCIES "set(FANAL_RAY ${FANAL_RAY})
set(FANAL_DRACO ${FANAL_HAS_DRACO})
set(FANAL_HAS_DRACO ${FANAL_HAS_DRACO})
include(\${CMAKE_CURRENT_LIST_DIR}/dependencies.cmake)
if(FANAL_MISSING)
  list(JOIN FANAL_MISSING \", \" fanal_NOT_FOUND_MESSAGE)
  set(fanal_NOT_FOUND_MESSAGE \"a static Fanal needs \${fanal_NOT_FOUND_MESSAGE}\")
  set(fanal_FOUND FALSE)
  return()
endif()")
  list(JOIN FANAL_PACKAGES " " FANAL_PC_REQUIRES)
  set(FANAL_PC_REQUIRES "${FANAL_PC_REQUIRES} OpenEXR")
  set(FANAL_PC_LIBS "-lmeshoptimizer -lOpenEXRCore -lpthread -ldl -lm")
  if(FANAL_RAY)
    set(FANAL_PC_LIBS "-lembree${embree_VERSION_MAJOR} ${FANAL_PC_LIBS}")
  endif()
  if(FANAL_HAS_DRACO)
    set(FANAL_PC_LIBS "-ldraco -lstdc++ ${FANAL_PC_LIBS}")
  endif()
  install(FILES cmake/dependencies.cmake DESTINATION ${package_folder})
endif()
configure_package_config_file(cmake/fanal-config.cmake.in ${PROJECT_BINARY_DIR}/fanal-config.cmake
  INSTALL_DESTINATION ${package_folder} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/fanal-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/fanal-config.cmake ${PROJECT_BINARY_DIR}/fanal-config-version.cmake
  DESTINATION ${package_folder})

file(RELATIVE_PATH FANAL_PC_PREFIX /x/${CMAKE_INSTALL_LIBDIR}/pkgconfig /x)
configure_file(cmake/fanal.pc.in ${PROJECT_BINARY_DIR}/fanal.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/fanal.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
