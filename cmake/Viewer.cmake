# The page that shows exported rooms (render/viewer): bundled from TypeScript by esbuild, with Node.js
# 18 or newer. Packages come from the npm registry as package-lock.json names them; nothing is fetched
# at run time.
#
# Target raywalk-viewer makes share/raywalk/viewer in the build folder; programs look for it beside
# their own folder (render/web/viewer_page.h), as in an installation.
set(RAYWALK_BUILD_VIEWER AUTO CACHE STRING "Build the page of export-web and serve: ON, OFF or AUTO (if Node.js is there)")

set(RAYWALK_VIEWER_FOUND OFF)
if(NOT RAYWALK_BUILD_VIEWER STREQUAL "OFF")
  find_program(RAYWALK_NODE NAMES node nodejs)
  find_program(RAYWALK_NPM NAMES npm)
  if(RAYWALK_NODE AND RAYWALK_NPM)
    execute_process(COMMAND ${RAYWALK_NODE} --version OUTPUT_VARIABLE node_version
                    OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(REGEX REPLACE "^v" "" node_version "${node_version}")
    if(node_version VERSION_GREATER_EQUAL 18)
      set(RAYWALK_VIEWER_FOUND ON)
    endif()
  endif()
  if(NOT RAYWALK_VIEWER_FOUND)
    set(without "Node.js 18 or newer and npm were not found: the viewer's page is left out, so that \
raywalk-render export-web and serve will not work (Debian packages nodejs and npm)")
    if(RAYWALK_BUILD_VIEWER STREQUAL "ON")
      message(FATAL_ERROR "${without}")
    endif()
    message(STATUS "${without}")
  endif()
endif()

if(RAYWALK_VIEWER_FOUND)
  set(viewer_source ${PROJECT_SOURCE_DIR}/render/viewer)
  set(RAYWALK_VIEWER_WORK ${PROJECT_BINARY_DIR}/viewer)
  set(viewer_page ${PROJECT_BINARY_DIR}/share/raywalk/viewer)
  file(GLOB_RECURSE viewer_files CONFIGURE_DEPENDS
       ${viewer_source}/src/*.ts ${viewer_source}/src/*.glsl)
  set(viewer_files ${viewer_files} ${viewer_source}/build.mjs ${viewer_source}/index.html
      ${viewer_source}/viewer.css)
  add_custom_command(
    OUTPUT ${RAYWALK_VIEWER_WORK}/node_modules/.package-lock.json
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer_source}/package.json ${viewer_source}/package-lock.json
            ${RAYWALK_VIEWER_WORK}/
    COMMAND ${RAYWALK_NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error
    WORKING_DIRECTORY ${RAYWALK_VIEWER_WORK}
    DEPENDS ${viewer_source}/package.json ${viewer_source}/package-lock.json
    COMMENT "Fetching the viewer's packages from the npm registry" VERBATIM)
  add_custom_command(
    OUTPUT ${viewer_page}/viewer.js
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${viewer_source}/src ${RAYWALK_VIEWER_WORK}/src
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer_source}/build.mjs ${viewer_source}/index.html
            ${viewer_source}/viewer.css ${RAYWALK_VIEWER_WORK}/
    COMMAND ${RAYWALK_NODE} build.mjs ${viewer_page}
    WORKING_DIRECTORY ${RAYWALK_VIEWER_WORK}
    DEPENDS ${viewer_files} ${RAYWALK_VIEWER_WORK}/node_modules/.package-lock.json
    COMMENT "Bundling the viewer's page" VERBATIM)
  add_custom_target(raywalk-viewer ALL DEPENDS ${viewer_page}/viewer.js)
  file(MAKE_DIRECTORY ${RAYWALK_VIEWER_WORK})
  install(DIRECTORY ${viewer_page}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/raywalk/viewer)
endif()
