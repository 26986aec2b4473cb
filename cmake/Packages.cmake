# Debian packages, one of each component: cpack -G DEB, or scripts/package.
#   raywalk            runtime
#   raywalk-simulate   simulator
#   python3-raywalk    python, where the module is built
#   libraywalk-dev     development
# They are for the Debian they are built on, which their version names.
if(RAYWALK_SANITIZE)
  return()
endif()
set(debian 0)
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release release REGEX "^VERSION_ID=")
  string(REGEX MATCH "[0-9]+" debian "${release}")
endif()
set(RAYWALK_MAINTAINER "Raywalk maintainers <raywalk@users.noreply.github.com>" CACHE STRING
    "Maintainer of the packages, with an address")

set(CPACK_PACKAGE_NAME raywalk)
set(CPACK_PACKAGE_VENDOR Raywalk)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${RAYWALK_MAINTAINER}")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SOURCE raywalk)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1~deb${debian})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

get_cmake_property(installed COMPONENTS)
set(CPACK_COMPONENTS_ALL runtime simulator development)
set(python3 python3)
if("python" IN_LIST installed)
  list(APPEND CPACK_COMPONENTS_ALL python)
  if(TARGET raywalk-python)
    add_dependencies(raywalk-installed raywalk-python)
    # A module is for one minor version, which its folder has looked for.
    get_target_property(folder raywalk-python SOURCE_DIR)
    get_directory_property(minor DIRECTORY ${folder} DEFINITION Python3_VERSION_MINOR)
    math(EXPR next_minor "${minor} + 1")
    set(python3 "python3 (>= 3.${minor}), python3 (<< 3.${next_minor})")
  endif()
endif()

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME raywalk)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "colmap, ffmpeg")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS raywalk-simulate)
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "360-degree light fields of rooms, captured and rendered
Raywalk turns a room into a place people can walk through, from the pictures
of one 360-degree camera on one motorised slider. It captures panoramas
along the lines of a grid, calibrates their poses, packs every line into a
light-field volume and renders full views at any point between the lines.")

set(CPACK_DEBIAN_SIMULATOR_PACKAGE_NAME raywalk-simulate)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SIMULATOR_PACKAGE_DEPENDS raywalk)
set(CPACK_DEBIAN_SIMULATOR_DESCRIPTION "360-degree light fields of rooms, simulated
Stands in for a slider and a camera, and renders captures of virtual rooms
with their ground truth, to rehearse and to measure what Raywalk does.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-raywalk)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${python3}, python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS raywalk)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "360-degree light fields of rooms, for Python
Opens rooms that Raywalk packed, renders views of them to NumPy arrays, and
computes the measures that views are evaluated by.")

# What cmake/raywalkConfig.cmake.in looks for.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libraywalk-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libegl-dev, libeigen3-dev, libexif-dev, libfmt-dev, libgles-dev, libhdf5-dev, liblcms2-dev, \
libopencv-dev, libspdlog-dev, libssl-dev, libtbb-dev, libturbojpeg0-dev, libutf8proc-dev, libyaml-cpp-dev, libzstd-dev, zlib1g-dev, nlohmann-json3-dev, pkgconf | pkg-config")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "360-degree light fields of rooms, for C++
Static libraries and headers that open rooms that Raywalk packed and render
views of them, with the configuration that CMake's find_package(raywalk) reads.")

# Dates are those of SOURCE_DATE_EPOCH where that is set: the same sources make the same package.
string(TIMESTAMP RAYWALK_CHANGED "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(RAYWALK_PACKAGE_VERSION ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
set(folder ${PROJECT_BINARY_DIR}/debian)
configure_file(cmake/debian/changelog.in ${folder}/changelog @ONLY)
execute_process(COMMAND gzip -9nc ${folder}/changelog
                OUTPUT_FILE ${folder}/changelog.Debian.gz COMMAND_ERROR_IS_FATAL ANY)

# What the pages are bundled from is named in the copyright file, with its licence.
file(READ cmake/debian/copyright copyright)
file(READ cmake/pages/package.json page)
string(JSON bundled LENGTH "${page}" dependencies)
math(EXPR last "${bundled} - 1")
foreach(i RANGE ${last})
  string(JSON package MEMBER "${page}" dependencies ${i})
  if(NOT copyright MATCHES "\nComment: [^\n]*npm package ${package}[^a-z]")
    message(FATAL_ERROR "cmake/debian/copyright does not name the npm package ${package}, which "
                        "pages are bundled from")
  endif()
endforeach()

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} name)
  set(doc ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${name}_PACKAGE_NAME})
  install(FILES cmake/debian/copyright ${folder}/changelog.Debian.gz DESTINATION ${doc}
          COMPONENT ${component})
endforeach()

include(CPack)
