# SPDX-License-Identifier: MIT
# Every library that Fanal links, found in one place; also read by the package configuration of a static libfanal.a.
# FANAL_PACKAGES are pkg-config's names: each becomes the target PkgConfig::NAME. Of Vulkan only
# the headers are used; the loader is opened at run time.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(OpenEXR CONFIG)
find_dependency(meshoptimizer CONFIG)
find_dependency(PkgConfig)
set(FANAL_PACKAGES jansson spng libjpeg libwebp libzstd)
foreach(package ${FANAL_PACKAGES})
  if(NOT TARGET PkgConfig::${package})
    pkg_check_modules(${package} REQUIRED QUIET IMPORTED_TARGET ${package})
  endif()
endforeach()
