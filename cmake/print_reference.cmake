# Writes what a program prints of itself: cmake -DPROGRAM=... -DPAGE=... -DBASH=... -P
# print_reference.cmake. The page is compressed, without a name and date inside.
foreach(file IN ITEMS ${PAGE} ${BASH})
  get_filename_component(folder ${file} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
endforeach()
execute_process(COMMAND ${PROGRAM} --completion bash OUTPUT_FILE ${BASH} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${PROGRAM} --man COMMAND gzip -9n OUTPUT_FILE ${PAGE}
                COMMAND_ERROR_IS_FATAL ANY)
