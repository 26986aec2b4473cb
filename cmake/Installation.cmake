# What is installed.

# Programs look for their files beside their own folder, in the build folder as in an installation.
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/share/raywalk)
file(RELATIVE_PATH configs ${PROJECT_BINARY_DIR}/share/raywalk ${PROJECT_SOURCE_DIR}/configs)
file(CREATE_LINK ${configs} ${PROJECT_BINARY_DIR}/share/raywalk/configs SYMBOLIC)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs/ DESTINATION ${CMAKE_INSTALL_DATADIR}/raywalk/configs)
