# Headers, library, tool and robots; others find them with find_package(veridyn).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/veridyn)

# Components are Debian packages, see packages.cmake.
install(TARGETS veridyn EXPORT veridynTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
if(TARGET veridyn_tool)
  install(TARGETS veridyn_tool RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tool)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/veridyn DESTINATION include COMPONENT dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data/robots ${PROJECT_SOURCE_DIR}/data/dvrk DESTINATION share/veridyn COMPONENT tool)
install(EXPORT veridynTargets NAMESPACE veridyn:: DESTINATION ${PACKAGE_DIR} COMPONENT dev)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/veridynConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/veridynConfig.cmake INSTALL_DESTINATION ${PACKAGE_DIR})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/veridynConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/veridynConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/veridynConfigVersion.cmake
        DESTINATION ${PACKAGE_DIR} COMPONENT dev)

include(${CMAKE_CURRENT_LIST_DIR}/packages.cmake)
