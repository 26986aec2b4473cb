# What is bundled from TypeScript by esbuild, with Node.js 18 or newer: the page of reports, inside the
# programs, and the viewer of exported rooms. Packages come from the npm registry as package-lock.json
# names them, or from npm's cache (docs/development.md); nothing is fetched at run time.
#
# The pages are built in copies beside each other, as npm puts packages above them:
#   pages/package.json, tsconfig.json, test.mjs, node_modules
#   pages/report, pages/viewer
find_program(RAYWALK_NODE NAMES node nodejs)
find_program(RAYWALK_NPM NAMES npm)
set(node_version 0)
if(RAYWALK_NODE AND RAYWALK_NPM)
  execute_process(COMMAND ${RAYWALK_NODE} --version OUTPUT_VARIABLE node_version
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  string(REGEX REPLACE "^v" "" node_version "${node_version}")
endif()
if(node_version VERSION_LESS 18)
  message(FATAL_ERROR "Node.js 18 or newer and npm were not found, which bundle the pages of reports \
and of the viewer (Debian packages nodejs and npm); scripts/install-packages build installs them")
endif()

set(RAYWALK_PAGES ${PROJECT_BINARY_DIR}/pages)
file(MAKE_DIRECTORY ${RAYWALK_PAGES})
set(raywalk_pages_files package.json package-lock.json tsconfig.json test.mjs .prettierrc.json .prettierignore)
list(TRANSFORM raywalk_pages_files PREPEND ${PROJECT_SOURCE_DIR}/cmake/pages/)
add_custom_command(
  OUTPUT ${RAYWALK_PAGES}/node_modules/.package-lock.json
  COMMAND ${CMAKE_COMMAND} -E copy ${raywalk_pages_files} ${RAYWALK_PAGES}
  COMMAND ${CMAKE_COMMAND} -E chdir ${RAYWALK_PAGES}
          ${RAYWALK_NPM} ci --ignore-scripts --no-audit --no-fund --loglevel=error
  DEPENDS ${raywalk_pages_files}
  COMMENT "Fetching the pages' packages from the npm registry" VERBATIM)
add_custom_target(raywalk-page-packages DEPENDS ${RAYWALK_PAGES}/node_modules/.package-lock.json)

# raywalk_report_kind(<kind>.ts): describes a kind of report, beside what writes its JSON.
function(raywalk_report_kind description)
  set_property(GLOBAL APPEND PROPERTY RAYWALK_REPORT_KINDS
               ${CMAKE_CURRENT_SOURCE_DIR}/${description})
endfunction()

# raywalk_page(<name> FILES ... [KINDS ...] [SHADERS ...] OUTPUTS ...): copies these files of the
# current folder, and its folders src and browser, to pages/<name>, descriptions of kinds to src/kinds
# there, the engine's shaders to src/engine, and runs build.mjs there, which makes the outputs; its
# argument is the folder of the first.
function(raywalk_page name)
  cmake_parse_arguments(ARG "" "" "FILES;KINDS;SHADERS;OUTPUTS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS src/*.ts src/*.glsl browser/*.mjs)
  set(copy ${RAYWALK_PAGES}/${name})
  file(MAKE_DIRECTORY ${copy})
  list(GET ARG_OUTPUTS 0 first)
  cmake_path(GET first PARENT_PATH folder)
  set(KINDS_folder kinds)
  set(SHADERS_folder engine)
  foreach(more KINDS SHADERS)
    set(into ${copy}/src/${${more}_folder})
    if(ARG_${more})
      list(APPEND copy_more COMMAND ${CMAKE_COMMAND} -E make_directory ${into}
                            COMMAND ${CMAKE_COMMAND} -E copy ${ARG_${more}} ${into})
    endif()
  endforeach()
  add_custom_command(
    OUTPUT ${ARG_OUTPUTS}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${copy}/src ${copy}/browser
    COMMAND ${CMAKE_COMMAND} -E copy_directory src ${copy}/src
    ${copy_more}
    COMMAND ${CMAKE_COMMAND} -E copy_directory browser ${copy}/browser
    COMMAND ${CMAKE_COMMAND} -E copy build.mjs ${ARG_FILES} ${copy}
    COMMAND ${CMAKE_COMMAND} -E chdir ${copy} ${RAYWALK_NODE} build.mjs ${folder}
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}
    DEPENDS ${sources} build.mjs ${ARG_FILES} ${ARG_KINDS} ${ARG_SHADERS} raywalk-page-packages
            ${RAYWALK_PAGES}/node_modules/.package-lock.json
    COMMENT "Bundling the page ${name}" VERBATIM)
endfunction()
