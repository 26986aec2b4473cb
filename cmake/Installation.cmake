# What is installed, by component: `runtime` (programs and what they need), `development` (libraries
# for C++ programs); the Python module adds `python`. Packages.cmake makes a package of each.

# All that is installed, and no tests.
add_custom_target(raywalk-installed)

set(RAYWALK_SHARE ${PROJECT_BINARY_DIR}/share)
set(RAYWALK_HEADERS ${CMAKE_INSTALL_INCLUDEDIR}/raywalk)
set(RAYWALK_CONFIG_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/raywalk)

# Programs look for their files beside their own folder, in the build folder as in an installation.
file(MAKE_DIRECTORY ${RAYWALK_SHARE}/raywalk)
file(RELATIVE_PATH configs ${RAYWALK_SHARE}/raywalk ${PROJECT_SOURCE_DIR}/configs)
file(CREATE_LINK ${configs} ${RAYWALK_SHARE}/raywalk/configs SYMBOLIC)
file(GLOB_RECURSE RAYWALK_CONFIGS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/configs/*.yaml)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/raywalk/configs
        COMPONENT runtime)
# For copying and editing.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/scripts/slurm DESTINATION ${CMAKE_INSTALL_DATADIR}/raywalk
        COMPONENT runtime)

find_program(RAYWALK_HELP2MAN NAMES help2man)
if(NOT RAYWALK_HELP2MAN)
  message(FATAL_ERROR "help2man was not found, which makes the manual pages; "
                      "scripts/install-packages build installs it")
endif()

# raywalk_install_program(<name> <component>): a program, with the manual pages of it and its commands
# and the completion of bash. A sanitizer's programs are not for installation.
function(raywalk_install_program name component)
  if(RAYWALK_SANITIZE)
    return()
  endif()
  set(pages ${RAYWALK_SHARE}/man/man1)
  add_custom_command(
    OUTPUT ${pages}/${name}.1.gz
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${name}> -DVERSION=${PROJECT_VERSION}
            -DHELP2MAN=${RAYWALK_HELP2MAN} -DFOLDER=${pages}
            -P ${PROJECT_SOURCE_DIR}/cmake/manual_pages.cmake
    DEPENDS ${name} ${RAYWALK_CONFIGS} ${PROJECT_SOURCE_DIR}/cmake/manual_pages.cmake
            ${PROJECT_SOURCE_DIR}/cmake/manual_pages.h2m
    COMMENT "Manual pages of ${name}" VERBATIM)
  add_custom_target(${name}-reference ALL DEPENDS ${pages}/${name}.1.gz)
  add_dependencies(raywalk-installed ${name}-reference)
  install(TARGETS ${name} COMPONENT ${component})
  install(DIRECTORY ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT ${component}
          FILES_MATCHING PATTERN "${name}*.1.gz")
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/completion.bash COMPONENT ${component}
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ${name})
endfunction()

# raywalk_install_library(<name> [HEADERS <file>...]): a library that C++ programs can link,
# raywalk_view as raywalk::view, with these headers and those of Raywalk that they include.
function(raywalk_install_library name)
  cmake_parse_arguments(ARG "" "" "HEADERS" ${ARGN})
  string(REGEX REPLACE "^raywalk_" "" short_name ${name})
  set_target_properties(${name} PROPERTIES EXPORT_NAME ${short_name})
  target_include_directories(${name} INTERFACE $<INSTALL_INTERFACE:${RAYWALK_HEADERS}>)
  target_compile_features(${name} INTERFACE cxx_std_20)
  add_dependencies(raywalk-installed ${name})
  install(TARGETS ${name} EXPORT raywalk-libraries ARCHIVE COMPONENT development)
  list(TRANSFORM ARG_HEADERS PREPEND core/)
  set(installed "")
  while(ARG_HEADERS)
    list(POP_FRONT ARG_HEADERS header)
    if(header IN_LIST installed)
      continue()
    endif()
    list(APPEND installed ${header})
    cmake_path(GET header PARENT_PATH folder)
    install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${RAYWALK_HEADERS}/${folder}
            COMPONENT development)
    file(STRINGS ${PROJECT_SOURCE_DIR}/${header} includes REGEX "^#include \"")
    list(TRANSFORM includes REPLACE "^#include \"(.*)\".*" "\\1")
    list(APPEND ARG_HEADERS ${includes})
  endwhile()
endfunction()

# raywalk_install_package_config(): what find_package(raywalk) reads, behind all libraries.
function(raywalk_install_package_config)
  include(CMakePackageConfigHelpers)
  configure_package_config_file(
    ${PROJECT_SOURCE_DIR}/cmake/raywalkConfig.cmake.in ${PROJECT_BINARY_DIR}/raywalkConfig.cmake
    INSTALL_DESTINATION ${RAYWALK_CONFIG_FOLDER})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/raywalkConfigVersion.cmake
                                   COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/raywalkConfig.cmake
                ${PROJECT_BINARY_DIR}/raywalkConfigVersion.cmake
          DESTINATION ${RAYWALK_CONFIG_FOLDER} COMPONENT development)
  install(EXPORT raywalk-libraries NAMESPACE raywalk:: FILE raywalkLibraries.cmake
          DESTINATION ${RAYWALK_CONFIG_FOLDER} COMPONENT development)
endfunction()
