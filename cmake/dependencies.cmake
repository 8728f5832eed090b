# SPDX-License-Identifier: MIT
# Every library that Fanal links, found in one place; also read by the package configuration of a static libfanal.a. FANAL_PACKAGES are
# pkg-config's names: each becomes the target PkgConfig::NAME. Of Vulkan only the headers are used; the loader is opened at run time.
# FANAL_MISSING lists what was not found, with the package of Debian and Ubuntu that has it; whoever includes this file says so.
set(FANAL_MISSING "")
macro(fanal_need found name package)
  if(NOT ${found})
    list(APPEND FANAL_MISSING "${name} (Debian and Ubuntu: ${package})")
  endif()
endmacro()

find_package(Threads QUIET)
fanal_need(Threads_FOUND "POSIX threads" libc6-dev)
find_package(OpenEXR CONFIG QUIET)
fanal_need(OpenEXR_FOUND OpenEXR libopenexr-dev)
find_package(meshoptimizer CONFIG QUIET)
fanal_need(meshoptimizer_FOUND meshoptimizer libmeshoptimizer-dev)
if(FANAL_RAY)
  find_package(embree CONFIG QUIET) # 3 or 4
  fanal_need(embree_FOUND "Embree, or -DFANAL_RAY=OFF" libembree-dev)
endif()
if(FANAL_DRACO) # optional, unless a libfanal.a was built with it
  find_package(draco CONFIG QUIET)
  if(FANAL_HAS_DRACO)
    fanal_need(draco_FOUND libdraco libdraco-dev)
  endif()
endif()
find_package(PkgConfig QUIET)
fanal_need(PkgConfig_FOUND pkg-config pkg-config)
set(FANAL_PACKAGES jansson spng libjpeg libwebp libzstd zlib)
set(fanal_debian_packages libjansson-dev libspng-dev libjpeg-dev libwebp-dev libzstd-dev zlib1g-dev)
foreach(package debian IN ZIP_LISTS FANAL_PACKAGES fanal_debian_packages)
  if(PkgConfig_FOUND AND NOT TARGET PkgConfig::${package})
    pkg_check_modules(${package} QUIET IMPORTED_TARGET ${package})
  endif()
  if(NOT TARGET PkgConfig::${package})
    list(APPEND FANAL_MISSING "${package} (Debian and Ubuntu: ${debian})")
  endif()
endforeach()
