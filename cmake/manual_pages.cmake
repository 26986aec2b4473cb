# Makes manual pages of what a program and its commands print as their help:
#   cmake -DPROGRAM=... -DVERSION=... -DHELP2MAN=... -DFOLDER=... -P manual_pages.cmake
# raywalk-render.1.gz and raywalk-render-view.1.gz, ... in the folder, without a name and date inside.
cmake_path(GET PROGRAM FILENAME name)
file(MAKE_DIRECTORY ${FOLDER})
set(sections ${CMAKE_CURRENT_LIST_DIR}/manual_pages.h2m)
function(make_page page command about)
  # help2man takes the page's name from the file that it runs.
  set(script ${FOLDER}/.${name}/${page})
  file(WRITE ${script} "#!/bin/sh\nexec '${PROGRAM}' ${command} \"$@\"\n")
  file(CHMOD ${script} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(COMMAND ${HELP2MAN} --no-info --version-string=${VERSION} --source=Raywalk
                          --manual=Raywalk --name=${about} --include=${sections} ${script}
                  COMMAND sed [[s/^raywalk\\-/.br\n&/]]  # an example begins a line
                  COMMAND gzip -9n OUTPUT_FILE ${FOLDER}/${page}.1.gz COMMAND_ERROR_IS_FATAL ANY)
endfunction()

execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "^[^\n]+" about "${help}")
make_page(${name} "" "${about}")
string(REGEX REPLACE "^.*\nS[Uu][a-zA-Z]*:\n" "" commands "${help}")
string(REGEX REPLACE "\n\n.*$" "" commands "${commands}")
string(REPLACE ";" "," commands "${commands}")
string(REPLACE "\n" ";" commands "${commands}")
foreach(line IN LISTS commands)
  if(line MATCHES "^  ([a-z][a-z-]*) +(.*)$")
    make_page(${name}-${CMAKE_MATCH_1} ${CMAKE_MATCH_1} "${CMAKE_MATCH_2}")
  endif()
endforeach()
file(REMOVE_RECURSE ${FOLDER}/.${name})
